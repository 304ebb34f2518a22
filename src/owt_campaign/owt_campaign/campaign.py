"""A campaign in a folder: runs what is not there yet, then writes results.nc, the tables and the totals.

A folder then has ``cases/`` with one checked file per case, ``results.nc``, ``tables/``, ``summary.json``,
``report.html`` and ``campaign.json``, which says what was asked for. The results are written from the files
of the cases in the order of the table: they do not depend on how the cases were run.
"""

from __future__ import annotations

import fcntl
import json
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from owt_campaign.campaign_tables import NAMES, CampaignTables
from owt_campaign.dataset import CampaignFile
from owt_campaign.engine import CaseOutcome
from owt_campaign.errors_full import errors_against_full
from owt_campaign.plan import CampaignPlan, Place
from owt_campaign.result_file import decode_outcome
from owt_campaign.runner import CaseRecord, run_cases
from owt_campaign.store import ResultStore
from owt_campaign.totals import OrderTotals, TotalsBuilder
from owt_model.errors import InputError
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import case_structure

__all__ = ["CampaignResult", "campaign_folder", "run_campaign"]

CASES, RESULTS, TABLES = "cases", "results.nc", "tables"
#: What was asked for: written first, so that a folder without it is no campaign's.
ASKED = "campaign.json"
#: What a campaign leaves in its folder.
OWN = (CASES, RESULTS, TABLES, "summary.json", "report.html", ASKED)
_CASE_FILE = re.compile(r"\.?[0-9a-f]{64}\.(npz|sha256)(\.partial)?")


@dataclass
class CampaignResult:
    """What a campaign gave.

    Attributes
    ----------
    computed, reused : int
        Finished cases that were computed now, and that were there.
    failed : dict of Place to str
        Cases without a result, and why.
    distrusted : int
        Results that were there but did not fit their checksum, and were computed again.
    totals : dict
        By wave order.
    compared : dict
        The same of the cases that every wave order finished, for ratios of one to the other.
    sample : CaseOutcome, optional
        The first of the outcomes; None if there is none.
    mesh : Mesh, optional
        The structure; None if there is no outcome.
    seconds, peak_memory_mib : list of float
        Of each case computed now, in its worker.
    """

    plan: CampaignPlan
    computed: int = 0
    reused: int = 0
    failed: dict[Place, str] = field(default_factory=dict)
    distrusted: int = 0
    totals: dict[int, OrderTotals] = field(default_factory=dict)
    compared: dict[int, OrderTotals] = field(default_factory=dict)
    sample: CaseOutcome | None = None
    mesh: Mesh | None = None
    seconds: list[float] = field(default_factory=list)
    peak_memory_mib: list[float] = field(default_factory=list)


@contextmanager
def campaign_folder(folder: Path, *, resume: bool, overwrite: bool) -> Iterator[Path]:
    """Open the folder of a campaign, for one process at a time.

    Raises
    ------
    InputError
        If it holds a campaign and is neither to be resumed nor overwritten, holds something else, cannot be
        written, or another process works in it.
    """
    if resume and overwrite:
        raise InputError("--resume", True, "must not be given with --overwrite", "Give one of them.")
    there = [name for name in OWN if (folder / name).exists()] if folder.is_dir() else []
    if folder.exists() and not folder.is_dir():
        raise InputError("output", str(folder), "is no folder", "Choose another name.")
    if there and not (resume or overwrite):
        raise InputError(
            "output", str(folder), f"holds a campaign already ({', '.join(there)})",
            "Give --resume to go on with it, --overwrite to begin anew, or another folder.",
        )  # fmt: skip
    if there and ASKED not in there:
        raise InputError(
            "output", str(folder), f"holds {', '.join(there)} but no {ASKED}: not those of a campaign",
            "Choose another folder.",
        )  # fmt: skip
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / ".lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    "output",
                    str(folder),
                    "is worked in by another campaign",
                    "Wait for it, or choose another folder.",
                ) from None
            if overwrite:
                _remove(folder)
            yield folder
    except PermissionError as error:
        raise InputError(
            "output", str(folder), f"cannot be written to ({error.strerror})", "Choose another folder."
        ) from None


def _remove(folder: Path) -> None:
    """Remove the files of a campaign, and nothing else."""
    for path in (folder / CASES).glob("*"):
        if _CASE_FILE.fullmatch(path.name):
            path.unlink()
    _remove_results(folder)
    for name in OWN:
        with suppress(OSError):  # a folder that holds something else stays
            (folder / name).rmdir() if (folder / name).is_dir() else (folder / name).unlink()


def _remove_results(folder: Path) -> None:
    """Remove the dataset and the tables."""
    for path in (folder / RESULTS, *(folder / TABLES / f"{name}.parquet" for name in NAMES)):
        path.unlink(missing_ok=True)


