"""Hot spots of all member ends: where stress is counted, as a linear map from the nominal stress.

Eight points on the chord side and eight on the brace side of every brace end, superposed as in DNV-RP-C203,
3.3.2: sigma(phi) = (AC cos^2 + AS sin^2) axial + MIP cos in_plane + MOP sin out_of_plane, phi from the crown
toe, and the influence of the other braces of the joint (:mod:`owt_postproc.core.scf`). All other ends have
eight points of the wall with nominal stress, phi from element axis y towards z.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from owt_model.axes import rotation
from owt_model.fatigue_config import Fatigue
from owt_model.frame import Frame
from owt_postproc.core.joints import Connection, Joints, find_joints
from owt_postproc.core.scf import CROWN, IN_PLANE, OUT_OF_PLANE, SADDLE, SIDES, Factors, connection_factors

__all__ = ["AXIAL", "BENDING_Y", "BENDING_Z", "POINT_ANGLE_DEG", "HotSpots", "build_hot_spots", "wall_spots"]

N_POINTS = 8
#: Angles of the points of one side, in degrees.
POINT_ANGLE_DEG = 360.0 / N_POINTS * np.arange(N_POINTS)
AXIAL, BENDING_Y, BENDING_Z = range(3)
#: Factors by member end and component of its nominal stress.
Terms = dict[tuple[int, int], float]
WALL = "wall"
#: Sides of spots, in the order of their numbers in messages.
SPOT_SIDES = (WALL, *SIDES)
#: Factor on the nominal stress of the chord at its crowns (API RP 2A-WSD, B.8.3.1).
CHORD_STRESS_FACTOR = 1.25
#: Columns of :attr:`HotSpots.scf`.
SCF_NAMES = (
    "axial_crown",
    "axial_saddle",
    "in_plane",
    "out_of_plane",
    "balanced_crown",
    "balanced_saddle",
    "through_crown",
    "through_saddle",
)


@dataclass(frozen=True)
class HotSpots:
    """Where stress is counted, and its linear map from the nominal stress of the member ends.

    Attributes
    ----------
    name : tuple of str [spot]
        Like ``M056:J21 chord 90``.
    end : int array [spot]
        Member end that a spot belongs to, ascending.
    side : tuple of str [spot]
        ``chord``, ``brace``, or ``wall`` where no tubular connection is.
    angle_deg : float array [spot]
        From the crown toe of a connection; on a wall from element axis y towards z.
    thickness_m : float array [spot]
        Wall that a crack would grow through.
    scf : float array [spot, 8]
        Factors of the spot's connection and side, by ``SCF_NAMES``: those of one brace loaded, and axial load
        balanced by a brace of the same side and through the chord; NaN where there is none.
    kind : tuple of str [end]
        Class of the joint that the end makes: ``T/Y``, ``K``, ``KT``, ``X``, ``KX``, ``KTX``; empty without.
    reason : tuple of str [end]
        Why an end has no tubular connection; empty where it has one.
    warnings : tuple of str
        Parameters out of the range of the equations, one line per class of joint and parameter.
    remarks : tuple of str
        What else a reader of results should know: ends without a connection.
    start : int array [spot + 1]
        The terms of spot i are start[i] to start[i + 1].
    term_end, term_component : int arrays [term]
        Member end, and ``AXIAL``, ``BENDING_Y`` or ``BENDING_Z``, whose nominal stress a term takes.
    term_factor : float array [term]
    """

    name: tuple[str, ...]
    end: Int[np.ndarray, " spot"]
    side: tuple[str, ...]
    angle_deg: Float[np.ndarray, " spot"]
    thickness_m: Float[np.ndarray, " spot"]
    scf: Float[np.ndarray, "spot 8"]
    kind: tuple[str, ...]
    reason: tuple[str, ...]
    warnings: tuple[str, ...]
    remarks: tuple[str, ...]
    start: Int[np.ndarray, " edge"]
    term_end: Int[np.ndarray, " term"]
    term_component: Int[np.ndarray, " term"]
    term_factor: Float[np.ndarray, " term"]

    @cached_property
    def side_code(self) -> Int[np.ndarray, " spot"]:
        """Side of each spot as a number: 0 wall, 1 chord, 2 brace."""
        return np.array([SPOT_SIDES.index(side) for side in self.side], dtype=np.int64)

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings and remarks."""
        return (*self.warnings, *self.remarks)

    @property
    def n_spots(self) -> int:
        """Number of hot spots."""
        return len(self.name)

    @property
    def n_ends(self) -> int:
        """Number of member ends."""
        return len(self.kind)

    @cached_property
    def first(self) -> Int[np.ndarray, " end"]:
        """First spot of each end."""
        return np.searchsorted(self.end, np.arange(self.n_ends))

    def largest(self, values: Float[np.ndarray, " spot"]) -> Float[np.ndarray, " end"]:
        """Largest value of each end's spots."""
        return np.asarray(np.maximum.reduceat(values, self.first))

    def worst(self, values: Float[np.ndarray, " spot"]) -> Int[np.ndarray, " end"]:
        """Spot of largest value of each end; the first of equal ones."""
        candidate = np.flatnonzero(values == self.largest(values)[self.end])
        return candidate[np.searchsorted(self.end[candidate], np.arange(self.n_ends))]

    def sources(self, spot: int) -> Int[np.ndarray, " source"]:
        """Member ends whose stress a spot takes."""
        return np.unique(self.term_end[self.start[spot] : self.start[spot + 1]])

    def stress(
        self,
        spot: int,
        axial: Float[np.ndarray, "sample end"],
        bending_y: Float[np.ndarray, "sample end"],
        bending_z: Float[np.ndarray, "sample end"],
    ) -> Float[np.ndarray, " sample"]:
        """Hot-spot stress in Pa of one spot from the nominal stress in Pa of all ends."""
        given = (axial, bending_y, bending_z)
        total = np.zeros(len(axial))
        for i in range(self.start[spot], self.start[spot + 1]):
            total = total + self.term_factor[i] * given[self.term_component[i]][:, self.term_end[i]]
        return total


