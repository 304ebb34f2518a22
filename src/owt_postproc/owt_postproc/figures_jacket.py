"""The structure in space, in the colour of what each member end bears, and two views of it for paper."""

from __future__ import annotations

import html
from itertools import combinations
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from owt_postproc.plot_style import FAINT, GRID, SCALE, Figure, layout, numbers
from owt_postproc.report_data import Geometry
from owt_postproc.report_measures import DesignLife, Measure, end_texts, measures, power
from owt_postproc.report_usage import Usage

__all__ = ["colour_of", "jacket"]

TOWER, TOWER_SHOWN_M, JOINT = "#b9c2ca", 20.0, "#8b97a3"
#: Corners of a tube's section, and stations along each half of it, where the pointer finds it.
CORNERS, STATIONS = 12, 4
#: Diameter in m of tubes whose own is not recorded.
USUAL_DIAMETER_M = 1.0
#: Diameter of a joint's ball over that of the thickest member there.
JOINT_SIZE = 1.18
VIEWS = ((0, "x"), (1, "y"))


def jacket(usage: Usage, geometry: Geometry, design: DesignLife | None) -> Figure:
    """The structure as tubes, every half member in the colour of its end, with a selector of the quantity."""
    shown = measures(usage, design)
    tubes, end_of_vertex = _tubes(geometry)
    tubes["intensity"] = numbers(np.asarray(shown[0].plain()["share"])[end_of_vertex])
    traces = [tubes, _joints(usage, geometry), *_tower(geometry)]
    extra = {
        "measures": [measure.plain() for measure in shown],
        "end_of_vertex": end_of_vertex.tolist(),
        "end_text": end_texts(usage, design),
        "scale": SCALE,
    }
    caption = (
        "Each half of a member in the colour of its end. Hover for names and numbers, drag to turn, "
        "scroll to "
        "zoom. Balls: joints. Grey: foot of the tower."
    )
    return Figure(
        "jacket", "Structure", caption, traces, _scene(geometry), height=640, extra=extra,
        html=_selector(shown) + _views(geometry, shown[0], usage),
    )  # fmt: skip


def colour_of(share: float) -> str:
    """Colour at a share between 0 and 1 of the scale."""
    position = [stop for stop, _ in SCALE]
    rgb = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for _, c in SCALE])
    mixed = [round(float(np.interp(share, position, rgb[:, i]))) for i in range(3)]
    return "#{:02x}{:02x}{:02x}".format(*mixed)


def _selector(shown: list[Measure]) -> str:
    options = "".join(
        f'<option value="{m.key}">{html.escape(m.label + (f", {m.unit}" if m.unit else ""))}</option>'
        for m in shown
    )
    return (
        f'<p class="select"><label for="measure">Coloured by</label> <select id="measure">{options}</select> '
        f'<span id="measure-note" aria-live="polite">{html.escape(shown[0].note)}</span></p>'
    )


