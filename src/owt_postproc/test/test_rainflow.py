"""Rainflow counting against the standard's example, exact identities and an independent four-point count."""

from __future__ import annotations

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import owt_postproc
from owt_model.errors import InputError
from owt_postproc.core.rainflow import rainflow

VALUES = json.loads((Path(__file__).parent / "data" / "fatigue_values.json").read_text())
SERIES = VALUES["astm_e1049_example"]["series"]
EXPECTED = {float(k): v for k, v in VALUES["astm_e1049_example"]["range_to_count"].items()}

integers = st.lists(st.integers(-6, 6), max_size=60)
reals = st.lists(st.floats(-100, 100, allow_nan=False, width=32), max_size=60)


def by_range(ranges, counts) -> dict[float, float]:
    table: Counter[float] = Counter()
    for r, c in zip(ranges, counts, strict=True):
        table[float(r)] += float(c)
    return dict(table)


def turning_points(series) -> list[float]:
    points: list[float] = []
    for x in series:
        if points and x == points[-1]:
            continue
        if len(points) >= 2 and (points[-1] - points[-2]) * (x - points[-1]) > 0:
            points[-1] = x
        else:
            points.append(x)
    return points


def four_point(series) -> dict[float, float]:
    """Reference: take out inner ranges by four points, then the residue as half cycles."""
    table: Counter[float] = Counter()
    stack: list[float] = []
    for x in turning_points(series):
        stack.append(x)
        while len(stack) >= 4:
            outer_1, inner, outer_2 = (abs(stack[i + 1] - stack[i]) for i in range(-4, -1))
            if inner > outer_1 or inner > outer_2:
                break
            table[inner] += 1.0
            del stack[-3:-1]
    for a, b in pairwise(stack):
        table[abs(b - a)] += 0.5
    return dict(table)


def no_half_cycles(series):
    """Wrong: every cycle counts in full."""
    ranges, means, counts = rainflow(series)
    return ranges, means, np.ceil(counts)


def range_counting(series):
    """Wrong: every range between neighbouring turning points is half a cycle."""
    points = np.array(turning_points(series), dtype=float)
    return np.abs(np.diff(points)), points[1:], np.full(max(len(points) - 1, 0), 0.5)


def without_residue(series):
    """Wrong: what no cycle closes is forgotten."""
    ranges, means, counts = rainflow(series)
    return ranges[counts == 1.0], means[counts == 1.0], counts[counts == 1.0]


def check_example(count):
    ranges, _, counts = count(SERIES)
    assert by_range(ranges, counts) == EXPECTED


def check_total_variation(count, series):
    ranges, _, counts = count(series)
    assert np.sum(ranges * counts) == pytest.approx(0.5 * np.sum(np.abs(np.diff(series))), rel=1e-12)


def check_largest_range(count, series):
    ranges, _, _ = count(series)
    assert ranges.max() == np.max(series) - np.min(series)


@pytest.fixture
def walk():
    return np.cumsum(np.random.default_rng(3).normal(size=5000))


def test_exported():
    assert owt_postproc.rainflow is rainflow


def test_standard_example():
    check_example(rainflow)


@pytest.mark.parametrize("wrong", [no_half_cycles, range_counting, without_residue])
def test_standard_example_would_notice(wrong):
    with pytest.raises(AssertionError):
        check_example(wrong)


def test_order_and_means():
    ranges, means, counts = rainflow(SERIES)
    assert ranges.tolist() == [3, 4, 4, 8, 9, 8, 6]
    assert means.tolist() == [-0.5, -1, 1, 1, 0.5, 0, 1]
    assert counts.tolist() == [0.5, 0.5, 1, 0.5, 0.5, 0.5, 0.5]


def test_sum_of_range_times_count_is_half_the_total_variation(walk):
    check_total_variation(rainflow, walk)


def test_total_variation_would_notice_full_counts(walk):
    with pytest.raises(AssertionError):
        check_total_variation(no_half_cycles, walk)


def test_largest_range_is_maximum_minus_minimum(walk):
    check_largest_range(rainflow, walk)


def test_largest_range_would_notice_a_lost_residue(walk):
    with pytest.raises(AssertionError):
        check_largest_range(without_residue, walk)


def test_time_reversal(walk):
    forward, backward = rainflow(walk), rainflow(walk[::-1])
    assert by_range(forward[0], forward[2]) == by_range(backward[0], backward[2])


@settings(max_examples=300, deadline=None)
@given(integers)
def test_equals_four_point_count_with_ties(series):
    ranges, _, counts = rainflow(series)
    assert by_range(ranges, counts) == four_point([float(x) for x in series])


@settings(max_examples=200, deadline=None)
@given(reals)
def test_equals_four_point_count(series):
    ranges, _, counts = rainflow(series)
    assert by_range(ranges, counts) == four_point(series)


@settings(max_examples=200, deadline=None)
@given(integers)
def test_identities_hold_for_any_series(series):
    ranges, _, counts = rainflow(series)
    assert np.sum(ranges * counts) == 0.5 * np.sum(np.abs(np.diff(series)))
    assert (ranges > 0).all()
    if len(set(series)) > 1:
        assert ranges.max() == max(series) - min(series)


@pytest.mark.parametrize("series", [[], [1.0], [2, 2, 2, 2], np.zeros(1000)])
def test_nothing_to_count(series):
    for part in rainflow(series):
        assert part.dtype == np.float64
        assert part.shape == (0,)


def test_monotonic_is_half_a_cycle():
    ranges, means, counts = rainflow(np.linspace(-1, 3, 50))
    assert (ranges.tolist(), means.tolist(), counts.tolist()) == ([4.0], [1.0], [0.5])


def test_plateaus_change_nothing(walk):
    flat = np.repeat(walk, np.random.default_rng(1).integers(1, 5, len(walk)))
    for a, b in zip(rainflow(walk), rainflow(flat), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite_is_refused(bad):
    with pytest.raises(InputError, match=r"series\[2\].*finite"):
        rainflow([0.0, 1.0, bad, 2.0])


@pytest.mark.parametrize("bad", [np.zeros((3, 2)), ["a", "b"], [1 + 2j, 0], 3.0, [[1], [2, 3]], None])
def test_not_a_real_series_is_refused(bad):
    with pytest.raises(InputError, match="series"):
        rainflow(bad)


def test_input_is_left_alone():
    series = np.array([0.0, 3.0, -1.0, 2.0])
    rainflow(series)
    assert series.tolist() == [0.0, 3.0, -1.0, 2.0]
