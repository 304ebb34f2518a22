"""Efthymiou's stress concentration factors of tubular joints, equation by equation.

Numbers T1 to KTB are those of API RP 2A-WSD, 22nd edition, tables B.8.1 to B.8.4; the numbers in brackets
those of DNV-RP-C203, appendix B, which prints the same set. A factor is hot-spot stress over nominal stress
in the brace. Angles are in rad; theta lies between chord and brace, beta = d/D, gamma = D/(2 T),
tau = t/T, alpha = 2 L/D, zeta = gap/D.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, exp, sin, sqrt

__all__ = [
    "CHORD_FIXED",
    "LONG_CHORD",
    "Shape",
    "brace_of_out_of_plane",
    "carried",
    "k1",
    "k2",
    "near",
    "overlap_in_plane",
    "short_chord_fixed",
    "short_chord_general",
    "short_chord_k",
    "short_chord_out_of_plane",
    "t3",
    "t5",
    "t6",
    "t7",
    "t8",
    "t9",
    "t10",
    "t11",
    "x1",
    "x2",
    "x3",
    "x4",
    "x5",
    "x6",
    "x_one_brace",
]

#: Chord fixity C of fixed ends; T5, T6 and T7 are then T1, T2 and T4.
CHORD_FIXED = 0.5
#: Alpha from which a chord is long.
LONG_CHORD = 12.0


@dataclass(frozen=True)
class Shape:
    """Parameters of one brace on its chord."""

    beta: float
    gamma: float
    tau: float
    theta: float
    alpha: float


def t5(p: Shape, fixity: float) -> float:
    """Chord saddle, axial (5); T1 (1) where the chord's ends are fixed."""
    t1 = p.gamma * p.tau**1.1 * (1.11 - 3.0 * (p.beta - 0.52) ** 2) * sin(p.theta) ** 1.6
    bending = (0.8 * p.alpha - 6.0) * p.tau * p.beta**2 * sqrt(max(1.0 - p.beta**2, 0.0))
    return float(t1 + 2.0 * (fixity - 0.5) * bending * sin(2.0 * p.theta) ** 2)


def t6(p: Shape, fixity: float) -> float:
    """Chord crown, axial (6); T2 (2) where the chord's ends are fixed."""
    wall = p.gamma**0.2 * p.tau * (2.65 + 5.0 * (p.beta - 0.65) ** 2)
    return float(wall + p.tau * p.beta * (0.5 * fixity * p.alpha - 3.0) * sin(p.theta))


def t3(p: Shape) -> float:
    """Brace saddle, axial (3)."""
    wall = 0.187 - 1.25 * p.beta**1.1 * (p.beta - 0.96)
    return float(1.3 + p.gamma * p.tau**0.52 * p.alpha**0.1 * wall * sin(p.theta) ** (2.7 - 0.01 * p.alpha))


def t7(p: Shape, fixity: float) -> float:
    """Brace crown, axial (7); T4 (4) where the chord's ends are fixed."""
    return x4(p) + p.beta * p.tau * (0.2 * fixity * p.alpha - 1.2)


def t8(p: Shape) -> float:
    """Chord crown, in-plane bending (8)."""
    return float(1.45 * p.beta * p.tau**0.85 * p.gamma ** (1.0 - 0.68 * p.beta) * sin(p.theta) ** 0.7)


def t9(p: Shape) -> float:
    """Brace crown, in-plane bending (9)."""
    wall = 0.65 * p.beta * p.tau**0.4 * p.gamma ** (1.09 - 0.77 * p.beta)
    return float(1.0 + wall * sin(p.theta) ** (0.06 * p.gamma - 1.16))


def t10(p: Shape) -> float:
    """Chord saddle, out-of-plane bending (10)."""
    return float(p.gamma * p.tau * p.beta * (1.7 - 1.05 * p.beta**3) * sin(p.theta) ** 1.6)


def brace_of_out_of_plane(p: Shape) -> float:
    """Factor from the chord saddle to the brace saddle in out-of-plane bending, of T11, X6, K5 and KTB."""
    return float(p.tau**-0.54 * p.gamma**-0.05 * (0.99 - 0.47 * p.beta + 0.08 * p.beta**4))


def t11(p: Shape) -> float:
    """Brace saddle, out-of-plane bending (11)."""
    return brace_of_out_of_plane(p) * t10(p)


def short_chord_fixed(p: Shape) -> float:
    """F1: saddles under axial load on a short chord with fixed ends."""
    decay = exp(-0.21 * p.gamma**-1.16 * p.alpha**2.5)
    return _short(p, (0.83 * p.beta - 0.56 * p.beta**2 - 0.02) * p.gamma**0.23 * decay)


def short_chord_general(p: Shape) -> float:
    """F2: saddles under axial load on a short chord of general fixity."""
    decay = exp(-0.71 * p.gamma**-1.38 * p.alpha**2.5)
    return _short(p, (1.43 * p.beta - 0.97 * p.beta**2 - 0.03) * p.gamma**0.04 * decay)


