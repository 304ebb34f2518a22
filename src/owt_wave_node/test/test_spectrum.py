"""Spectra, their realisation and dispersion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from owt_model.config import SeaStateConfig, parse_case
from owt_model.errors import ComputationError, InputError
from owt_wave_node.core import realisation, spectrum
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.realisation import Realisation, realise
from owt_wave_node.core.sea import build_sea_state, waves

SEA = {"hs": 6.0, "tp": 9.45, "gamma": 3.3}
FREQUENCY = np.linspace(1e-3, 4.0, 40000)


def config(**given: object) -> SeaStateConfig:
    """A sea state as a case file gives it."""
    sea = parse_case({"sea_state": {"gamma": 3.3} | given if "spectrum" not in given else given}).sea_state
    assert sea is not None
    return sea


def realised(duration: float = 600.0, **given: object) -> Realisation:
    return realise(config(**given), duration=duration, gravity=9.81)


def test_gamma_rule() -> None:
    """Eq. 4.80: both ends, the exponential between them, and the value of the reference sea."""
    assert spectrum.gamma_rule(9.0, 3.0 * 3.59) == 5.0
    assert spectrum.gamma_rule(9.0, 3.0 * 5.01) == 1.0
    assert spectrum.gamma_rule(6.0, 9.45) == pytest.approx(3.7186537342331367, rel=1e-14)
    assert spectrum.gamma_rule(4.0, 2.0 * 4.5) == pytest.approx(math.exp(5.75 - 1.15 * 4.5), rel=1e-14)


def check_height(amplitude: np.ndarray) -> None:
    assert 4.0 * math.sqrt(np.sum(amplitude**2) / 2.0) == pytest.approx(6.0, rel=1e-13)


def test_height_is_exact_within_the_band() -> None:
    for name in spectrum.SHAPES:
        for cutoff in (1.5, 4.0):
            tp = 11.83 if name == "ochi-hubble" else 9.45
            check_height(realised(spectrum=name, tp_s=tp, cutoff_over_peak=cutoff).amplitude)


def test_height_would_notice_the_unscaled_spectrum() -> None:
    f = np.arange(1, 254) / 600.0
    with pytest.raises(AssertionError):
        check_height(np.sqrt(2.0 * spectrum.jonswap(f, **SEA) / 600.0))


def test_jonswap_holds_the_energy_of_hs() -> None:
    """The energy scale of DNV-RP-C205 is good to a percent, and the peak lies at fp."""
    f = np.linspace(1e-3, 4.0, 40000)
    for gamma in (1.0, 3.3, 5.0):
        s = spectrum.jonswap(f, hs=6.0, tp=9.45, gamma=gamma)
        assert 4.0 * math.sqrt(np.sum(s) * (f[1] - f[0])) == pytest.approx(6.0, rel=0.01)
        assert f[s.argmax()] == pytest.approx(1.0 / 9.45, rel=2e-3)


def test_phases_are_the_same_everywhere() -> None:
    """PCG64(1), ascending frequency: the first three phases, and a longer band begins like a shorter."""
    assert realisation.phases(3, 1) == pytest.approx([3.21587011, 5.97193953, 0.90578156], abs=1e-8)
    assert np.array_equal(realisation.phases(10, 7), realisation.phases(50, 7)[:10])
    assert not np.allclose(realisation.phases(3, 1), realisation.phases(3, 2))
    many = realisation.phases(20000, 3)
    assert many.min() >= 0.0
    assert many.max() < 2.0 * math.pi


def test_components_are_multiples_up_to_the_cutoff() -> None:
    omega = realised().omega
    assert len(omega) == 253
    assert omega == pytest.approx(2.0 * math.pi / 600.0 * np.arange(1, 254), rel=1e-14)


def test_empty_band_is_refused() -> None:
    with pytest.raises(InputError, match=r"time\.n .*no component"):
        realised(duration=2.0)


OMEGA = np.concatenate([np.geomspace(1e-3, 60.0, 400), np.array([0.5, 1.0])])


def check_dispersion(k: np.ndarray, depth: float) -> None:
    residual = 9.81 * k * np.tanh(k * depth) / OMEGA**2 - 1.0
    assert np.abs(residual).max() < 5e-15


@pytest.mark.parametrize("depth", [0.5, 20.0, 50.0, 4000.0])
def test_dispersion(depth: float) -> None:
    check_dispersion(wavenumber(OMEGA, water_depth=depth, gravity=9.81), depth)


def test_dispersion_would_notice_deep_water() -> None:
    with pytest.raises(AssertionError):
        check_dispersion(OMEGA**2 / 9.81, 50.0)


def test_dispersion_matches_the_reference(reference: dict) -> None:
    d = reference["A"]
    k = wavenumber(d["omega"], water_depth=50.0, gravity=9.81)
    assert np.abs(k / d["k"] - 1.0).max() < 1e-13


def test_dispersion_never_fails_silently() -> None:
    with pytest.raises(ComputationError, match="dispersion"):
        wavenumber(np.array([0.5, np.nan]), water_depth=50.0, gravity=9.81)


def test_sea_state_records_how_it_was_made() -> None:
    sea = build_sea_state(parse_case({}))
    assert (sea.hs_m, sea.tp_s, sea.seed, sea.order, sea.stretching) == (6.0, 9.45, 1, 2, "taylor")
    assert sea.direction_deg == 210.0
    assert sea.gamma == spectrum.gamma_rule(6.0, 9.45)
    assert len(sea.omega_rad_s) == len(sea.wavenumber_rad_m) == 253


def test_equal_frequencies_are_merged(listed) -> None:
    """Two components of one frequency are one of the summed phasor."""
    both = waves(build_sea_state(listed([0.7, 0.6, 0.7], [1.0, 0.5, 1.0], [0.0, 0.3, math.pi / 2])))
    assert both.omega.tolist() == [0.6, 0.7]
    assert both.amplitude[1] == pytest.approx(1.0 - 1.0j, abs=1e-15)
