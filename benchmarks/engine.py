"""One case of a campaign: the engine beside the pipeline that ``./owt simulate`` runs, on one thread."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.measure import Table, Timing, process, timing

if TYPE_CHECKING:
    from owt_campaign.engine import SharedModel
    from owt_model.config import CaseConfig

#: Relative difference of damage and stress from the pipeline's: round-off of sums in another order.
ROUND_OFF = 1e-9
REPEATS = 3


def bench_engine(table: Table) -> None:
    """Both orders with CB10M10, shared load vectors, the unreduced model, and the memory of a worker."""
    before = os.environ.get("OWT_THREADS")
    os.environ["OWT_THREADS"] = "1"
    try:
        _bench(table)
    finally:
        if before is None:
            del os.environ["OWT_THREADS"]
        else:
            os.environ["OWT_THREADS"] = before


def _case(order: int, reduction: str) -> CaseConfig:
    from owt_model.config import parse_case

    return parse_case(
        {
            "sea_state": {"hs_m": 6.0, "tp_s": 9.45, "direction_deg": 210.0, "seed": 1},
            "wave": {"order": order},
            "structure": {"model": "oc4-thesis", "reduction": reduction},
        }
    )


def _bench(table: Table) -> None:
    from owt_campaign.engine import cluster_basis, evaluate_case, prepare_model

    case, first, full = _case(2, "CB10M10"), _case(1, "CB10M10"), _case(2, "full")
    model = prepare_model(case)
    _reduced(table, case, model, 2)
    basis = timing(lambda: cluster_basis([case], model), REPEATS)
    shared = model.with_basis(case, cluster_basis([case], model))
    found = timing(lambda: evaluate_case(case, shared), REPEATS)
    table.add("engine", "  with load vectors shared by a cluster", found)
    table.add("engine", "  its part of the cluster's vectors", basis)
    _reduced(table, first, model, 1)
    whole = prepare_model(full)
    found = timing(lambda: evaluate_case(full, whole), 2)
    table.add("engine", "one case of 600 s, order 2, full model", found)
    worker = process([sys.executable, "-m", "benchmarks.engine"], {"OWT_THREADS": "1"})
    table.add("engine", "a process that evaluates three cases", worker)


def _reduced(table: Table, case: CaseConfig, model: SharedModel, order: int) -> None:
    """One order, against the pipeline, and its stages."""
    from owt_campaign.engine import evaluate_case
    from owt_campaign.pipeline import run_case

    _check(evaluate_case(case, model), run_case(case))
    beside = {"the pipeline, with blocks and report": timing(lambda: run_case(case), 2).wall}
    found = timing(lambda: evaluate_case(case, model), REPEATS)
    table.add("engine", f"one case of 600 s, order {order}, CB10M10, sea to damage", found, beside)
    for stage, seconds in evaluate_case(case, model).stage_seconds.items():
        if seconds > 1e-3:
            table.add("engine", f"  {stage}", Timing(seconds, seconds))


def _check(ours: Any, theirs: Any) -> None:
    """Same cycles at every hot spot, same damage and total stress to round-off."""
    reference = theirs.report.fatigue
    assert np.array_equal(ours.fatigue.cycles, reference.cycles)
    for name in ("damage", "total_stress", "max_range"):
        found, wanted = getattr(ours.fatigue, name), getattr(reference, name)
        error = np.abs(found - wanted).max() / np.abs(wanted).max()
        assert error < ROUND_OFF, f"{name} differs by {error:.1e}"


if __name__ == "__main__":
    from owt_campaign.engine import evaluate_case, prepare_model

    case = _case(2, "CB10M10")
    model = prepare_model(case)
    for _ in range(3):
        evaluate_case(case, model)
