"""Fourier coefficients of a regular wave of given height and period or length, from its theory."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_wave_node.core.dispersion import wavenumber

__all__ = ["SteadyWave", "highest_wave", "steady_wave"]

#: Depth over length beyond which the bed is not felt: exp(-2 k d) is below round-off. The theories are solved
#: in water of at most this depth, where their coefficients keep all their digits.
DEEP = 3.0
#: Relative error of the period that a length is solved to, and the trials that it may take.
TOLERANCE, MAX_TRIALS = 1e-12, 40
#: Residual of the equations of the stream function, made dimensionless by the depth, that counts as solved.
RESIDUAL = 1e-13
#: Steps of Newton's method and the iterations that they may take: full steps are fast, short ones are safe.
#: In shallow water full steps from the linear wave end in solutions of several crests.
STEPS = ((1.0, 30), (0.5, 80), (0.25, 200))
#: Largest Ursell number H L^2 / d^3 of a Stokes wave (Fenton 1990, Nonlinear wave theories, The Sea 9).
MAX_FIFTH_ORDER_URSELL = 40.0
#: Rise between samples from crest to trough, over the height, that may be left of a series cut off; several
#: crests rise by more than 0.1.
RIPPLE = 1e-2
#: Share of the highest wave at which the first trial of a length is at most: steeper ones are hard to solve.
EASY = 0.95
#: Longest wave of a period over the linear one (solitary waves come to 1.3, deep water to 1.2).
LONGEST = 1.4
#: Length of the highest wave of a period over that of the linear one, roughly: for a message.
STEEPEST = 1.2
#: Round-off of the period over depth / height: low waves are a small part of their equations.
ROUND_OFF = 1e-14
DEFAULT_ORDER = {"airy": 1, "stokes": 5, "stream": 20}
MAX_ORDER = {"airy": 1, "stokes": 5, "stream": 100}


@dataclass(frozen=True)
class SteadyWave:
    """Coefficients of a regular wave, see :mod:`~owt_wave_node.core.regular`.

    Attributes
    ----------
    wavenumber, omega : float
        rad/m and rad/s of the first harmonic.
    elevation : float array [harmonic]
        Amplitudes a_j in m of the surface.
    speed : float array [harmonic]
        Amplitudes U_j in m/s of the horizontal velocity at still water.
    """

    wavenumber: float
    omega: float
    elevation: Float[np.ndarray, " harmonic"]
    speed: Float[np.ndarray, " harmonic"]

    @property
    def crest(self) -> float:
        """Height in m of the crest over still water."""
        return float(self.elevation.sum())

    @property
    def length(self) -> float:
        """Length in m."""
        return 2.0 * math.pi / self.wavenumber

    @property
    def period(self) -> float:
        """Period in s."""
        return 2.0 * math.pi / self.omega


Trial = Callable[[float], SteadyWave]


def highest_wave(length: float, depth: float) -> float:
    """Height in m of the highest regular wave of a length in m [Fenton 1990, eq. 32, after Williams 1981]."""
    r = length / depth
    top = 0.141063 * r + 0.0095721 * r**2 + 0.0077829 * r**3
    return depth * top / (1.0 + 0.0788340 * r + 0.0317567 * r**2 + 0.0093407 * r**3)


@lru_cache(maxsize=64)
def steady_wave(
    theory: str,
    *,
    height: float,
    period: float | None,
    length: float | None,
    order: int | None,
    depth: float,
    gravity: float,
) -> SteadyWave:
    """Solve a regular wave.

    Parameters
    ----------
    theory : str
        "airy", "stokes" (Fenton 1985) or "stream" (Rienecker and Fenton 1981).
    height, depth, gravity : float
        Trough to crest in m, water depth in m, m/s2.
    period, length : float or None
        s and m; exactly one of the two.
    order : int or None
        Highest harmonic; None for 1, 5 and 20.

    Raises
    ------
    InputError
        If the wave is higher than the highest of its length, the order is not one of the theory, a Stokes
        wave is too long for the depth, or the equations have no solution that is one wave.
    """
    order = DEFAULT_ORDER[theory] if order is None else order
    if order > MAX_ORDER[theory]:
        raise InputError(
            "regular.order",
            order,
            f"must be at most {MAX_ORDER[theory]} with theory {theory!r}",
            "Use a lower order, or theory stream.",
        )
    solve = {"airy": _airy, "stokes": _stokes, "stream": _stream}[theory]

    def trial(length: float) -> SteadyWave:
        _check(theory, height, length, depth)
        wave = solve(height, length, min(depth, DEEP * length), order, gravity)
        if wave is None:
            limit = highest_wave(length, depth)
            raise InputError(
                "regular.height_m",
                height,
                f"has no wave of theory {theory!r} and order {order} at length {length:.4g} m, where the "
                f"highest is {limit:.4g} m",
                "Lower it, change regular.order, or use theory stream.",
            )
        return wave

    if length is not None:
        return trial(length)
    assert period is not None  # RegularWave holds one of the two
    return _of_period(trial, period, height=height, depth=depth, gravity=gravity)


def _check(theory: str, height: float, length: float, depth: float) -> None:
    """Refuse a wave that breaks, and a Stokes wave that is long."""
    limit = highest_wave(length, depth)
    if height > limit:
        raise InputError(
            "regular.height_m",
            height,
            f"must be at most {limit:.4g} m, the highest regular wave of length {length:.4g} m here",
            "Lower it, or give a longer wave.",
        )
    ursell = height * length**2 / depth**3
    if theory == "stokes" and ursell > MAX_FIFTH_ORDER_URSELL:
        raise InputError(
            "regular.theory",
            theory,
            f"does not hold at H L^2 / d^3 = {ursell:.3g}, above {MAX_FIFTH_ORDER_URSELL:g}",
            "Use theory stream.",
        )


def _of_period(trial: Trial, period: float, *, height: float, depth: float, gravity: float) -> SteadyWave:
    """Find the length whose wave has the period in s: secants, from the linear length and its slope."""
    omega = 2.0 * math.pi / period
    k = float(wavenumber(np.array([omega]), water_depth=depth, gravity=gravity)[0])
    linear, shortest = 2.0 * math.pi / k, _shortest(height, depth)
    length = min(max(linear, _shortest(height / EASY, depth)), LONGEST * linear)
    tolerance = TOLERANCE + ROUND_OFF * min(depth, DEEP * linear) / height
    # dT/dL = (T/L) (group speed / phase speed) of the linear wave.
    slope = period / linear * (0.5 + k * depth / math.sinh(min(2.0 * k * depth, 700.0)))
    previous: SteadyWave | None = None
    for _ in range(MAX_TRIALS):
        if not shortest <= length <= LONGEST * linear:
            break
        wave = trial(length)
        error = wave.period - period
        if abs(error) <= tolerance * period:
            return replace(wave, omega=omega)
        if previous is not None and wave.length != previous.length:
            slope = (wave.period - previous.period) / (wave.length - previous.length)
        previous, length = wave, length - error / slope
    limit = highest_wave(STEEPEST * linear, depth)
    raise InputError(
        "regular.height_m",
        height,
        f"must be at most about {limit:.3g} m, the highest regular wave of period {period:g} s here",
        "Lower it, or give a longer period.",
    )


def _shortest(height: float, depth: float) -> float:
    """Length in m of the wave that is the highest at `height`; infinite where none is so high."""
    low, high = height, height
    while highest_wave(high, depth) < height:
        low, high = high, 2.0 * high
        if high > 1e9:
            return math.inf
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if highest_wave(middle, depth) < height else (low, middle)
    return high


def _airy(height: float, length: float, depth: float, order: int, gravity: float) -> SteadyWave:
    """Linear wave [eq. 2.4-2.8]."""
    k = 2.0 * math.pi / length
    omega = math.sqrt(gravity * k * math.tanh(k * depth))
    amplitude = np.array([0.5 * height])
    return SteadyWave(k, omega, amplitude, gravity * k / omega * amplitude)


def _stokes(height: float, length: float, depth: float, order: int, gravity: float) -> SteadyWave | None:
    """Stokes wave: the library's elevation and velocity at the level of the crest, as Fourier series."""
    from raschii import StokesWave  # here: it is no part of starting up

    wave = StokesWave(height, depth, length, N=order, g=gravity)
    k, harmonic = 2.0 * math.pi / length, np.arange(1, order + 1)
    x = np.arange(2 * order + 2) * (length / (2 * order + 2))
    surface = np.asarray(wave.surface_elevation(x, include_depth=False))
    elevation = _harmonics(surface, order)
    crest = float(elevation.sum())
    speed = wave.velocity(x, np.full(x.size, depth + crest), all_points_wet=True)[:, 0]
    # From the crest down to still water: cosh jkd / cosh jk(d + crest), in terms that do not overflow.
    down = np.exp(-harmonic * k * crest) * (1.0 + np.exp(-2.0 * harmonic * k * depth))
    down /= 1.0 + np.exp(-2.0 * harmonic * k * (depth + crest))
    found = SteadyWave(k, float(wave.omega), elevation, _harmonics(speed, order) * down)
    half = np.cos(np.outer(np.linspace(0.0, math.pi, 181), harmonic)) @ elevation
    return found if _one_wave(half, height) else None


