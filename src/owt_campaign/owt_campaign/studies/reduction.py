"""Reduced models over the load-case table: thesis chapter 6.2, figures 6.1 to 6.3, tables 6.1 and 6.2."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.engine import evaluate_case, prepare_model
from owt_campaign.standard_load import standard_load_basis
from owt_campaign.studies.cases import MODEL
from owt_campaign.studies.reduction_runs import (
    CLUSTERS,
    PLAIN,
    SPECIFIC,
    SeaErrors,
    cluster_of,
    table_errors,
)
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import (
    Cell,
    cell_case,
    few_cells,
    load_case_table,
)
from owt_campaign.studies.store import Store
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.response import build_modal_model

__all__ = ["COUNT", "LIMIT", "ReductionStudy", "further_seeds", "reduction_study"]

#: Error of a frequency beyond which the thesis calls a model no longer accurate.
LIMIT = 0.01
#: Frequencies of the turbine that figure 6.1 may show.
COUNT = 40


@dataclass(frozen=True)
class ReductionStudy:
    """What the study found.

    Attributes
    ----------
    errors : dict
        By seed and cell, errors of all models; clusters are made of seed 1.
    frequency : dict of float arrays [mode]
        Frequencies of the turbine in Hz, unreduced ("full") and by each reduction.
    seconds : dict of float
        CPU seconds of response and stress of one sea state, unreduced and reduced.
    size : dict of int
        Degrees of freedom of both.
    models : dict of int
        Number of reduced models of each strategy, for all seeds of the table.
    """

    errors: dict[int, dict[Cell, SeaErrors]]
    frequency: dict[str, Float[np.ndarray, " mode"]]
    seconds: dict[str, float]
    size: dict[str, int]
    models: dict[str, int]

    def values(
        self, model: str, of: str = "mean", seeds: tuple[int, ...] | None = None
    ) -> Float[np.ndarray, " run"]:
        """Errors of a model in all runs, or in those of some seeds; `of` names an attribute of SeaErrors."""
        return np.array(
            [
                getattr(errors, of)[model]
                for seed, cells in self.errors.items()
                if seeds is None or seed in seeds
                for errors in cells.values()
            ]
        )

    def spread(self, measure: Callable[[tuple[int, ...]], float]) -> tuple[float, float]:
        """Lowest and highest over the seeds of what `measure` makes of one of them."""
        values = [measure((seed,)) for seed in self.errors]
        return min(values), max(values)

    def reach_hz(self, model: str) -> tuple[float, float]:
        """Frequencies in Hz of the mode before the first that errs by more than :data:`LIMIT`, and of that.

        Both are those of the unreduced turbine; infinity where no mode errs so much.
        """
        full, own = self.frequency["full"], self.frequency[model]
        n = min(len(full), len(own))
        beyond = np.flatnonzero(np.abs(own[:n] / full[:n] - 1.0) > LIMIT)
        if not len(beyond):
            return float(full[n - 1]), float("inf")
        return float(full[beyond[0] - 1]), float(full[beyond[0]])

    def without_norm(self, model: str, of: str = "mean") -> tuple[float, float]:
        """Median error of *tot* of loads as they are, over that of *tot*: lowest and highest third of Hs."""
        cells = [cell.hs_m for runs in self.errors.values() for cell in runs]
        low, high = np.quantile(cells, (1.0 / 3.0, 2.0 / 3.0))
        plain, norm = self.values(f"{model} {PLAIN}", of), self.values(f"{model} tot", of)
        thirds = (np.array(cells) <= low, np.array(cells) >= high)
        first, last = (float(np.median(plain[some]) / np.median(norm[some])) for some in thirds)
        return first, last


def reduction_study(*, full: bool, progress: Progress) -> ReductionStudy:
    """Run the study."""
    cells = list(load_case_table()) if full else few_cells()
    others = further_seeds(cells, full=full)
    errors = table_errors(cells, others, samples=6000 if full else 1200, store=Store(), progress=progress)
    models = {"spec": 3 * len(cells)}
    models |= {c: len({cluster_of(cell, c) for cell in cells}) for c in CLUSTERS}
    seconds, size = _times(cells[-1], 6000 if full else 600)
    return ReductionStudy(errors, _frequencies(), seconds, size, models)


def further_seeds(cells: Sequence[Cell], *, full: bool) -> dict[int, Sequence[Cell]]:
    """Sea states of further seeds, which the clusters have not seen."""
    return {2: cells, 3: cells} if full else {2: cells[:1], 3: cells[-1:]}


def _frequencies() -> dict[str, Float[np.ndarray, " mode"]]:
    """Frequencies of the turbine; load vectors as in table B.1."""
    structure = load_structure(MODEL)
    mesh, basis = build_mesh(structure), standard_load_basis(structure, 20)
    return {name: build_modal_model(mesh, name, basis).frequency_hz[:COUNT] for name in ("full", *SPECIFIC)}


def _times(cell: Cell, samples: int) -> tuple[dict[str, float], dict[str, int]]:
    """CPU seconds of response and stress at 0.02 s, and degrees of freedom."""
    seconds, size = {}, {}
    for name in ("full", "CB10M10"):
        case = cell_case(cell, samples=samples, reduction=name)
        model = prepare_model(case)
        start = time.process_time()
        outcome = evaluate_case(case, model, keep=["coordinate"])
        spent = time.process_time() - start
        share = outcome.stage_seconds["response and stress"] / sum(outcome.stage_seconds.values())
        seconds[name] = spent * share
        size[name] = model.mesh.n_dof if name == "full" else outcome.series["coordinate"].shape[1]
    return seconds, size


def ordered(
    study: ReductionStudy, model: str, measure: Callable[..., float] = np.median
) -> list[tuple[str, float]]:
    """Errors of the strategies of a model, each by its `measure` over all runs, in the order of the print."""
    names = [model, *(f"{model} {clustering}" for clustering in CLUSTERS)]
    return [(name, float(measure(study.values(name)))) for name in names]
