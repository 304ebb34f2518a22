"""Closed residue, streams, many channels, and what counting leaves unchanged, exactly."""

from __future__ import annotations

import os
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from owt_model.errors import InputError
from owt_postproc.core.cycles import Cycles
from owt_postproc.core.rainflow import RainflowStream, rainflow, rainflow_batch

SERIES = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
#: ASTM E1049-85, figure 7: the same series as a repeating history.
REPEATING = {9.0: 1.0, 7.0: 1.0, 4.0: 1.0, 3.0: 1.0}

integers = st.lists(st.integers(-5, 5), min_size=2, max_size=40)
reals = st.lists(st.floats(-100, 100, allow_nan=False, width=32), min_size=2, max_size=40)
cuts = st.lists(st.integers(0, 40), max_size=6)


def table(cycles, *, means: bool = True) -> dict[object, float]:
    """Count of each range and mean, however it is split into halves."""
    found: Counter[object] = Counter()
    for r, m, c in zip(*cycles, strict=True):
        found[(float(r), float(m)) if means else float(r)] += float(c)
    return dict(found)


def same(a: Cycles, b: Cycles) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def twice(series) -> dict[object, float]:
    """Independent closed count: four points over two periods from the largest peak, less those over one."""

    def four_point(points) -> Counter[object]:
        found: Counter[object] = Counter()
        stack: list[float] = []
        for x in points:
            if stack and x == stack[-1]:
                continue
            if len(stack) >= 2 and (stack[-1] - stack[-2]) * (x - stack[-1]) > 0:
                stack[-1] = x
            else:
                stack.append(x)
        points, stack = stack, []
        for x in points:
            stack.append(x)
            while len(stack) >= 4:
                a, b, c, d = stack[-4:]
                if abs(c - b) > min(abs(b - a), abs(d - c)):
                    break
                found[float(abs(c - b)), 0.5 * (b + c)] += 1.0
                del stack[-3:-1]
        return found

    values = [float(x) for x in series]
    once, again = four_point(values * 4), four_point(values * 5)
    return {key: again[key] - once[key] for key in again if again[key] > once[key]}


# Closed residue


def test_repeating_history_of_the_standard():
    cycles = rainflow(SERIES, closed=True)
    assert table(cycles, means=False) == REPEATING
    assert (cycles.counts == 1.0).all()
    assert table(rainflow(SERIES), means=False) != REPEATING  # the residue as half cycles is another count


@settings(max_examples=300, deadline=None)
@given(integers)
def test_closed_equals_another_period_of_a_long_record(series):
    assert table(rainflow(series, closed=True)) == twice(series)


@settings(max_examples=200, deadline=None)
@given(reals, st.integers(0, 40))
def test_closed_is_the_same_wherever_the_period_is_cut(series, at):
    at %= len(series)
    assert table(rainflow(series[at:] + series[:at], closed=True)) == table(rainflow(series, closed=True))


def test_half_cycles_are_not_the_same_wherever_the_period_is_cut():
    assert table(rainflow(SERIES[3:] + SERIES[:3])) != table(rainflow(SERIES))


@settings(max_examples=200, deadline=None)
@given(integers)
def test_closed_counts_full_cycles_of_the_whole_loop(series):
    ranges, _, counts = rainflow(series, closed=True)
    loop = [*series, series[0]]
    assert (counts == 1.0).all()
    assert np.sum(ranges) == 0.5 * np.sum(np.abs(np.diff(loop)))
    if len(set(series)) > 1:
        assert ranges.max() == max(series) - min(series)


@pytest.mark.parametrize("series", [[], [1.0], [3, 3, 3]])
def test_closed_count_of_nothing(series):
    assert all(part.shape == (0,) for part in rainflow(series, closed=True))


def test_monotonic_series_closes_to_one_cycle():
    assert table(rainflow([0, 1, 5], closed=True)) == {(5.0, 2.5): 1.0}


# What is invariant


@settings(max_examples=300, deadline=None)
@given(reals, st.booleans())
def test_time_reversal_keeps_the_count_of_every_range_and_mean(series, closed):
    forward, backward = rainflow(series, closed=closed), rainflow(series[::-1], closed=closed)
    assert table(forward) == table(backward)


