"""Grue's velocity profile under the crest of a steep wave in deep water [eq. 2.20, 2.21].

Grue, Clamond, Huseby and Jensen (2003), Kinematics of extreme waves in deep water, Appl. Ocean Res. 25,
355-366: the height of a crest and the time between the troughs around it give the velocity below the crest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.errors import ComputationError, InputError

__all__ = ["GrueCrest", "grue_crest", "trough_to_trough"]

#: Largest k eta_m of the measured waves that the profile was found in.
MAX_STEEPNESS = 0.62
#: Depth over local wave length from which water counts as deep.
DEEP = 0.5
MAX_ITERATIONS = 50


@dataclass(frozen=True)
class GrueCrest:
    """A crest and the wave that is fitted to it.

    Attributes
    ----------
    slope : float
        epsilon.
    wavenumber : float
        Local wave number k in rad/m.
    """

    crest: float
    slope: float
    wavenumber: float
    gravity: float

    def velocity(self, z: Float[np.ndarray, " level"]) -> Float[np.ndarray, " level"]:
        """Horizontal velocity epsilon sqrt(g/k) exp(kz) in m/s under the crest, at levels z in m [eq. 2.21].

        Levels above the crest take its value.
        """
        scale = self.slope * math.sqrt(self.gravity / self.wavenumber)
        return np.asarray(scale * np.exp(self.wavenumber * np.minimum(z, self.crest)))


def grue_crest(crest: float, period: float, *, water_depth: float, gravity: float) -> GrueCrest:
    """Solve omega^2/(gk) = 1 + e^2 and k eta_m = e + e^2/2 + e^3/2 for k and e [eq. 2.20].

    With k from the first, the second becomes omega^2 eta_m/g = (1 + e^2)(e + e^2/2 + e^3/2), which grows
    with e: one root, found by Newton's method from above.

    Parameters
    ----------
    crest : float
        Height eta_m in m over still water.
    period : float
        Time in s between the troughs before and after the crest, see :func:`trough_to_trough`.
    water_depth, gravity : float
        m, m/s2.

    Raises
    ------
    InputError
        If the crest or the period is not positive, k eta_m exceeds 0.62, the steepest wave that was measured,
        or the water is not deep.
    """
    for name, value in (("crest", crest), ("period", period)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "must be finite and > 0", "Give the crest in m, the period in s.")
    omega = 2.0 * math.pi / period
    target = omega**2 * crest / gravity
    # The right side is convex and exceeds e: the root lies below the target, and steps only go down.
    e = target
    for _ in range(MAX_ITERATIONS):
        height = e + 0.5 * e**2 + 0.5 * e**3
        value = (1.0 + e**2) * height - target
        slope = 2.0 * e * height + (1.0 + e**2) * (1.0 + e + 1.5 * e**2)
        step = value / slope
        e -= step
        if step <= 4e-16 * e:
            break
    else:
        raise ComputationError(f"no local wave found for a crest of {crest:g} m and a period of {period:g} s")
    k = omega**2 / (gravity * (1.0 + e**2))
    if k * crest > MAX_STEEPNESS:
        raise InputError(
            "crest",
            crest,
            f"makes k eta = {k * crest:.3g} with period {period:g} s, above {MAX_STEEPNESS:g}, the steepest "
            "that was measured",
            "Use a lower crest or a longer period.",
        )
    if k * water_depth < 2.0 * math.pi * DEEP:
        raise InputError(
            "water_depth",
            water_depth,
            f"is below half the local wave length of {2.0 * math.pi / k:.4g} m: this is no deep water",
            "Use the second-order field.",
        )
    return GrueCrest(crest, e, k, gravity)


def trough_to_trough(t: Float[np.ndarray, " time"], eta: Float[np.ndarray, " time"], at: int) -> float:
    """Time in s from the trough before the crest at sample `at` to the trough after it.

    A trough is the lowest point between the crest's zero crossing and the next one beyond it, placed between
    samples by a parabola.

    Raises
    ------
    InputError
        If the record, of even time step, has no whole trough on one side.
    """
    after = _trough(eta[at:])
    before = _trough(eta[at::-1])
    if after is None or before is None:
        raise InputError("at", at, "has no whole trough on both sides", "Use a crest inside the record.")
    return (after + before) * float(t[1] - t[0])


def _trough(eta: Float[np.ndarray, " time"]) -> float | None:
    """Samples from the first, a crest, to the next trough; None if the record ends before its end."""
    below = np.flatnonzero(eta < 0.0)
    if below.size == 0:
        return None
    start = int(below[0])
    above = np.flatnonzero(eta[start:] >= 0.0)
    if above.size == 0:
        return None
    i = start + int(eta[start : start + int(above[0])].argmin())
    left, middle, right = eta[i - 1], eta[i], eta[i + 1]
    bend = left - 2.0 * middle + right
    return i + (0.5 * float((left - right) / bend) if bend > 0.0 else 0.0)
