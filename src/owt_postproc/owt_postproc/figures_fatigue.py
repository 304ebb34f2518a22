"""Figures of the fatigue results: damage by member end, exceedance of stress ranges, the coloured jacket."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_postproc.plot_style import BLUE, FAINT, GRID, Figure, axis, layout, log_axis, numbers
from owt_postproc.report_data import Geometry, ReportData

__all__ = ["damage_bars", "exceedance", "jacket"]

ENDS_SHOWN = 20
SCALE = [[0.0, "#dfe7ee"], [0.25, "#9cc0dc"], [0.5, "#4f8fbf"], [0.75, "#e0a13c"], [1.0, "#b3261e"]]
#: Decades of damage that the colours span.
DECADES = 6.0
TOWER, TOWER_SHOWN_M = "#b9c2ca", 20.0


def damage_bars(data: ReportData) -> Figure:
    """The most damaged member ends."""
    fatigue = data.fatigue
    damage, spot = fatigue.end_damage, fatigue.worst_spot
    order = np.argsort(-damage, kind="stable")[:ENDS_SHOWN][::-1]
    trace = {
        "type": "bar",
        "orientation": "h",
        "x": [float(damage[e]) for e in order],
        "y": [data.reduced.end_name[e] for e in order],
        "customdata": [
            [float(fatigue.cycles[spot[e]]), 1e-6 * float(fatigue.max_range[spot[e]])] for e in order
        ],
        "hovertemplate": "damage %{x:.3g}<br>%{customdata[0]:.0f} cycles<br>"
        "largest range %{customdata[1]:.1f} MPa<extra>%{y}</extra>",
        "marker": {"color": BLUE},
        "showlegend": False,
    }
    look = layout(
        xaxis=axis("Palmgren-Miner sum over the record", exponentformat="power", rangemode="tozero"),
        yaxis=axis("", type="category", tickfont={"size": 11}),
        hovermode="closest",
        bargap=0.35,
    )
    caption = (
        f"The {len(order)} most damaged of {len(damage)} member ends. S-N curve {fatigue.curve.name}, the "
        "largest of each end's hot spots, residue as half cycles."
    )
    return Figure("damage", "Fatigue damage by member end", caption, [trace], look, height=440)


def exceedance(data: ReportData) -> Figure:
    """Cycles above each stress range at the most damaged point."""
    counts = data.fatigue.histogram[data.stress_spot]
    edge = 1e-6 * data.fatigue.range_edge
    above = np.cumsum(counts[::-1])[::-1][1:]
    shown = above > 0
    trace = {
        "type": "scatter",
        "mode": "lines+markers",
        "line": {"color": BLUE, "width": 1.2},
        "marker": {"color": BLUE, "size": 4},
        "x": numbers(above[shown]),
        "y": numbers(edge[shown]),
        "hovertemplate": "%{x:g} cycles above %{y:.3g} MPa<extra></extra>",
        "showlegend": False,
    }
    look = layout(
        xaxis=log_axis(
            "cycles that exceed the range", 0.5, max(1.2 * float(above[0]), 2.0), labels=(1, 2, 5)
        ),
        yaxis=axis("stress range in MPa", rangemode="tozero"),
        hovermode="closest",
    )
    caption = (
        f"Rainflow cycles of the hot-spot stress at {data.spot_name}°, at the edges of 20 bins per decade."
    )
    return Figure("exceedance", "Exceedance of stress ranges", caption, [trace], look, height=280)


def jacket(data: ReportData, geometry: Geometry) -> Figure:
    """The structure as lines in space, every half member in the colour of its end."""
    traces = [_members(data, geometry)]
    tower = np.zeros((0, 3))
    if len(geometry.tower_node):
        jacket_top = geometry.node[geometry.member_node.ravel(), 2].max()
        chain = geometry.node[np.append(geometry.tower_node[:, 0], geometry.tower_node[-1, 1])]
        tower = chain[chain[:, 2] <= jacket_top + TOWER_SHOWN_M]
        traces.append(
            {
                "type": "scatter3d",
                "mode": "lines",
                **{name: numbers(tower[:, i]) for i, name in enumerate("xyz")},
                "line": {"width": 9, "color": TOWER},
                "hoverinfo": "skip",
                "showlegend": False,
            }
        )
    corners = np.concatenate([geometry.node[geometry.member_node.ravel()], tower])
    low, size = corners.min(axis=0) - 2.0, np.ptp(corners, axis=0) + 4.0
    span = np.stack([low, low + size], axis=1).tolist()
    ratio = 1.5 * size / size.max()
    quiet = {"showbackground": False, "gridcolor": GRID, "zeroline": False, "color": FAINT, "nticks": 6}
    look = layout(
        margin={"l": 0, "r": 0, "t": 0, "b": 0},
        hovermode="closest",
        scene={
            "aspectmode": "manual",
            "aspectratio": dict(zip("xyz", ratio.tolist(), strict=True)),
            **{
                f"{name}axis": {**quiet, "title": {"text": f"{name} in m"}, "range": span[i]}
                for i, name in enumerate("xyz")
            },
            "camera": {"eye": {"x": 1.18, "y": 1.63, "z": 0.28}},
        },
    )
    caption = (
        "Each half of a member in the colour of its end, on a logarithmic scale; six decades and more below "
        "the largest is the lightest colour. Grey: foot of the tower. Drag to turn."
    )
    return Figure("jacket", "Jacket coloured by damage", caption, traces, look, height=760)


def _members(data: ReportData, geometry: Geometry) -> dict[str, Any]:
    """One trace of all members: five points each, the last of them a gap."""
    damage = data.fatigue.end_damage
    top = float(damage.max()) or 1.0
    high = float(np.log10(top))
    colour = np.log10(np.maximum(damage, top * 10.0**-DECADES)).reshape(-1, 2)
    first, second = geometry.node[geometry.member_node[:, 0]], geometry.node[geometry.member_node[:, 1]]
    middle = 0.5 * (first + second)
    points = np.stack([first, middle, middle, second, np.full_like(first, np.nan)], axis=1).reshape(-1, 3)
    text: list[str] = []
    for m in range(len(first)):
        a, b = (f"{data.reduced.end_name[e]}<br>damage {damage[e]:.3g}" for e in (2 * m, 2 * m + 1))
        text += [a, a, b, b, ""]
    ticks = np.arange(np.ceil(high - DECADES), high + 1e-9)
    bar = {
        "title": {"text": "damage", "side": "top"},
        "thickness": 14,
        "len": 0.6,
        "x": 0.98,
        "tickvals": ticks.tolist(),
        "ticktext": [f"10<sup>{int(v)}</sup>" for v in ticks],
    }
    line = {
        "width": 7,
        "color": numbers(colour[:, [0, 0, 1, 1, 1]].ravel()),
        "colorscale": SCALE,
        "cmin": high - DECADES,
        "cmax": high,
        "showscale": True,
        "colorbar": bar,
    }
    return {
        "type": "scatter3d",
        "mode": "lines",
        **{name: numbers(points[:, i]) for i, name in enumerate("xyz")},
        "line": line,
        "text": text,
        "hoverinfo": "text",
        "showlegend": False,
    }
