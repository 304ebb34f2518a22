"""Damage from spectra: closed forms, integrals, and rainflow of long Gaussian records."""

from __future__ import annotations

from math import gamma, sqrt

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_postproc.core.rainflow import rainflow
from owt_postproc.core.sn import SNCurve, cycles_to_failure, miner_damage, sn_curve
from owt_postproc.core.spectral import dirlik_damage, narrow_band_damage, spectral_moments

DT, N = 0.1, 2**18
F = np.linspace(0.004, 2.0, 4000)


def one_slope(m: float) -> SNCurve:
    return SNCurve("one slope", (m, m), (12.0, 12.0), 1e7)


def pierson_moskowitz() -> np.ndarray:
    return 1e14 * F**-5.0 * np.exp(-1.25 * (F / 0.1) ** -4.0) * 1e-5


def sea_and_resonance() -> np.ndarray:
    """Stress of a jacket: waves about 0.1 Hz, its first bending about 0.35 Hz."""
    return pierson_moskowitz() + 3e13 * np.exp(-(((F - 0.35) / 0.02) ** 2))


def narrow() -> np.ndarray:
    return 1e15 * np.exp(-(((F - 0.3) / 0.006) ** 2))


def record(density: np.ndarray, seed: int) -> np.ndarray:
    """Gaussian by the sum of many lines of random phase; its variance is that of the spectrum."""
    line = np.arange(N // 2 + 1) / (N * DT)
    amplitude = np.sqrt(2.0 * np.interp(line, F, density, left=0.0, right=0.0) / (N * DT))
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, line.size)
    return np.fft.irfft(0.5 * N * amplitude * np.exp(1j * phase), N)


def counted(density: np.ndarray, curve: SNCurve) -> float:
    """Mean damage of three records by rainflow."""
    found = []
    for seed in range(3):
        ranges, _, counts = rainflow(record(density, seed))
        found.append(miner_damage(curve, ranges, counts))
    return float(np.mean(found))


def test_moments_of_a_triangle():
    """S = f on (0, 1): m_n = 1/(n + 2)."""
    f = np.linspace(0.0, 1.0, 20_001)
    moments = spectral_moments(f, f)
    found = [moments.m0, moments.m1, moments.m2, moments.m4]
    np.testing.assert_allclose(found, [1 / 2, 1 / 3, 1 / 4, 1 / 6], rtol=1e-7)
    assert moments.crossing_hz == pytest.approx(sqrt(1 / 2))
    assert moments.irregularity == pytest.approx(0.25 / sqrt(1 / 12))


@pytest.mark.parametrize("m", [3.0, 4.0, 5.0])
def test_narrow_band_in_closed_form(m):
    moments = spectral_moments(F, narrow())
    sigma, nu = sqrt(moments.m0) / 1e6, sqrt(moments.m2 / moments.m0)
    expected = nu * 3600.0 / 1e12 * (2.0 * sqrt(2.0) * sigma) ** m * gamma(1.0 + m / 2.0)
    found = narrow_band_damage(moments, 3600.0, one_slope(m))
    assert found == pytest.approx(expected, rel=1e-12)
    assert found != pytest.approx(expected / 2.0 ** (m / 2.0), rel=0.1)  # ranges are twice the amplitudes


@pytest.mark.parametrize("scale", [0.3, 1.0, 4.0])
def test_two_slopes_equal_the_integral_over_rayleigh_ranges(scale):
    moments, curve = spectral_moments(F, scale**2 * narrow()), sn_curve("D_air")
    s = np.linspace(1e3, 30 * sqrt(moments.m0), 400_001)
    rayleigh = s / (4 * moments.m0) * np.exp(-(s**2) / (8 * moments.m0))
    integral = np.trapezoid(rayleigh / cycles_to_failure(curve, s), s)
    assert narrow_band_damage(moments, 1.0, curve) == pytest.approx(moments.crossing_hz * integral, rel=1e-6)


def dirlik_density(s: np.ndarray, m0: float, m1: float, m2: float, m4: float) -> np.ndarray:
    """Dirlik's probability density of ranges as printed in textbooks, with Z = S / (2 sqrt(m0))."""
    z, xm, ga = s / (2 * sqrt(m0)), m1 / m0 * sqrt(m2 / m4), m2 / sqrt(m0 * m4)
    D1 = 2 * (xm - ga**2) / (1 + ga**2)
    R = (ga - xm - D1**2) / (1 - ga - D1 + D1**2)
    D2 = (1 - ga - D1 + D1**2) / (1 - R)
    D3 = 1 - D1 - D2
    Q = 1.25 * (ga - D3 - D2 * R) / D1
    p = D1 / Q * np.exp(-z / Q) + D2 * z / R**2 * np.exp(-(z**2) / (2 * R**2)) + D3 * z * np.exp(-(z**2) / 2)
    return p / (2 * sqrt(m0))


