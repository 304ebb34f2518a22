"""Statistics of spectra and records, seas from files, and the numbers of a regime."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from owt_wave_node.core.crests import rayleigh_crest, tayfun_crest
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.measured import Band, components_of_record
from owt_wave_node.core.regime import orbital_speed
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import build_sea_state, waves
from owt_wave_node.core.sea_statistics import (
    RecordStatistics,
    SpectralStatistics,
    density_statistics,
    record_statistics,
)
from owt_wave_node.core.tabulated import TabulatedSpectrum, realise_table
from owt_wave_node.core.wave_theory import RegularRegime, regular_regime
from proofs.cases import listed, recorded, reference, relative
from proofs.registry import Proof

G = 9.81


def pierson_moskowitz(f: np.ndarray, hs: float, fp: float) -> np.ndarray:
    return 5.0 / 16.0 * hs**2 * fp**4 * f**-5.0 * np.exp(-1.25 * (f / fp) ** -4.0)


def moments(variant: Callable[[SpectralStatistics], tuple[float, ...]]) -> float:
    """m_n = A/4 B^(n/4 - 1) Gamma(1 - n/4) of A f^-5 exp(-B f^-4): Hs, Tm-10, Tm01 and Tm02."""
    hs, fp = 4.0, 0.11
    A, B = 5.0 / 16.0 * hs**2 * fp**4, 1.25 * fp**4
    m = {n: A / 4.0 * B ** (n / 4.0 - 1.0) * math.gamma(1.0 - n / 4.0) for n in (-1, 0, 1, 2)}
    f = fp * np.geomspace(0.3, 1e4, 20_000)
    expected = (4.0 * math.sqrt(m[0]), m[-1] / m[0], m[0] / m[1], math.sqrt(m[0] / m[2]))
    found = variant(density_statistics(f, pierson_moskowitz(f, hs, fp)))
    return float(np.abs(np.array(found) / expected - 1.0).max())


def sine(variant: Callable[[np.ndarray, float], tuple[np.ndarray, np.ndarray]]) -> float:
    """Heights 2 a and periods T of a sine about a mean that is not zero."""
    a, period, dt = 1.7, 7.33, 0.1
    record = 0.4 + a * np.sin(2.0 * math.pi / period * np.arange(400) * dt + 0.6)
    height, periods = variant(record, dt)
    return float(max(np.abs(height / (2.0 * a) - 1.0).max(), np.abs(periods / period - 1.0).max()))


def code(record: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    found = record_statistics(record, dt)
    return found.height_m, found.period_s


def whole_samples(record: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Crossings at samples, not between them."""
    above = record > record.mean()
    at = np.flatnonzero(above[1:] & ~above[:-1])
    return code(record, dt)[0], np.diff(at) * dt


