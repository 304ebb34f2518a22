"""Wind over a turning rotor and its thrust: turbulence, rotational sampling, tower passing, thrust curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from owt_structure_node.core.rotor_thrust import (
    Rotor,
    blade_wind,
    passing_wind,
    slow_part,
    thrust_curve,
    tower_deficit,
)
from owt_structure_node.core.rotor_wind import (
    HARMONICS,
    Turbulence,
    Wind,
    coherence,
    harmonic_factor,
    kaimal,
    realise_rotor_wind,
    rotor_spectrum,
)
from proofs.registry import Proof

AIR = Turbulence(speed=12.0, sigma=1.6, scale=42.0)
R, P = 65.0, 0.2

Decay = Callable[[np.ndarray], np.ndarray]
Spectrum = Callable[[np.ndarray], np.ndarray]


def variance_below(variant: Spectrum) -> float:
    """sigma^2 (1 - (1 + 6 f L/V)^(-2/3)) below f, to f = 1e6 V/L, over sigma^2."""
    time = AIR.length / AIR.speed
    f = np.append(0.0, np.geomspace(1e-6, 1e6, 40_001)) / time
    S = variant(f)
    found = np.cumsum(np.diff(f) * 0.5 * (S[1:] + S[:-1]))
    exact = AIR.sigma**2 * (1.0 - (1.0 + 6.0 * time * f[1:]) ** (-2.0 / 3.0))
    return float(np.abs(found - exact).max()) / AIR.sigma**2


def limits(variant: Callable[..., np.ndarray]) -> float:
    """exp(-1.44 D/L_c) at zero frequency, exp(-12 f D/V) at a high one."""
    slow = variant(np.zeros(1), 100.0, AIR)[0] - math.exp(-1.44 * 100.0 / (8.1 * 42.0))
    fast = variant(np.array([5.0]), 0.4, AIR)[0] - math.exp(-12.0 * 5.0 * 0.4 / 12.0)
    return float(max(abs(slow), abs(fast)))


def without_second_term(f: np.ndarray, distance: float, air: Turbulence) -> np.ndarray:
    return np.asarray(np.exp(-12.0 * f * distance / air.speed))


def blade_points(count: int, power: float) -> tuple[np.ndarray, np.ndarray]:
    """Radii over R of Gauss and Legendre, and weights of a mean with weight r^power."""
    x, w = np.polynomial.legendre.leggauss(count)
    r = 0.5 * (x + 1.0)
    return r, 0.5 * w * (power + 1.0) * r**power


def by_quadrature(n: int, alpha: np.ndarray, power: float = 1.0) -> np.ndarray:
    """Double integral over radii and Fourier integral over azimuth of exp(-alpha d), point by point."""
    r, w = blade_points(80, power)
    angle = 2.0 * math.pi * np.arange(1024) / 1024
    found = np.zeros(alpha.size)
    for i, radius in enumerate(r):
        d = np.sqrt(np.maximum(radius**2 + (r**2)[:, None] - 2.0 * radius * r[:, None] * np.cos(angle), 0.0))
        for k, a in enumerate(alpha):
            found[k] += w[i] * float(w @ np.exp(-a * d) @ np.cos(n * angle)) / angle.size
    return found


def disc(variant: Decay) -> float:
    """Mean of exp(-alpha d) over pairs of points of a disc, from the distribution of their distance."""
    alpha = np.array([1e-3, 0.3, 1.0, 4.0, 15.0])
    x, weight = np.polynomial.legendre.leggauss(200)
    d = x + 1.0
    density = 4.0 * d / math.pi * (np.arccos(0.5 * d) - 0.5 * d * np.sqrt(1.0 - 0.25 * d**2))
    exact = np.exp(-np.outer(alpha, d)) @ (density * weight)
    return float(np.abs(variant(alpha) / exact - 1.0).max())


def azimuth_terms(variant: Callable[[int, np.ndarray], np.ndarray]) -> float:
    alpha = np.array([0.3, 3.0])
    found = np.array([variant(n, alpha) / by_quadrature(n, alpha) for n in (3, 6)])
    return float(np.abs(found - 1.0).max())


def blades(variant: tuple[int, float]) -> float:
    """Sum of F_n over multiples of the number of blades against the mean over all pairs of three blades."""
    step, both = variant
    worst = 0.0
    for alpha in (0.3, 1.0, 5.0):
        r, w = blade_points(200, 1.0)
        exact = 0.0
        for angle in (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0):
            d = np.sqrt(np.maximum(r**2 + (r**2)[:, None] - 2.0 * np.outer(r, r) * math.cos(angle), 0.0))
            exact += float(w @ np.exp(-alpha * d) @ w) / 3.0
        at = np.array([alpha])
        factors = [harmonic_factor(n, at)[0] for n in range(0, 31, step)]
        # F_n falls with n^-3: the rest is the last term times sum (N/n)^3, about N/(2 step) - 1/2.
        rest = factors[-1] * (0.5 * (len(factors) - 1) - 0.5)
        worst = max(worst, abs((factors[0] + both * (sum(factors[1:]) + rest)) / exact - 1.0))
    return worst


LAGS = np.array([0.0, 0.07, 0.25, 0.5, 0.75, 1.0, 4.0 / 3.0, 1.5, 2.0]) / (3.0 * P)


@cache
def seen_by_blades() -> np.ndarray:
    """Autocorrelation R(tau) = mean over radii and blades of int S(f) coh(f, d) cos(2 pi f tau) df, at LAGS.

    d is the distance of one blade's point now and another's, or its own, a time tau later.
    """
    step = np.append(np.full(2000, 5e-4), np.full(5800, 5e-3))
    f = np.cumsum(step) - 0.5 * step
    S = np.asarray(kaimal(f, AIR)) * step
    grid = 2.0 * R * np.linspace(0.0, 1.0, 300) ** 3
    across = np.array([S * coherence(f, d, AIR) for d in grid])
    table = across @ np.cos(2.0 * math.pi * np.outer(f, LAGS))
    r, w = blade_points(60, 1.0)
    found = np.zeros(LAGS.size)
    for k, lag in enumerate(LAGS):
        for blade in range(3):
            cosine = math.cos(2.0 * math.pi * (P * lag + blade / 3.0))
            d = R * np.sqrt(np.maximum(r**2 + (r**2)[:, None] - 2.0 * np.outer(r, r) * cosine, 0.0))
            found[k] += float(w @ np.interp(d, grid, table[:, k]) @ w) / 3.0
    return found


def correlation(variant: Spectrum) -> float:
    """Autocorrelation of the rotor's wind from its spectrum, over the variance."""
    df = 5e-4
    f = df * (np.arange(20_000) + 0.5)
    found = np.cos(2.0 * math.pi * np.outer(LAGS, f)) @ variant(f) * df
    exact = seen_by_blades()
    return float(np.abs(found - exact).max() / exact[0])