@dataclass
class _Spots:
    """Spots in the order in which they are added."""

    frame: Frame

    def __post_init__(self) -> None:
        first, last = (self.frame.node_position[self.frame.member_node[:, i]] for i in range(2))
        self.axes = np.repeat(rotation(first, last), 2, axis=0)
        self.name: list[str] = []
        self.end: list[int] = []
        self.side: list[str] = []
        self.angle: list[float] = []
        self.thickness: list[float] = []
        self.scf: list[np.ndarray] = []
        self.start = [0]
        self.terms: list[tuple[int, int, float]] = []

    def along(self, end: int, direction: Float[np.ndarray, " 3"]) -> tuple[float, float]:
        """Factors on bending_y and bending_z of the normal stress at the fibre in a direction."""
        _, y, z = self.axes[end]
        return float(direction @ z), float(direction @ y)

    def add(self, end: int, side: str, angle: float, thickness: float, scf: np.ndarray, terms: Terms) -> None:
        """Add a spot; terms by member end and component."""
        self.name.append(f"{self.frame.end_name[end]} {side} {angle:g}")
        self.end.append(end)
        self.side.append(side)
        self.angle.append(angle)
        self.thickness.append(thickness)
        self.scf.append(scf)
        self.terms += [(*source, factor) for source, factor in terms.items()]
        self.start.append(len(self.terms))

    def wall(self, end: int, factor: float) -> None:
        """Add the eight points of a wall."""
        none = np.full(len(SCF_NAMES), np.nan)
        for angle in POINT_ANGLE_DEG:
            cosine, sine = _circle(float(angle))
            terms = {(end, AXIAL): factor, (end, BENDING_Y): factor * sine, (end, BENDING_Z): factor * cosine}
            self.add(end, WALL, float(angle), float(self.frame.end_thickness[end]), none, terms)

    def connection(self, own: Connection, joints: Joints, factors: Factors, by_frame: bool) -> None:
        """Add the sixteen points of a connection."""
        for s, side in enumerate(SIDES):
            chord = own.chord if by_frame and side == "chord" else ()
            thickness = own.chord_thickness if side == "chord" else own.thickness
            scf = np.concatenate([factors.own[s], factors.balanced[s], factors.through[s]])
            for angle in POINT_ANGLE_DEG:
                terms = self._terms(own, joints, factors, s, chord, float(angle))
                self.add(own.end, side, float(angle), thickness, scf, terms)

    def _terms(
        self, own: Connection, joints: Joints, factors: Factors, s: int, chord: tuple[int, ...], angle: float
    ) -> Terms:
        """Terms of the spot at an angle on side `s`, with the nominal stress of the ends `chord`."""
        mine, end = factors.own[s], own.end
        cosine, sine = _circle(angle)
        bending = mine[IN_PLANE] * cosine * own.crown + mine[OUT_OF_PLANE] * sine * own.normal
        y, z = self.along(end, bending)
        axial = float(mine[CROWN] * cosine**2 + mine[SADDLE] * sine**2)
        terms: Terms = {(end, AXIAL): axial, (end, BENDING_Y): y, (end, BENDING_Z): z}
        for other, influence in factors.axial.items():
            crown, saddle = influence[s]
            terms[other, AXIAL] = float(crown * cosine**2 + saddle * sine**2)
        for other, influence in factors.bending.items():
            its = joints.connection[other].normal
            fibre = its if its @ own.normal > 0.0 else -its
            terms[other, BENDING_Y], terms[other, BENDING_Z] = self.along(other, influence[s] * sine * fibre)
        for other in chord:
            factor = CHORD_STRESS_FACTOR * cosine**2 / len(chord)
            terms[other, AXIAL] = factor
            terms[other, BENDING_Y], terms[other, BENDING_Z] = self.along(other, factor * own.radial)
        return {source: factor for source, factor in terms.items() if factor != 0.0 or source[0] == end}

    def finish(
        self, kind: list[str], reason: tuple[str, ...], warnings: tuple[str, ...], remarks: tuple[str, ...]
    ) -> HotSpots:
        """Put the spots together."""
        end, component, factor = ([term[i] for term in self.terms] for i in range(3))
        return HotSpots(
            name=tuple(self.name),
            end=np.array(self.end, dtype=np.int64),
            side=tuple(self.side),
            angle_deg=np.array(self.angle, dtype=np.float64),
            thickness_m=np.array(self.thickness, dtype=np.float64),
            scf=np.reshape(self.scf, (-1, len(SCF_NAMES))),
            kind=tuple(kind),
            reason=reason,
            warnings=warnings,
            remarks=remarks,
            start=np.array(self.start, dtype=np.int64),
            term_end=np.array(end, dtype=np.int64),
            term_component=np.array(component, dtype=np.int64),
            term_factor=np.array(factor, dtype=np.float64),
        )


