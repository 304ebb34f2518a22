"""Longitudinal wind as a rotor of three blades meets it: turbulence sampled by blades that go round.

The turbulence is that of IEC 61400-1: Kaimal's spectrum at a point, exponential coherence between points.
Each blade weighs the wind along it by the radius, which is a uniform thrust per swept area. Of the Fourier
series of the wind in azimuth, three blades let pass the terms n = 0 (the mean over the disc) and n = +-3,
+-6, ..., which turning shifts by n times the rotor frequency P: the peaks at 3P and 6P.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = [
    "HARMONICS",
    "Turbulence",
    "Wind",
    "coherence",
    "harmonic_factor",
    "kaimal",
    "normal_turbulence",
    "realise_rotor_wind",
    "rotor_spectrum",
    "rotor_variance",
    "turbulence_at",
]

Array = Float[np.ndarray, " frequency"]

#: Expected turbulence intensity at 15 m/s of the categories of IEC 61400-1, ed. 3, table 1.
CATEGORIES: Mapping[str, float] = {"A": 0.16, "B": 0.14, "C": 0.12}
#: Harmonics of the rotor frequency that are counted beside 0; those above hold 0.4 % of the variance.
HARMONICS = (3, 6, 9, 12, 15)
#: Stream of random numbers derived from a seed: waves of the same seed use the seed itself, streams 1 and 2.
WIND_STREAM = 3

#: Largest argument and step of the table of a harmonic's weight; its mean asymptote goes on to FARTHEST.
LARGEST, STEP, FARTHEST = 200.0, 0.02, 1e9
#: Decay over the radius at which a harmonic factor is tabulated, 8 points per decade.
DECAYS = np.geomspace(1e-4, 1e6, 81)


@dataclass(frozen=True)
class Wind:
    """Mean wind and its turbulence at hub height.

    Attributes
    ----------
    speed : float
        Mean V in m/s.
    turbulence : float or str
        Turbulence intensity sigma/V as a fraction, or the category "A", "B" or "C" of IEC 61400-1.
    direction_deg : float
        Direction that the wind blows to, from +x towards +y, in degrees.
    shear_exponent : float
        Exponent of the power law of the mean wind over height; 0 for none.
    seed : int
        Seed of the random phases.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    speed: float = 12.0
    turbulence: float | str = "B"
    direction_deg: float = 0.0
    shear_exponent: float = 0.14
    seed: int = 1

    def __post_init__(self) -> None:
        if not 0.0 < self.speed <= 100.0:
            raise InputError("wind.speed", self.speed, "must be > 0 and <= 100 m/s", "Use 12.")
        if isinstance(self.turbulence, str):
            normal_turbulence(self.speed, self.turbulence)  # refuses what is no category
        elif not 0.0 < self.turbulence <= 1.0:
            limit = "is a fraction of the mean wind, > 0 and <= 1"
            raise InputError("wind.turbulence", self.turbulence, limit, 'Use 0.12, or "B".')
        if not -360.0 <= self.direction_deg <= 360.0:
            limit = "must lie in -360 ... 360 degrees"
            raise InputError("wind.direction_deg", self.direction_deg, limit, "Take it modulo a turn.")
        if not 0.0 <= self.shear_exponent <= 1.0:
            limit = "must lie in 0 ... 1"
            raise InputError("wind.shear_exponent", self.shear_exponent, limit, "Use 0.14 at sea.")
        if not 0 <= self.seed < 2**63:
            raise InputError("wind.seed", self.seed, "must be an integer in 0 ... 2^63 - 1", "Use 1.")

    @property
    def sigma(self) -> float:
        """Standard deviation of the longitudinal wind at a point in m/s."""
        if isinstance(self.turbulence, str):
            return normal_turbulence(self.speed, self.turbulence)
        return self.turbulence * self.speed


@dataclass(frozen=True)
class Turbulence:
    """Longitudinal turbulence at hub height.

    Attributes
    ----------
    speed : float
        Mean wind V in m/s.
    sigma : float
        Standard deviation at a point in m/s.
    scale : float
        Scale parameter Lambda_1 in m; the integral and the coherence scale are 8.1 times as long.
    """

    speed: float
    sigma: float
    scale: float

    @property
    def length(self) -> float:
        """Scale L_1 = L_c = 8.1 Lambda_1 in m."""
        return 8.1 * self.scale


def normal_turbulence(speed: float, category: str) -> float:
    """Standard deviation in m/s of the normal turbulence model [IEC 61400-1, ed. 3, eq. 11].

    sigma = Iref (0.75 V + 5.6 m/s), the 90 % quantile at the mean wind V = `speed` in m/s.

    Raises
    ------
    InputError
        If `category` is not "A", "B" or "C".
    """
    if category not in CATEGORIES:
        limit = "must be a turbulence intensity, or one of the categories A, B and C"
        raise InputError("wind.turbulence", category, limit, 'Use "B".')
    return CATEGORIES[category] * (0.75 * speed + 5.6)


