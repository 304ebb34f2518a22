"""Second order against linear: thesis chapter 5.2, figures 5.1 to 5.4 and table 5.1, beside the print."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.signal import welch

from owt_campaign.studies.cases import CUTOFFS, LINEAR, SECOND_ORDER, SEEDS, WAVE_MODELS
from owt_campaign.studies.focus import Focus, focus_members
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, few_cells, load_case_table
from owt_campaign.studies.store import Store
from owt_campaign.studies.stress_runs import STEP_S, Sea, StressRuns, leg_ends
from owt_campaign.studies.wave_totals import Members, Part, TableRuns, by_member, run_table
from owt_wave_node.core.stage import WaveStage

__all__ = ["EnergyPeaks", "WaveComparison", "energy_peaks", "processes", "table_plan", "wave_comparison"]

LINEARS = tuple(name for name in WAVE_MODELS if name != SECOND_ORDER)
#: Figure 5.3: Hs 1.5 m of direction 330 deg with these Tp in s; bands round the eigenfrequencies in Hz.
SPECTRA_TP = (4.5, 9.1, 14.5)
BANDS = {"first two modes": (0.34, 0.43), "modes 3 and 4": (0.98, 1.15)}
#: Half the width in s of the window of figure 5.4, which is not printed.
WINDOWS = (5.0, 10.0, 20.0)


@dataclass(frozen=True)
class EnergyPeaks:
    """Kinetic energy of one sea state round its largest value, second order over linear.

    Attributes
    ----------
    factor : dict of float
        Ratio of the mean energies in the window round the largest linear energy, by half its width in s.
    whole : float
        The same over the whole record.
    largest : float
        Ratio of the largest energies.
    time_s : float
        Time of the largest linear energy.
    """

    factor: dict[float, float]
    whole: float
    largest: float
    time_s: float


def energy_peaks(linear: Float[np.ndarray, " sample"], second: Float[np.ndarray, " sample"]) -> EnergyPeaks:
    """Compare two kinetic energies in J of the same sea, sampled at the step of the runs."""
    top = int(linear.argmax())
    factor = {}
    for half in WINDOWS:
        reach = round(half / STEP_S)
        window = slice(max(top - reach, 0), top + reach + 1)
        factor[half] = float(second[window].mean() / linear[window].mean())
    return EnergyPeaks(
        factor=factor,
        whole=float(second.mean() / linear.mean()),
        largest=float(second.max() / linear.max()),
        time_s=top * STEP_S,
    )


@dataclass(frozen=True)
class WaveComparison:
    """What the study found.

    Attributes
    ----------
    table : TableRuns
        Reference structure over the table.
    members : Members
    focus : Focus
        Members that the text looks at.
    leg_end_name : tuple of str
        Ends whose ranges are binned.
    peaks : dict of lists of EnergyPeaks
        Highest sea state by (linear model, cut-off), one per seed.
    trace : dict of float arrays [sample]
        Kinetic energy in J of the highest sea state, seed 1, by wave model.
    spectra : dict of arrays [2, frequency]
        Frequencies in Hz and spectrum in Pa2/Hz of the normal stress of focus member 2, by Tp.
    seconds : dict of float
        CPU seconds of waves and loads of the default sea by wave model.
    """

    table: TableRuns
    members: Members
    focus: Focus
    leg_end_name: tuple[str, ...]
    peaks: dict[tuple[str, str], list[EnergyPeaks]]
    trace: dict[str, Float[np.ndarray, " sample"]]
    spectra: dict[float, Float[np.ndarray, "2 frequency"]]
    seconds: dict[str, float]
    mesh: Any

    @property
    def tried(self) -> list[str]:
        """Linear models that the highest sea state ran."""
        return list(dict.fromkeys(wave for wave, _ in self.peaks))

    def band_share(self, tp: float) -> dict[str, float]:
        """Share of the variance of the stress in the bands round the eigenfrequencies."""
        frequency, power = self.spectra[tp]
        total = power.sum()
        return {
            name: float(power[(frequency >= low) & (frequency <= high)].sum() / total)
            for name, (low, high) in BANDS.items()
        }


def wave_comparison(*, full: bool, progress: Progress) -> WaveComparison:
    """Run the study."""
    cells = load_case_table()
    some = list(cells) if full else few_cells()
    samples = 6000 if full else 1200
    runs = StressRuns(samples=samples, store=Store())
    table = run_table(samples, table_plan(some, full=full), progress, workers=processes(full=full))[
        "reference"
    ]
    mesh = runs.mesh
    peaks, trace = _highest(runs, cells[-1], range(1, 6) if full else range(1, 4), full)
    members = Members.of(mesh)
    total = table.total(SECOND_ORDER)
    focus = focus_members(mesh, members, by_member(total))
    end = 2 * focus.half_way + int(total[2 * focus.half_way + 1] > total[2 * focus.half_way])
    spectra = {tp: _spectrum(runs, tp, mesh.end_name[end]) for tp in SPECTRA_TP}
    return WaveComparison(
        table=table,
        members=members,
        focus=focus,
        leg_end_name=tuple(mesh.end_name[end] for end in leg_ends(mesh)),
        peaks=peaks,
        trace=trace,
        spectra=spectra,
        seconds={wave: _load_seconds(runs, wave) for wave in WAVE_MODELS},
        mesh=mesh,
    )


def table_plan(cells: Sequence[Cell], *, full: bool) -> list[Part]:
    """Runs of chapter 5: three seeds; all structures with the two wave models that are compared throughout.

    The reduced version runs two sea states of direction 330 degrees, on the reference structure.
    """
    structures, alone = ("reference", "damping", "frequency"), ("reference",)
    others = [name for name in LINEARS if name != LINEAR]
    some = cells if full else cells[-2:]
    plan: list[Part] = [
        (seed, wave, some, structures if full else alone) for seed in SEEDS for wave in (SECOND_ORDER, LINEAR)
    ]
    return plan + [(seed, wave, some, alone) for seed in (SEEDS if full else SEEDS[:1]) for wave in others]


def processes(*, full: bool) -> int:
    """Processes that a study takes: all that there are, or its own for the reduced version."""
    return len(os.sched_getaffinity(0)) if full else 0


def _highest(
    runs: StressRuns, cell: Cell, seeds: range, full: bool
) -> tuple[dict[tuple[str, str], list[EnergyPeaks]], dict[str, Float[np.ndarray, " sample"]]]:
    """Kinetic energies of the highest sea state."""
    peaks: dict[tuple[str, str], list[EnergyPeaks]] = {}
    trace: dict[str, Float[np.ndarray, " sample"]] = {}
    for cutoff in CUTOFFS if full else list(CUTOFFS)[:1]:
        for seed in seeds:
            kinetic = {
                wave: runs.series(Sea(cell, seed, wave, cutoff), ["kinetic"])["kinetic"]
                for wave in (WAVE_MODELS if full else (SECOND_ORDER, LINEAR))
            }
            trace = trace or kinetic
            for wave in kinetic:
                if wave != SECOND_ORDER:
                    found = energy_peaks(kinetic[wave], kinetic[SECOND_ORDER])
                    peaks.setdefault((wave, cutoff), []).append(found)
    return peaks, trace


def _spectrum(runs: StressRuns, tp: float, end: str) -> Float[np.ndarray, "2 frequency"]:
    """Spectrum of the normal stress by normal force, linear waves."""
    stress = runs.series(Sea(Cell(1.5, 330.0, tp), 1, LINEAR), [f"stress {end}"])[f"stress {end}"][:, 0]
    frequency, power = welch(stress, 1.0 / STEP_S, nperseg=min(1024, len(stress)))
    return np.array([frequency, power])


def _load_seconds(runs: StressRuns, wave: str) -> float:
    """CPU seconds of waves and loads of one sea state, the least of several."""
    model, case = runs.model("reference"), runs.case(Sea(load_case_table()[-1], 1, wave))
    seconds = []
    for _ in range(4):
        start = time.process_time()
        WaveStage(case, model.mesh, hydro=model.hydro).history()
        seconds.append(time.process_time() - start)
    return min(seconds)
