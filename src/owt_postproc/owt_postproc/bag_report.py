"""Report data and fatigue results from a recorded bag: the stages of a run, fed with what was recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from owt_model.config import CaseConfig, parse_case
from owt_model.contracts import Block, ReducedDescription, StressBlock, sea_facts
from owt_model.errors import InputError
from owt_postproc.bag_reader import PREFIX, BagMessage, decoded, to_block
from owt_postproc.bag_source import BagSource
from owt_postproc.core.running import RunningCount
from owt_postproc.fatigue_check import FatigueCheck
from owt_postproc.report_data import Geometry, ReportCollector, ReportData
from owt_ros.decode import is_whole, to_frame, to_reduced_model

__all__ = ["BlockSource", "as_recorded", "bag_case", "bag_report"]

#: Reads the messages of a case's bag in order; with each it gives the block that the message stands for.
BlockSource = Callable[[CaseConfig, Iterator[BagMessage]], Iterator[tuple[BagMessage, Block | None]]]

TYPES = tuple(
    PREFIX + name
    for name in (
        "ModelDescription",
        "SeaState",
        "LoadBasis",
        "ReducedModel",
        "SurfaceElevation",
        "NodalLoads",
        "TowerTopLoad",
        "ModalState",
        "MemberStress",
        "Energy",
        "FatigueState",
    )
)


def as_recorded(
    case: CaseConfig, messages: Iterator[BagMessage]
) -> Iterator[tuple[BagMessage, Block | None]]:
    """Take every block from its message alone.

    Raises
    ------
    InputError
        If a message leaves out a part of its arrays.
    """
    for message in messages:
        if not is_whole(message.content):
            raise InputError(
                "bag",
                message.topic,
                "leaves out what can be computed again from the loads",
                "Read it with ./owt analyse, which does, or record with record = all.",
            )
        yield message, to_block(message)


def bag_case(source: BagSource) -> CaseConfig:
    """Return the case that made a bag.

    Raises
    ------
    InputError
        If the bag is damaged or holds no case.
    """
    case = source.files.case
    if not case:
        raise InputError(
            "bag", str(source.path), "holds no case", "Record it with the bring-up of this project."
        )
    fatigue = case.get("fatigue")
    if isinstance(fatigue, dict) and "hot_spots" not in fatigue:  # of a version that counted it otherwise
        case = {**case, "fatigue": {**fatigue, "hot_spots": "nominal", "thickness_effect": False}}
    return parse_case(case, source="case.json in the bag")


def bag_report(
    bag: str | Path | BagSource,
    *,
    versions: Mapping[str, str] | None = None,
    blocks: BlockSource = as_recorded,
    check: FatigueCheck | None = None,
) -> ReportData:
    """Read a bag as far as it goes and count its stress; needs the case attached to it as ``case.json``.

    Parameters
    ----------
    bag : path or BagSource
        Bag folder, complete or not.
    versions : mapping, optional
        Replaces those in the bag's metadata record ``versions``.
    blocks : callable
        What gives the blocks; by default they are read from the messages.
    check : FatigueCheck, optional
        Compares the counting with the recorded one, block by block; tells afterwards what it found.

    Raises
    ------
    InputError
        If the bag is not readable, or lacks the case or the model.
    ComputationError
        If a stream in it has a gap or is not finite, or the recorded fatigue is another.
    """
    if not isinstance(bag, BagSource):
        with BagSource(bag) as source:
            return bag_report(source, versions=versions, blocks=blocks, check=check)
    case = bag_case(bag)
    reading = _Reading(case, check or FatigueCheck())
    for message, block in blocks(case, decoded(bag, types=TYPES)):
        reading.take(message, block)
    return reading.finish(bag, bag.files.metadata.get("versions", {}) if versions is None else dict(versions))


class _Reading:
    """Where the reading of a bag stands; blocks wait for the description of the reduced model."""

    def __init__(self, case: CaseConfig, check: FatigueCheck) -> None:
        self._case, self._check, self._fatigue = case, check, RunningCount(case)
        self._reduced: ReducedDescription | None = None
        self._geometry: Geometry | None = None
        self._sea: dict[str, Any] = {}
        self._waiting: list[Block] = []

    def take(self, message: BagMessage, block: Block | None) -> None:
        kind, content = message.type_name.removeprefix(PREFIX), message.content
        if kind == "ModelDescription":
            self._geometry = _geometry(content)
            self._fatigue.learn(frame=to_frame(content))
        elif kind == "SeaState":
            self._sea = {name: _plain(value) for name, value in sea_facts(content).items()}
        elif kind == "FatigueState":
            self._check.recorded(content)
        elif kind == "ReducedModel" and self._reduced is None:
            self._reduced = to_reduced_model(content)
            self._collector = ReportCollector(self._reduced.tower_top_coordinate)
            self._fatigue.learn(reduced=self._reduced)
        if block is not None:
            self._waiting.append(block)
        if self._fatigue.is_ready:
            for ready in self._waiting:
                self._count(ready)
            self._waiting.clear()

    def _count(self, block: Block) -> None:
        self._collector.add(block)
        if isinstance(block, StressBlock):
            self._check.counted(self._fatigue.count(block))

    def finish(self, bag: BagSource, versions: Mapping[str, str]) -> ReportData:
        if self._reduced is None or not self._fatigue.is_ready:
            raise InputError(
                "bag", str(bag.path), "holds no reduced model", "The recording ended before its first block."
            )
        self._check.finish(complete=self._fatigue.is_closed)
        return self._collector.finish(
            case=self._case.model_dump(mode="json"),
            reduced=self._reduced,
            fatigue=self._fatigue.result(),
            geometry=self._geometry,
            sea_state=self._sea,
            versions=versions,
        )


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _geometry(content: Any) -> Geometry:
    members = len(content.member_name)
    elements = content.element_node.reshape(-1, 2).astype(np.int64)
    return Geometry(
        node=content.node_position_m.reshape(-1, 3),
        member_node=content.member_node.reshape(-1, 2).astype(np.int64),
        tower_node=elements[np.asarray(content.element_member) >= members],
        node_name=tuple(content.node_name),
        member_name=tuple(content.member_name),
        member_diameter=np.asarray(content.member_diameter_m, dtype=np.float64),
    )