def sampled(f: np.ndarray, numbers: dict[int, int], decay: Decay | None = None) -> np.ndarray:
    """Sum of S F_n shifted by k P, for n: k in `numbers` and their negatives."""
    total = np.zeros_like(f)
    for n, k in numbers.items():
        for sign in (1, -1) if n else (0,):
            g = np.abs(f - sign * k * P)
            alpha = R * (-np.log(coherence(g, 1.0, AIR)) if decay is None else decay(g))
            total += kaimal(g, AIR) * harmonic_factor(n, alpha)
    return total


def in_band(variant: Callable[[np.ndarray], np.ndarray]) -> float:
    """Variance of a record over int S df between half a component's distance and the Nyquist frequency."""
    dt, n = 0.2, 2**15
    u = variant(realise_rotor_wind(AIR, radius=R, rotor_frequency=P, dt=dt, n=n, seed=4))
    f = np.geomspace(0.5 / (n * dt), 0.5 / dt, 200_001)
    S = rotor_spectrum(f, AIR, radius=R, rotor_frequency=P)
    return abs(float(np.mean(u**2)) / float(np.trapezoid(S, f)) - 1.0)


ROTOR = Rotor()


def cylinder(variant: Callable[[np.ndarray], np.ndarray]) -> float:
    """1 - dw/dz of the complex potential w = z + b^2/z upstream, mean over the blade; half the tower."""
    b, e = 0.5 * ROTOR.tower_diameter, ROTOR.tower_distance
    angle = np.array([0.0, 1e-4, 0.05, 0.2, 0.7, 1.4, 1.8, 3.0, -0.2])
    r, w = blade_points(400, 1.0)
    z = -e + 1j * R * np.sin(angle)[:, None] * r
    h = 1e-4
    slope = ((z + h) + b**2 / (z + h) - (z - h) - b**2 / (z - h)) / (2.0 * h)
    exact = np.where(np.cos(angle) > 0.0, (slope.real - 1.0) @ w, 0.0)
    return float(np.abs(variant(angle) - exact).max()) / (b / e) ** 2


def tip_only(azimuth: np.ndarray) -> np.ndarray:
    b, e = 0.5 * ROTOR.tower_diameter, ROTOR.tower_distance
    y = R * np.sin(azimuth)
    return np.asarray(np.where(np.cos(azimuth) > 0.0, -(b**2) * (e**2 - y**2) / (e**2 + y**2) ** 2, 0.0))


