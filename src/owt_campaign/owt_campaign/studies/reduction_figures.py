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


#: Smaller errors in percent are drawn here.
FLOOR = 1e-5


def frequency_figure(study: ReductionStudy) -> Figure:
    """Figure 6.1: errors of the frequencies."""
    figure, panels = canvas(1, 1, (7.5, 3.4))
    panel, full = panels[0, 0], study.frequency["full"]
    for colour, name in zip(COLOURS, SPECIFIC, strict=False):
        own = study.frequency[name][: len(full)]
        error = 100.0 * np.abs(own / full[: len(own)] - 1.0)
        look = {"color": colour, "marker": "o", "ms": 2.5, "lw": 1.0}
        panel.semilogy(full[: len(own)], np.maximum(error, FLOOR), label=name, **look)
    panel.axhline(100.0 * LIMIT, color=INK, lw=0.8, ls=":", label="1 %")
    panel.set(
        xlabel=f"frequency of the unreduced turbine [Hz]; errors below {FLOOR:g} % are drawn there",
        ylabel="error [%]",
        xlim=(0.0, 9.0),
    )
    panel.legend()
    return figure


def models_figure(study: ReductionStudy) -> Figure:
    """Figure 6.2: errors in all sea states, of the bases of their own loads."""
    return _errors(study, {"": list(SPECIFIC)})


def clusters_figure(study: ReductionStudy) -> Figure:
    """Figure 6.3: errors in all sea states, of clustered bases, one row per model."""
    names = {
        model: [f"{model}{'' if c == 'spec' else ' ' + c}" for c in ("spec", *CLUSTERS)]
        for model in CLUSTERED
    }
    return _errors(study, names, limit=LIMIT)


def _errors(study: ReductionStudy, rows: dict[str, list[str]], limit: float | None = None) -> Figure:
    """One row of panels for each group of models."""
    figure, panels = canvas(len(rows), 2, (9.5, 0.8 + 2.8 * len(rows)), share_x=True, share_y=True)
    for line, names in zip(panels, rows.values(), strict=True):
        for panel, of in zip(line, TITLES, strict=True):
            for colour, name in zip(COLOURS, names, strict=False):
                values = 100.0 * study.values(name, of, (1,))
                look = {"marker": "o", "ms": 2.6, "ls": "", "color": colour}
                panel.semilogy(np.arange(1, len(values) + 1), values, label=name, **look)
            if limit is not None:
                panel.axhline(
                    100.0 * limit, color=INK, lw=0.8, ls=":", label=f"print: below {100.0 * limit:g} %"
                )
        line[0].set(ylabel="error [%]")
        line[1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for panel, title in zip(panels[0], TITLES.values(), strict=True):
        panel.set(title=title)
    for panel in panels[-1]:
        panel.set(xlabel="sea state of seed 1, by rising Hs")
    return figure