def turbulence_at(wind: Wind, hub_height: float) -> Turbulence:
    """Turbulence of `wind` at a hub in m above still water [IEC 61400-1, ed. 3, eq. 5].

    Lambda_1 is 0.7 z up to z = 60 m, and 42 m above.
    """
    return Turbulence(speed=wind.speed, sigma=wind.sigma, scale=0.7 * min(hub_height, 60.0))


def kaimal(frequency: Array, turbulence: Turbulence) -> Array:
    """Variance density S(f) in m2/s of the wind at a point [IEC 61400-1, ed. 3, eq. B.14].

    S = sigma^2 (4 L/V) / (1 + 6 f L/V)^(5/3), one-sided: over f > 0 it integrates to sigma^2.

    Parameters
    ----------
    frequency : float array [frequency]
        Frequencies f in Hz, >= 0.
    turbulence : Turbulence
        sigma, V and L.
    """
    time = turbulence.length / turbulence.speed
    return np.asarray(turbulence.sigma**2 * 4.0 * time * (1.0 + 6.0 * time * frequency) ** (-5.0 / 3.0))


def decay(frequency: Array, turbulence: Turbulence) -> Array:
    """Decay a(f) in 1/m of the coherence exp(-a D) at frequencies in Hz, >= 0 [IEC 61400-1, eq. B.16]."""
    V, L = turbulence.speed, turbulence.length
    return np.asarray(12.0 * np.hypot(frequency / V, 0.12 / L))


def coherence(frequency: Array, distance: float, turbulence: Turbulence) -> Array:
    """Cross-spectrum of the wind at two points over S(f) [IEC 61400-1, ed. 3, eq. B.16].

    exp(-12 sqrt((f D/V)^2 + (0.12 D/L_c)^2)), D the distance in m across the wind; real, without phase.
    """
    return np.asarray(np.exp(-decay(frequency, turbulence) * distance))


@cache
def _weight(harmonic: int) -> tuple[Float[np.ndarray, " x"], Float[np.ndarray, " x"]]:
    """Arguments x and W_n(x)^2, W_n the Hankel transform int_0^1 2 r J_n(x r) dr of the radial weight.

    Beyond LARGEST it is replaced by its mean over a period, 4/(pi x^3) + 4 n^2/x^4.
    """
    from scipy.special import jv  # here: cases without wind start without it

    n = harmonic
    x = STEP * np.arange(round(LARGEST / STEP) + 1)
    far = np.geomspace(LARGEST, FARTHEST, 401)[1:]
    gauss = x[:-1, None] + STEP * (0.5 + math.sqrt(1.0 / 12.0) * np.array([-1.0, 1.0]))
    W = np.full(x.size, 1.0 if n == 0 else 0.0)  # the limit x -> 0
    W[1:] = STEP * np.cumsum((gauss * jv(n, gauss)).sum(axis=1)) / x[1:] ** 2
    return np.append(x, far), np.append(W**2, 4.0 / (math.pi * far**3) + 4.0 * n**2 / far**4)


@cache
def _log_factor(harmonic: int) -> Callable[[Array], Array]:
    """Logarithm of the factor of a harmonic over that of the decay, interpolated between DECAYS."""
    from scipy.interpolate import CubicSpline

    x, squared = _weight(harmonic)
    # -alpha / hypot(alpha, x) is the primitive of alpha x / (alpha^2 + x^2)^(3/2).
    below = -DECAYS[:, None] / np.hypot(DECAYS[:, None], x)
    fine, coarse = (np.diff(below[:, ::k]) @ (squared[k::k] + squared[:-k:k]) / 2.0 for k in (1, 2))
    factor = (4.0 * fine - coarse) / 3.0  # leaves the trapezoids' error of second order out
    spline: Callable[[Array], Array] = CubicSpline(np.log(DECAYS), np.log(factor))
    return spline


