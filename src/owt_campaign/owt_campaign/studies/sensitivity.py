"""Damping and frequency model against the reference: thesis chapter 5.3, figures 5.5 to 5.7."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, few_cells, load_case_table
from owt_campaign.studies.store import Store
from owt_campaign.studies.stress_runs import Sea, StressRuns
from owt_campaign.studies.wave_comparison import EnergyPeaks, energy_peaks, processes, table_plan
from owt_campaign.studies.wave_totals import Members, Part, TableRuns, by_member, run_table
from owt_model.mesh import Mesh

__all__ = ["STRUCTURES", "Sensitivity", "sensitivity_study"]

STRUCTURES = ("reference", "frequency", "damping")


@dataclass(frozen=True)
class Sensitivity:
    """What the study found.

    Attributes
    ----------
    tables : dict of TableRuns
        Runs over the table by structure.
    members : Members
    peaks : dict of lists of EnergyPeaks
        Highest sea state, second order over linear by structure, one per seed.
    mean_kinetic : dict of lists of float
        Mean kinetic energy in J of the second order there, by structure, one per seed.
    trace : dict of float arrays [sample]
        Kinetic energy in J there, seed 1, by "structure, wave model".
    """

    tables: dict[str, TableRuns]
    members: Members
    peaks: dict[str, list[EnergyPeaks]]
    mean_kinetic: dict[str, list[float]]
    trace: dict[str, Float[np.ndarray, " sample"]]
    mesh: Mesh

    def change(self, structure: str, seed: int, weights: str = "assumed") -> Float[np.ndarray, " member"]:
        """Total stress of the members by the second order, over that of the reference structure.

        Sea states that the seed ran on both; NaN for members without stress.
        """
        own, base = self.tables[structure], self.tables["reference"]
        mine, other = (t.records[seed, SECOND_ORDER] for t in (own, base))
        both = [cell for cell in mine if cell in other]
        one, two = (
            by_member(
                TableRuns({(seed, SECOND_ORDER): {cell: records[cell] for cell in both}}).total(
                    SECOND_ORDER, seed, weights=weights
                )
            )
            for records in (other, mine)
        )
        return np.asarray(np.where(one > 1e-3 * one.max(), two, np.nan) / one.clip(min=1e-300))

    @property
    def seeds(self) -> list[int]:
        """Seeds that all structures ran."""
        return sorted(set.intersection(*(set(t.seeds(LINEAR)) for t in self.tables.values())))


def _plan(cells: Sequence[Cell], *, full: bool) -> list[Part]:
    """Runs on all structures: as in the wave comparison."""
    structures = ("reference", "damping", "frequency")
    if full:
        return [part for part in table_plan(cells, full=True) if tuple(part[3]) == structures]
    return [
        (seed, wave, cells if seed == 1 else cells[-2:], structures)
        for seed in (1, 2, 3)
        for wave in (SECOND_ORDER, LINEAR)
    ]


def sensitivity_study(*, full: bool, progress: Progress) -> Sensitivity:
    """Run the study."""
    cells = list(load_case_table()) if full else few_cells()
    runs = StressRuns(samples=6000 if full else 1200, store=Store())
    both = (SECOND_ORDER, LINEAR)
    tables = run_table(runs.samples, _plan(cells, full=full), progress, workers=processes(full=full))
    peaks: dict[str, list[EnergyPeaks]] = {}
    mean: dict[str, list[float]] = {}
    trace: dict[str, Float[np.ndarray, " sample"]] = {}
    for structure in STRUCTURES:
        for seed in range(1, 6 if full else 4):
            kinetic = {
                wave: runs.series(Sea(load_case_table()[-1], seed, wave), ["kinetic"], structure)["kinetic"]
                for wave in both
            }
            peaks.setdefault(structure, []).append(energy_peaks(kinetic[LINEAR], kinetic[SECOND_ORDER]))
            mean.setdefault(structure, []).append(float(kinetic[SECOND_ORDER].mean()))
            if seed == 1:
                trace |= {f"{structure}, {wave}": series for wave, series in kinetic.items()}
    return Sensitivity(tables, Members.of(runs.mesh), peaks, mean, trace, runs.mesh)
