"""Statistics of spectra and records: what they refuse, and what an odd record gives."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.errors import InputError
from owt_wave_node.core.crests import (
    counted_exceedance,
    forristall_crest,
    forristall_shape,
    rayleigh_crest,
    tayfun_crest,
)
from owt_wave_node.core.sea import build_sea_state
from owt_wave_node.core.sea_report import sea_report
from owt_wave_node.core.sea_statistics import (
    component_statistics,
    density_statistics,
    record_statistics,
)


def test_one_component_has_one_period_and_no_width() -> None:
    one = component_statistics(np.array([2.0 * math.pi / 8.0]), np.array([1.5]))
    assert one.hm0_m == pytest.approx(4.0 * 1.5 / math.sqrt(2.0), rel=1e-14)
    for period in (one.peak_period_s, one.tm01_s, one.tm02_s, one.tm10_s):
        assert period == pytest.approx(8.0, rel=1e-14)
    assert one.width == pytest.approx(0.0, abs=1e-7)
    assert one.broadness == pytest.approx(0.0, abs=1e-7)


def test_two_components() -> None:
    """nu^2 = m0 m2 / m1^2 - 1 of two lines of equal energy at f1, f2 is ((f2 - f1)/(f2 + f1))^2."""
    two = component_statistics(2.0 * math.pi * np.array([0.1, 0.14]), np.array([1.0, 1.0]))
    assert two.width == pytest.approx(0.04 / 0.24, rel=1e-12)


def test_the_peak_of_random_amplitudes_is_near_that_of_the_spectrum() -> None:
    """Mean error of 20 seeds: 3 % in 600 s; that of the largest amplitude is a third larger."""
    weighted, largest = [], []
    for seed in range(1, 21):
        sea = {"hs_m": 4.0, "tp_s": 10.0, "gamma": 3.3, "seed": seed, "amplitudes": "rayleigh"}
        state = build_sea_state(parse_case({"sea_state": sea}))
        found = component_statistics(state.omega_rad_s, state.amplitude_m)
        weighted.append(abs(found.peak_period_s / 10.0 - 1.0))
        highest = 2.0 * math.pi / state.omega_rad_s[state.amplitude_m.argmax()]
        largest.append(abs(highest / 10.0 - 1.0))
    assert np.mean(weighted) < 0.04
    assert np.mean(largest) > 1.1 * np.mean(weighted)


def test_empty_spectra_and_records_are_refused() -> None:
    with pytest.raises(InputError, match="no energy"):
        component_statistics(np.array([1.0]), np.array([0.0]))
    with pytest.raises(InputError, match="no energy"):
        density_statistics(np.linspace(0.1, 1.0, 5), np.zeros(5))
    for bad in (np.array([1.0]), np.array([0.0, np.nan])):
        with pytest.raises(InputError, match="two finite samples"):
            record_statistics(bad, 0.1)


def test_a_record_without_waves() -> None:
    flat = record_statistics(np.full(10, 2.0), 0.1)
    assert flat.as_dict() == {
        "mean_m": 2.0, "std_m": 0.0, "minimum_m": 2.0, "maximum_m": 2.0, "skewness": 0.0, "kurtosis": 0.0,
        "hm0_m": 0.0, "n_waves": 0, "mean_height_m": None, "h13_m": None, "h110_m": None, "hmax_m": None,
        "tz_s": None, "highest_crest_m": None,
    }  # fmt: skip
    assert record_statistics(np.array([1.0, 0.0, -1.0]), 0.1).n_waves == 0


def test_waves_of_unlike_height() -> None:
    """Three waves of heights 2, 4, 6 m: H1/3 is the highest third, and heights come in order of time."""
    t = np.arange(0, 40) / 10.0 * 2.0 * math.pi / 1.0
    a = np.repeat([1.0, 2.0, 3.0, 1.0], 10)
    found = record_statistics(-a * np.sin(t), 0.1)
    # sin starts with a trough here: the first up-crossing lies half a wave in
    assert found.n_waves == 3
    assert found.mean_of_highest(3) == pytest.approx(found.height_m.max())
    assert found.mean_of_highest(1) == pytest.approx(found.height_m.mean())
    assert found.crest_m[0] == pytest.approx(math.sin(0.4 * math.pi), rel=0.01)


def test_counted_exceedance() -> None:
    height, share = counted_exceedance(np.array([1.0, 3.0, 2.0]))
    assert height.tolist() == [3.0, 2.0, 1.0]
    assert share.tolist() == [0.25, 0.5, 0.75]


def test_second_order_crests_become_rayleigh_in_a_flat_sea() -> None:
    """Forristall's and Tayfun's crests tend to Rayleigh's as the steepness vanishes, and lie above it."""
    p = np.array([0.1, 0.001])
    linear = rayleigh_crest(p, hs=1e-3)
    shape = forristall_shape(hs=1e-3, tm01=10.0, wavenumber=0.04, depth=200.0, gravity=9.81)
    np.testing.assert_allclose(forristall_crest(p, hs=1e-3, alpha=shape[0], beta=shape[1]), linear, rtol=2e-4)
    np.testing.assert_allclose(tayfun_crest(p, hs=1e-3, wavenumber=0.04), linear, rtol=1e-4)
    steep = forristall_shape(hs=10.0, tm01=9.0, wavenumber=0.05, depth=50.0, gravity=9.81)
    spread = forristall_shape(hs=10.0, tm01=9.0, wavenumber=0.05, depth=50.0, gravity=9.81, spread=True)
    assert (
        forristall_crest(p, hs=10.0, alpha=steep[0], beta=steep[1]) > 1.05 * rayleigh_crest(p, hs=10.0)
    ).all()
    assert spread != steep


def test_report_is_plain_numbers() -> None:
    import json

    report = sea_report(parse_case({"time": {"n": 1200}}))
    data = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert data["spectrum"]["hm0_m"] == pytest.approx(6.0)
    assert data["record"]["total"]["skewness"] > data["record"]["first_order"]["skewness"]
    assert data["regime"]["members"] == []
    assert [row["probability"] for row in data["crests"]] == [0.1, 0.01, 0.001]


def test_a_regular_wave_has_no_spectrum() -> None:
    """Its height and period are those asked for; nothing of an irregular sea is said of it."""
    report = sea_report(parse_case({"regular": {"height_m": 6.0, "period_s": 10.0}}))
    assert report.spectrum is None
    assert report.first is None
    assert not report.crests
    # samples miss the crest by up to half a step
    assert report.total.height_m.max() == pytest.approx(6.0, abs=1e-2)
    assert report.total.period_s.mean() == pytest.approx(10.0, rel=1e-6)
    assert json.dumps(report.as_dict(), allow_nan=False)
