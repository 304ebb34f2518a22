"""Small tubular joints of a few members, and the stress at their hot spots."""

from __future__ import annotations

import math

import numpy as np

from owt_model.fatigue_config import Fatigue
from owt_model.frame import Frame
from owt_postproc.core.efthymiou import Shape
from owt_postproc.core.hot_spots import POINT_ANGLE_DEG, HotSpots, build_hot_spots

__all__ = [
    "BARE", "BRACE", "CHORD", "CHORDS", "WALL_B", "WALL_T", "O", "around", "brace", "end_of", "frame_of",
    "k_frame", "response", "shape", "spots_of",
]  # fmt: skip

#: No floor under the factors, no nominal stress of the chord: what the equations say, and nothing else.
BARE = {"scf_minimum": 0.0, "chord_effect": "length", "chord_fixity": 0.5}
CHORD, WALL_T, BRACE, WALL_B = 1.0, 0.04, 0.5, 0.02


def frame_of(
    lines: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]],
    size: dict[str, tuple[float, float]] | None = None,
) -> Frame:
    """Members between points; those whose name begins with C are chords."""
    places = list(dict.fromkeys(tuple(p) for line in lines.values() for p in line))
    node = np.array([[places.index(p) for p in line] for line in lines.values()])
    default = {name: (CHORD, WALL_T) if name.startswith("C") else (BRACE, WALL_B) for name in lines}
    walls = np.array([(default | (size or {}))[name] for name in lines])
    return Frame(
        node_name=tuple("J" if p == (0.0, 0.0, 0.0) else f"N{i}" for i, p in enumerate(places)),
        node_position=np.array(places),
        node_tied=np.zeros(len(places), dtype=bool),
        member_name=tuple(lines),
        member_node=node,
        end_diameter=np.repeat(walls[:, 0], 2),
        end_thickness=np.repeat(walls[:, 1], 2),
    )


O = (0.0, 0.0, 0.0)
CHORDS = {"C1": ((0.0, 0.0, -20.0), O), "C2": (O, (0.0, 0.0, 20.0))}


def brace(theta_deg: float, azimuth_deg: float = 0.0, *, up: bool = True, length: float = 10.0):
    """Brace from the joint at an angle to the upright chord."""
    s, a = math.radians(theta_deg), math.radians(azimuth_deg)
    z = math.cos(s) if up else -math.cos(s)
    return O, (
        length * math.sin(s) * math.cos(a),
        length * math.sin(s) * math.sin(a),
        length * z,
    )


def shape(theta_deg: float, alpha: float = 80.0) -> Shape:
    return Shape(BRACE / CHORD, CHORD / (2 * WALL_T), WALL_B / WALL_T, math.radians(theta_deg), alpha)


def spots_of(frame: Frame, **choices) -> HotSpots:
    return build_hot_spots(frame, Fatigue.model_validate({**BARE, **choices}))


def end_of(frame: Frame, member: str, joint: str = "J") -> int:
    return frame.end_name.index(f"{member}:{joint}")


def response(hot_spots: HotSpots, end: int, side: str, **stress: dict[int, float]) -> np.ndarray:
    """Stress at the eight points of a side under constant nominal stress of some ends."""
    given = {name: np.zeros((1, hot_spots.n_ends)) for name in ("axial", "bending_y", "bending_z")}
    for name, values in stress.items():
        for at, value in values.items():
            given[name][0, at] = value
    chosen = [i for i in range(hot_spots.n_spots) if hot_spots.end[i] == end and hot_spots.side[i] == side]
    return np.array([hot_spots.stress(i, **given)[0] for i in chosen])


def around(crown: float, saddle: float) -> np.ndarray:
    angle = np.radians(POINT_ANGLE_DEG)
    return crown * np.cos(angle) ** 2 + saddle * np.sin(angle) ** 2


def k_frame() -> Frame:
    return frame_of(CHORDS | {"A": brace(45.0), "B": brace(60.0, up=False)})
