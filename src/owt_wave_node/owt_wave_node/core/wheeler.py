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
    Place,
    Prepared,
    Profile,
    Series,
)
from owt_wave_node.core.profile import first_order_profile
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.window import window_of
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
        self.n_axes, self.n = linear.n_axes, linear.n
        self.wavenumber = linear.wavenumber

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First-order elevation in m and zeros."""
        return self._linear.elevation(place)

    def first(self, place: Place) -> Kinematics:
        """Stretched kinematics."""
        out = np.empty((len(place), 2 * self.n_axes, self.n))
        eta, _ = self.elevation(place)
        depth = self.waves.depth
        for p, z in enumerate(place[:, 2]):
            level = np.maximum((z - eta[p]) / (1.0 + eta[p] / depth), -depth)
            self._at_level(place[p : p + 1], level, out[p])
        return out

    def _at_level(
        self,
        place: Float[np.ndarray, "1 3"],
        level: Float[np.ndarray, " time"],
        out: Float[np.ndarray, "channel time"],
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
        coefficient = self._linear.shaped(
            np.repeat(place, count, axis=0), *(transform @ part for part in profile)
        )
        _kernel.series(coefficient, (wet - middle) / half, out)
        above = np.maximum(level, 0.0)
        if above.any():
            k = self.wavenumber[None, :]
            out += above * self._linear.shaped(place, k * np.tanh(k * self.waves.depth), k.copy())[0]

    def second(self, place: Place) -> Kinematics:
        """Zeros: Wheeler stretches the first order only."""
        return np.zeros((len(place), 2 * self.n_axes, self.n))

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """Kinematics with given vertical factors, which leave nothing to stretch."""
        return self._linear.shaped(place, horizontal, vertical)

    def window(self, start: int, count: int) -> Field:
        """Return the field over `count` samples from `start`."""
        return WheelerField(self.waves, window_of(self._linear, start, count))

    def prepare(self, place: Place) -> Prepared:
        """Remember the points."""
        return _WheelerPrepared(self, place)


class _WheelerPrepared:
    def __init__(self, field: WheelerField, place: Place) -> None:
        self._field, self._place = field, place

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._field.first(self._place[index])
