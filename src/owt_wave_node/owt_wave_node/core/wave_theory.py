"""Which theory a regular wave needs, and where it breaks (figure 2.8, after Le Méhauté 1976).

Le Méhauté drew the borders by judgement. Here a Stokes theory of order n suffices where the first harmonic
that it leaves out is below 1 % of the linear wave, and stream function is taken where none does, beyond the
Ursell number 26 that his graph has between Stokes and cnoidal waves, and near breaking. In deep water this
puts the border of linear theory at H/(g T^2) = 0.001, where his graph has it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from owt_wave_node.core.dispersion import wavenumber

__all__ = ["THEORIES", "RegularRegime", "breaking_height", "harmonics", "linear_wavenumber", "regular_regime"]

#: Share of the linear wave below which a harmonic is left out.
NEGLIGIBLE = 0.01
#: Ursell number H L^2 / d^3 between Stokes and long waves (Le Méhauté 1976).
LONG_WAVE_URSELL = 26.0
#: Share of the breaking height above which a series of five terms does not suffice.
NEAR_BREAKING = 0.9
#: Largest height over depth of a wave on a flat bed (McCowan 1894), which rules in very shallow water.
MAX_HEIGHT_OVER_DEPTH = 0.78
#: In ascending ability; "breaking" is no theory.
THEORIES = ("airy", "stokes 2", "stokes 3", "stokes 5", "stream function", "breaking")


@dataclass(frozen=True)
class RegularRegime:
    """A regular wave and where it lies among the theories.

    Attributes
    ----------
    length_m : float
        Linear wave length.
    steepness, relative_depth, ursell : float
        H/L, d/L and H L^2/d^3.
    breaking_height_m : float
        See :func:`breaking_height`.
    theory : str
        One of :data:`THEORIES`.
    """

    height_m: float
    period_s: float
    length_m: float
    depth_m: float
    gravity_m_s2: float
    breaking_height_m: float
    theory: str

    @property
    def steepness(self) -> float:
        """H/L."""
        return self.height_m / self.length_m

    @property
    def relative_depth(self) -> float:
        """d/L."""
        return self.depth_m / self.length_m

    @property
    def water(self) -> str:
        """Deep (d/L > 1/2), intermediate, or shallow (d/L < 1/20) water."""
        ratio = self.relative_depth
        return "deep" if ratio > 0.5 else "shallow" if ratio < 0.05 else "intermediate"

    @property
    def ursell(self) -> float:
        """H L^2 / d^3."""
        return self.height_m * self.length_m**2 / self.depth_m**3

    @property
    def diagram(self) -> tuple[float, float]:
        """Coordinates d/(g T^2) and H/(g T^2) of figure 2.8."""
        scale = self.gravity_m_s2 * self.period_s**2
        return self.depth_m / scale, self.height_m / scale

    def as_dict(self) -> dict[str, float | str]:
        """Plain numbers with units in their keys."""
        names = ("height_m", "period_s", "length_m", "steepness", "relative_depth", "water", "ursell",
                 "breaking_height_m", "theory")  # fmt: skip
        d, h = self.diagram
        return {name: getattr(self, name) for name in names} | {"d_over_gT2": d, "H_over_gT2": h}


def linear_wavenumber(period: float, *, depth: float, gravity: float) -> float:
    """Wave number in rad/m of a period in s."""
    return float(wavenumber(np.array([2.0 * math.pi / period]), water_depth=depth, gravity=gravity)[0])


def breaking_height(wavenumber: float, depth: float) -> float:
    """Height in m at which a wave breaks: the smaller of 0.142 L tanh kd (Miche 1944) and 0.78 d."""
    miche = 0.142 * 2.0 * math.pi / wavenumber * math.tanh(wavenumber * depth)
    return min(miche, MAX_HEIGHT_OVER_DEPTH * depth)


def harmonics(wavenumber: float, height: float, depth: float) -> tuple[float, float, float, float]:
    """Highest harmonic of the elevation at orders 2, 3, 4 and 5, over the linear amplitude H/2.

    Fenton (1985), J. Waterway 111, 216-234, table 1: eps B22, eps^2 B33, eps^3 B44, eps^4 B55, eps = k H/2.
    """
    kd, e = wavenumber * depth, 0.5 * wavenumber * height
    kd = min(kd, 300.0)  # deep beyond any doubt, and cosh stays finite
    S = 1.0 / math.cosh(2.0 * kd)
    C, coth = 2.0 * math.sinh(kd) ** 2 * S, 1.0 / math.tanh(kd)  # C = 1 - S without cancellation
    b22 = coth * (1.0 + 2.0 * S) / (2.0 * C)
    b33 = 3.0 * (1.0 + 3.0 * S + 3.0 * S**2 + 2.0 * S**3) / (8.0 * C**3)
    b44 = np.polyval([34.0, 67.0, 66.0, 122.0, 92.0, 24.0], S) * coth / (24.0 * (3.0 + 2.0 * S) * C**4)
    b55 = 5.0 * np.polyval([130.0, 827.0, 1326.0, 675.0, 1188.0, 2949.0, 3176.0, 1579.0, 300.0], S)
    b55 /= 384.0 * (3.0 + 2.0 * S) * (4.0 + S) * C**6
    return e * b22, e**2 * b33, e**3 * float(b44), e**4 * float(b55)


def regular_regime(*, height: float, period: float, depth: float, gravity: float) -> RegularRegime:
    """Classify a regular wave of height in m and period in s."""
    k = linear_wavenumber(period, depth=depth, gravity=gravity)
    limit = breaking_height(k, depth)
    length = 2.0 * math.pi / k
    second, third, fourth, fifth = harmonics(k, height, depth)
    sixth = fifth * fifth / fourth if fourth > 0.0 else 0.0  # by the ratio of the two before it
    left_out = ((1, second), (2, third), (3, fourth), (5, sixth))
    order = next((n for n, ratio in left_out if ratio < NEGLIGIBLE), None)
    if height >= limit:
        theory = "breaking"
    elif order is None or height * length**2 / depth**3 > LONG_WAVE_URSELL or height > NEAR_BREAKING * limit:
        theory = "stream function"
    else:
        theory = "airy" if order == 1 else f"stokes {order}"
    return RegularRegime(height, period, length, depth, gravity, limit, theory)