def test_time_reversal_may_turn_a_full_cycle_into_two_halves():
    """What is not invariant: how a count is split, and the order."""
    assert rainflow([0, 1, 0, 2]).counts.tolist() == [0.5, 0.5, 0.5]
    assert rainflow([2, 0, 1, 0]).counts.tolist() == [1.0, 0.5]


@settings(max_examples=200, deadline=None)
@given(reals, st.booleans())
def test_negation_negates_the_means(series, closed):
    cycles, mirrored = rainflow(series, closed=closed), rainflow([-x for x in series], closed=closed)
    assert table(cycles) == {(r, -m): c for (r, m), c in table(mirrored).items()}  # type: ignore[misc]


# Streams


def pieces(series, at) -> list[list[float]]:
    edges = [0, *sorted(min(i, len(series)) for i in at), len(series)]
    return [list(series[a:b]) for a, b in pairwise(edges)]


def streamed(parts, *, closed: bool) -> Cycles:
    stream = RainflowStream(closed=closed)
    found = [stream.push(np.asarray(part, dtype=float)) for part in parts]
    return Cycles(*map(np.concatenate, zip(*found, stream.finish(), strict=True)))


def forgetful(parts, *, closed: bool) -> Cycles:
    """Wrong: every block is counted by itself."""
    found = [rainflow(np.asarray(part, dtype=float), closed=closed) for part in parts]
    return Cycles(*map(np.concatenate, zip(*found, strict=True)))


@settings(max_examples=300, deadline=None)
@given(reals, cuts, st.booleans())
def test_any_split_gives_the_same_cycles_in_the_same_order(series, at, closed):
    assert same(streamed(pieces(series, at), closed=closed), rainflow(series, closed=closed))


def test_splitting_would_notice_a_lost_residue():
    assert not same(forgetful(pieces(SERIES, [4]), closed=False), rainflow(SERIES))


def test_finishing_changes_nothing():
    stream = RainflowStream()
    first = stream.push(SERIES[:5])
    assert same(stream.finish(), stream.finish())
    rest = stream.push(SERIES[5:])
    whole = Cycles(*map(np.concatenate, zip(first, rest, stream.finish(), strict=True)))
    assert same(whole, rainflow(SERIES))


def test_memory_of_a_stream_does_not_grow():
    """A stationary record of a million samples leaves some tens of turning points."""
    rng, stream, longest = np.random.default_rng(5), RainflowStream(), 0
    for _ in range(100):
        stream.push(rng.standard_normal(10_000))
        longest = max(longest, stream.residue.size)
    assert stream.samples == 1_000_000
    assert longest < 64


def test_refused_block_leaves_the_stream_as_it_was():
    stream = RainflowStream()
    found = [stream.push(SERIES[:4])]
    with pytest.raises(InputError, match=r"series\[1\] = nan"):
        stream.push([1.0, np.nan])
    found += [stream.push(SERIES[4:]), stream.finish()]
    assert same(Cycles(*map(np.concatenate, zip(*found, strict=True))), rainflow(SERIES))


# Many channels


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("threads", ["1", "3"])
def test_batch_is_each_channel_whatever_the_threads(closed, threads, monkeypatch):
    monkeypatch.setitem(os.environ, "OWT_THREADS", threads)
    series = np.random.default_rng(4).standard_normal((700, 50)).cumsum(axis=0)
    for column, cycles in zip(series.T, rainflow_batch(series, closed=closed), strict=True):
        assert same(cycles, rainflow(column, closed=closed))


def test_batch_of_nothing():
    assert rainflow_batch(np.zeros((10, 0))) == []
    assert [part.size for cycles in rainflow_batch(np.zeros((0, 2))) for part in cycles] == [0] * 6


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_batch_names_channel_and_sample(bad):
    series = np.zeros((30, 40))
    series[7, 33] = series[3, 35] = bad
    with pytest.raises(InputError, match=r"series, channel 33, sample 7 = (nan|inf): must be finite"):
        rainflow_batch(series)


@pytest.mark.parametrize("bad", [np.zeros(3), np.zeros((2, 2, 2)), [["a"]], None])
def test_batch_of_another_shape_is_refused(bad):
    with pytest.raises(InputError, match="series"):
        rainflow_batch(bad)