def any_crossing(record: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Up- and down-crossings alike."""
    above = record > record.mean()
    at = np.flatnonzero(above[1:] != above[:-1])
    return code(record, dt)[0], np.diff(at) * dt


@cache
def gaussian() -> RecordStatistics:
    """A narrow-banded Gaussian record of 13,000 waves."""
    n, dt, rng = 2**18, 0.5, np.random.Generator(np.random.PCG64(5))
    f = np.fft.rfftfreq(n, dt)
    spread = np.exp(-0.5 * ((f - 0.1) / 0.006) ** 2)
    half = np.sqrt(spread) * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    return record_statistics(np.fft.irfft(half, n), dt)


def rayleigh_heights(variant: Callable[[RecordStatistics], float | None]) -> float:
    """H1/3 = 4.004 sqrt(m0): mean over the highest third of a Rayleigh distribution."""
    found = gaussian()
    q = math.sqrt(math.log(3.0))
    exact = math.sqrt(8.0) * (q + 3.0 * math.sqrt(math.pi) / 2.0 * math.erfc(q))
    return abs(float(variant(found) or 0.0) / (exact * found.std_m) - 1.0)


@cache
def narrow() -> tuple[np.ndarray, np.ndarray]:
    """Crests of a narrow-banded deep-water sea, k sigma = 0.05: first order and total, ascending."""
    n, dt, depth, rng = 2**14, 0.5, 400.0, np.random.Generator(np.random.PCG64(8))
    m = np.arange(round(0.09 * n * dt), round(0.11 * n * dt))
    spread = np.exp(-0.5 * ((m / (n * dt) - 0.1) / 0.003) ** 2)
    amplitude = np.sqrt(spread / spread.sum()) * 0.05 / (0.2 * math.pi) ** 2 * G * math.sqrt(2.0)
    case = listed(
        2.0 * math.pi * m / (n * dt),
        amplitude,
        2.0 * math.pi * rng.random(m.size),
        time={"dt_s": dt, "n": n},
        water_depth_m=depth,
    )
    first, second = component_field(waves(build_sea_state(case))).elevation(np.zeros((1, 3)))
    return tuple(np.sort(record_statistics(e[0], dt).crest_m) for e in (first, first + second))  # type: ignore


def crests(variant: Callable[..., np.ndarray]) -> float:
    """Crests that 10, 3 and 1 % of the waves exceed, from those of the first order."""
    first, total = narrow()
    at = [round(first.size * (1.0 - p)) for p in (0.1, 0.03, 0.01)]
    hs, k = 1.0, (0.2 * math.pi) ** 2 / G
    p = np.exp(-8.0 * first[at] ** 2 / hs**2)
    return relative(total[[i - first.size + total.size for i in at]], variant(p, hs=hs, wavenumber=k))


def orbital(variant: Callable[[RegularRegime, float], float]) -> float:
    """Largest horizontal velocity of one component at four levels, in three depths."""
    worst = 0.0
    for depth in (8.0, 50.0, 300.0):
        wave = regular_regime(height=2.0, period=10.0, depth=depth, gravity=G)
        levels = [0.0, -2.0, -0.5 * depth, -depth]
        case = listed(
            0.2 * math.pi, 1.0, 0.0,
            points_m=[[0.0, 0.0, z] for z in levels],
            water_depth_m=depth, wave={"order": 1}, time={"dt_s": 0.1, "n": 100},
        )  # fmt: skip
        exact = wave_kinematics(case).velocity[:, :, 0].max(axis=0)
        found = np.array([variant(wave, z) for z in levels])
        worst = max(worst, float(np.abs(found / exact - 1.0).max()))
    return worst


def deep(wave: RegularRegime, z: float) -> float:
    return math.pi * wave.height_m / wave.period_s * math.exp(2.0 * math.pi / wave.length_m * z)


def at_surface(wave: RegularRegime, z: float) -> float:
    return orbital_speed(wave, 0.0)


@cache
def record() -> np.ndarray:
    """First and second order of the reference sea A, every 0.2 s."""
    case = recorded("A", time={"dt_s": 0.2, "n": 3000})
    first, second = component_field(waves(build_sea_state(case))).elevation(np.zeros((1, 3)))
    return np.asarray(first[0] + second[0])


def measured(variant: dict[str, float]) -> float:
    """Components of the record against those that it was made of, at the origin, 12 m down the waves."""
    sea = reference("A")
    found = components_of_record(
        record(), dt=0.2, x=variant.get("x", 0.0), depth=50.0, gravity=G,
        band=Band(0.0, variant.get("cutoff", 2.65), 1e-7), order=int(variant.get("order", 2)),
    )  # fmt: skip
    A = found.amplitude * np.exp(-1j * found.phase)
    exact = sea["a"] * np.exp(-1j * sea["phi"])
    both = np.zeros((2, 400), dtype=complex)
    for row, omega, values in ((0, found.omega, A), (1, sea["omega"], exact)):
        both[row, np.rint(omega * 600.0 / (2.0 * math.pi)).astype(int)] = values
    return relative(*both)


def table() -> TabulatedSpectrum:
    f = 0.03 * 1.1 ** np.arange(30)
    only = np.array([0.0])
    return TabulatedSpectrum(f, only, only - 0.5, only + 0.5, pierson_moskowitz(f, 3.0, 0.1)[:, None])


def file_height(variant: Callable[[TabulatedSpectrum, float], np.ndarray]) -> float:
    """Variance of the components over sum S_i df_i of the file's bins, for records of 30 s to 3 h."""
    given = table()
    exact = float(given.one_dimensional @ np.gradient(given.frequency))
    found = [0.5 * float(np.sum(variant(given, duration) ** 2)) for duration in (30.0, 600.0, 10_800.0)]
    return float(np.abs(np.array(found) / exact - 1.0).max())


def realised(given: TabulatedSpectrum, duration: float) -> np.ndarray:
    return realise_table(given, duration=duration).amplitude


def sampled(given: TabulatedSpectrum, duration: float) -> np.ndarray:
    """sqrt(2 S df) with S interpolated at each component."""
    f = np.arange(1, math.ceil(given.bounds[-1] * duration)) / duration
    s = np.interp(f, given.frequency, given.one_dimensional, left=0.0, right=0.0)
    return np.asarray(np.sqrt(2.0 * s / duration))


PROOFS = (
    Proof(
        key="spectral-moments",
        claim="Hm0 and the mean periods follow from the moments of the spectrum",
        against="closed form of the Pierson-Moskowitz moments, Gamma(1 - n/4)",
        error=moments,
        right=lambda s: (s.hm0_m, s.tm10_s, s.tm01_s, s.tm02_s),
        wrong={
            "moments of omega": lambda s: (s.hm0_m, s.tm10_s, s.tm01_s / (2.0 * math.pi), s.tm02_s),
            "Tm01 taken for Tm02": lambda s: (s.hm0_m, s.tm10_s, s.tm01_s, s.tm01_s),
        },
        allowed=1e-6,
        reason="trapezoids at a step of 5e-4 of the frequency: 2e-7",
    ),
    Proof(
        key="zero-crossing-waves",
        claim="heights and periods of the waves of a sine between up-crossings of its mean",
        against="H = 2 a and T",
        error=sine,
        right=code,
        wrong={"crossings at samples": whole_samples, "every crossing": any_crossing},
        allowed=1e-3,
        reason="a crest between two samples is missed by (pi dt / T)^2 / 2 = 9e-4 at most",
    ),
    Proof(
        key="rayleigh-heights",
        claim="H1/3 of a narrow-banded Gaussian record is 4.004 sqrt(m0)",
        against="mean of the highest third of a Rayleigh distribution",
        error=rayleigh_heights,
        right=lambda s: s.mean_of_highest(3),
        wrong={
            "mean height": lambda s: s.mean_of_highest(1),
            "highest tenth": lambda s: s.mean_of_highest(10),
            "median of the highest third": lambda s: float(np.quantile(s.height_m, 5.0 / 6.0)),
        },
        allowed=0.02,
        reason="about 13,000 waves in some 1500 independent groups: standard error 0.8 %",
    ),
    Proof(
        key="tayfun-crests",
        claim="crest heights of a narrow-banded deep-water sea to second order have Tayfun's distribution",
        against="quantiles of the crests of a simulated record, first order against total",
        error=crests,
        right=tayfun_crest,
        wrong={"Rayleigh, as at first order": lambda p, *, hs, wavenumber: rayleigh_crest(p, hs=hs)},
        allowed=0.01,
        reason="bandwidth 0.03 and crests between samples; the second order itself is 5 to 8 %",
    ),
    Proof(
        key="keulegan-carpenter-velocity",
        claim="the velocity in KC and Re is the largest of the linear wave",
        against="kinematics of one component over a period",
        error=orbital,
        right=orbital_speed,
        wrong={"deep water": deep, "value at still water": at_surface},
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="measured-record",
        claim="components come back from a record of their first and second order",
        against="components of the reference sea A (Hs 6 m)",
        error=measured,
        right={},
        wrong={
            "second order left in": {"order": 1},
            "gauge at another place": {"x": 1.0},
            "cut-off below the last component": {"cutoff": 2.3},
        },
        allowed=1e-6,
        reason="tolerance of the iteration, 1e-7, over its rate of convergence",
    ),
    Proof(
        key="energy-of-a-file",
        claim="components of a tabulated spectrum hold its energy, finer or coarser than its bins",
        against="sum of S df over the file's bins",
        error=file_height,
        right=realised,
        wrong={"density sampled at the components": sampled},
        allowed=1e-12,
        reason="round-off",
    ),
)
