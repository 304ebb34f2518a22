"""Thesis appendix D: one sea state of weighted Tp against every specific Tp, in total stress.

Ratios of the mean over all member ends of the total stress (sum of range times count of the von Mises
stress), printed as increases. The specific cases are weighted by their number of occurrence.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from owt_campaign.engine import SharedModel, cluster_basis, prepare_model
from owt_campaign.studies.cases import CUTOFFS, LINEAR, SECOND_ORDER, SEEDS, study_case
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import StudyResult
from owt_campaign.studies.store import Store
from owt_campaign.studies.total_stress import total_stress
from owt_model.config import CaseConfig

__all__ = ["RATIOS", "STRUCTURES", "Run", "increases", "mean_stress", "printed", "run", "runs", "structures"]

#: Structure of each table.
STRUCTURES = {"D.1": "reference", "D.2": "frequency"}
#: Upper and lower case of each printed ratio: wave model, then weighted or specific Tp.
RATIOS = {
    "L_ref/L_spec": (("L", "ref"), ("L", "spec")),
    "NL_ref/NL_spec": (("NL", "ref"), ("NL", "spec")),
    "NL_ref/L_ref": (("NL", "ref"), ("L", "ref")),
    "NL_spec/L_spec": (("NL", "spec"), ("L", "spec")),
}
#: One basis serves all cases: second-order loads at the weighted Tp of Hs 1.5 m. Its mean total stress lies
#: within 3e-4 of the unreduced model's over cells of both heights, nearer than each case's own CB10M10.
REDUCTION = "CB20M30"
BASIS = (1.5, 9.06)
DIRECTION = 210.0  # 330 degrees of the table


@dataclass(frozen=True)
class Run:
    """One sea state.

    ``kind`` is ref (weighted Tp) or spec, ``weight`` the number of occurrence, ``number`` the column of the
    scatter diagram.
    """

    hs: float
    tp: float
    kind: str
    weight: float
    wave: str
    cutoff: str
    seed: int
    number: int

    @property
    def case(self) -> CaseConfig:
        """The case; each period has phases of its own, as in the thesis, the same for every wave model."""
        seed = self.seed if self.kind == "ref" else 1000 * self.seed + self.number
        return study_case(
            self.hs,
            self.tp,
            seed=seed,
            wave=self.wave,
            cutoff=self.cutoff,
            reduction=REDUCTION,
            direction_deg=DIRECTION,
        )


@cache
def printed() -> dict[str, Any]:
    """Tables D.1 and D.2, and the line of table 4.4 of each height."""
    text = (resources.files("owt_campaign") / "data" / "thesis_printed.json").read_text(encoding="utf-8")
    data: dict[str, Any] = json.loads(text)["load_case_table"]
    return data


def runs(hs: float, wave: str, cutoff: str, seed: int) -> Iterator[Run]:
    """The weighted Tp of a height, then every specific one that occurs."""
    scatter, key = printed()["scatter_330_deg"], f"{hs:g}"
    yield Run(hs, scatter["weighted_tp_s"][key], "ref", 1.0, wave, cutoff, seed, 0)
    for i, (tp, count) in enumerate(zip(scatter["tp_s"], scatter["occurrences"][key], strict=True)):
        if count:
            yield Run(hs, tp, "spec", float(count), wave, cutoff, seed, i + 1)


def structures(names: tuple[str, ...]) -> dict[str, SharedModel]:
    """The structures of the tables, reduced with one set of load vectors."""
    found = {}
    for name in names:
        case = study_case(*BASIS, reduction=REDUCTION, structure=STRUCTURES[name], direction_deg=DIRECTION)
        found[name] = prepare_model(case, basis=cluster_basis([case]))
    return found


def mean_stress(run: Run, models: dict[str, SharedModel], store: Store | None = None) -> dict[str, float]:
    """Mean total stress in Pa over all member ends, for each structure."""
    case = run.case
    key = ["mean total stress", BASIS, {name: model.key for name, model in models.items()}]

    def compute() -> dict[str, np.ndarray]:
        return {name: np.array(stress.mean()) for name, stress in total_stress(case, models).items()}

    found = (store or Store()).run([*key, case.model_dump(mode="json")], compute)
    return {name: float(value) for name, value in found.items()}


def increases(linear: dict[str, float], second: dict[str, float]) -> dict[str, float]:
    """The four printed increases from mean stresses, each with ``ref`` and ``spec``."""
    value = {"L": linear, "NL": second}
    return {
        name: value[over][above] / value[under][below] - 1.0
        for name, ((over, above), (under, below)) in RATIOS.items()
    }


@dataclass(frozen=True)
class Part:
    """Runs of one wave model and cut-off: for which tables, heights and seeds."""

    wave: str
    cutoff: str
    tables: tuple[str, ...]
    heights: tuple[float, ...]
    seeds: tuple[int, ...] = SEEDS

    def runs(self) -> list[tuple[Run, tuple[str, ...]]]:
        """Every run, with its tables."""
        return [
            (run, self.tables)
            for hs in self.heights
            for seed in self.seeds
            for run in runs(hs, self.wave, self.cutoff, seed)
        ]


LOW, HIGH = 1.5, 7.5
TABLE_CUTOFF, STEEP_CUTOFF = CUTOFFS
REDUCED = tuple(Part(wave, TABLE_CUTOFF, ("D.1",), (HIGH,), SEEDS[:1]) for wave in (LINEAR, SECOND_ORDER))
#: What the print hangs on, the wave models, is run for the reference model only.
OTHERS = ("linear, Wheeler", "linear, Taylor")
FULL = (
    *(Part(wave, TABLE_CUTOFF, ("D.1", "D.2"), (HIGH, LOW)) for wave in (LINEAR, SECOND_ORDER)),
    *(Part(wave, STEEP_CUTOFF, ("D.1",), (HIGH, LOW)) for wave in (LINEAR, SECOND_ORDER)),
    *(Part(wave, TABLE_CUTOFF, ("D.1",), (HIGH, LOW)) for wave in OTHERS),
)

#: (table, Hs, wave model, cut-off, seed) -> mean stress of the weighted Tp, weighted one of the specific.
Stresses = dict[tuple[str, float, str, str, int], dict[str, float]]
#: The same with the period in the key, unweighted: for the figure.
Periods = dict[tuple[str, float, str, int, float], float]


def compute(plan: tuple[Part, ...], progress: Progress) -> tuple[Stresses, Periods]:
    """Run a plan."""
    models, found = structures(plan[0].tables), {}
    periods: Periods = {}
    store = Store()
    sums: dict[tuple[str, float, str, str, int], list[float]] = {}
    every = [entry for part in plan for entry in part.runs()]
    for done, (run, tables) in enumerate(every):
        for table, stress in mean_stress(run, {name: models[name] for name in tables}, store).items():
            key = (table, run.hs, run.wave, run.cutoff, run.seed)
            if run.kind == "ref":
                found[key] = {"ref": stress}
                continue
            total = sums.setdefault(key, [0.0, 0.0])
            total[0] += run.weight * stress
            total[1] += run.weight
            if run.cutoff == TABLE_CUTOFF:
                periods[table, run.hs, run.wave, run.seed, run.tp] = stress
        progress(done + 1, len(every))
    for key, (weighted, weight) in sums.items():
        found[key]["spec"] = weighted / weight
    return found, periods


def run(*, full: bool, progress: Progress) -> StudyResult:
    """The study: all periods of two heights, two structures, four wave models, two cut-offs, three seeds."""
    from owt_campaign.studies.load_case_table_page import load_case_table_result

    plan = FULL if full else REDUCED
    stresses, periods = compute(plan, progress)
    return load_case_table_result(stresses, periods, full=full)