def short_chord_out_of_plane(p: Shape) -> float:
    """F3: saddles under out-of-plane bending of one brace, or of two through a short chord."""
    return _short(p, 0.55 * p.beta**1.8 * p.gamma**0.16 * exp(-0.49 * p.gamma**-0.89 * p.alpha**1.8))


def short_chord_k(p: Shape) -> float:
    """F4: saddles under out-of-plane bending of all braces of a K or KT joint on a short chord."""
    return _short(p, 1.07 * p.beta**1.88 * exp(-0.16 * p.gamma**-1.06 * p.alpha**2.4))


def _short(p: Shape, reduction: float) -> float:
    return 1.0 - reduction if p.alpha < LONG_CHORD else 1.0


def x1(p: Shape) -> float:
    """Chord saddle, axial load through the chord (12)."""
    return float(3.87 * p.gamma * p.tau * p.beta * (1.10 - p.beta**1.8) * sin(p.theta) ** 1.7)


def x2(p: Shape) -> float:
    """Chord crown, axial load through the chord (13)."""
    wall = p.gamma**0.2 * p.tau * (2.65 + 5.0 * (p.beta - 0.65) ** 2)
    return float(wall - 3.0 * p.tau * p.beta * sin(p.theta))


def x3(p: Shape) -> float:
    """Brace saddle, axial load through the chord (14)."""
    wall = 1.9 * p.gamma * p.tau**0.5 * p.beta**0.9 * (1.09 - p.beta**1.7)
    return float(1.0 + wall * sin(p.theta) ** 2.5)


def x4(p: Shape) -> float:
    """Brace crown, axial load through the chord (15)."""
    return float(3.0 + p.gamma**1.2 * (0.12 * exp(-4.0 * p.beta) + 0.011 * p.beta**2 - 0.045))


def x5(p: Shape) -> float:
    """Chord saddle, balanced out-of-plane bending of two braces through the chord (16)."""
    return float(p.gamma * p.tau * p.beta * (1.56 - 1.34 * p.beta**4) * sin(p.theta) ** 1.6)


def x6(p: Shape) -> float:
    """Brace saddle, balanced out-of-plane bending of two braces through the chord (17)."""
    return brace_of_out_of_plane(p) * x5(p)


def x_one_brace(p: Shape) -> float:
    """Factor on the saddles of T5 and T3 where another brace stands opposite without load (18, 19)."""
    return 1.0 - 0.26 * p.beta**3


def k1(p: Shape, others: Sequence[Shape], zeta: float) -> float:
    """Chord under the brace `p`, axial load balanced by others of its plane (20)."""
    sines = sorted(sin(q.theta) for q in (p, *others))
    betas = sorted(q.beta for q in (p, *others))
    wall = p.tau**0.9 * p.gamma**0.5 * (0.67 - p.beta**2 + 1.16 * p.beta) * sin(p.theta)
    pair = (sines[-1] / sines[0]) ** 0.30 * (betas[-1] / betas[0]) ** 0.30
    return float(wall * pair * (1.64 + 0.29 * p.beta**-0.38 * atan(8.0 * zeta)))


def k2(p: Shape, others: Sequence[Shape], zeta: float, through: float) -> float:
    """Brace `p`, axial load balanced by others of its plane (21).

    `through` is 0 for a gap, 1 for the through brace of an overlap and 0.5 for the overlapping one.
    """
    gap = 1.0 + k1(p, others, zeta) * (1.97 - 1.57 * p.beta**0.25) * p.tau**-0.14 * sin(p.theta) ** 0.7
    if through == 0.0:
        return float(gap)
    angles = sorted(q.theta for q in (p, *others))
    both = max(sin(angles[-1] + angles[0]), 0.0) ** 1.8
    wall = through * p.beta**1.5 * p.gamma**0.5 * p.tau**-1.22
    return float(gap + wall * both * (0.131 - 0.084 * atan(14.0 * zeta + 4.2 * p.beta)))


def overlap_in_plane(p: Shape, overlap: float) -> tuple[float, float]:
    """Factors on T8 and T9 of a brace whose contact length another overlaps by the share `overlap` (24)."""
    if overlap <= 0.0:
        return 1.0, 1.0
    return (1.2 if overlap > 0.3 else 1.0), 0.9 + 0.4 * p.beta


def near(p: Shape, other: Shape, zeta: float) -> float:
    """Relief at the saddle of `p` by the stiffness of an unloaded neighbour (25, 30)."""
    return 1.0 - 0.08 * sqrt(other.beta * p.gamma) * exp(-0.8 * _distance(p, zeta))


def carried(p: Shape, other: Shape, zeta: float, beta_max: float) -> float:
    """Chord at the saddle of `p` under out-of-plane bending of its neighbour: second term of K4 (22, 27)."""
    x = _distance(p, zeta)
    relief = 1.0 - 0.08 * sqrt(p.beta * p.gamma) * exp(-0.8 * x)
    return t10(other) * relief * 2.05 * sqrt(beta_max) * exp(-1.3 * x)


def _distance(p: Shape, zeta: float) -> float:
    """X of K4 and KT1: 1 + zeta sin(theta) / beta."""
    return 1.0 + zeta * sin(p.theta) / p.beta
