"""Wheeler stretching of the first order [eq. 2.17, 2.18].

The stretched level z' of a fixed point moves with the surface. The linear field is evaluated at the
Chebyshev levels of the range that z' covers, as many as make the interpolation exact to round-off, and
interpolated in z' at every time.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float, Int

from owt_model.errors import ComputationError
from owt_wave_node.core.field import (
    Field,
    Kinematics,
    Points,
    Prepared,
    Profile,
    Series,
)
from owt_wave_node.core.profile import first_order_profile
from owt_wave_node.core.sea import Waves
from owt_wave_node.kernels import wheeler as _kernel

__all__ = ["WheelerField"]

#: Bound on the error of the interpolation, relative to the largest value in the range of levels.
TOLERANCE = 1e-13
MAX_LEVELS = 400


def _level_count(exponent: float) -> int:
    """Levels that interpolate exp(k z) to round-off where k times half the range is `exponent`.

    The Chebyshev coefficients of exp(e s) are 2 I_j(e) <= 2 (e / 2)^j / j! exp(e^2 / 4 / (j + 1)); they are
    compared with the largest value, exp(e).
    """
    term, count = 2.0, 0
    while term > TOLERANCE:
        count += 1
        term *= 0.5 * exponent / count
        bound = term * math.exp(min(0.25 * exponent**2 / (count + 1) - exponent, 0.0))
        if bound <= TOLERANCE and count > exponent:
            break
        if count > MAX_LEVELS:
            raise ComputationError(
                f"Wheeler stretching over k dz = {2.0 * exponent:.3g} needs too many levels; "
                "lower the cut-off"
            )
    return count + 2


class WheelerField:
    """First order at z' = (z - eta) / (1 + eta / d), evaluated at every time (order 1 only).

    Velocities and local accelerations are those of the linear field at the level z'. Above the surface, where
    the formula does not hold, the profile continues along its tangent at the surface.
    """

    def __init__(self, waves: Waves, linear: Field) -> None:
        self.waves = waves
        self._linear = linear
        self.wavenumber = linear.wavenumber

    def elevation(self, x: Points) -> tuple[Series, Series]:
        """First-order elevation in m and zeros."""
        return self._linear.elevation(x)

    def first(self, x: Points, z: Points) -> Kinematics:
        """Stretched kinematics."""
        out = np.empty((x.size, 4, self.waves.n))
        eta, _ = self.elevation(x)
        depth = self.waves.depth
        for p in range(x.size):
            level = np.maximum((z[p] - eta[p]) / (1.0 + eta[p] / depth), -depth)
            self._at_level(x[p : p + 1], level, out[p])
        return out

    def _at_level(
        self, x: Float[np.ndarray, " 1"], level: Float[np.ndarray, " time"], out: Float[np.ndarray, "4 time"]
    ) -> None:
        """Kinematics at a level in m that changes with time."""
        wet = np.minimum(level, 0.0)
        low, high = float(wet.min()), float(wet.max())
        middle, half = 0.5 * (high + low), max(0.5 * (high - low), 1e-12)
        count = _level_count(float(self.wavenumber.max()) * half)
        node = np.cos(np.pi * (np.arange(count) + 0.5) / count)
        profile = first_order_profile(
            self.wavenumber,
            np.minimum(middle + half * node, 0.0),
            water_depth=self.waves.depth,
            stretching="constant",
        )
        # Discrete cosine transform from values at the nodes to coefficients of the series.
        transform = np.cos(np.outer(np.arange(count), np.arccos(node))) * (2.0 / count)
        transform[0] *= 0.5
        coefficient = self._linear.shaped(np.full(count, x[0]), *(transform @ part for part in profile))
        _kernel.series(coefficient, (wet - middle) / half, out)
        above = np.maximum(level, 0.0)
        if above.any():
            k = self.wavenumber[None, :]
            out += above * self._linear.shaped(x, k * np.tanh(k * self.waves.depth), k.copy())[0]

    def second(self, x: Points, z: Points) -> Kinematics:
        """Zeros: Wheeler stretches the first order only."""
        return np.zeros((x.size, 4, self.waves.n))

    def shaped(self, x: Points, horizontal: Profile, vertical: Profile) -> Kinematics:
        """Kinematics with given vertical factors, which leave nothing to stretch."""
        return self._linear.shaped(x, horizontal, vertical)

    def prepare(self, x: Points, z: Points) -> Prepared:
        """Remember the points."""
        return _WheelerPrepared(self, x, z)


class _WheelerPrepared:
    def __init__(self, field: WheelerField, x: Points, z: Points) -> None:
        self._field, self._x, self._z = field, x, z

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some 4 time"]:
        return self._field.first(self._x[index], self._z[index])