def passing(variant: Callable[[Callable[[np.ndarray], np.ndarray], np.ndarray], np.ndarray]) -> float:
    """Series of the harmonics against another sum over blades: deviation over the standard deviation."""
    wind = Wind(speed=14.0)
    dt, n = 0.01, 4000
    P = ROTOR.frequency(wind.speed)
    series = passing_wind(ROTOR, wind, dt=dt, n=n)
    other = variant(lambda angle: blade_wind(angle, ROTOR, wind), 2.0 * math.pi * P * dt * np.arange(n))
    return float(np.std(series - other) / np.std(other))


def three_blades(of: Callable[[np.ndarray], np.ndarray], angle: np.ndarray) -> np.ndarray:
    found = sum(of(angle + 2.0 * math.pi * blade / 3.0) for blade in range(3))
    return np.asarray(found) / 3.0


def constant_power(variant: Callable[[np.ndarray], np.ndarray]) -> float:
    """T V (1 - a) with a of C_T = 4 a (1 - a), from the rated speed to cut-out."""
    V = np.linspace(ROTOR.rated_speed, ROTOR.cut_out, 50)
    T = variant(V)
    loading = T / (0.5 * ROTOR.air_density * math.pi * R**2 * V**2)
    power = T * V * 0.5 * (1.0 + np.sqrt(1.0 - loading))
    return float(np.abs(power / power[0] - 1.0).max())


def falling(V: np.ndarray, exponent: float) -> np.ndarray:
    return np.asarray(thrust_curve(V[:1], ROTOR) * (V[0] / V) ** exponent)


def sines(variant: Callable[[np.ndarray, float, float], np.ndarray]) -> float:
    """tau dv/dt + v = cos(w t): v = cos(w t - atan w tau) / sqrt(1 + (w tau)^2)."""
    dt, n, tau = 0.1, 2000, 5.0
    t, omega = dt * np.arange(n), 2.0 * math.pi * np.array([1, 7, 60]) / (n * dt)
    exact = [np.cos(w * t - math.atan(w * tau)) / math.hypot(1.0, w * tau) for w in omega]
    found = variant(np.sum([np.cos(w * t) for w in omega], axis=0), dt, tau)
    return float(np.abs(found - np.sum(exact, axis=0)).max())


def without_lag(series: np.ndarray, dt: float, tau: float) -> np.ndarray:
    omega = 2.0 * math.pi * np.fft.rfftfreq(series.size, dt)
    return np.fft.irfft(np.fft.rfft(series) / np.hypot(1.0, omega * tau), series.size)


EVERY = {n: n for n in (0, *HARMONICS)}