def _tubes(geometry: Geometry) -> tuple[dict[str, Any], Int[np.ndarray, " vertex"]]:
    """One surface of all members; and the member end that each of its vertices belongs to."""
    first, last = (geometry.node[geometry.member_node[:, i]] for i in (0, 1))
    members = len(first)
    diameter = _diameter(geometry)
    along = last - first
    along = along / np.linalg.norm(along, axis=1)[:, None]
    aside = np.cross(along, np.where(np.abs(along[:, 2:]) > 0.9, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]]))
    aside = aside / np.linalg.norm(aside, axis=1)[:, None]
    across = np.cross(along, aside)
    angle = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    ring = np.cos(angle)[:, None] * aside[:, None] + np.sin(angle)[:, None] * across[:, None]
    ring = 0.5 * diameter[:, None, None] * ring  # [member, corner, 3]
    share = np.concatenate([np.linspace(0.0, 0.5, STATIONS), np.linspace(0.5, 1.0, STATIONS)])
    centre = first[:, None] + share[None, :, None] * (last - first)[:, None]
    vertex = centre[:, :, None] + ring[:, None]  # [member, station, corner, 3]
    rings = 2 * STATIONS
    end = np.repeat(np.arange(2 * members), STATIONS * CORNERS)
    corner, following = np.arange(CORNERS), (np.arange(CORNERS) + 1) % CORNERS
    faces = []
    for r in (r for r in range(rings - 1) if r != STATIONS - 1):
        low, high = r * CORNERS, (r + 1) * CORNERS
        faces += [np.stack([low + corner, low + following, high + corner], axis=1)]
        faces += [np.stack([low + following, high + following, high + corner], axis=1)]
    one = np.concatenate(faces)
    face = (one[None] + (rings * CORNERS * np.arange(members))[:, None, None]).reshape(-1, 3)
    flat = vertex.reshape(-1, 3)
    trace = {
        "type": "mesh3d",
        **{name: numbers(flat[:, i]) for i, name in enumerate("xyz")},
        **{name: face[:, i].tolist() for i, name in enumerate("ijk")},
        "colorscale": SCALE,
        "cmin": 0.0,
        "cmax": 1.0,
        "colorbar": {
            "title": {"text": "", "side": "top"}, "thickness": 16, "len": 0.7, "x": 1.0, "xanchor": "right",
            "outlinewidth": 0, "tickfont": {"size": 12},
        },
        "lighting": {"ambient": 0.8, "diffuse": 0.35, "specular": 0.05, "roughness": 0.9},
        "flatshading": False,
        "hoverinfo": "text",
        "showlegend": False,
    }  # fmt: skip
    return trace, end


def _joints(usage: Usage, geometry: Geometry) -> dict[str, Any]:
    """Joints as balls that tell their name and which member ends meet there."""
    damage = usage.end_damage
    node_of_end = geometry.member_node.ravel()
    joint = np.unique(node_of_end)
    text, members_of = [], {}
    for node in joint:
        ends = np.flatnonzero(node_of_end == node)
        members_of[node] = ends // 2
        worst = ends[np.argmax(damage[ends])]
        members = ", ".join(usage.end_name[e].partition(":")[0] for e in ends)
        x, y, z = geometry.node[node]
        text.append(
            f"<b>joint {geometry.node_name[node]}</b><br>at ({x:.2f}, {y:.2f}, {z:.2f}) m<br>members "
            f"{members}<br>"
            f"largest damage {power(float(damage[worst]))} at {usage.end_name[worst]}"
        )
    corner, face = _ball()
    diameter = _diameter(geometry)
    radius = 0.5 * JOINT_SIZE * np.array([diameter[members_of[node]].max() for node in joint])
    ball = geometry.node[joint][:, None] + radius[:, None, None] * corner
    faces = (face + len(corner) * np.arange(len(joint))[:, None, None]).reshape(-1, 3)
    flat = ball.reshape(-1, 3)
    return {
        "type": "mesh3d",
        **{name: numbers(flat[:, i]) for i, name in enumerate("xyz")},
        **{name: faces[:, i].tolist() for i, name in enumerate("ijk")},
        "color": JOINT,
        "text": [line for line in text for _ in corner],
        "hoverinfo": "text",
        "showlegend": False,
    }


def _ball() -> tuple[Float[np.ndarray, "corner 3"], Int[np.ndarray, "face 3"]]:
    """Corners and faces of an icosahedron of radius 1."""
    g = 0.5 * (1.0 + np.sqrt(5.0))
    corner = np.array([np.roll([0.0, a, b * g], k) for k in range(3) for a in (1, -1) for b in (1, -1)])
    apart = np.linalg.norm(corner[:, None] - corner, axis=2)
    near = (apart > 0.0) & (apart < 2.1)
    face = [(i, j, k) for i, j, k in combinations(range(12), 3) if near[i, j] and near[j, k] and near[i, k]]
    return corner / np.linalg.norm(corner[0]), np.array(face)


def _diameter(geometry: Geometry) -> Float[np.ndarray, " member"]:
    """Diameter of each member in m."""
    recorded = geometry.member_diameter
    return recorded if len(recorded) else np.full(len(geometry.member_node), USUAL_DIAMETER_M)


