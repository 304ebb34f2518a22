"""Random seas: amplitudes and directions of components."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from owt_wave_node.core import realisation
from owt_wave_node.core.realisation import amplitudes, realise
from owt_wave_node.core.spreading import angle_of, spreading_density
from proofs.registry import Proof
from proofs.sea import G, sea_of

EXPONENTS = (0.5, 1.0, 2.0, 10.0, 100.0)
SEEDS = range(400)


def expected() -> np.ndarray:
    """S df of the default sea, without the lowest components, that underflow."""
    variance = realise(sea_of(), duration=600.0, gravity=G).variance
    return variance[variance > 1e-12]


def squares(draw: Callable[..., np.ndarray]) -> np.ndarray:
    """a^2 / (2 S df) of 400 realisations [seed, component] of the default sea."""
    variance = expected()
    return np.array([draw(variance, kind="rayleigh", seed=s) ** 2 / (2 * variance) for s in SEEDS])


def mean_square(draw: Callable[..., np.ndarray]) -> float:
    """Distance of the mean of a^2 / (2 S df) from 1 over its standard deviation 1 / sqrt(n)."""
    found = squares(draw)
    return float(abs(found.mean() - 1) * math.sqrt(found.size))


def exponential(draw: Callable[..., np.ndarray]) -> float:
    """Kolmogorov-Smirnov distance of a^2 / (2 S df) from the exponential distribution, times sqrt(n)."""
    found = np.sort(squares(draw), axis=None)
    n = found.size
    exact = -np.expm1(-found)
    step = np.arange(n + 1) / n
    return float(max(np.abs(step[1:] - exact).max(), np.abs(step[:-1] - exact).max()) * math.sqrt(n))


def variance_of_variance(draw: Callable[..., np.ndarray]) -> float:
    """Relative error of the variance over seeds of m0 = sum a^2 / 2, expected: sum (S df)^2."""
    s = expected()
    m0 = squares(draw) @ s
    return float(abs(m0.var() / np.sum(s**2) - 1))


def mean_amplitude(variance: np.ndarray, **how: object) -> np.ndarray:
    """Eq. 2.23 with the mean mu = sqrt(2 S df), where it is the root mean square that equals it."""
    return amplitudes(variance, **how) * math.sqrt(4 / math.pi)  # type: ignore[arg-type]


def rescaled(variance: np.ndarray, **how: object) -> np.ndarray:
    """Rayleigh amplitudes scaled back to the variance of the spectrum."""
    a = amplitudes(variance, **how)  # type: ignore[arg-type]
    return np.asarray(a * math.sqrt(2 * variance.sum() / np.sum(a**2)))


def deterministic(variance: np.ndarray, **_: object) -> np.ndarray:
    return amplitudes(variance, kind="deterministic", seed=0)


def uniform(variance: np.ndarray, *, seed: int, **_: object) -> np.ndarray:
    """Amplitudes of the right mean square, uniform where they should be Rayleigh distributed."""
    drawn = np.random.Generator(np.random.PCG64(seed)).random(variance.size)
    return np.sqrt(2 * variance) * math.sqrt(3) * drawn


# Directions


def circle() -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights on the circle."""
    x, w = np.polynomial.legendre.leggauss(400)
    return math.pi * x, math.pi * w


def spreading_integrals(density: Callable[[np.ndarray, float], np.ndarray]) -> float:
    """Integral 1 and mean vector s / (s + 1), largest error over exponents 0.5 to 100."""
    angle, weight = circle()
    errors = []
    for s in EXPONENTS:
        d = density(angle, s)
        errors += [weight @ d - 1, weight @ (d * np.cos(angle)) - s / (s + 1), weight @ (d * np.sin(angle))]
    return float(np.abs(errors).max())


