"""Campaigns: cases a minute, the gain of a second worker, what Dask costs, memory, and what larger ones take.

The same cases run in this process, on one worker and on two; that all give the same bits is checked before
anything is said about time. Times are without the start of the workers, which a campaign pays once.
"""

from __future__ import annotations

import resource
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.measure import Table, Timing
from owt_campaign.load_cases import case_of, german_bight
from owt_campaign.runner import CaseRecord, run_cases
from owt_campaign.store import ResultStore

__all__ = ["bench_campaign"]

#: Every tenth row of the table: low and high sea states, all directions; with two seeds, so that both of two
#: workers have the same number of them.
EVERY, SEEDS = 10, (1, 2)
#: Runs of the whole table with three seeds; cases of a full one; workers of a cluster that is projected to.
TABLE, LARGE, CLUSTER = 507, 10_000, 64


@dataclass(frozen=True)
class Run:
    """What one way gave; in s: from the first case to the last, the start, processor time of the client."""

    wall: float
    start: float
    client: float
    records: list[CaseRecord]

    @property
    def busy(self) -> float:
        """Seconds that the cases took in their workers."""
        return sum(record.seconds for record in self.records)

    @property
    def cpu(self) -> float:
        """Processor time in s of the cases."""
        return sum(record.cpu_seconds for record in self.records)

    @property
    def memory(self) -> float:
        """Largest memory of a worker in MiB."""
        return max(record.peak_memory_mib for record in self.records)


def _run(workers: int) -> Run:
    cases = [
        case_of(row, {"structure": {"reduction": "CB10M10"}}, seed=seed, order=2)
        for row in german_bight().rows[::EVERY]
        for seed in SEEDS
    ]
    begun: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        called = time.perf_counter()
        records = list(
            run_cases(
                cases, workers=workers, store=ResultStore(Path(folder)),
                on_start=lambda _: begun.append((time.perf_counter(), time.process_time())),
            )
        )  # fmt: skip
        ended, used = time.perf_counter(), time.process_time()
    # Workers import while they start; what the first case of each prepares counts as work.
    start, used_before = begun[0]
    return Run(
        ended - start, start - called, used - used_before, sorted(records, key=lambda record: record.index)
    )


def _check(runs: dict[int, Run]) -> None:
    """All ways must give the same bits."""
    for run in runs.values():
        for ours, theirs in zip(run.records, runs[0].records, strict=True):
            if ours.outcome is None or theirs.outcome is None:
                raise RuntimeError(f"a case failed: {ours.message or theirs.message}")
            if not np.array_equal(ours.outcome.fatigue.damage, theirs.outcome.fatigue.damage):
                raise RuntimeError("the number of workers changes the damage")


def bench_campaign(table: Table) -> None:
    """Cases of 600 s, second order, CB10M10, every tenth sea state of thesis table 4.5 with two seeds."""
    runs = {workers: _run(workers) for workers in (0, 1, 2)}
    _check(runs)
    part, n = "campaign", len(runs[0].records)
    for workers, run in runs.items():
        where = "in process" if workers == 0 else f"{workers} worker{'s' if workers > 1 else ''}"
        table.add(part, f"{n} cases of 600 s, second order, {where}", Timing(run.wall, run.cpu))
    one, two = runs[1], runs[2]
    table.note(part, "cases a minute, 2 workers", 60.0 * n / two.wall, "")
    table.note(part, "gain of the second worker", one.wall / two.wall, "x")
    # Time of the only worker in which no case was computed: messages, scheduling, writing of results. It
    # grows where others use the machine; processor time of the scheduler and the client does not.
    table.note(part, "time that Dask adds, 1 worker", 100.0 * (one.wall - one.busy) / one.wall, "%")
    added = 100.0 * one.client / (one.client + one.cpu)
    table.note(part, "processor time that Dask adds, 1 worker", added, "%")
    table.note(part, "start of 2 workers", two.start, "s")
    table.note(part, "largest memory of a worker", two.memory, "MiB")
    client = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    table.note(part, "peak memory of a campaign of 2 workers", 2.0 * two.memory + client, "MiB")
    table.note(part, f"projected: {TABLE} runs, 2 workers, at this rate", two.wall / n * TABLE / 60.0, "min")
    # Larger campaigns by processor time: what they take where each worker has a processor to itself.
    case, handling = one.cpu / n, one.client / n
    table.note(part, "processor time per case", case, "s")
    table.note(
        part, f"projected: {TABLE} runs on 2 free processors", (case + handling) * TABLE / 120.0, "min"
    )
    keeps_busy = case / max(handling, 1e-9)
    table.note(part, "workers that one client keeps busy", keeps_busy, "")
    table.note(
        part, f"projected: {LARGE} cases, {CLUSTER} workers",
        max(case / CLUSTER, handling) * LARGE / 60.0, "min",
    )  # fmt: skip
