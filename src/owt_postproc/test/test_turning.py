"""Samples on a slope are left out before counting, and change nothing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from owt_postproc import rainflow
from owt_postproc.kernels.turning import keep_turning

RNG = np.random.default_rng(11)
SERIES = {
    "smooth": np.sin(0.05 * np.arange(900)) + 0.3 * np.sin(0.31 * np.arange(900) + 1.0),
    "noise": RNG.standard_normal(517),
    "plateaus": np.repeat(RNG.integers(-3, 4, 90), RNG.integers(1, 12, 90)).astype(float),
    "rising": np.arange(40.0),
    "constant": np.ones(33),
    "tiny": 1e-200 * RNG.standard_normal(64),
} | {f"length {n}": RNG.standard_normal(n) for n in (1, 2, 3, 8, 9, 10, 11, 17)}


def kept(series: np.ndarray) -> np.ndarray:
    out = np.empty(series.size)
    return out[: keep_turning(series, out)]


def wanted(series: np.ndarray, on_slope: Callable[[float, float, float], bool]) -> list[float]:
    inner = range(1, len(series) - 1)
    some = [i for i in inner if not on_slope(series[i - 1], series[i], series[i + 1])]
    return [series[i] for i in sorted({0, len(series) - 1, *some})]


@pytest.mark.parametrize("name", SERIES)
def test_only_slopes_are_left_out(name: str) -> None:
    series = SERIES[name]
    found = kept(series).tolist()
    assert found == wanted(series, lambda a, b, c: a < b < c or a > b > c)
    if name in ("plateaus", "constant"):  # a plateau is no slope
        assert found != wanted(series, lambda a, b, c: a <= b <= c or a >= b >= c)
    if name == "tiny":  # products of differences vanish where comparisons do not
        assert found != wanted(series, lambda a, b, c: not (b - a) * (c - b) < 0.0)


@pytest.mark.parametrize("name", SERIES)
def test_cycles_stay_the_same(name: str) -> None:
    series = SERIES[name]
    for ours, theirs in zip(rainflow(kept(series)), rainflow(series), strict=True):
        np.testing.assert_array_equal(ours, theirs)
