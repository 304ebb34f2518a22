"""Tubular joints as the members make them: which brace end stands on which chord, and how.

The chord of a joint is the pair of members that runs straight through it, the one of largest diameter and
wall. Two pairs of the same size, as where the braces of an X cross, cannot be told apart: each is then
a brace on the other. Without a pair a single member larger than all others is the chord. All axes meet in
the joint, since the members meet in a node: eccentricity is nil, and gaps follow from diameters and angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_model.fatigue_config import JointChoice
from owt_model.frame import Frame

__all__ = ["Connection", "Joints", "find_joints"]

#: Largest bend in degrees of two members that run on into each other.
STRAIGHT_DEG = 15.0
#: Braces whose azimuths round the chord differ by less lie in one plane; by more than 180 minus it, opposite.
PLANE_DEG = 15.0
#: Least angle in degrees between brace and chord.
LEAST_ANGLE_DEG = 5.0


@dataclass(frozen=True)
class Connection:
    """One brace end on its chord.

    Attributes
    ----------
    end : int
        Member end of the brace.
    joint : str
        Name of the joint.
    chord : tuple of int
        Member ends of the chord there: two, or one where the chord ends.
    chord_name : str
        Its members.
    chord_diameter, chord_thickness, chord_length : float
        In m; the smaller of both sides, and the length between the neighbouring joints.
    diameter, thickness : float
        Of the brace in m.
    theta : float
        Angle between brace and chord in rad, at most 90 degrees.
    along : float
        Cosine of the angle between the brace and :attr:`axis`: its sign tells to which side it leans.
    axis, radial : float arrays [3]
        Unit vectors along the chord, and from the chord towards the brace.
    crown, normal : float arrays [3]
        Unit vectors across the brace from its axis towards the crown at 0 degrees and the saddle at 90. The
        crown at 0 is the toe, on the side of the acute angle; of a brace square to the chord the one along
        `axis`.
    """

    end: int
    joint: str
    chord: tuple[int, ...]
    chord_name: str
    chord_diameter: float
    chord_thickness: float
    chord_length: float
    diameter: float
    thickness: float
    theta: float
    along: float
    axis: Float[np.ndarray, " 3"]
    radial: Float[np.ndarray, " 3"]
    crown: Float[np.ndarray, " 3"]
    normal: Float[np.ndarray, " 3"]

    @property
    def area(self) -> float:
        """Cross-section of the brace over pi, in m2."""
        return self.thickness * (self.diameter - self.thickness)

    @property
    def modulus(self) -> float:
        """Section modulus of the brace times 32 over pi, in m3."""
        return (self.diameter**4 - (self.diameter - 2.0 * self.thickness) ** 4) / self.diameter

    @property
    def footprint(self) -> float:
        """Length in m that the brace covers along the chord."""
        return self.diameter / float(np.sin(self.theta))

    @property
    def foot(self) -> float:
        """Place in m along `axis` where the axis of the brace meets the surface of the chord."""
        return 0.5 * self.chord_diameter * self.along / float(np.sin(self.theta))

    def azimuth_deg(self, other: Connection) -> float:
        """Angle round the chord to another brace, 0 to 180 degrees."""
        return float(np.degrees(np.arccos(np.clip(self.radial @ other.radial, -1.0, 1.0))))

    def gap(self, other: Connection) -> float:
        """Gap in m along the chord between two braces of one plane; negative where they overlap."""
        return abs(self.foot - other.foot) - 0.5 * (self.footprint + other.footprint)


@dataclass(frozen=True)
class Joints:
    """The connections of a structure, and why the other ends have none.

    Attributes
    ----------
    connection : dict
        Of each brace end.
    reason : tuple of str [end]
        Why an end has no connection; empty where it has.
    """

    connection: dict[int, Connection]
    reason: tuple[str, ...]

    @cached_property
    def _on_chord(self) -> dict[tuple[int, ...], list[Connection]]:
        """Connections by their chord."""
        found: dict[tuple[int, ...], list[Connection]] = {}
        for connection in self.connection.values():
            found.setdefault(connection.chord, []).append(connection)
        return found

    def neighbours(self, end: int) -> tuple[list[Connection], list[Connection]]:
        """Other braces of an end's plane, on its own side of the chord and on the opposite one."""
        own = self.connection[end]
        others = [c for c in self._on_chord[own.chord] if c.end != end]
        same = [c for c in others if own.azimuth_deg(c) < PLANE_DEG]
        opposite = [c for c in others if own.azimuth_deg(c) > 180.0 - PLANE_DEG]
        return same, opposite