def _circle(angle_deg: float) -> tuple[float, float]:
    """Cosine and sine, exact at multiples of 90 degrees."""
    angle = np.deg2rad(angle_deg)
    return float(np.cos(angle).round(15)), float(np.sin(angle).round(15))


def wall_spots(frame: Frame, factor: float = 1.0) -> HotSpots:
    """Eight points with nominal stress at every end, times `factor`."""
    made = _Spots(frame)
    for end in range(frame.n_ends):
        made.wall(end, factor)
    reason = ("the case counts nominal stress",) * frame.n_ends
    return made.finish([""] * frame.n_ends, reason, (), ())


def build_hot_spots(frame: Frame, fatigue: Fatigue) -> HotSpots:
    """Hot spots of a structure, by the geometry of its joints.

    Parameters
    ----------
    frame : Frame
        Lines and walls of the members.
    fatigue : Fatigue
        What the case chooses.

    Raises
    ------
    InputError
        If a choice names what is not there, or the geometry is out of a range that the case refuses.
    """
    joints = find_joints(frame, fatigue.joints)
    if fatigue.hot_spots == "nominal":
        return wall_spots(frame, fatigue.scf)
    made = _Spots(frame)
    kind, found = [""] * frame.n_ends, {}
    for end in range(frame.n_ends):
        if end not in joints.connection:
            made.wall(end, fatigue.scf)
            continue
        found[end] = connection_factors(joints, end, fatigue, frame.end_name[end])
        kind[end] = found[end].kind
        made.connection(joints.connection[end], joints, found[end], fatigue.chord_effect == "frame")
    warnings = _out_of_range(found, frame, fatigue.scf_range)
    return made.finish(kind, joints.reason, warnings, _without_connection(joints.reason))


def _out_of_range(found: dict[int, Factors], frame: Frame, how: str) -> tuple[str, ...]:
    """One line for each class of joint and parameter that is out of range."""
    groups: dict[tuple[str, str], list[tuple[float, float, str]]] = {}
    for end, factors in found.items():
        for name, value, limit in factors.outside:
            groups.setdefault((factors.kind, name), []).append((value, limit, frame.end_name[end]))
    done = {"report": "taken as it is", "larger": "the larger factor used", "clamp": "the limit used"}
    lines = []
    for (kind, name), ends in groups.items():
        value, limit, at = max(ends, key=lambda entry: abs(entry[0] - entry[1]))
        lines.append(
            f"hot spots: {name} of {len(ends)} brace ends in {kind} joints is out of range, "
            f"worst {value:.3g} (limit {limit:.3g}) at {at}: {done[how]}"
        )
    return tuple(lines)


def _without_connection(reason: tuple[str, ...]) -> tuple[str, ...]:
    """One line for the ends that are neither brace nor chord nor run on."""
    quiet = ("is the chord at", "runs on at")
    ends = Counter(text for text in reason if text and not text.startswith(quiet))
    if not ends:
        return ()
    first = ", ".join(list(ends)[:3]) + (", ..." if len(ends) > 3 else "")
    return (f"hot spots: {sum(ends.values())} ends without a connection have nominal stress: {first}",)
