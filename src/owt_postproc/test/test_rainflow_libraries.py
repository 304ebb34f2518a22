"""Counts against the rainflow and fatpack libraries, and where their conventions differ.

rainflow (three points, ASTM E1049): equal cycle by cycle. It counts half a cycle of range 0 for a constant
series, nothing for a series of two samples, and takes NaN as no turning point; ours counts nothing, half
a cycle, and refuses NaN.

fatpack (four points): sorts samples into classes first: ranges are multiples of the class width. On a series
whose values are the centres of its classes it counts exactly. Its residue is closed by repetition, as ours
with ``closed=True`` is. Where the record ends in one direction and starts in the other, version 0.7.8 joins
the two by leaving out the extreme and keeping the point on the way, and so loses the largest range of
[2, 0, 3]. It refuses constant and monotonic series with an IndexError or ValueError.
"""

from __future__ import annotations

from collections import Counter

import fatpack
import numpy as np
import pytest
import rainflow as library

from owt_model.errors import InputError
from owt_postproc.core.rainflow import rainflow

CLASSES = 32


def by_range(ranges, counts) -> dict[float, float]:
    table: Counter[float] = Counter()
    for r, c in zip(ranges, counts, strict=True):
        table[round(float(r), 9)] += float(c)
    return dict(table)


def of_library(series) -> list[tuple[float, float, float]]:
    return [(r, m, c) for r, m, c, _, _ in library.extract_cycles([float(x) for x in series])]


def random(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(3000).cumsum()


def falling(series: np.ndarray) -> np.ndarray:
    """The same with ends that fatpack can join."""
    return np.concatenate([[series[0] + 1.0], series, [series[-1] + 1.0, series[-1]]])


def plateaus(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.repeat(rng.integers(-4, 5, 400), rng.integers(1, 6, 400)).astype(float)


SAME = {
    "random": random(1),
    "noise": np.random.default_rng(2).standard_normal(3000),
    "plateaus": plateaus(3),
    "monotonic": np.linspace(-1.0, 4.0, 50),
    "plateau at the start and the end": np.array([1.0, 1.0, 3.0, 0.0, 2.0, 2.0]),
}


@pytest.mark.parametrize("name", list(SAME))
def test_equals_the_rainflow_library_cycle_by_cycle(name):
    ours = [tuple(map(float, row)) for row in zip(*rainflow(SAME[name]), strict=True)]
    assert ours == of_library(SAME[name])


def test_comparison_would_notice_another_rule():
    closed = [tuple(map(float, row)) for row in zip(*rainflow(SAME["random"], closed=True), strict=True)]
    assert closed != of_library(SAME["random"])


def test_where_the_rainflow_library_differs():
    assert of_library([2, 2, 2]) == [(0.0, 2.0, 0.5)]
    assert rainflow([2, 2, 2]).ranges.size == 0
    assert of_library([0, 1]) == []
    assert rainflow([0, 1]).ranges.tolist() == [1.0]
    with_nan = [0.0, 1.0, float("nan"), 2.0, 0.0]
    assert of_library(with_nan) == [(0.0, 0.0, 0.5)]  # the cycle of range 2 is lost
    with pytest.raises(InputError, match=r"series\[2\] = nan"):
        rainflow(with_nan)


def in_classes(seed: int) -> np.ndarray:
    """Integers 0 .. CLASSES, the ends included: fatpack's classes of width 1 are centred on them."""
    rng = np.random.default_rng(seed)
    steps = rng.integers(-6, 7, 4000).cumsum()
    series = np.abs((steps + CLASSES) % (2 * CLASSES) - CLASSES).astype(float)  # reflected at both ends
    return np.concatenate([[5.0, 0.0, CLASSES], series, [CLASSES, 3.0]])  # starts and ends falling


@pytest.mark.parametrize("seed", range(5))
def test_equals_fatpack_on_the_centres_of_its_classes(seed):
    series = in_classes(seed)
    theirs = fatpack.find_rainflow_ranges(series, k=CLASSES)
    ours = rainflow(series, closed=True)
    assert by_range(theirs, np.ones(len(theirs))) == by_range(ours.ranges, ours.counts)
    halves = rainflow(series)
    assert by_range(theirs, np.ones(len(theirs))) != by_range(halves.ranges, halves.counts)


def test_residue_of_fatpack_as_half_cycles():
    series = in_classes(7)
    reversals, _ = fatpack.find_reversals(series, k=CLASSES)
    cycles, residue = fatpack.find_rainflow_cycles(reversals)
    ranges = np.concatenate([np.abs(np.diff(cycles, axis=1))[:, 0], np.abs(np.diff(residue))])
    counts = np.concatenate([np.ones(len(cycles)), np.full(len(residue) - 1, 0.5)])
    ours = rainflow(series)
    assert by_range(ranges, counts) == by_range(ours.ranges, ours.counts)


@pytest.mark.parametrize("k", [64, 65536])
def test_fatpack_on_any_series_is_off_by_its_classes_only(k):
    """Classes move both ends of a range by up to half a width."""
    series = falling(random(8))
    theirs = np.sort(fatpack.find_rainflow_ranges(series, k=k))
    ours = rainflow(series, closed=True)
    width = np.ptp(series) / k
    assert abs(theirs.max() - ours.ranges.max()) <= width
    # a range is off by a width at most, and sum r^3 by 3 width sum r^2; ranges within a class are lost
    bound = 3.0 * width * np.sum(ours.ranges**2) / np.sum(ours.ranges**3)
    assert np.sum(theirs**3) / np.sum(ours.ranges**3) == pytest.approx(1.0, abs=bound)
    assert bound < 30.0 / k


def test_fatpack_loses_an_extreme_where_ends_turn():
    record = np.array([2.0, 0.0, 3.0])
    assert fatpack.concatenate_reversals(record, record).tolist() == [2, 0, 2, 0, 3]  # 3, the peak, is gone
    assert rainflow(record, closed=True).ranges.tolist() == [3.0]


def test_fatpack_refuses_what_has_no_cycle():
    for series in (np.ones(5), np.linspace(0.0, 1.0, 9)):
        with pytest.raises((IndexError, ValueError)):
            fatpack.find_rainflow_ranges(series)
