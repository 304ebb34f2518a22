"""Look and parts of the report's figures: plain Plotly descriptions, no plotting library at run time."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

__all__ = [
    "BLUE",
    "FAINT",
    "GRID",
    "INK",
    "MOST_POINTS",
    "MOST_SAMPLES",
    "ORANGE",
    "SCALE",
    "TEAL",
    "Figure",
    "axis",
    "envelope",
    "layout",
    "log_axis",
    "numbers",
]

INK, GRID, FAINT = "#1c2733", "#e3e7eb", "#66727f"
BLUE, ORANGE, TEAL = "#1f5f99", "#c8602b", "#2a8c82"
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, Helvetica, Arial, sans-serif"
#: Longest line drawn, in points; longer ones are drawn as their envelope.
MOST_POINTS = 3000
#: Longest line of which the page holds all samples, to be drawn when one zooms in.
MOST_SAMPLES = 40_000
#: Colours from little to much: ever darker, so that grey paper and all colour blindness keep the order.
SCALE: list[tuple[float, str]] = [
    (0.0, "#dbe4ea"), (0.25, "#f3c77b"), (0.5, "#e5834a"), (0.75, "#b3294c"), (1.0, "#4a0d3f"),
]  # fmt: skip


@dataclass(frozen=True)
class Figure:
    """A Plotly figure with the words around it; `height` in pixels.

    ``extra`` is what the page's script needs besides: ``samples``, all samples of lines that are drawn as
    their envelope until one zooms in, and ``measures``, the quantities that a figure can be coloured by.
    ``html`` stands above the plot: a selector, or what takes its place on paper.
    """

    key: str
    title: str
    caption: str
    data: list[dict[str, Any]]
    layout: dict[str, Any]
    height: int = 320
    extra: Mapping[str, Any] = field(default_factory=dict)
    html: str = ""


def envelope(
    x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"], most: int = MOST_POINTS
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"], int]:
    """Thin out a line without losing a peak: first, lowest, highest and last sample of each interval.

    Returns
    -------
    x, y : float arrays [m]
        Samples of the line, in order.
    interval : int
        Samples per interval; 1 where the line is complete.
    """
    n = len(x)
    if n <= most:
        return x, y, 1
    interval = int(np.ceil(4 * n / most))
    whole = n // interval * interval
    rows, start = y[:whole].reshape(-1, interval), np.arange(0, whole, interval)
    keep = [np.array([0, n - 1]), start, start + interval - 1]
    keep += [start + rows.argmin(axis=1), start + rows.argmax(axis=1)]
    if whole < n:
        keep.append(whole + np.array([y[whole:].argmin(), y[whole:].argmax()]))
    index = np.unique(np.concatenate(keep))
    return x[index], y[index], interval


def numbers(values: Float[np.ndarray, " n"]) -> dict[str, str]:
    """An array as Plotly's typed array, in single precision: enough for a screen."""
    raw = np.ascontiguousarray(values, dtype="<f4").tobytes()
    return {"dtype": "f4", "bdata": base64.b64encode(raw).decode("ascii")}


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis in the style of the report."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": GRID,
        "linecolor": FAINT,
        "zerolinecolor": FAINT,
        "zerolinewidth": 1,
        "ticks": "outside",
        "tickcolor": FAINT,
        "automargin": True,
        **more,
    }


def log_axis(title: str, low: float, high: float, *, labels: tuple[int, ...] = (1,)) -> dict[str, Any]:
    """A logarithmic axis from `low` to `high`, labelled at these multiples of the powers of ten."""
    decades = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    if len(decades) > 7:
        decades = decades[::2]
    values = [float(m * 10.0**d) for d in decades for m in labels if low <= m * 10.0**d <= high * 1.0001]
    powers = len(labels) == 1 and len(decades) > 4
    text = [f"10<sup>{round(np.log10(v))}</sup>" if powers else f"{v:g}" for v in values]
    span = [float(np.log10(low)), float(np.log10(high))]
    return axis(title, type="log", range=span, tickvals=values, ticktext=text)


def layout(**more: Any) -> dict[str, Any]:
    """A layout in the style of the report."""
    return {
        "font": {"family": FONT, "size": 12, "color": INK},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "margin": {"l": 60, "r": 16, "t": 34, "b": 44},
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "xanchor": "left", "yanchor": "bottom"},
        "hovermode": "x unified",
        **more,
    }