def harmonic_factor(harmonic: int, decay_over_radius: Array) -> Array:
    """Share F_n of S(f) that the n-th term of the Fourier series in azimuth has, mean along a blade.

    F_n = int int w(r) w(s) [1/(2 pi) int exp(-a d) cos(n theta) dtheta] dr ds, w = 2 r/R^2 and d the distance
    of two points at the radii r and s, theta apart: the double integral of Kristensen and Frandsen (1982)
    with the weight of this rotor. By exp(-a d) = int a k/(a^2 + k^2)^(3/2) J_0(k d) dk and Gegenbauer's
    addition theorem for J_0(k d) it is a single integral,

        F_n = int_0^inf alpha x / (alpha^2 + x^2)^(3/2) W_n(x)^2 dx,    W_n = int_0^1 2 r J_n(x r) dr

    which depends on alpha = a R alone: it is tabulated once per harmonic. F_0 -> 1 for alpha -> 0, and every
    F_n -> 2/alpha^2 for alpha -> inf.

    Parameters
    ----------
    harmonic : int
        n >= 0; -n has the same factor.
    decay_over_radius : float array [frequency]
        alpha = a(f) R, > 0; taken as within 1e-4 ... 1e6.

    References
    ----------
    L. Kristensen, S. Frandsen, Model for power spectra of the blade of a wind turbine measured from the
    moving frame of reference, J. Wind Eng. Ind. Aerodyn. 10, 1982; G. N. Watson, A treatise on the theory of
    Bessel functions, 11.3 and 13.2.
    """
    within = np.clip(decay_over_radius, DECAYS[0], DECAYS[-1])
    return np.asarray(np.exp(_log_factor(harmonic)(np.log(within))))


def rotor_spectrum(
    frequency: Array, turbulence: Turbulence, *, radius: float, rotor_frequency: float
) -> Array:
    """Variance density in m2/s of the mean wind over three turning blades, one-sided.

    S_rotor(f) = sum S(|f - n P|) F_n(|f - n P|) over n = 0, +-3, ..., +-15: terms of different n are
    uncorrelated, for the coherence depends on distances only, and turning shifts each by n P.

    Parameters
    ----------
    frequency : float array [frequency]
        Frequencies f in Hz, >= 0.
    turbulence : Turbulence
        Wind at a point.
    radius, rotor_frequency : float
        R in m, P in Hz.
    """
    total = np.zeros(frequency.shape)
    for n in (0, *HARMONICS, *(-n for n in HARMONICS)):
        f = np.abs(frequency - n * rotor_frequency)
        total += kaimal(f, turbulence) * harmonic_factor(abs(n), radius * decay(f, turbulence))
    return total


def rotor_variance(turbulence: Turbulence, radius: float) -> float:
    """Variance in m2/s2 of the mean wind over three blades of `radius` in m, over all frequencies.

    Turning does not change it: int S(f) sum F_n(f) df.
    """
    time = turbulence.length / turbulence.speed
    f = np.append(0.0, np.geomspace(1e-6, 1e4, 1000) / time)
    # Variance below f, in closed form: the steps of it are exact, whatever the grid.
    below = turbulence.sigma**2 * (1.0 - (1.0 + 6.0 * time * f) ** (-2.0 / 3.0))
    alpha = radius * decay(f, turbulence)
    share = harmonic_factor(0, alpha) + 2.0 * sum(harmonic_factor(n, alpha) for n in HARMONICS)
    return float(np.diff(below) @ (0.5 * (share[1:] + share[:-1])))


def realise_rotor_wind(
    turbulence: Turbulence, *, radius: float, rotor_frequency: float, dt: float, n: int, seed: int
) -> Float[np.ndarray, " sample"]:
    """Deviation u in m/s from the mean wind of the mean over three blades, periodic in `n` samples.

    u(t) = sum sqrt(2 S_rotor df) cos(2 pi f_m t - phase_m), f_m = m / (n dt) below the Nyquist frequency:
    deterministic amplitudes, so that the variance is sum S_rotor df exactly; zero mean. What lies above the
    Nyquist frequency is left out, not folded back. The phases are 2 pi times the numbers of
    ``PCG64(SeedSequence(seed, spawn_key=(3,)))``, independent of those of waves of the same seed.

    Parameters
    ----------
    turbulence, radius, rotor_frequency
        As :func:`rotor_spectrum` takes them.
    dt, n : float, int
        Time step in s and number of samples.
    seed : int
        Seed of the phases.

    Raises
    ------
    InputError
        If no frequency lies between zero and Nyquist's.
    """
    if not (dt > 0.0 and math.isfinite(dt)):
        raise InputError("time.dt_s", dt, "must be > 0 s", "Use 0.1.")
    if n < 3:
        raise InputError("time.n", n, "must be >= 3: fewer samples hold no frequency", "Use 6000.")
    count = (n - 1) // 2
    df = 1.0 / (n * dt)
    f = df * np.arange(1, count + 1)
    S = rotor_spectrum(f, turbulence, radius=radius, rotor_frequency=rotor_frequency)
    sequence = np.random.SeedSequence(seed, spawn_key=(WIND_STREAM,))
    phase = 2.0 * math.pi * np.random.Generator(np.random.PCG64(sequence)).random(count)
    half = np.zeros(n // 2 + 1, dtype=complex)
    half[1 : count + 1] = 0.5 * n * np.sqrt(2.0 * S * df) * np.exp(-1j * phase)
    return np.asarray(np.fft.irfft(half, n))
