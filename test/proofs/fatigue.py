"""Counting of cycles, damage, and its estimate from a spectrum."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import Any

import fatpack
import numpy as np
import rainflow as library

from owt_postproc.core.cycles import Cycles
from owt_postproc.core.rainflow import RainflowStream, rainflow
from owt_postproc.core.sn import SNCurve, cycles_to_failure, miner_damage, sn_curve
from owt_postproc.core.spectral import SpectralMoments, dirlik_damage, narrow_band_damage, spectral_moments
from proofs.registry import Proof

Count = Callable[[np.ndarray], Cycles]

STANDARD = np.array([-2.0, 1, -3, 5, -1, 3, -4, 4, -2])
AS_PRINTED = {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
REPEATING = {3.0: 1.0, 4.0: 1.0, 7.0: 1.0, 9.0: 1.0}
DT, N = 0.1, 2**18
F = np.linspace(0.004, 2.0, 4000)


def table(cycles: Cycles, *, means: bool = True) -> Counter[Any]:
    found: Counter[Any] = Counter()
    for r, m, c in zip(*cycles, strict=True):
        found[(float(r), float(m)) if means else float(r)] += float(c)
    return found


def apart(a: Any, b: Any) -> float:
    """Cycles that are in one table and not in the other."""
    return float(sum(abs(a.get(key, 0.0) - b.get(key, 0.0)) for key in {*a, *b}))


def walk(seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(20_000).cumsum()


def closed(series: np.ndarray) -> Cycles:
    return rainflow(series, closed=True)


def every_cycle_full(series: np.ndarray) -> Cycles:
    ranges, means, counts = rainflow(series)
    return Cycles(ranges, means, np.ceil(counts))


def without_residue(series: np.ndarray) -> Cycles:
    return Cycles(*(part[rainflow(series).counts == 1.0] for part in rainflow(series)))


def range_counting(series: np.ndarray) -> Cycles:
    inner = np.flatnonzero(np.diff(np.sign(np.diff(series)))) + 1
    turns = series[[0, *inner, len(series) - 1]]
    return Cycles(np.abs(np.diff(turns)), turns[1:], np.full(len(turns) - 1, 0.5))


def integers() -> np.ndarray:
    """Integers 0 .. 64 with many equal ranges; they start and end falling."""
    steps = np.random.default_rng(1).integers(-6, 7, 20_000).cumsum()
    return np.concatenate([[9.0, 0.0, 64.0], np.abs((steps + 64) % 128 - 64), [64.0, 3.0]])


def example(count: Count) -> float:
    return apart(table(count(STANDARD), means=False), AS_PRINTED)


def repeating(count: Count) -> float:
    return apart(table(count(STANDARD), means=False), REPEATING)


def variation(count: Count) -> float:
    ranges, _, counts = count(walk())
    return abs(float(np.sum(ranges * counts)) / (0.5 * float(np.abs(np.diff(walk())).sum())) - 1.0)


def largest(count: Count) -> float:
    return abs(float(count(walk()).ranges.max()) - float(np.ptp(walk())))


def reversal(count: Count) -> float:
    return max(
        apart(table(count(x)), table(count(x[::-1]))) for x in (walk(), integers(), np.array([0.0, 1, 0, 2]))
    )


def rotation(count: Count) -> float:
    return max(apart(table(count(walk())), table(count(np.roll(walk(), k)))) for k in (1, 777, 12_345))


def splitting(count_block: Callable[[RainflowStream, np.ndarray], Cycles]) -> float:
    worst, series = 0.0, walk()[:2000]
    for size in (1, 7, 500, 1999):
        stream = RainflowStream()
        parts = [count_block(stream, series[i : i + size]) for i in range(0, len(series), size)]
        found = Cycles(*map(np.concatenate, zip(*parts, stream.finish(), strict=True)))
        worst = max(worst, apart(table(found), table(rainflow(series))))
    return worst


def of_rainflow_library(count: Count) -> float:
    found = Counter[Any]()
    for r, m, c, _, _ in library.extract_cycles(walk().tolist()):
        found[float(r), float(m)] += c
    return apart(table(count(walk())), found)


def of_fatpack(count: Count) -> float:
    series = integers()
    theirs = Counter(np.round(fatpack.find_rainflow_ranges(series, k=64), 9).tolist())
    return apart(table(count(series), means=False), theirs)


def one_slope(m: float) -> SNCurve:
    return SNCurve("one slope", (m, m), (12.0, 12.0), 1e7)


def power_law(power: Callable[[float], float]) -> float:
    """Damage of c times the series over that of the series, against c^power(m)."""

    def damage(c: float, m: float) -> float:
        ranges, _, counts = rainflow(c * 1e6 * walk())
        return miner_damage(one_slope(m), ranges, counts)

    return max(
        abs(damage(c, m) / damage(1.0, m) / c ** power(m) - 1.0) for c in (0.5, 3.0) for m in (3.0, 4.0, 5.0)
    )


def sine(cycles: Callable[[SNCurve, np.ndarray], np.ndarray]) -> float:
    """Amplitudes on both slopes of class D in air, in walls of 25 and 50 mm."""
    worst = 0.0
    for amplitude in (10.0, 20.0, 40.0, 100.0):
        for thickness, factor in ((0.025, 1.0), (0.05, 2.0**0.2)):
            s = 2.0 * amplitude * factor
            exact = 37.0 / (10**12.164 / s**3 if s > (10**5.164) ** (1 / 3) else 10**15.606 / s**5)
            wave = amplitude * 1e6 * np.cos(2.0 * np.pi * np.arange(37 * 64 + 1) / 64)
            ranges, _, counts = rainflow(wave)
            found = float(np.sum(counts / cycles(sn_curve("D_air"), ranges, thickness)))
            worst = max(worst, abs(found / exact - 1.0))
    return worst


def unsigned(ratio: dict[float, float]) -> float:
    """Damage of |bending| over that of bending, zero mean, against the ratios 2 / 2^m."""
    bending = 60e6 * np.cos(2.0 * np.pi * np.arange(1000 * 64 + 1) / 64)
    worst = 0.0
    for m, expected in ratio.items():
        damage = []
        for series in (np.abs(bending), bending):
            ranges, _, counts = rainflow(series)
            damage.append(miner_damage(one_slope(m), ranges, counts))
        worst = max(worst, abs(damage[0] / damage[1] - expected))
    return worst


def line(density: np.ndarray, seed: int) -> np.ndarray:
    f = np.arange(N // 2 + 1) / (N * DT)
    amplitude = np.sqrt(2.0 * np.interp(f, F, density, left=0.0, right=0.0) / (N * DT))
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, f.size)
    return np.fft.irfft(0.5 * N * amplitude * np.exp(1j * phase), N)


@cache
def counted(is_narrow: bool) -> float:
    found = []
    for seed in range(3):
        ranges, _, counts = rainflow(line(band(is_narrow), seed))
        found.append(miner_damage(one_slope(3.0), ranges, counts))
    return float(np.mean(found))


def band(is_narrow: bool) -> np.ndarray:
    if is_narrow:
        return 1e15 * np.exp(-(((F - 0.3) / 0.006) ** 2))
    sea = 1e9 * F**-5.0 * np.exp(-1.25 * (F / 0.1) ** -4.0)
    return np.asarray(sea + 3e13 * np.exp(-(((F - 0.35) / 0.02) ** 2)))


def rayleigh(estimate: Callable[[SpectralMoments, float, SNCurve], float]) -> float:
    moments = spectral_moments(F, band(True))
    scale = 2.0 * math.sqrt(2.0 * moments.m0) / 1e6
    nu = math.sqrt(moments.m2 / moments.m0)
    return max(
        abs(estimate(moments, 1.0, one_slope(m)) / (nu / 1e12 * scale**m * math.gamma(1.0 + m / 2.0)) - 1.0)
        for m in (3.0, 4.0, 5.0)
    )


def gaussian(is_narrow: bool) -> Callable[[Callable[..., float]], float]:
    def error(estimate: Callable[[SpectralMoments, float, SNCurve], float]) -> float:
        moments = spectral_moments(F, band(is_narrow))
        return abs(counted(is_narrow) / estimate(moments, N * DT, one_slope(3.0)) - 1.0)

    return error


def of_amplitudes(moments: SpectralMoments, duration: float, curve: SNCurve) -> float:
    return narrow_band_damage(moments, duration, curve) / 2.0 ** curve.m[0]


def rate_of_maxima(moments: SpectralMoments, duration: float, curve: SNCurve) -> float:
    return narrow_band_damage(moments, duration, curve) / moments.irregularity


def code(curve: SNCurve, ranges: np.ndarray, thickness: float) -> np.ndarray:
    return np.asarray(cycles_to_failure(curve, ranges, thickness_m=thickness))


def no_thickness(curve: SNCurve, ranges: np.ndarray, thickness: float) -> np.ndarray:
    return np.asarray(cycles_to_failure(curve, ranges))


def first_slope(curve: SNCurve, ranges: np.ndarray, thickness: float) -> np.ndarray:
    alone = SNCurve(
        "first slope", (3.0, 3.0), (12.164, 12.164), 1e7, thickness_exponent=curve.thickness_exponent
    )
    return code(alone, ranges, thickness)


HALVES = {"every cycle full": every_cycle_full, "residue left out": without_residue}
EXACT = "counts are whole and half numbers; ranges and means are single differences and sums"

PROOFS = [
    Proof(
        "rainflow-standard-example", "Half cycles and residue as in ASTM E1049-85",
        "the standard's example, figure 6; cycles that differ", example,
        rainflow, {**HALVES, "ranges between turning points": range_counting, "residue closed": closed},
        0.0, EXACT,
    ),
    Proof(
        "rainflow-repeating-history", "Closed residue as ASTM E1049-85 counts a repeating history",
        "the standard's example, figure 7; cycles that differ", repeating,
        closed, {"residue as half cycles": rainflow, **HALVES}, 0.0, EXACT,
    ),
    Proof(
        "rainflow-total-variation", "Sum of range times count is half the total variation",
        "sum of the steps of a random walk, 20,000 samples", variation,
        rainflow, HALVES, 1e-12, "round-off of sums of 20,000 terms",
    ),
    Proof(
        "rainflow-largest-range", "The largest range is maximum minus minimum", "a random walk",
        largest, rainflow,
        {"residue left out": without_residue, "ranges between turning points": range_counting}, 0.0, EXACT,
    ),
    Proof(
        "rainflow-time-reversal", "A reversed record has the same count of every range and mean",
        "random, with equal ranges too; cycles that differ. Which counts are halves may change", reversal,
        rainflow, HALVES, 0.0, EXACT,
    ),
    Proof(
        "rainflow-rotation", "A closed residue counts the same wherever the period is cut",
        "a random walk cut at three places; cycles that differ", rotation,
        closed, {"residue as half cycles": rainflow}, 0.0, EXACT,
    ),
    Proof(
        "rainflow-splitting", "Blocks of any length give the cycles of the whole record",
        "blocks of 1, 7, 500 and 1,999 samples; cycles that differ", splitting,
        lambda stream, part: stream.push(part),
        {"each block by itself": lambda stream, part: rainflow(part)}, 0.0, EXACT,
    ),
    Proof(
        "rainflow-library", "Cycle by cycle what the library rainflow 3.2.0 counts",
        "a random walk; cycles that differ", of_rainflow_library,
        rainflow, {"residue closed": closed, **HALVES}, 0.0, EXACT,
    ),
    Proof(
        "rainflow-fatpack", "With closed residue what the library fatpack 0.7.8 counts",
        "integers, the centres of its classes; cycles that differ", of_fatpack,
        closed, {"residue as half cycles": rainflow}, 0.0, EXACT,
    ),
    Proof(
        "damage-power-law", "c times the stress has c^m times the damage, one slope",
        "m = 3, 4, 5; c = 0.5, 3", power_law,
        lambda m: m, {"c^(m + 1)": lambda m: m + 1.0, "c^3": lambda m: 3.0}, 1e-10, "round-off of sums",
    ),
    Proof(
        "damage-of-a-sine", "Damage of a sine on both slopes, in walls of 25 and 50 mm",
        "n / N of class D in air", sine,
        code, {"first slope alone": first_slope, "no thickness effect": no_thickness}, 1e-10, "round-off",
    ),
    Proof(
        "unsigned-stress", "Unsigned stress keeps 0.25 (m = 3) and 0.06 (m = 5) of a bending sine's damage",
        "half the range, twice the cycles: 2/2^m, a thousand cycles", unsigned, {3.0: 0.25, 5.0: 0.0625},
        {"no loss": {3.0: 1.0, 5.0: 1.0}, "half the range only": {3.0: 0.125, 5.0: 0.03125}},
        1e-9, "round-off of sums",
    ),
    Proof(
        "narrow-band-closed-form", "Narrow band: nu T/a (2 sqrt(2 m0))^m Gamma(1 + m/2)", "m = 3, 4, 5",
        rayleigh, narrow_band_damage,
        {"amplitudes for ranges": of_amplitudes, "rate of maxima": rate_of_maxima}, 1e-12, "round-off",
    ),
    Proof(
        "narrow-band-record", "Narrow band against rainflow of Gaussian records",
        "three of 26,000 s, m = 3",
        gaussian(True), narrow_band_damage, {"amplitudes for ranges": of_amplitudes},
        0.03, "three standard errors: damage of a record scatters by 1.8 % (8 seeds)",
    ),
    Proof(
        "dirlik-record", "Dirlik against rainflow of Gaussian records of a sea and a resonance",
        "three of 26,000 s, irregularity 0.7, m = 3", gaussian(False), dirlik_damage,
        {"narrow band": narrow_band_damage, "amplitudes for ranges": of_amplitudes},
        0.08, "Dirlik's fit is off by 6 % there (8 seeds), three standard errors are 0.5 %",
    ),
]  # fmt: skip