def quantiles(inverse: Callable[[np.ndarray, float], np.ndarray]) -> float:
    """Largest error of the density integrated from -pi to the angle of a probability."""
    x, w = np.polynomial.legendre.leggauss(400)
    worst = 0.0
    probability = np.array([0.01, 0.2, 0.5, 0.7, 0.999])
    for s in EXPONENTS:
        for p, end in zip(probability, inverse(probability, s), strict=True):
            half = (end + math.pi) / 2
            worst = max(worst, abs(half * (w @ spreading_density(half * (x + 1) - math.pi, s)) - p))
    return float(worst)


def mean_vector(draw: Callable[[int, int, float], np.ndarray]) -> float:
    """Mean cosine and sine of 20,000 directions, their distance from s/(s + 1) and 0 in standard errors."""
    n, worst = 20_000, 0.0
    for s in (1.0, 5.0, 25.0):
        first, second = s / (s + 1), s * (s - 1) / ((s + 1) * (s + 2))
        angle = draw(n, 7, s)
        error = [np.cos(angle).mean() - first, np.sin(angle).mean()]
        spread = [math.sqrt(((1 + second) / 2 - first**2) / n), math.sqrt((1 - second) / 2 / n)]
        worst = max(worst, float(np.max(np.abs(error) / spread)))
    return worst


PROOFS = (
    Proof(
        "rayleigh-mean-square",
        "E[a^2] = 2 S df of Rayleigh amplitudes, 400 seeds",
        "1, in standard errors 1/sqrt(n)",
        mean_square,
        amplitudes,
        {"mean of a is sqrt(2 S df)": mean_amplitude},
        4.0,
        "four standard errors: 1 in 16,000",
    ),
    Proof(
        "rayleigh-distribution",
        "a^2 of Rayleigh amplitudes is exponential, 400 seeds",
        "Kolmogorov-Smirnov distance times sqrt(n)",
        exponential,
        amplitudes,
        {"deterministic": deterministic, "uniform": uniform, "mean of a is sqrt(2 S df)": mean_amplitude},
        1.95,
        "exceeded by 1 in 1000 samples",
    ),
    Proof(
        "rayleigh-variance",
        "m0 of Rayleigh realisations fluctuates as that of a finite record",
        "variance sum (S df)^2 over 400 seeds",
        variance_of_variance,
        amplitudes,
        {"scaled back to Hs": rescaled, "deterministic": deterministic},
        0.31,
        "four standard errors sqrt((2 + excess kurtosis 0.4)/400)",
    ),
    Proof(
        "spreading-density",
        "cos^2s(angle/2) integrates to 1 and has the mean vector s/(s + 1)",
        "Gauss quadrature, s from 0.5 to 100",
        spreading_integrals,
        spreading_density,
        {
            "full angle": lambda a, s: np.where(
                np.abs(a) < math.pi / 2, spreading_density(2 * a, s) * 2, 0.0
            ),
            "Gamma(s + 1/2)^2 / Gamma(2 s + 1)": lambda a, s: spreading_density(a, s) * math.sqrt(s),
        },
        1e-10,
        "quadrature",
    ),
    Proof(
        "spreading-quantiles",
        "angles of given probability",
        "integral of the density",
        quantiles,
        angle_of,
        {
            "half the angle": lambda p, s: angle_of(p, s) / 2,
            "s for s + 1/2": lambda p, s: angle_of(p, s - 0.5 + 1e-9),
        },
        1e-10,
        "quadrature",
    ),
    Proof(
        "directions-drawn",
        "directions drawn have the mean vector of the distribution",
        "s/(s + 1) and 0 in standard errors of 20,000",
        mean_vector,
        lambda n, seed, s: realisation.directions(n, seed, exponent=s),
        {
            "exponent 2 s": lambda n, seed, s: realisation.directions(n, seed, exponent=2 * s),
            "one side": lambda n, seed, s: np.abs(realisation.directions(n, seed, exponent=s)),
        },
        4.0,
        "four standard errors: 1 in 16,000",
    ),
)
