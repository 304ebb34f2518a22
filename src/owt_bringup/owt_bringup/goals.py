"""One goal of the action ``RunSeaState``: run the graph, and say in a status what came of it."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from owt_msgs.action import RunSeaState

from owt_bringup.analysis import analyse
from owt_bringup.graph import run_graph
from owt_bringup.sea_notes import case_warnings
from owt_bringup.supervisor import NodeError
from owt_model.config import CaseConfig, parse_case_text
from owt_model.errors import ComputationError, InputError, OwtError, StreamError
from owt_model.structure import Structure, case_structure
from owt_postproc.core.sn import sn_curve
from owt_postproc.partial_folder import partial_path
from owt_postproc.report import summary
from owt_wave_node.sea_source import resolve_case

__all__ = ["RECORDS", "CancelledError", "Outcome", "Speed", "check_case", "run_goal"]

#: What a bag may hold.
RECORDS = ("default", "all")
_Status = RunSeaState.Result


class CancelledError(OwtError):
    """The run was ended on demand."""


@dataclass(frozen=True)
class Outcome:
    """What a goal comes to; the fields of the action's result."""

    status: int
    message: str
    bag: str
    statistics_json: str


class Speed:
    """Simulated over wall time since the stream began to move.

    Parameters
    ----------
    clock : callable
        Wall time in s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._from: tuple[float, float] | None = None

    def at(self, reached: float) -> float:
        """Return the speed when simulated time `reached` in s is passed; zero at first."""
        now = self._clock()
        if self._from is None:
            if reached > 0.0:
                self._from = now, reached
            return 0.0
        then, start = self._from
        return (reached - start) / max(now - then, 1e-9)


def check_case(text: str) -> tuple[CaseConfig, list[str]]:
    """Validate a case as its run would, without running it; return it and one line per warning.

    Raises
    ------
    InputError
        If the case, the file of its sea or its structure is refused.
    ComputationError
        If the first order of a measured record is not found.
    """
    case, structure = _read(text)
    return case, case_warnings(resolve_case(case), structure)


def _read(text: str) -> tuple[CaseConfig, Structure]:
    """Read a case and what it names."""
    case = parse_case_text(text)
    structure = case_structure(case.structure)
    structure.check_water_depth(case.water_depth_m)
    sn_curve(case.fatigue.sn_curve, case.fatigue.sn_file)
    return case, structure


def run_goal(
    goal: RunSeaState.Goal,
    *,
    domain: int,
    namespace: str,
    progress: Callable[[float, float], None],
    should_stop: Callable[[], None],
) -> Outcome:
    """Run what `goal` asks for and write summary and report into the bag; errors become a status.

    Parameters
    ----------
    goal : RunSeaState.Goal
        Case, bag and what to record.
    domain, namespace : int, str
        Where the graph runs.
    progress : callable
        Called with the simulated time reached and the duration, in s.
    should_stop : callable
        Called often; raises :class:`CancelledError` to end the run.
    """
    bag = Path(goal.bag).absolute()
    before = _identity(partial_path(bag))
    try:
        if not goal.bag:
            raise InputError("bag", "", "is missing", "Give the folder to record into.")
        record = goal.record or "default"
        if record not in RECORDS:
            raise InputError("record", record, f"must be one of: {', '.join(RECORDS)}", "Leave it empty.")
        case, _ = _read(goal.case_json)
        progress(0.0, case.time.duration_s)
        result = run_graph(
            case,
            bag,
            domain_id=domain,
            namespace=namespace,
            record=record,
            progress=progress,
            should_stop=should_stop,
        )
        progress(case.time.duration_s, case.time.duration_s)
        data, _, _ = analyse(result.bag)
        return Outcome(_Status.SUCCEEDED, "", str(bag), json.dumps(summary(data), allow_nan=False))
    except OwtError as error:
        message = " ".join(str(error).split())
        return Outcome(_status_of(error), message, _left(bag, before), "")


def _identity(path: Path) -> int:
    """Number of a folder that tells it from another of the same name; 0 if it is not there."""
    return path.stat().st_ino if path.is_dir() else 0


def _left(bag: Path, before: int) -> str:
    """What a failed run left: its bag, complete or partial, or nothing."""
    partial = partial_path(bag)
    return str(partial) if _identity(partial) not in (0, before) else ""


def _status_of(error: OwtError) -> int:
    """Status of the action for an error."""
    if isinstance(error, CancelledError):
        return int(_Status.CANCELLED)
    if isinstance(error, NodeError):
        return error.kind or int(_Status.STREAM_ERROR)
    if isinstance(error, InputError):
        return int(_Status.INPUT_ERROR)
    numerics = isinstance(error, ComputationError) and not isinstance(error, StreamError)
    return int(_Status.NUMERICS_ERROR if numerics else _Status.STREAM_ERROR)
