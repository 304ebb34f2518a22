"""Figures of the studies: the only module that imports matplotlib, itself imported when one is drawn."""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

__all__ = [
    "BLUE",
    "COLOURS",
    "FAINT",
    "GREEN",
    "GRID",
    "INK",
    "ORANGE",
    "PURPLE",
    "TEAL",
    "canvas",
    "frame",
    "legend",
    "save",
]

INK, FAINT, GRID = "#1c2733", "#8a96a3", "#e3e7eb"
BLUE, ORANGE, GREEN, TEAL, PURPLE = "#1f5f99", "#c8602b", "#3a7d44", "#2a8c82", "#7a4b94"
#: Colours of series, in order.
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, TEAL, FAINT)
#: Dots per inch, and colours kept in a file: lines need few.
DPI, SHADES = 110, 255
_STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
}


def canvas(
    rows: int = 1,
    columns: int = 1,
    size: tuple[float, float] = (9.0, 3.6),
    *,
    share_x: bool | Literal["none", "all", "row", "col"] = False,
    share_y: bool | Literal["none", "all", "row", "col"] = False,
    **more: Any,
) -> tuple[Figure, Any]:
    """A figure in the style of the studies, and its panels as an array [rows, columns].

    Parameters
    ----------
    rows, columns : int
        Panels.
    size : tuple of float
        Width and height in inch.
    share_x, share_y
        As matplotlib's ``subplots``, which takes `more` too.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(rows, columns, squeeze=False, sharex=share_x, sharey=share_y, **more)
    return figure, panels


def frame(
    panel: Axes,
    segments: Iterable[Float[np.ndarray, "point 2"]],
    *,
    colour: str = BLUE,
    width: float = 1.0,
    **more: Any,
) -> None:
    """Draw lines of a structure, seen from one side: no axes, one scale."""
    for line in segments:
        panel.plot(line[:, 0], line[:, 1], color=colour, lw=width, solid_capstyle="round", **more)
    panel.set_aspect("equal")
    panel.axis("off")


def legend(panel: Axes, **more: Any) -> None:
    """A legend in the style of the studies; `more` as matplotlib's ``legend`` takes it."""
    panel.legend(**{"frameon": False, "fontsize": 8, **more})


def save(figure: Figure, path: Path) -> None:
    """Write a figure as a small PNG: few colours, and no date in it."""
    raw = io.BytesIO()
    with mpl.rc_context(_STYLE):
        figure.savefig(raw, format="png", dpi=DPI, metadata={"Software": None})
    raw.seek(0)
    with Image.open(raw) as image:
        few = image.convert("RGB").quantize(SHADES, dither=Image.Dither.NONE)
    with path.open("wb") as stream:
        few.save(stream, format="png", optimize=True)
