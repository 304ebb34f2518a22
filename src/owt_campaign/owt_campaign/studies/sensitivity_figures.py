"""Figures of the sensitivity study: thesis figures 5.5 to 5.7."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.jacket_figures import levels
from owt_campaign.studies.plotting import BLUE, COLOURS, INK, ORANGE, canvas
from owt_campaign.studies.sensitivity import STRUCTURES, Sensitivity
from owt_campaign.studies.stress_runs import STEP_S
from owt_campaign.studies.wave_totals import by_member

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["energy_figure", "ratio_figure", "stress_figure"]


def stress_figure(found: Sensitivity) -> Figure:
    """Figure 5.5: total stress of the three structures."""
    figure, panels = canvas(1, 3, (9.5, 3.8), share_y=True, share_x=True)
    top = by_member(found.tables["reference"].total(SECOND_ORDER, weights="alike")).max()
    for panel, colour, name in zip(panels[0], COLOURS, STRUCTURES, strict=False):
        levels(
            panel,
            found.members,
            by_member(found.tables[name].total(SECOND_ORDER, weights="alike")) / top,
            colour,
        )
        panel.set(title=f"{name} model")
    for panel in panels[0, 1:]:
        panel.set(ylabel="")
    figure.supxlabel("total stress, over the largest of the reference; legs filled, braces open", fontsize=9)
    return figure


def ratio_figure(found: Sensitivity) -> Figure:
    """Figure 5.6: second order over linear on the three structures."""
    figure, panels = canvas(1, 3, (9.5, 3.8), share_y=True, share_x=True)
    for panel, colour, name in zip(panels[0], COLOURS, STRUCTURES, strict=False):
        levels(panel, found.members, 100.0 * (found.tables[name].ratio(None, LINEAR, "alike") - 1.0), colour)
        panel.axvline(0.0, color=INK, lw=0.8)
        panel.set(title=f"{name} model")
    for panel in panels[0, 1:]:
        panel.set(ylabel="")
    figure.supxlabel(
        "increase of the total stress by the second order [%]; legs filled, braces open", fontsize=9
    )
    return figure


def energy_figure(found: Sensitivity) -> Figure:
    """Figure 5.7: kinetic energy in the highest sea state, seed 1, round its largest value."""
    figure, panels = canvas(3, 1, (8.0, 6.0), share_x=False)
    top = found.trace[f"reference, {LINEAR}"].max()
    for panel, name in zip(panels[:, 0], STRUCTURES, strict=True):
        middle = int(found.trace[f"{name}, {LINEAR}"].argmax())
        window = slice(max(middle - 200, 0), middle + 201)
        for colour, wave in ((BLUE, LINEAR), (ORANGE, SECOND_ORDER)):
            series = found.trace[f"{name}, {wave}"][window] / top
            panel.plot(STEP_S * (window.start + np.arange(len(series))), series, color=colour, label=wave)
        panel.set(title=f"{name} model")
    panels[2, 0].set(xlabel="t [s]")
    figure.supylabel("kinetic energy, over the largest linear one of the reference", fontsize=9)
    panels[0, 0].legend()
    return figure
