"""Gate, matrix and exceedance of counted cycles: nothing is lost without being said."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from owt_model.errors import InputError
from owt_postproc.core.cycles import exceedance, gate_cycles, range_mean_matrix
from owt_postproc.core.rainflow import rainflow

SERIES = [-2, 1, -3, 5, -1, 3, -4, 4, -2]  # ASTM E1049: 3 x 0.5, 4 x 1.5, 6 x 0.5, 8 x 1, 9 x 0.5
reals = st.lists(st.floats(-100, 100, allow_nan=False, width=32), max_size=60)


@pytest.fixture
def walk():
    return rainflow(np.random.default_rng(3).normal(size=5000).cumsum())


def test_gate_states_what_it_drops():
    kept, dropped = gate_cycles(rainflow(SERIES), 6.0, m=2.0)
    assert sorted(kept.ranges.tolist()) == [6, 8, 8, 9]
    assert dropped.cycles == 2.0
    assert dropped.cycle_share == pytest.approx(2.0 / 4.0)
    assert dropped.variation_share == pytest.approx(7.5 / 23.0)
    assert dropped.damage_share == pytest.approx(28.5 / (28.5 + 18 + 64 + 40.5))


def test_gate_of_zero_drops_nothing(walk):
    kept, dropped = gate_cycles(walk, 0.0)
    assert all(np.array_equal(a, b) for a, b in zip(kept, walk, strict=True))
    assert (dropped.cycles, dropped.cycle_share, dropped.damage_share) == (0.0, 0.0, 0.0)


@settings(max_examples=100, deadline=None)
@given(reals, st.floats(0, 50))
def test_kept_and_dropped_are_all(series, threshold):
    cycles = rainflow(series)
    kept, dropped = gate_cycles(cycles, threshold)
    assert kept.counts.sum() + dropped.cycles == cycles.counts.sum()
    assert (kept.ranges >= threshold).all()


def test_range_at_the_threshold_is_kept():
    assert gate_cycles(rainflow([0, 2, 0]), 2.0)[1].cycles == 0.0
    assert gate_cycles(rainflow([0, 2, 0]), 2.0 + 1e-9)[1].cycles == 1.0


@pytest.mark.parametrize(("threshold", "m"), [(-1.0, 3.0), (np.nan, 3.0), (1.0, 0.0), (1.0, np.inf)])
def test_impossible_gate_is_refused(threshold, m, walk):
    with pytest.raises(InputError, match=r"threshold|m = "):
        gate_cycles(walk, threshold, m=m)


@settings(max_examples=100, deadline=None)
@given(reals)
def test_matrix_holds_every_cycle(series):
    cycles = rainflow(series)
    assert range_mean_matrix(cycles, bins=7).count.sum() == cycles.counts.sum()
    edges = np.array([10.0, 20.0, 30.0])  # much lies outside
    outside = range_mean_matrix(cycles, range_edge=edges, mean_edge=edges)
    assert outside.count.sum() == cycles.counts.sum()


def test_matrix_of_the_standard_example():
    matrix = range_mean_matrix(
        rainflow(SERIES), range_edge=np.arange(0.0, 11.0), mean_edge=np.array([-1.0, 0.0, 1.0])
    )
    expected = np.zeros((10, 2))
    expected[3, 0], expected[4] = 0.5, (0.5, 1.0)  # an edge belongs to the bin above it, the last bin is open
    expected[6, 1], expected[8, 1], expected[9, 1] = 0.5, 1.0, 0.5
    np.testing.assert_array_equal(matrix.count, expected)


def test_matrix_would_notice_a_transposed_one(walk):
    edges = {"range_edge": np.linspace(0, 100, 11), "mean_edge": np.linspace(-80, 80, 11)}
    count = range_mean_matrix(walk, **edges).count
    by_range = np.histogram(np.clip(walk.ranges, 0, 99.9), edges["range_edge"], weights=walk.counts)[0]
    np.testing.assert_allclose(count.sum(axis=1), by_range)
    assert not np.allclose(count.sum(axis=0), by_range)


@pytest.mark.parametrize("edge", [[1.0], [1.0, 1.0], [2.0, 1.0], [0.0, np.inf]])
def test_impossible_edges_are_refused(edge, walk):
    with pytest.raises(InputError, match="range_edge"):
        range_mean_matrix(walk, range_edge=np.array(edge))


def test_exceedance_of_the_standard_example():
    ranges, cumulative = exceedance(rainflow(SERIES))
    assert ranges.tolist() == [9, 8, 6, 4, 3]
    assert cumulative.tolist() == [0.5, 1.5, 2.0, 3.5, 4.0]


def test_exceedance_ends_at_all_cycles(walk):
    ranges, cumulative = exceedance(walk)
    assert cumulative[-1] == walk.counts.sum()
    assert (np.diff(ranges) < 0).all()
    assert cumulative[100] == walk.counts[walk.ranges >= ranges[100]].sum()


def test_nothing_counted():
    nothing = rainflow([1.0, 1.0])
    assert [part.size for part in exceedance(nothing)] == [0, 0]
    assert range_mean_matrix(nothing).count.sum() == 0.0
    assert gate_cycles(nothing, 1.0)[1].cycle_share == 0.0
