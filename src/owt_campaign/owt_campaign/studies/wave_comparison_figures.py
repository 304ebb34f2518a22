"""Figures of the wave comparison: thesis figures 5.1 to 5.4."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.jacket_figures import jacket, levels
from owt_campaign.studies.plotting import BLUE, COLOURS, FAINT, INK, ORANGE, canvas
from owt_campaign.studies.stress_runs import BIN_PA, STEP_S
from owt_campaign.studies.wave_comparison import BANDS, WaveComparison
from owt_campaign.studies.wave_totals import by_member

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["energy_figure", "ranges_figure", "spectra_figure", "stress_figure"]


def stress_figure(found: WaveComparison, focus: dict[str, int]) -> Figure:
    """Figure 5.1: total stress and its ratio over the members."""
    figure, panels = canvas(1, 3, (9.5, 4.6), share_y=True, gridspec_kw={"width_ratios": (1, 0.7, 1.2)})
    total = by_member(found.table.total(SECOND_ORDER))
    levels(panels[0, 0], found.members, total / total.max(), BLUE)
    panels[0, 0].set(xlabel="total stress, over the largest", title="second order")
    jacket(panels[0, 1], found.mesh, focus)
    for colour, wave in zip(COLOURS[1:], found.table.linears, strict=False):
        increase = 100.0 * (found.table.ratio(linear=wave) - 1.0)
        levels(panels[0, 2], found.members, increase, colour, wave)
    panels[0, 2].set(
        xlabel="second order over linear, total stress [%]", ylabel="", title="mean of the seeds"
    )
    panels[0, 2].axvline(0.0, color=INK, lw=0.8)
    panels[0, 2].axvspan(1.0, 6.0, color=FAINT, alpha=0.2, lw=0, label="print: 1 to 6 %")
    panels[0, 2].legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    return figure


def ranges_figure(found: WaveComparison, end: str) -> Figure:
    """Figure 5.2: weighted occurrence of the ranges of focus member 3."""
    figure, panels = canvas(1, 2, (9.0, 3.2))
    place = found.leg_end_name.index(end)
    for panel, (low, high) in zip(panels[0], ((0.0, 2e5), (6e5, 8e5)), strict=True):
        for colour, wave in ((BLUE, LINEAR), (ORANGE, SECOND_ORDER)):
            count = found.table.total(wave, part="leg_ranges")[place]
            edge = BIN_PA * np.arange(len(count) + 1)
            shown = (edge[:-1] >= low - 1.0) & (edge[1:] <= high + 1.0)
            panel.stairs(count[shown], np.append(edge[:-1][shown], high) / 1e6, color=colour, label=wave)
        panel.set(xlabel="range of the von Mises stress [MPa]", ylabel="cycles in 600 s, weighted")
    panels[0, 0].legend()
    return figure


def spectra_figure(found: WaveComparison) -> Figure:
    """Figure 5.3: spectra of the stress in focus member 2."""
    figure, panels = canvas(1, 1, (7.0, 3.4))
    panel = panels[0, 0]
    for colour, (tp, (frequency, power)) in zip(COLOURS, found.spectra.items(), strict=False):
        panel.semilogy(frequency, power / 1e12, color=colour, lw=1.0, label=f"Tp {tp:g} s")
        panel.axvline(1.0 / tp, color=colour, lw=0.8, ls=":")
    for low, high in BANDS.values():
        panel.axvspan(low, high, color=FAINT, alpha=0.2, lw=0)
    highest = max(power.max() for _, power in found.spectra.values()) / 1e12
    panel.set(
        xlim=(0.0, 1.6), ylim=(1e-7 * highest, 2.0 * highest),
        xlabel="frequency [Hz]; dotted: peak of the waves; grey: modes 1, 2 and 3, 4",
        ylabel="normal stress [MPa2/Hz]",
    )  # fmt: skip
    panel.legend()
    return figure


def energy_figure(found: WaveComparison) -> Figure:
    """Figure 5.4: kinetic energy round its largest value in the highest sea state, seed 1."""
    figure, panels = canvas(1, 1, (8.0, 3.2))
    top = found.trace[LINEAR].max()
    middle = int(found.trace[LINEAR].argmax())
    window = slice(max(middle - 200, 0), middle + 201)
    for colour, wave in ((BLUE, LINEAR), (ORANGE, SECOND_ORDER)):
        series = found.trace[wave][window] / top
        panels[0, 0].plot(STEP_S * (window.start + np.arange(len(series))), series, color=colour, label=wave)
    panels[0, 0].set(xlabel="t [s]", ylabel="kinetic energy, over the largest linear")
    panels[0, 0].legend()
    return figure
