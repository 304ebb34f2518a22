"""Stress concentration factors of the brace ends of a structure, and the influence of other braces.

The factors that hold for one loaded brace, for balanced axial load of two braces of a plane (K) and for
axial load through the chord (X) are joined by Efthymiou's influence functions (OTH 88): the load of another
brace j adds (one brace - K), or (X - one brace), times N_j sin(theta_j) / (N_i sin(theta_i)). No load path
has to be chosen: under the load of a pure path the sum is the factor of that path, exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sin

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_model.fatigue_config import Fatigue, JointChoice, SideFactors
from owt_postproc.core import efthymiou as eq
from owt_postproc.core.efthymiou import Shape
from owt_postproc.core.joints import Connection, Joints

__all__ = ["CROWN", "IN_PLANE", "LIMITS", "OUT_OF_PLANE", "SADDLE", "SIDES", "Factors", "connection_factors"]

SIDES = ("chord", "brace")
CROWN, SADDLE, IN_PLANE, OUT_OF_PLANE = range(4)
#: Range of the equations; theta in rad, zeta for beta / sin(theta) of 1 at its lower end.
LIMITS = {
    "beta": (0.2, 1.0),
    "gamma": (8.0, 32.0),
    "tau": (0.2, 1.0),
    "theta": (float(np.radians(20.0)), float(np.radians(90.0))),
    "alpha": (4.0, 40.0),
}
ZETA_LIMITS = (-0.6, 1.0)
#: Rounding that is not out of range.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Factors:
    """What multiplies nominal stress at crowns and saddles of one brace end.

    Attributes
    ----------
    kind : str
        Braces of its plane: "T/Y" none, "K" one more on its side, "KT" two or more, "X" opposite ones.
    own : float array [side, 4]
        By chord and brace side: axial at the crown and at the saddle, in-plane and out-of-plane bending of
        the brace, while no other brace is loaded.
    balanced, through : float arrays [side, 2]
        Axial at crown and saddle where the nearest brace on its side balances it, and where an opposite one
        does; NaN without such braces.
    axial : dict of float arrays [side, 2]
        Factors at crown and saddle on the nominal axial stress of other brace ends.
    bending : dict of float arrays [side]
        Factors at the saddle on the nominal out-of-plane bending stress of other brace ends.
    outside : tuple of (str, float, float)
        Parameters outside the range of the equations, their value and the limit.
    """

    kind: str
    own: Float[np.ndarray, "2 4"]
    balanced: Float[np.ndarray, "2 2"]
    through: Float[np.ndarray, "2 2"]
    axial: dict[int, Float[np.ndarray, "2 2"]]
    bending: dict[int, Float[np.ndarray, " 2"]]
    outside: tuple[tuple[str, float, float], ...]


@dataclass(frozen=True)
class _Neighbour:
    """Another brace of a plane: its shape, gap over chord diameter, and whether none stands between."""

    connection: Connection
    shape: Shape
    zeta: float = 0.0
    adjacent: bool = False


def connection_factors(joints: Joints, end: int, fatigue: Fatigue, name: str) -> Factors:
    """Factors of one brace end.

    Parameters
    ----------
    joints : Joints
    end : int
        One that has a connection.
    fatigue : Fatigue
        What the case chooses.
    name : str
        Of the end, for messages and choices.

    Raises
    ------
    InputError
        If the geometry is outside the range of the equations and the case refuses that.
    """
    same, opposite = joints.neighbours(end)
    own = joints.connection[end]
    plane = _Plane.of(own, same, opposite, fatigue)
    outside = plane.outside()
    if outside and fatigue.scf_range == "refuse":
        parameter, value, limit = outside[0]
        raise InputError(
            "fatigue.scf_range",
            f"refuse, {parameter} = {value:.4g} at {name}",
            f"is beyond {limit:.4g}, the range of Efthymiou's equations",
            "Take report, larger or clamp, or give the factors of the joint.",
        )
    as_it_is, limited = plane.values(), plane.limited().values()
    choose: dict[str, Callable[[], Float[np.ndarray, ...]]] = {
        "clamp": lambda: limited,
        "larger": lambda: np.maximum(as_it_is, limited),
    }
    values = choose.get(fatigue.scf_range, lambda: as_it_is)()
    return plane.factors(values, outside, _given(fatigue, own.joint, name))


def _given(fatigue: Fatigue, joint: str, name: str) -> Float[np.ndarray, "2 4"]:
    """Factors that the case gives, NaN where it gives none."""
    found = np.full((2, 4), np.nan)
    for choice in (fatigue.joints.get(joint, JointChoice()), fatigue.joints.get(name, JointChoice())):
        if choice.scf is None:
            continue
        for side, factors in enumerate((choice.scf.chord, choice.scf.brace)):
            for i, field in enumerate(SideFactors.model_fields):
                value = getattr(factors, field)
                if value is not None:
                    found[side, i] = value
    return found


@dataclass(frozen=True)
class _Plane:
    """A brace, its shape, and the other braces of its plane."""

    own: Connection
    shape: Shape
    same: tuple[_Neighbour, ...]
    opposite: tuple[_Neighbour, ...]
    fixity: float
    least: float

    @classmethod
    def of(
        cls, own: Connection, same: list[Connection], opposite: list[Connection], fatigue: Fatigue
    ) -> _Plane:
        by_length = fatigue.chord_effect == "length"
        row = sorted([own, *same], key=lambda c: (c.foot, c.end))
        at = row.index(own)
        neighbours = []
        for other in same:
            j = row.index(other)
            low, high = min(at, j), max(at, j)
            between = sum(c.footprint for c in row[low + 1 : high])
            gaps = sum(
                _gap(a, b, fatigue) for a, b in zip(row[low:high], row[low + 1 : high + 1], strict=True)
            )
            zeta = (gaps + between) / own.chord_diameter
            neighbours.append(_Neighbour(other, _shape(other, by_length), zeta, high == low + 1))
        return cls(
            own,
            _shape(own, by_length),
            tuple(neighbours),
            tuple(_Neighbour(other, _shape(other, by_length)) for other in opposite),
            fatigue.chord_fixity if by_length else eq.CHORD_FIXED,
            fatigue.scf_minimum,
        )

    def limited(self) -> _Plane:
        """The same with all parameters inside the range of the equations."""

        def inside(shape: Shape) -> Shape:
            return Shape(**{k: float(np.clip(getattr(shape, k), *LIMITS[k])) for k in LIMITS})

        def near(other: _Neighbour) -> _Neighbour:
            low, high = self._zeta_limits(inside(self.shape))
            return replace(other, shape=inside(other.shape), zeta=float(np.clip(other.zeta, low, high)))

        return replace(
            self,
            shape=inside(self.shape),
            same=tuple(map(near, self.same)),
            opposite=tuple(replace(other, shape=inside(other.shape)) for other in self.opposite),
        )

    @staticmethod
    def _zeta_limits(shape: Shape) -> tuple[float, float]:
        return ZETA_LIMITS[0] * shape.beta / sin(shape.theta), ZETA_LIMITS[1]

    def outside(self) -> tuple[tuple[str, float, float], ...]:
        """Parameters of the brace that are outside the range, with the limit that they pass."""
        given = [(name, getattr(self.shape, name), LIMITS[name]) for name in LIMITS]
        given += [
            ("zeta", other.zeta, self._zeta_limits(self.shape)) for other in self.same if other.adjacent
        ]
        found = {}
        for name, value, (low, high) in given:
            if not low - ROUNDING <= value <= high + ROUNDING:
                unit = float(np.degrees(1.0)) if name == "theta" else 1.0
                found[name] = (name, value * unit, (low if value < low else high) * unit)
        return tuple(found.values())

    def values(self) -> Float[np.ndarray, "row 2 4"]:
        """Rows: one brace loaded; K with each brace of the same side; X with each opposite one.

        In rows of K the last column is what the neighbour's bending adds, not a factor of its own.
        """
        rows = [self._one_brace(), *map(self._k, self.same), *map(self._x, self.opposite)]
        return np.array(rows)

    def _short(self) -> float:
        fixed = self.fixity == eq.CHORD_FIXED
        return eq.short_chord_fixed(self.shape) if fixed else eq.short_chord_general(self.shape)

    def _one_brace(self) -> list[list[float]]:
        p, c = self.shape, self.fixity
        saddle = self._short() * (eq.x_one_brace(p) if self.opposite else 1.0)
        share = max((-n.zeta * self.own.chord_diameter / self.own.footprint for n in self.same), default=0.0)
        over = eq.overlap_in_plane(p, share)
        bending = eq.short_chord_out_of_plane(p) * self._relief()
        chord = [eq.t6(p, c), eq.t5(p, c) * saddle, eq.t8(p) * over[0], eq.t10(p) * bending]
        brace = [eq.t7(p, c), eq.t3(p) * saddle, eq.t9(p) * over[1], eq.t11(p) * bending]
        return [[max(value, self.least) for value in side] for side in (chord, brace)]

    def _relief(self) -> float:
        """Out-of-plane bending of one brace: what its unloaded neighbours take (K6, KT3, KT4)."""
        p, product = self.shape, 1.0
        sides = {other.connection.foot > self.own.foot for other in self.same}
        for other in self.same:
            power = (other.shape.beta / p.beta) ** 2 if len(sides) > 1 else 1.0
            product *= eq.near(p, other.shape, other.zeta) ** power
        return product

    def _k(self, other: _Neighbour) -> list[list[float]]:
        p, q = self.shape, other.shape
        through = 0.0
        if other.zeta < 0.0:
            mine, its = ((c.thickness, c.diameter) for c in (self.own, other.connection))
            through = 0.5 if mine < its else 1.0
        chord = max(eq.k1(p, [q], other.zeta), self.least)
        brace = max(eq.k2(p, [q], other.zeta, through), self.least)
        # All braces bent alike have F4 on the whole, one brace F3: the difference is the neighbours'.
        beta_max = max(p.beta, *(n.shape.beta for n in self.same))
        f3, f4 = eq.short_chord_out_of_plane(p), eq.short_chord_k(p)
        share = (f4 - f3) * eq.t10(p) * self._relief() / len(self.same)
        carried = f4 * eq.carried(p, q, other.zeta, beta_max) + share
        return [[chord, chord, 0.0, carried], [brace, brace, 0.0, carried * eq.brace_of_out_of_plane(p)]]

    def _x(self, _: _Neighbour) -> list[list[float]]:
        p, f, f3 = self.shape, self._short(), eq.short_chord_out_of_plane(self.shape)
        chord = [eq.x2(p), eq.x1(p) * f, 0.0, eq.x5(p) * f3]
        brace = [eq.x4(p), eq.x3(p) * f, 0.0, eq.x6(p) * f3]
        return [[max(value, self.least) for value in side] for side in (chord, brace)]

    def factors(
        self,
        values: Float[np.ndarray, "row 2 4"],
        outside: tuple[tuple[str, float, float], ...],
        given: Float[np.ndarray, "2 4"],
    ) -> Factors:
        """Join the rows of :meth:`values` by influence functions; what the case gives goes before."""
        n = len(self.same)
        one, k, x = values[0], values[1 : n + 1], values[n + 1 :]
        free = np.isnan(given)
        axial: dict[int, Float[np.ndarray, "2 2"]] = {}
        bending: dict[int, Float[np.ndarray, " 2"]] = {}
        for row, other in zip(k, self.same, strict=True):
            axial[other.connection.end] = (one - row)[:, :2] * free[:, :2] * self._force(other)
            bending[other.connection.end] = row[:, OUT_OF_PLANE] * free[:, OUT_OF_PLANE]
        for row, other in zip(x, self.opposite, strict=True):
            axial[other.connection.end] = (row - one)[:, :2] * free[:, :2] * self._force(other)
            moment = self._sine(other) * other.connection.modulus / self.own.modulus
            bending[other.connection.end] = (row - one)[:, OUT_OF_PLANE] * free[:, OUT_OF_PLANE] * moment
        nearest = min(range(n), key=lambda i: abs(self.same[i].zeta), default=None)
        nothing = np.full((2, 2), np.nan)
        return Factors(
            kind=("KT" if n > 1 else "K" if n else "T/Y" if not len(x) else "") + ("X" if len(x) else ""),
            own=np.where(free, one, given),
            balanced=nothing if nearest is None else k[nearest, :, :2],
            through=x[0, :, :2] if len(x) else nothing,
            axial=axial,
            bending=bending,
            outside=outside if free.any() else (),
        )

    def _sine(self, other: _Neighbour) -> float:
        return sin(other.connection.theta) / sin(self.own.theta)

    def _force(self, other: _Neighbour) -> float:
        """Force across the chord per axial stress of another brace, over that of this one."""
        return self._sine(other) * other.connection.area / self.own.area


def _gap(a: Connection, b: Connection, fatigue: Fatigue) -> float:
    """Gap of two neighbours in m, of the case where it gives one."""
    choice = fatigue.joints.get(a.joint)
    return a.gap(b) if choice is None or choice.gap_m is None else choice.gap_m


def _shape(c: Connection, by_length: bool) -> Shape:
    d = c.chord_diameter
    return Shape(
        beta=c.diameter / d,
        gamma=d / (2.0 * c.chord_thickness),
        tau=c.thickness / c.chord_thickness,
        theta=c.theta,
        alpha=2.0 * c.chord_length / d if by_length else eq.LONG_CHORD,
    )
