"""Wheeler stretching of the first order [eq. 2.17, 2.18].

The stretched level z' of a fixed point moves with the surface. The linear field is evaluated at the
Chebyshev levels of the range that z' covers, as many as make the interpolation exact to 1e-11 of its root
mean square, and interpolated in z' at every time.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from owt_model.errors import ComputationError
from owt_wave_node.core.chebyshev import chebyshev_basis
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

#: Bound on the error of the interpolation, relative to the root mean square.
TOLERANCE = 1e-11
MAX_LEVELS = 400
#: Numbers of levels that are tried at a time.
BLOCK = 20


def _level_count(waves: Waves, middle: float, half: float) -> int:
    """Levels that interpolate all components over `middle` +- `half`.

    The Chebyshev coefficients of exp(e s) are 2 I_j(e) <= 2 (e / 2)^j / j! exp(e^2 / 4 / (j + 1)).

    Raises
    ------
    ComputationError
        If more than 400 are needed.
    """
    # Of the accelerations, in which short waves weigh most; the velocities need no more.
    weight = np.abs(waves.amplitude) * waves.wavenumber * np.exp(waves.wavenumber * middle)
    exponent = waves.wavenumber * half
    allowed = TOLERANCE * np.sqrt(0.5 * np.sum(weight**2))
    term = 2.0 * weight
    for start in range(1, MAX_LEVELS, BLOCK):
        order = np.arange(start, start + BLOCK)[:, None]
        terms = term * np.cumprod(0.5 * exponent / order, axis=0)
        bound = (terms * np.exp(np.minimum(0.25 * exponent**2 / (order + 1.0), 600.0))).sum(axis=1)
        if (bound <= allowed).any():
            return start + int(np.argmax(bound <= allowed)) + 1
        term = terms[-1]
    raise ComputationError(
        f"Wheeler stretching over k dz = {2.0 * exponent.max():.3g} needs too many levels; lower the cut-off"
    )


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

    @property
    def error_estimate(self) -> float:
        """Error of the linear field; zero where it is exact."""
        return float(getattr(self._linear, "error_estimate", 0.0))

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
        wet, above = np.minimum(level, 0.0), np.maximum(level, 0.0)
        low, high = float(wet.min()), float(wet.max())
        middle, half = 0.5 * (high + low), max(0.5 * (high - low), 1e-12)
        count = _level_count(self.waves, middle, half)
        node, transform = chebyshev_basis(count)
        profile = first_order_profile(
            self.wavenumber,
            np.minimum(middle + half * node, 0.0),
            water_depth=self.waves.depth,
            stretching="constant",
        )
        horizontal, vertical = (transform @ part for part in profile)
        if above.any():  # one more row: the slopes at still water
            k = self.wavenumber
            horizontal = np.vstack([horizontal, k * np.tanh(k * self.waves.depth)])
            vertical = np.vstack([vertical, k])
        motion = self._linear.shaped(np.repeat(place, len(horizontal), axis=0), horizontal, vertical)
        _kernel.series(motion[:count], (wet - middle) / half, out)
        if len(motion) > count:
            out += above * motion[count]

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
