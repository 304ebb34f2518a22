"""Figures of the fatigue results: damage by member end, exceedance of stress ranges, rainflow matrix."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_postproc.core.rainflow import rainflow
from owt_postproc.plot_style import BLUE, SCALE, Figure, axis, layout, log_axis, numbers
from owt_postproc.report_usage import Usage

__all__ = ["damage_bars", "exceedance", "rainflow_matrix"]

ENDS_SHOWN = 20
#: Bins of a rainflow matrix: of the range, and of the mean.
RANGE_BINS, MEAN_BINS = 32, 32


def damage_bars(usage: Usage) -> Figure:
    """The most damaged member ends."""
    damage, spot = usage.end_damage, usage.worst_spot
    order = np.argsort(-damage, kind="stable")[:ENDS_SHOWN][::-1]
    trace = {
        "type": "bar",
        "orientation": "h",
        "x": [float(damage[e]) for e in order],
        "y": [usage.end_name[e] for e in order],
        "customdata": [
            [
                float(usage.cycles[spot[e]]),
                1e-6 * float(usage.max_range[spot[e]]),
                usage.describe(int(spot[e])),
            ]
            for e in order
        ],
        "hovertemplate": "damage %{x:.3g}<br>%{customdata[0]:.0f} cycles<br>"
        "largest range %{customdata[1]:.1f} MPa<br>%{customdata[2]}<extra>%{y}</extra>",
        "marker": {"color": BLUE},
        "showlegend": False,
    }
    look = layout(
        xaxis=axis("damage (Palmgren-Miner sum over the record)", exponentformat="power", rangemode="tozero"),
        yaxis=axis("", type="category", tickfont={"size": 12}),
        hovermode="closest",
        bargap=0.35,
    )
    caption = (
        f"The {len(order)} most damaged of {len(damage)} member ends, each by the worst of its spots. "
        f"S-N curve {usage.curve.name}, residue as half cycles."
    )
    return Figure("damage", "Fatigue damage by member end", caption, [trace], look, height=640)


def exceedance(usage: Usage) -> Figure:
    """Cycles above each stress range at the most used spot."""
    spot = usage.most_used
    counts = usage.histogram[spot]
    edge = 1e-6 * usage.range_edge
    above = np.cumsum(counts[::-1])[::-1][1:]
    shown = above > 0
    trace = {
        "type": "scatter",
        "mode": "lines+markers",
        "line": {"color": BLUE, "width": 1.4},
        "marker": {"color": BLUE, "size": 5},
        "x": numbers(above[shown]),
        "y": numbers(edge[shown]),
        "hovertemplate": "%{x:g} cycles above %{y:.3g} MPa<extra></extra>",
        "showlegend": False,
    }
    most = float(above[0]) if len(above) else 0.0
    look = layout(
        xaxis=log_axis("cycles that exceed the range", 0.5, max(1.2 * most, 2.0), labels=(1, 2, 5)),
        yaxis=axis("stress range in MPa", rangemode="tozero"),
        hovermode="closest",
    )
    caption = (
        f"Rainflow cycles at the most used spot, {usage.spot_name[spot]}, at the edges of the range bins."
    )
    return Figure("exceedance", "Exceedance of stress ranges", caption, [trace], look, height=400)


def rainflow_matrix(stress: Float[np.ndarray, " n"], name: str) -> Figure | None:
    """Cycles by mean and range of one stress series in Pa; None of a constant one."""
    ranges, means, counts = rainflow(1e-6 * stress)
    if not len(ranges):
        return None
    top, low, high = float(ranges.max()), float(means.min()), float(means.max())
    if high - low <= 1e-9 * top:
        low, high = low - 0.5 * top, high + 0.5 * top
    range_edge, mean_edge = np.linspace(0.0, top, RANGE_BINS + 1), np.linspace(low, high, MEAN_BINS + 1)
    matrix, _, _ = np.histogram2d(ranges, means, bins=(range_edge, mean_edge), weights=counts)
    log = [[float(np.log10(v)) if v > 0.0 else None for v in row] for row in matrix]
    most = float(np.log10(matrix.max()))
    least = float(np.log10(matrix[matrix > 0.0].min()))
    values = [
        v for v in (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 1e4, 1e5) if v <= 10**most
    ]
    trace = {
        "type": "heatmap",
        "x": [float(v) for v in 0.5 * (mean_edge[1:] + mean_edge[:-1])],
        "y": [float(v) for v in 0.5 * (range_edge[1:] + range_edge[:-1])],
        "z": log,
        "customdata": matrix.tolist(),
        "colorscale": SCALE,
        "zmin": least,
        "zmax": max(most, least + 0.3),
        "xgap": 1,
        "ygap": 1,
        "hoverongaps": False,
        "colorbar": {
            "title": {"text": "cycles", "side": "top"},
            "thickness": 14,
            "outlinewidth": 0,
            "tickvals": [float(np.log10(v)) for v in values],
            "ticktext": [f"{v:g}" for v in values],
        },
        "hovertemplate": "mean %{x:.3g} MPa<br>range %{y:.3g} MPa<br>%{customdata:g} cycles<extra></extra>",
    }
    look = layout(
        xaxis=axis("mean of the cycle in MPa"),
        yaxis=axis("stress range in MPa", rangemode="tozero"),
        hovermode="closest",
    )
    caption = (
        f"Of the normal stress at {name}: {counts.sum():g} cycles in {RANGE_BINS} × {MEAN_BINS} equal "
        "bins, no cycle "
        "left out, empty bins white, colours logarithmic."
    )
    return Figure("matrix", "Rainflow matrix", caption, [trace], look, height=400)