def find_joints(frame: Frame, choices: Mapping[str, JointChoice] | None = None) -> Joints:
    """Find the chord of every brace end.

    Parameters
    ----------
    frame : Frame
    choices : mapping, optional
        What the case says of single joints and ends.

    Raises
    ------
    InputError
        If a choice names a joint, an end or a member that is not there.
    """
    choices = choices or {}
    _check_names(frame, choices)
    made = _Finder(frame, choices)
    for node in dict.fromkeys(int(node) for node in frame.end_node):
        made.joint(node)
    return Joints(dict(sorted(made.connection.items())), tuple(made.reason))


def _check_names(frame: Frame, choices: Mapping[str, JointChoice]) -> None:
    joints = {frame.node_name[node] for node in frame.end_node}
    known = joints | set(frame.end_name)
    for name, choice in choices.items():
        if name not in known:
            raise InputError(
                f"fatigue.joints.{name}",
                name,
                "is neither a joint with members nor a member end",
                "Name a joint like J21, or an end like M056:J21.",
            )
        if choice.chord is not None and name not in joints:
            raise InputError(
                f"fatigue.joints.{name}.chord",
                choice.chord,
                "is a choice for joints",
                "Name the joint alone.",
            )


class _Finder:
    """Collects connections joint by joint."""

    def __init__(self, frame: Frame, choices: Mapping[str, JointChoice]) -> None:
        self.frame, self.choices = frame, choices
        self.at: dict[int, list[int]] = {}
        for end, node in enumerate(frame.end_node):
            self.at.setdefault(int(node), []).append(end)
        vectors = np.array([frame.outwards(end) for end in range(frame.n_ends)])
        self.length = np.linalg.norm(vectors, axis=1)
        self.direction = vectors / self.length[:, None]
        self.connection: dict[int, Connection] = {}
        self.reason = [""] * frame.n_ends

    def joint(self, node: int) -> None:
        """Connect the ends that meet at a node."""
        ends, name = self.at[node], self.frame.node_name[node]
        chords = [] if self.frame.node_tied[node] else self._chords(node)
        for end in ends:
            on = [chord for chord in chords if end not in chord]
            if self.frame.node_tied[node]:
                self.reason[end] = f"{name} is part of a rigid body"
            elif len(ends) == 1:
                self.reason[end] = f"no other member ends at {name}"
            elif not chords:
                self.reason[end] = f"no member at {name} runs through or is larger than all others"
            elif not on:
                self.reason[end] = f"is the chord at {name}" if len(ends) > 2 else f"runs on at {name}"
            elif len(on) > 1:
                self.reason[end] = f"several pairs of one size run through {name}: name its chord"
            else:
                self._connect(end, name, on[0])

    def _chords(self, node: int) -> list[tuple[int, ...]]:
        """Chord at a node; all candidates where several are of one size."""
        ends, frame = self.at[node], self.frame
        choice = self.choices.get(frame.node_name[node])
        if choice is not None and choice.chord is not None:
            return [self._named(node, choice.chord)]
        size = {end: (float(frame.end_diameter[end]), float(frame.end_thickness[end])) for end in ends}
        pairs = [(a, b) for i, a in enumerate(ends) for b in ends[i + 1 :] if self._straight(a, b)]
        if pairs:
            largest = max(min(size[a], size[b]) for a, b in pairs)
            pairs = [pair for pair in pairs if _same(min(size[pair[0]], size[pair[1]]), largest)]
            others = [size[end][0] for end in ends if all(end not in pair for pair in pairs)]
            if not others or largest[0] >= max(others) * (1.0 - 1e-6):
                return _disjoint(sorted(pairs, key=self._bend))
        first, *rest = sorted(ends, key=lambda end: size[end], reverse=True)
        return [(first,)] if rest and size[first][0] > size[rest[0]][0] * (1.0 + 1e-6) else []

    def _named(self, node: int, members: tuple[str, ...]) -> tuple[int, ...]:
        name = self.frame.node_name[node]
        found = {self.frame.member_name[end // 2]: end for end in self.at[node]}
        for member in members:
            if member not in found:
                raise InputError(
                    f"fatigue.joints.{name}.chord",
                    member,
                    f"does not end at {name}",
                    f"There are: {', '.join(found)}.",
                )
        return tuple(sorted(found[member] for member in dict.fromkeys(members)))

    def _bend(self, pair: tuple[int, ...]) -> float:
        a, b = self.direction[pair[0]], self.direction[pair[1]]
        return float(np.degrees(np.arccos(np.clip(-a @ b, -1.0, 1.0))))

    def _straight(self, a: int, b: int) -> bool:
        return self._bend((a, b)) < STRAIGHT_DEG

    def _bay(self, end: int) -> float:
        """Length in m from a chord's joint to the next one, through nodes where nothing else ends."""
        length, seen = 0.0, set()
        while True:
            length += float(self.length[end])
            far = end ^ 1
            node = int(self.frame.end_node[far])
            here = self.at[node]
            onward = [other for other in here if other != far]
            if len(onward) != 1 or self.frame.node_tied[node] or node in seen:
                return length
            if not self._straight(far, onward[0]):
                return length
            seen.add(node)
            end = onward[0]

    def _connect(self, end: int, joint: str, chord: tuple[int, ...]) -> None:
        frame, out = self.frame, self.direction[end]
        axis = self.direction[chord[0]] - (self.direction[chord[1]] if len(chord) == 2 else 0.0)
        axis = axis / np.linalg.norm(axis)
        along = float(out @ axis)
        across = out - along * axis
        sine = float(np.linalg.norm(across))
        if sine < np.sin(np.radians(LEAST_ANGLE_DEG)):
            self.reason[end] = f"runs along the chord at {joint}"
            return
        radial = across / sine
        # Across the chord there is neither toe nor heel: rounding must not choose.
        towards = axis if along > -1e-6 else -axis
        crown = towards - (towards @ out) * out
        crown = crown / np.linalg.norm(crown)
        choice = self._choice(end, joint)
        thickness = min(float(frame.end_thickness[e]) for e in chord)
        length = sum(self._bay(e) for e in chord)
        self.connection[end] = Connection(
            end=end,
            joint=joint,
            chord=chord,
            chord_name="+".join(frame.member_name[e // 2] for e in chord),
            chord_diameter=min(float(frame.end_diameter[e]) for e in chord),
            chord_thickness=choice.chord_thickness_m or thickness,
            chord_length=choice.chord_length_m or length,
            diameter=float(frame.end_diameter[end]),
            thickness=float(frame.end_thickness[end]),
            theta=float(np.arctan2(sine, abs(along))),
            along=along,
            axis=axis,
            radial=radial,
            crown=crown,
            normal=np.cross(out, crown),
        )

    def _choice(self, end: int, joint: str) -> JointChoice:
        nothing = JointChoice()
        of_end = self.choices.get(self.frame.end_name[end], nothing)
        of_joint = self.choices.get(joint, nothing)
        fields = ("chord_thickness_m", "chord_length_m")
        return nothing.model_copy(
            update={name: getattr(of_end, name) or getattr(of_joint, name) for name in fields}
        )


def _same(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return all(abs(x - y) <= 1e-6 * abs(y) for x, y in zip(a, b, strict=True))


def _disjoint(pairs: list[tuple[int, int]]) -> list[tuple[int, ...]]:
    """Pairs that share no end with one before."""
    kept: list[tuple[int, ...]] = []
    for pair in pairs:
        if all(end not in other for other in kept for end in pair):
            kept.append(pair)
    return kept
