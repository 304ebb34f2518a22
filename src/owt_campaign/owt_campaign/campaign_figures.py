"""Figures of a campaign's report: what each sea state and direction contributes, and the orders compared."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_campaign.load_cases import LoadCaseTable
from owt_campaign.totals import OrderTotals
from owt_postproc.plot_style import BLUE, ORANGE, SCALE, Figure, axis, layout, log_axis

__all__ = ["by_direction", "by_sea_state", "exceedance_of_orders", "orders_compared"]

NAMES = {1: "linear waves", 2: "second order"}
COLOURS = {1: BLUE, 2: ORANGE}
#: Spots of less than this share of the largest damage are left out where orders are compared.
COMPARED = 1e-4


def by_sea_state(table: LoadCaseTable, totals: OrderTotals, spot: int, spot_name: str) -> Figure:
    """Share of each sea state in the damage of a spot, as a map."""
    share = _percent(totals, spot)
    directions = sorted({row.direction_deg for row in table.rows if row.problem is None})
    many = len(directions) > 1
    across = [row.direction_deg if many else row.tp_s for row in table.rows]
    places = sorted({value for value, row in zip(across, table.rows, strict=True) if row.problem is None})
    heights = sorted({row.hs_m for row in table.rows if row.problem is None})
    value: list[list[float | None]] = [[None] * len(places) for _ in heights]
    text = [[""] * len(places) for _ in heights]
    for i, row in enumerate(table.rows):
        if row.problem is not None:
            continue
        y, x = heights.index(row.hs_m), places.index(across[i])
        value[y][x] = (value[y][x] or 0.0) + float(share[i])
        text[y][x] = (
            f"Hs {row.hs_m:g} m, Tp {row.tp_s:.2f} s, from {row.direction_deg:g}°: {value[y][x]:.3g} %"
        )
    trace = {
        "type": "heatmap", "x": [f"{place:g}" for place in places],
        "y": [f"{height:g}" for height in heights],
        "z": value, "text": text, "hoverinfo": "text", "colorscale": SCALE, "xgap": 2, "ygap": 1,
        "colorbar": {"title": {"text": "%"}, "thickness": 14, "outlinewidth": 0},
    }  # fmt: skip
    x_title = "waves come from, degrees clockwise from north" if many else "peak period Tp in s"
    return Figure(
        "sea-states",
        "Contribution of each sea state",
        f"Share in the damage of {spot_name}, by probability; empty: no such sea state, or it failed.",
        [trace],
        layout(
            xaxis=axis(x_title, type="category"),
            yaxis=axis("significant wave height Hs in m", type="category"),
            hovermode="closest",
        ),
        height=460,
    )


def by_direction(table: LoadCaseTable, totals: dict[int, OrderTotals], spot: int, spot_name: str) -> Figure:
    """Damage of a spot by direction, or by height where there is one direction."""
    directions = sorted({row.direction_deg for row in table.rows if row.problem is None})
    many = len(directions) > 1
    of_row = np.array([row.direction_deg if many else row.hs_m for row in table.rows])
    groups = directions if many else sorted({row.hs_m for row in table.rows if row.problem is None})
    traces: list[dict[str, Any]] = [
        {
            "type": "bar",
            "name": NAMES[order],
            "x": [f"{group:g}" for group in groups],
            "y": [float(total.row_damage_per_year[of_row == group, spot].sum()) for group in groups],
            "marker": {"color": COLOURS[order]},
            "hovertemplate": "%{y:.3e} a year",
        }
        for order, total in totals.items()
    ]
    what = "direction" if many else "height"
    return Figure(
        "directions",
        f"Contribution of each {what}",
        f"Damage of {spot_name} in a year, by probability.",
        traces,
        layout(
            xaxis=axis(
                "waves come from, degrees clockwise from north"
                if many
                else "significant wave height Hs in m",
                type="category",
            ),
            yaxis=axis("damage in a year", exponentformat="power", rangemode="tozero"),
            barmode="group",
        ),
        height=460,
    )


def orders_compared(
    totals: dict[int, OrderTotals],
    worst_spot: Float[np.ndarray, " end"],
    end_name: tuple[str, ...],
    level: Float[np.ndarray, " end"],
    stretching: str,
) -> Figure:
    """Damage and total stress of each member end with waves of second order over those with linear waves.

    The ratio hangs on `stretching`, the kinematics of both above still water, so that the caption names it.
    """
    first, second = totals[1], totals[2]
    damage = first.damage_per_year[worst_spot], second.damage_per_year[worst_spot]
    stress = first.total_stress_per_year, second.total_stress_per_year
    traces: list[dict[str, Any]] = []
    for name, colour, (a, b), size in (
        ("damage, worst hot spot", ORANGE, damage, damage[0]),
        ("total stress", BLUE, stress, stress[0]),
    ):
        shown = a > COMPARED * a.max()
        traces.append({
            "type": "scatter", "mode": "markers", "name": name,
            "x": (b[shown] / a[shown]).tolist(), "y": level[shown].tolist(),
            "marker": {
                "color": colour, "opacity": 0.65, "line": {"width": 0},
                "size": (4.0 + 14.0 * np.sqrt(size[shown] / size.max())).round(1).tolist(),
            },
            "text": [f"{end_name[e]}: {b[e] / a[e]:.3f}" for e in np.flatnonzero(shown)],
            "hoverinfo": "text+name",
        })  # fmt: skip
    return Figure(
        "orders",
        "Second order over linear waves",
        "Ratio of the yearly sums of each member end, by its level; larger dots bear more. Ends of less than "
        f"{COMPARED:g} of the largest are left out. Kinematics of the linear waves above still water "
        f"(wave.stretching): {stretching}; with another one the ratio is another one too.",
        traces,
        layout(
            xaxis=axis("second order / linear", zeroline=False),
            yaxis=axis("level of the joint in m above still water"),
            hovermode="closest",
            shapes=[{"type": "line", "x0": 1, "x1": 1, "yref": "paper", "y0": 0, "y1": 1,
                     "line": {"color": "#66727f", "width": 1, "dash": "dot"}}],
        ),
        height=480,
    )  # fmt: skip


def exceedance_of_orders(
    totals: dict[int, OrderTotals], spot: int, spot_name: str, edge: Float[np.ndarray, " edge"]
) -> Figure:
    """Cycles of a year above each stress range, by wave order."""
    traces: list[dict[str, Any]] = []
    low, high, most, least = np.inf, 0.0, 0.0, np.inf
    for order, total in totals.items():
        above = np.cumsum(total.cycles_per_year[spot][::-1])[::-1][1:]
        shown = above > 0.0
        if not shown.any():
            continue
        x, y = 1e-6 * edge[shown], above[shown]
        low, high = min(low, x.min()), max(high, x.max())
        least, most = min(least, y.min()), max(most, y.max())
        traces.append({
            "type": "scatter", "mode": "lines", "name": NAMES[order], "x": y.tolist(), "y": x.tolist(),
            "line": {"color": COLOURS[order], "width": 2}, "hovertemplate": "%{y:.3g} MPa: %{x:.3g} a year",
        })  # fmt: skip
    if not traces:
        least, most = 1.0, 1.0
    return Figure(
        "exceedance", "Stress ranges of a year",
        f"Cycles in a year above each range, {spot_name}, by probability.",
        traces,
        layout(
            xaxis=log_axis("cycles in a year above the range", max(least, 1e-3), max(most, 1.0)),
            yaxis=axis("stress range in MPa", rangemode="tozero"),
            hovermode="closest",
        ),
        height=480,
    )  # fmt: skip


def _percent(totals: OrderTotals, spot: int) -> Float[np.ndarray, " row"]:
    whole = float(totals.damage_per_year[spot])
    return np.asarray(100.0 * totals.row_damage_per_year[:, spot] / (whole or 1.0))
