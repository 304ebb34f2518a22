"""Figures of the reduced models: thesis figures 6.1 to 6.3."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from owt_campaign.studies.plotting import COLOURS, INK, canvas
from owt_campaign.studies.reduction import LIMIT, ReductionStudy
from owt_campaign.studies.reduction_runs import CLUSTERED, CLUSTERS, SPECIFIC

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["clusters_figure", "frequency_figure", "models_figure"]

TITLES = {"mean": "mean of the potential energy", "std": "standard deviation of the potential energy"}


def frequency_figure(study: ReductionStudy) -> Figure:
    """Figure 6.1: errors of the frequencies."""
    figure, panels = canvas(1, 1, (7.5, 3.4))
    panel, full = panels[0, 0], study.frequency["full"]
    for colour, name in zip(COLOURS, SPECIFIC, strict=False):
        own = study.frequency[name][: len(full)]
        error = np.abs(own / full[: len(own)] - 1.0)
        panel.semilogy(
            full[: len(own)], np.maximum(error, 1e-7), color=colour, marker="o", ms=2.5, lw=1.0, label=name
        )
    panel.axhline(LIMIT, color=INK, lw=0.8, ls=":")
    panel.set(xlabel="frequency of the unreduced turbine [Hz]", ylabel="relative error", xlim=(0.0, 9.0))
    panel.legend()
    return figure


def models_figure(study: ReductionStudy) -> Figure:
    """Figure 6.2: errors in all sea states, of the bases of their own loads."""
    return _errors(study, list(SPECIFIC), "sea state, by rising Hs")


def clusters_figure(study: ReductionStudy) -> Figure:
    """Figure 6.3: errors in all sea states, of clustered bases."""
    names = [f"{name}{'' if c == 'spec' else ' ' + c}" for name in CLUSTERED for c in ("spec", *CLUSTERS)]
    return _errors(study, names, "sea state, by rising Hs; print: all below 1 %", limit=LIMIT)


def _errors(study: ReductionStudy, names: list[str], words: str, limit: float | None = None) -> Figure:
    figure, panels = canvas(1, 2, (9.5, 3.6), share_y=True)
    colours = [COLOURS[i % 4] for i in range(len(names))]
    for panel, (of, title) in zip(panels[0], TITLES.items(), strict=True):
        for i, name in enumerate(names):
            values = study.values(name, of, (1,))
            look = {"marker": "o" if i < 4 else "x", "ms": 3.0, "mew": 0.9, "ls": ""}
            panel.semilogy(
                np.arange(1, len(values) + 1), 100.0 * values, color=colours[i], label=name, **look
            )
        if limit is not None:
            panel.axhline(100.0 * limit, color=INK, lw=0.8, ls=":")
        panel.set(title=title, xlabel=words)
    panels[0, 0].set(ylabel="relative error [%]")
    panels[0, 1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure
