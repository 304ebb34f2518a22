"""Counted cycles: small ones left out, sorted into a matrix, or accumulated to an exceedance curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["Cycles", "Dropped", "RangeMeanMatrix", "exceedance", "gate_cycles", "range_mean_matrix"]


class Cycles(NamedTuple):
    """Range and mean of each cycle in the unit of the series, and its count, 1.0 or 0.5."""

    ranges: Float[np.ndarray, " cycle"]
    means: Float[np.ndarray, " cycle"]
    counts: Float[np.ndarray, " cycle"]

    def joined(self, other: Cycles) -> Cycles:
        """Return these cycles and then those of `other`."""
        return Cycles(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))


@dataclass(frozen=True)
class Dropped:
    """What a gate left out.

    Attributes
    ----------
    threshold : float
        Smallest range that was kept.
    cycles : float
        Cycles left out.
    cycle_share, variation_share, damage_share : float
        Their share of all cycles, of the sum of range x count, and of the sum of range^m x count; 0 of none.
    m : float
        The exponent m of `damage_share`.
    """

    threshold: float
    cycles: float
    cycle_share: float
    variation_share: float
    damage_share: float
    m: float


@dataclass(frozen=True)
class RangeMeanMatrix:
    """Cycles per bin of range and mean; the sum of `count` is that of all cycles.

    Attributes
    ----------
    range_edge, mean_edge : float arrays [bin + 1]
        Edges in the unit of the series. A cycle on an edge belongs to the bin above it. The first and last
        bin of either take what lies outside the edges as well.
    count : float array [range bin, mean bin]
        Cycles.
    """

    range_edge: Float[np.ndarray, " range_edge"]
    mean_edge: Float[np.ndarray, " mean_edge"]
    count: Float[np.ndarray, "range_bin mean_bin"]


def gate_cycles(cycles: Cycles, threshold: float, *, m: float = 3.0) -> tuple[Cycles, Dropped]:
    """Leave out the cycles of a range below `threshold`, and say what they were.

    The gate works on counted cycles, not on the series: the larger cycles stay as they are.

    Parameters
    ----------
    cycles : Cycles
    threshold : float
        In the unit of the series.
    m : float
        Slope of the S-N curve for the share of damage.

    Raises
    ------
    InputError
        If the threshold is negative or not finite, or m not > 0.
    """
    if not (np.isfinite(threshold) and threshold >= 0.0):
        raise InputError("threshold", threshold, "must be finite and >= 0", "Use 0 to keep every cycle.")
    if not (np.isfinite(m) and m > 0.0):
        raise InputError("m", m, "must be finite and > 0", "Give the slope of the S-N curve.")
    ranges, _, counts = cycles
    small = ranges < threshold
    relative = ranges / ranges.max() if ranges.size else ranges

    def share(weight: Float[np.ndarray, " cycle"]) -> float:
        return float(weight[small].sum() / weight.sum()) if small.any() else 0.0

    dropped = Dropped(
        threshold=float(threshold),
        cycles=float(counts[small].sum()),
        cycle_share=share(counts),
        variation_share=share(relative * counts),
        damage_share=share(relative**m * counts),
        m=float(m),
    )
    return Cycles(*(part[~small] for part in cycles)), dropped


def range_mean_matrix(
    cycles: Cycles,
    *,
    range_edge: Float[np.ndarray, " range_edge"] | None = None,
    mean_edge: Float[np.ndarray, " mean_edge"] | None = None,
    bins: int = 64,
) -> RangeMeanMatrix:
    """Sort cycles by range and mean; none is lost.

    Parameters
    ----------
    cycles : Cycles
    range_edge, mean_edge : float arrays [edge], optional
        Rising edges of the bins. Without them `bins` bins of equal width reach from zero to the largest
        range, and from the lowest to the highest mean.
    bins : int
        Number of bins where no edges are given.

    Raises
    ------
    InputError
        If edges do not rise, are fewer than two or not finite, or bins < 1.
    """
    if bins < 1:
        raise InputError("bins", bins, "must be at least 1", "Give a number of bins.")
    ranges, means, counts = cycles
    if range_edge is None:
        range_edge = _equal_edges(0.0, ranges.max() if ranges.size else 1.0, bins)
    if mean_edge is None:
        lowest, highest = (means.min(), means.max()) if means.size else (0.0, 1.0)
        mean_edge = _equal_edges(lowest, highest, bins)
    count = np.zeros((len(range_edge) - 1, len(mean_edge) - 1))
    np.add.at(count, (_bin(ranges, range_edge, "range_edge"), _bin(means, mean_edge, "mean_edge")), counts)
    return RangeMeanMatrix(range_edge, mean_edge, count)


def exceedance(cycles: Cycles) -> tuple[Float[np.ndarray, " level"], Float[np.ndarray, " level"]]:
    """Cumulative counts over range.

    Returns
    -------
    ranges : float array [level]
        Distinct ranges, the largest first.
    cumulative : float array [level]
        Number of cycles of at least that range; the last one is the number of all cycles.
    """
    levels, index = np.unique(cycles.ranges, return_inverse=True)
    count = np.zeros(levels.size)
    np.add.at(count, index, cycles.counts)
    return levels[::-1].copy(), np.cumsum(count[::-1])


def _equal_edges(lowest: float, highest: float, bins: int) -> Float[np.ndarray, " edge"]:
    if not highest > lowest:
        lowest, highest = lowest - 0.5, lowest + 0.5
    return np.linspace(lowest, highest, bins + 1)


def _bin(values: Float[np.ndarray, " cycle"], edge: Float[np.ndarray, " edge"], name: str) -> np.ndarray:
    if len(edge) < 2 or not np.isfinite(edge).all() or not (np.diff(edge) > 0.0).all():
        raise InputError(name, edge, "must be two or more rising finite numbers", "Give edges of bins.")
    return np.clip(np.searchsorted(edge, values, side="right") - 1, 0, len(edge) - 2)