def _harmonics(samples: Float[np.ndarray, " x"], order: int) -> Float[np.ndarray, " harmonic"]:
    """Cosine amplitudes 1 to `order` of samples of one length."""
    return np.asarray(np.fft.rfft(samples)[1 : order + 1].real * (2.0 / samples.size))


def _stream(height: float, length: float, depth: float, order: int, gravity: float) -> SteadyWave | None:
    """Stream function wave of the library, solved to round-off; the safer steps where full ones fail."""
    from raschii.common import RaschiiError
    from raschii.wave_fenton import fenton_coefficients

    for relax, iterations in STEPS:
        try:
            with np.errstate(all="ignore"):
                data = fenton_coefficients(
                    height, depth, length, order, gravity, maxiter=iterations, tolerance=RESIDUAL, relax=relax
                )
        except (RaschiiError, OverflowError, np.linalg.LinAlgError):
            continue
        surface, stream = np.asarray(data["eta"]) - depth, np.asarray(data["B"])[1:]
        if not _one_wave(surface, height) or abs(stream[-1]) > abs(stream[0]):
            continue  # a solution of the equations that is not this wave
        k, harmonic = float(data["k"]), np.arange(1, order + 1)
        elevation = _harmonics(np.concatenate([surface, surface[-2:0:-1]]), order)
        elevation[-1] *= 0.5  # the last harmonic is that of Nyquist
        return SteadyWave(k, float(data["c"]) * k, elevation, harmonic * k * stream)
    return None


def _one_wave(half: Float[np.ndarray, " x"], height: float) -> bool:
    """Whether the surface falls all the way from crest to trough."""
    return bool(np.isfinite(half).all() and np.diff(half).max() <= RIPPLE * height)