def _tower_chain(geometry: Geometry) -> Float[np.ndarray, "node 3"]:
    """Foot of the tower."""
    if not len(geometry.tower_node):
        return np.zeros((0, 3))
    top = geometry.node[geometry.member_node.ravel(), 2].max()
    chain = geometry.node[np.append(geometry.tower_node[:, 0], geometry.tower_node[-1, 1])]
    return np.asarray(chain[chain[:, 2] <= top + TOWER_SHOWN_M])


def _tower(geometry: Geometry) -> list[dict[str, Any]]:
    tower = _tower_chain(geometry)
    if not len(tower):
        return []
    return [
        {
            "type": "scatter3d",
            "mode": "lines",
            **{name: numbers(tower[:, i]) for i, name in enumerate("xyz")},
            "line": {"width": 9, "color": TOWER},
            "hoverinfo": "skip",
            "showlegend": False,
        }
    ]


def _scene(geometry: Geometry) -> dict[str, Any]:
    corners = np.concatenate([geometry.node[geometry.member_node.ravel()], _tower_chain(geometry)])
    low, size = corners.min(axis=0) - 2.0, np.ptp(corners, axis=0) + 4.0
    span = np.stack([low, low + size], axis=1).tolist()
    ratio = 1.5 * size / size.max()
    quiet = {"showbackground": False, "gridcolor": GRID, "zeroline": False, "color": FAINT, "nticks": 6}
    return layout(
        margin={"l": 0, "r": 0, "t": 0, "b": 0},
        hovermode="closest",
        hoverlabel={"align": "left"},
        scene={
            "aspectmode": "manual",
            "aspectratio": dict(zip("xyz", ratio.tolist(), strict=True)),
            **{
                f"{name}axis": {
                    **quiet, "title": {"text": f"{name} in m"}, "range": span[i], "showspikes": False,
                }
                for i, name in enumerate("xyz")
            },
            "camera": {"eye": {"x": 0.95, "y": 1.35, "z": 0.2}, "center": {"x": 0, "y": 0, "z": -0.06}},
        },
    )  # fmt: skip


def _views(geometry: Geometry, measure: Measure, usage: Usage) -> str:
    """Views along y and along x as drawings: for paper, and where the browser cannot draw in space."""
    share = measure.plain()["share"]
    tower = _tower_chain(geometry)
    first, last = (geometry.node[geometry.member_node[:, i]] for i in (0, 1))
    middle = 0.5 * (first + last)
    corners = np.concatenate([first, last, tower])
    top, bottom = corners[:, 2].max() + 2.0, corners[:, 2].min() - 2.0
    drawings = []
    for axis, name in VIEWS:
        low, high = corners[:, axis].min() - 2.0, corners[:, axis].max() + 2.0
        depth = 1 - axis
        order = np.argsort((first + last)[:, depth] * (1.0 if axis else -1.0), kind="stable")
        lines = [
            f'<polyline class="tower" points="{" ".join(f"{p[axis]:.2f},{top - p[2]:.2f}" for p in tower)}"/>'
        ]
        for m in order:
            for e, (a, b) in ((2 * m, (first[m], middle[m])), (2 * m + 1, (middle[m], last[m]))):
                lines.append(
                    f'<line data-end="{e}" stroke="{colour_of(share[e])}" x1="{a[axis]:.2f}" '
                    f'y1="{top - a[2]:.2f}" x2="{b[axis]:.2f}" y2="{top - b[2]:.2f}">'
                    f"<title>{html.escape(usage.end_name[e])}</title></line>"
                )
        drawings.append(
            f'<svg viewBox="{low:.2f} 0 {high - low:.2f} {top - bottom:.2f}" role="img" '
            f'aria-label="Structure in the {name}-z plane, coloured by the chosen quantity">'
            f"{''.join(lines)}</svg>"
        )
    legend = "".join(f'<i style="background:{colour_of(s)}"></i>' for s in np.linspace(0.0, 1.0, 24))
    return (
        f'<div class="views"><div>{drawings[0]}<p>x–z plane</p></div><div>{drawings[1]}<p>y–z plane</p></div>'
        f'<div class="legend"><p id="views-title"></p><div class="bar">{legend}</div>'
        '<div id="views-ticks"></div></div></div>'
    )