@pytest.mark.parametrize("density", [pierson_moskowitz(), sea_and_resonance()], ids=["sea", "jacket"])
def test_dirlik_equals_the_integral_over_its_ranges(density):
    moments, curve = spectral_moments(F, density), sn_curve("T_cathodic_protection")
    s = np.linspace(1.0, 60 * sqrt(moments.m0), 2_000_001)
    p = dirlik_density(s, moments.m0, moments.m1, moments.m2, moments.m4)
    assert np.trapezoid(p, s) == pytest.approx(1.0, rel=1e-5)
    integral = np.trapezoid(p / cycles_to_failure(curve, s), s)
    assert dirlik_damage(moments, 1.0, curve) == pytest.approx(moments.peak_hz * integral, rel=1e-5)


def check_narrow(estimate, m):
    """Three standard errors: damage of one record scatters by 1.8 % at m = 3 and 7.2 % at m = 5 (8 seeds)."""
    density, curve = narrow(), one_slope(m)
    found = estimate(spectral_moments(F, density), N * DT, curve)
    assert counted(density, curve) == pytest.approx(found, rel={3.0: 0.03, 5.0: 0.12}[m])


@pytest.mark.parametrize("m", [3.0, 5.0])
@pytest.mark.parametrize("estimate", [narrow_band_damage, dirlik_damage])
def test_rainflow_of_a_narrow_band(estimate, m):
    check_narrow(estimate, m)


@pytest.mark.parametrize("m", [3.0, 5.0])
def test_narrow_band_would_notice_amplitudes_for_ranges(m):
    def amplitudes(moments, duration, curve):
        return narrow_band_damage(moments, duration, curve) / 2.0**m

    with pytest.raises(AssertionError):
        check_narrow(amplitudes, m)


def check_broad(estimate, density, m):
    """Dirlik fitted simulated records, and is off by some percent: over 8 seeds -2 and +6 % at m = 3, -3 and
    +7 % at m = 5. Three standard errors of these records are 0.8 and 4 %.
    """
    curve = one_slope(m)
    found = estimate(spectral_moments(F, density), N * DT, curve)
    assert counted(density, curve) == pytest.approx(found, rel={3.0: 0.08, 5.0: 0.11}[m])


@pytest.mark.parametrize("m", [3.0, 5.0])
@pytest.mark.parametrize("density", [pierson_moskowitz(), sea_and_resonance()], ids=["sea", "jacket"])
def test_rainflow_of_a_broad_band(density, m):
    check_broad(dirlik_damage, density, m)


def test_broad_band_would_notice_the_narrow_band_formula():
    with pytest.raises(AssertionError):
        check_broad(narrow_band_damage, sea_and_resonance(), 3.0)


def test_dirlik_turns_to_the_narrow_band():
    f = 0.3 * (1.0 + np.linspace(-1e-4, 1e-4, 11))
    moments = spectral_moments(f, np.full(11, 1e18))
    assert moments.irregularity > 1.0 - 1e-6
    assert dirlik_damage(moments, 1.0, one_slope(3.0)) == narrow_band_damage(moments, 1.0, one_slope(3.0))
    wider = spectral_moments(F, narrow())
    ratio = dirlik_damage(wider, 1.0, one_slope(3.0)) / narrow_band_damage(wider, 1.0, one_slope(3.0))
    assert ratio == pytest.approx(1.0, abs=2e-3)


def test_thick_wall_has_more_damage():
    moments = spectral_moments(F, pierson_moskowitz())
    curve = SNCurve("k", (3.0, 3.0), (12.0, 12.0), 1e7, thickness_exponent=0.2)
    for estimate in (narrow_band_damage, dirlik_damage):
        thick, thin = estimate(moments, 1.0, curve, thickness_m=0.05), estimate(moments, 1.0, curve)
        assert thick / thin == pytest.approx(2.0**0.6)


@pytest.mark.parametrize(
    ("f", "density"),
    [([1.0], [1.0]), ([1.0, 1.0], [1.0, 1.0]), ([1.0, 2.0], [1.0, np.nan]), ([1.0, 2.0], [0.0, 0.0])],
)
def test_impossible_spectrum_is_refused(f, density):
    with pytest.raises(InputError, match=r"frequency|density"):
        spectral_moments(np.array(f), np.array(density))