PROOFS = (
    Proof(
        key="kaimal-variance",
        claim="the variance of Kaimal's spectrum below any frequency, in all sigma^2",
        against="closed form sigma^2 (1 - (1 + 6 f L/V)^(-2/3))",
        error=variance_below,
        right=lambda f: kaimal(f, AIR),
        wrong={
            "two-sided density": lambda f: 0.5 * kaimal(f, AIR),
            "Lambda for L": lambda f: kaimal(f, replace(AIR, scale=AIR.scale / 8.1)),
            "exponent 3/2": lambda f: kaimal(f, AIR) ** 0.9 * kaimal(0.0 * f, AIR) ** 0.1,
        },
        allowed=2e-4,
        reason="variance above 1e6 V/L, 3e-5, and trapezoids",
    ),
    Proof(
        key="wind-coherence",
        claim="coherence of the wind at zero frequency and at a high one",
        against="exp(-1.44 D/L) and exp(-12 f D/V)",
        error=limits,
        right=coherence,
        wrong={
            "without the second term": without_second_term,
            "squared coherence": lambda f, d, air: coherence(f, d, air) ** 2,
            "Lambda for L": lambda f, d, air: coherence(f, d, replace(air, scale=air.scale / 8.1)),
        },
        allowed=1e-6,
        reason="second term at the high frequency, 4e-7 of the exponent",
    ),
    Proof(
        key="rotor-disc-average",
        claim="F_0 is the mean coherence of two points of the disc, 1 for a small rotor",
        against="distribution of the distance of two random points of a disc",
        error=disc,
        right=lambda alpha: harmonic_factor(0, alpha),
        wrong={
            "blade weighed evenly": lambda alpha: by_quadrature(0, alpha, power=0.0),
            "diameter for radius": lambda alpha: harmonic_factor(0, 2.0 * alpha),
            "squared": lambda alpha: harmonic_factor(0, alpha) ** 2,
        },
        allowed=1e-5,
        reason="interpolation over the decay, 3e-6",
    ),
    Proof(
        key="rotor-azimuth-terms",
        claim="F_3 and F_6 of the single integral are the double integral over radii of the terms in azimuth",
        against="Gauss points along both blades, Fourier sum in azimuth",
        error=azimuth_terms,
        right=harmonic_factor,
        wrong={
            "cosine amplitude, twice the term": lambda n, alpha: 2.0 * harmonic_factor(n, alpha),
            "first term": lambda n, alpha: harmonic_factor(n // 3, alpha),
            "decay over the diameter": lambda n, alpha: harmonic_factor(n, 2.0 * alpha),
        },
        allowed=1e-4,
        reason="quadrature across the cusp of exp(-a d)",
    ),
    Proof(
        key="rotor-sum-rule",
        claim="the terms 0, +-3, +-6, ... add up to the mean coherence of all pairs of three blades",
        against="Gauss points along two blades 0, 1/3 and 2/3 of a turn apart",
        error=blades,
        right=(3, 2.0),
        wrong={"every term (one blade)": (1, 2.0), "two blades": (2, 2.0), "terms n > 0 alone": (3, 1.0)},
        allowed=1e-3,
        reason="terms above 30, taken as n^-3",
    ),
    Proof(
        key="rotational-sampling",
        claim="the spectrum of the mean wind over three turning blades, with its peaks at 3P, 6P, ...",
        against="autocorrelation int S coh cos(2 pi f tau) df of points that turn",
        error=correlation,
        right=lambda f: rotor_spectrum(f, AIR, radius=R, rotor_frequency=P),
        wrong={
            "disc average alone": lambda f: sampled(f, {0: 0}),
            "peaks at 1P, 2P, ...": lambda f: sampled(f, {n: n // 3 for n in (0, *HARMONICS)}),
            "every term (one blade)": lambda f: sampled(f, {n: n for n in range(16)}),
            "coherence without the second term": lambda f: sampled(f, EVERY, lambda g: 12.0 * g / 12.0),
            "spectrum of a point": lambda f: kaimal(f, AIR),
        },
        allowed=0.01,
        reason="terms above 15 hold 0.4 % of the variance",
    ),
    Proof(
        key="rotor-wind-variance",
        claim="the variance of a record of the rotor's wind is that of the spectrum within its band",
        against="integral of the spectrum",
        error=in_band,
        right=lambda u: u,
        wrong={
            "amplitude sqrt(S df)": lambda u: u / math.sqrt(2.0),
            "every second component": lambda u: 0.5 * (u + np.roll(u, u.size // 2)),
        },
        allowed=2e-3,
        reason="sum for an integral over 16,000 components",
    ),
    Proof(
        key="tower-deficit",
        claim="deficit of the wind upstream of the tower, mean over a blade",
        against="complex potential of a cylinder, Gauss points along the blade",
        error=cylinder,
        right=lambda angle: tower_deficit(angle, ROTOR),
        wrong={
            "diameter for radius": lambda angle: 4.0 * tower_deficit(angle, ROTOR),
            "tip alone": tip_only,
            "tower above the hub too": lambda angle: tower_deficit(np.arcsin(np.sin(angle)), ROTOR),
        },
        allowed=1e-5,
        reason="series below q = 1e-6, Gauss points",
    ),
    Proof(
        key="blades-passing",
        claim="harmonics of 3P are the mean over three blades that pass the tower and the shear",
        against="steady wind of the three blades, azimuth by azimuth",
        error=passing,
        right=three_blades,
        wrong={
            "one blade": lambda of, angle: of(angle),
            "sum over the blades": lambda of, angle: 3.0 * three_blades(of, angle),
            "blade up at the start": lambda of, angle: three_blades(of, angle + math.pi),
        },
        allowed=0.05,
        reason="jump where the tower ends, 0.2 % of the wind, cut at the 120th harmonic: 0.6 %",
    ),
    Proof(
        key="constant-power",
        claim="the thrust above the rated speed is that of constant power",
        against="momentum theory: T V (1 - a)",
        error=constant_power,
        right=lambda V: thrust_curve(V, ROTOR),
        wrong={
            "coefficient falls with the power's": lambda V: falling(V, 1.0),
            "constant thrust": lambda V: falling(V, 0.0),
            "coefficient falls with V^-4": lambda V: falling(V, 2.0),
        },
        allowed=1e-10,
        reason="round-off",
    ),
    Proof(
        key="operating-point",
        claim="the slow wind is a first-order low-pass of the wind",
        against="steady solution of tau dv/dt + v = cos(omega t)",
        error=sines,
        right=lambda u, dt, tau: slow_part(u, dt=dt, time_constant=tau),
        wrong={
            "without lag": without_lag,
            "time constant taken for a period": lambda u, dt, tau: slow_part(
                u, dt=dt, time_constant=tau / (2.0 * math.pi)
            ),
        },
        allowed=1e-12,
        reason="round-off",
    ),
)