def run_campaign(
    plan: CampaignPlan,
    folder: Path,
    *,
    workers: int,
    scheduler: str | None = None,
    cluster: str = "spec",
    attributes: Mapping[str, Any] | None = None,
    on_start: Callable[[str], None] | None = None,
    on_done: Callable[[CaseRecord], None] | None = None,
) -> CampaignResult:
    """Run what is not in the folder yet, and write its results.

    Parameters
    ----------
    plan : CampaignPlan
        The cases.
    folder : Path
        From :func:`campaign_folder`.
    workers, scheduler, cluster, on_start, on_done
        See :func:`owt_campaign.runner.run_cases`.
    attributes : mapping, optional
        Provenance.

    Raises
    ------
    InputError
        If an argument is refused, or nothing can be written.
    ComputationError
        If the scheduler is lost.
    """
    store, result = ResultStore(folder / CASES), CampaignResult(plan)
    result.failed.update(plan.refused)
    keys: dict[Place, str] = {}
    for record in run_cases(
        plan.cases, workers=workers, scheduler=scheduler, cluster=cluster, store=store,
        on_start=on_start, on_done=on_done,
    ):  # fmt: skip
        place = plan.places[record.index]
        keys[place] = record.key
        if record.status == "failed":
            result.failed[place] = record.message
        elif record.reused:
            result.reused += 1
        else:
            result.computed += 1
            result.seconds.append(record.seconds)
            result.peak_memory_mib.append(record.peak_memory_mib)
    result.distrusted = len(store.distrusted)
    described = {"title": "Load-case campaign", "cluster": cluster, **_described(plan), **(attributes or {})}
    _write_results(result, store, keys, folder, described)
    return result


def _described(plan: CampaignPlan) -> dict[str, Any]:
    """Attributes of the results that the plan tells."""
    return {
        "table": plan.table.name,
        "table_comments": "\n".join(plan.table.comments),
        "occurrence": plan.occurrence.source,
        "occurrence_assumed": int(plan.occurrence.assumed),
        "direction_convention": "from, clockwise from north; waves travel to b = (180 - direction) mod 360",
    }


def _write_results(
    result: CampaignResult,
    store: ResultStore,
    keys: Mapping[Place, str],
    folder: Path,
    attributes: dict[str, Any],
) -> None:
    """Write the dataset and the tables from the files of the cases."""
    plan = result.plan
    outcomes = _Outcomes(store, keys, result.failed)
    result.sample = _sample(plan, outcomes)
    if result.sample is None:
        _remove_results(folder)
        return
    mesh = result.mesh = build_mesh(case_structure(result.sample.case.structure))
    design_fatigue_factor = result.sample.case.fatigue.design_fatigue_factor
    case = result.sample.case.model_dump(mode="json")
    del case["sea_state"], case["wave"]["order"]  # of the cases; those of the file are its dimensions
    attributes |= {
        "structure": mesh.structure.name,
        "model_hash": mesh.structure.content_hash,
        "reduction": result.sample.reduction,
        "sn_curve": result.sample.fatigue.curve.name,
        "case": json.dumps(case),
        "notes": "\n".join((*result.sample.notes, *result.sample.fatigue.hot_spots.notes)),
    }
    partial = folder / f".{RESULTS}.partial"
    builders = {order: TotalsBuilder(plan.occurrence.probability) for order in plan.orders}
    of_both = {order: TotalsBuilder(plan.occurrence.probability) for order in plan.orders}
    with (
        CampaignFile(partial, plan, result.sample, mesh, attributes) as file,
        CampaignTables(folder / TABLES, plan, mesh.end_name, attributes) as tables,
    ):
        for row in range(len(plan.table.rows)):
            found: dict[int, dict[int, CaseOutcome]] = {order: {} for order in plan.orders}
            for order in plan.orders:
                for seed in plan.seeds:
                    place = Place(row, seed, order)
                    outcome = outcomes.get(place)
                    if outcome is None:
                        message = result.failed.get(place, "")
                        file.write_failed(place, keys.get(place, ""), message)
                        tables.add_failed(place, keys.get(place, ""), message)
                        continue
                    found[order][seed] = outcome
                    file.write(place, keys[place], outcome)
                    tables.add(place, keys[place], outcome)
                    full = outcomes.get(Place(row, seed, order, full=True))
                    if full is not None:
                        errors = errors_against_full(outcome, full)
                        file.write_errors(place, errors)
                        tables.add_errors(place, errors, outcome)
            both = set.intersection(*(set(of) for of in found.values()))
            for order, of in found.items():
                builders[order].add_row(row, list(of.values()))
                of_both[order].add_row(row, [of[seed] for seed in plan.seeds if seed in both])
        result.totals, result.compared = (
            {o: made for o, b in some.items() if (made := b.totals()) is not None}
            for some in (builders, of_both)
        )
        if result.totals:
            file.write_totals(result.totals, design_fatigue_factor)
            tables.add_totals(result.totals, result.sample, design_fatigue_factor)
    partial.replace(folder / RESULTS)


def _sample(plan: CampaignPlan, outcomes: _Outcomes) -> CaseOutcome | None:
    """The first outcome in the order of the plan, none of the unreduced model, with the case asked for.

    The case of a kept outcome may differ in what changes no number of it.
    """
    for place, case in zip(plan.places, plan.cases, strict=True):
        found = None if place.full else outcomes.get(place)
        if found is not None:
            return replace(found, case=case)
    return None


class _Outcomes:
    """Outcomes by their place, read when they are asked for."""

    def __init__(self, store: ResultStore, keys: Mapping[Place, str], failed: Mapping[Place, str]) -> None:
        self._store, self._keys, self._failed = store, keys, failed

    def get(self, place: Place) -> CaseOutcome | None:
        """The outcome of a case; None if it failed."""
        if place in self._failed or place not in self._keys:
            return None
        data = self._store.get(self._keys[place])
        if data is None:
            raise InputError(
                "output", str(self._store.path(self._keys[place])), "was changed while the campaign ran",
                "Run it again with --resume.",
            )  # fmt: skip
        return decode_outcome(data)
