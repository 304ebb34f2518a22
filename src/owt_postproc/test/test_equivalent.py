"""Equivalent ranges, damage over cases and life in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_postproc.core.equivalent import (
    accumulated_damage,
    combined_equivalent,
    equivalent_range,
    life_years,
    occurrences,
)
from owt_postproc.core.rainflow import rainflow
from owt_postproc.core.sn import SNCurve, miner_damage

MS = [3.0, 4.0, 5.0, 10.0]


def sine(amplitude: float, cycles: int) -> np.ndarray:
    return amplitude * np.cos(2 * np.pi * np.arange(cycles * 64 + 1) / 64)


@pytest.mark.parametrize("m", MS)
def test_sine_is_equivalent_to_itself(m):
    ranges, _, counts = rainflow(sine(3.0, 20))
    assert equivalent_range(ranges, counts, m=m, cycles=20.0) == pytest.approx(6.0, rel=1e-12)
    # a tenth of the cycles have to be larger by 10^(1/m)
    assert equivalent_range(ranges, counts, m=m, cycles=2.0) == pytest.approx(6.0 * 10 ** (1 / m), rel=1e-12)


@pytest.mark.parametrize("m", MS)
def test_equivalent_range_does_the_same_damage(m):
    ranges, _, counts = rainflow(np.random.default_rng(1).standard_normal(4000).cumsum() * 1e6)
    duration, frequency, curve = 600.0, 1.0, SNCurve("one slope", (m, m), (12.0, 12.0), 1e7)
    found = equivalent_range(ranges, counts, m=m, cycles=frequency * duration)
    same = miner_damage(curve, np.array([found]), np.array([frequency * duration]))
    assert same == pytest.approx(miner_damage(curve, ranges, counts), rel=1e-10)
    wrong = equivalent_range(ranges, counts, m=m + 1.0, cycles=frequency * duration)
    assert miner_damage(curve, np.array([wrong]), np.array([600.0])) != pytest.approx(same, rel=1e-3)


@pytest.mark.parametrize("m", MS)
def test_equivalent_range_scales_with_the_load(m):
    ranges, _, counts = rainflow(np.random.default_rng(1).standard_normal(400))
    one = equivalent_range(ranges, counts, m=m, cycles=600.0)
    assert equivalent_range(1e9 * ranges, counts, m=m, cycles=600.0) == pytest.approx(1e9 * one, rel=1e-12)


def test_no_cycles_no_equivalent_range():
    assert equivalent_range(np.zeros(0), np.zeros(0), m=3.0, cycles=1.0) == 0.0


@pytest.mark.parametrize(("m", "cycles"), [(0.0, 1.0), (np.nan, 1.0), (3.0, 0.0), (3.0, -1.0), (3.0, np.inf)])
def test_impossible_reference_is_refused(m, cycles):
    with pytest.raises(InputError, match=r"must be finite and > 0"):
        equivalent_range(np.ones(1), np.ones(1), m=m, cycles=cycles)


def test_two_cases_of_half_the_time_each():
    found = combined_equivalent(np.array([[1.0, 2.0], [3.0, 2.0]]), np.array([0.5, 0.5]), m=3.0)
    np.testing.assert_allclose(found, [14.0 ** (1 / 3), 2.0], rtol=1e-12)


def test_damage_is_summed_at_each_spot_before_the_maximum():
    damage, weight = np.array([[1e-6, 9e-6], [8e-6, 2e-6]]), np.array([100.0, 300.0])
    total = accumulated_damage(damage, weight)
    np.testing.assert_allclose(total, [25e-4, 15e-4])
    sum_of_maxima = float(np.sum(weight * damage.max(axis=1)))  # wrong: no spot has that
    assert total.max() < sum_of_maxima


def test_occurrences_of_a_year():
    found = occurrences(np.array([0.25, 0.75]), 600.0)
    assert found.sum() == pytest.approx(365.25 * 24 * 6)
    np.testing.assert_allclose(occurrences(np.array([0.25, 0.75]), 600.0, years=20.0), 20 * found)


def test_life_with_a_design_fatigue_factor():
    assert life_years(0.02) == pytest.approx(50.0)
    assert life_years(0.02, design_fatigue_factor=2.5) == pytest.approx(20.0)
    np.testing.assert_array_equal(life_years(np.array([0.5, 0.0])), [2.0, np.inf])


@pytest.mark.parametrize(
    "call",
    [
        lambda: accumulated_damage(np.ones((2, 3)), np.ones(3)),
        lambda: accumulated_damage(np.array([[np.nan]]), np.ones(1)),
        lambda: accumulated_damage(np.ones((1, 1)), -np.ones(1)),
        lambda: occurrences(np.array([np.nan]), 600.0),
        lambda: occurrences(np.ones(1), 0.0),
        lambda: life_years(-1.0),
        lambda: life_years(1.0, design_fatigue_factor=0.5),
    ],
)
def test_what_makes_no_sense_is_refused(call):
    with pytest.raises(InputError):
        call()
