"""Stress at points round the section, counted and summed to damage, many member ends at once."""

from __future__ import annotations

import numpy as np
from numba import njit

from owt_postproc.kernels.rainflow import close_residue, extract_cycles

__all__ = ["close_block", "count_block"]

#: Member ends gathered together, and samples worked on at a time: both only keep the data in cache.
TILE = 8
SLICE = 256


@njit(cache=True, nogil=True)
def _power(base, exponent):
    """``base ** exponent``, by products for the exponents of the common curves."""
    if exponent == 3.0:
        return base * base * base
    if exponent == 5.0:
        square = base * base
        return square * square * base
    return base**exponent


@njit(cache=True, nogil=True)
def _damage(stress_range, halves, curve):
    """Miner damage of one cycle; `curve` is knee stress in Pa, then 1/a and m of either slope, in Pa."""
    if stress_range >= curve[0]:
        return 0.5 * halves * _power(stress_range, curve[2]) * curve[1]
    return 0.5 * halves * _power(stress_range, curve[4]) * curve[3]


@njit(cache=True, nogil=True)
def _bin(stress_range, lowest, bins_per_decade, n_bins):
    """Logarithmic bin of a range; the first and last bin take what lies outside."""
    if stress_range < lowest:
        return 0
    return min(1 + int(np.log10(stress_range / lowest) * bins_per_decade), n_bins - 1)


@njit(cache=True, nogil=True)
def _book(ranges, halves, found, curve, lowest, bins_per_decade, totals, count, histogram):
    """Add cycles of one channel to its totals (damage, sum of range x count, largest range) and counts."""
    for j in range(found):
        totals[0] += _damage(ranges[j], halves[j], curve)
        totals[1] += 0.5 * halves[j] * ranges[j]
        totals[2] = max(totals[2], ranges[j])
        count[0] += halves[j]
        if histogram.size:
            histogram[_bin(ranges[j], lowest, bins_per_decade, histogram.size)] += halves[j]


@njit(cache=True, nogil=True)
def count_block(
    axial, bending_y, bending_z, von_mises, sine, cosine, factor, curve, lowest, bins_per_decade,
    stack, depth, last, totals, count, histogram,
):  # fmt: skip
    """Count one block of stress.

    Parameters
    ----------
    axial, bending_y, bending_z, von_mises : float arrays [sample, end]
        Finite stress in Pa.
    sine, cosine : float arrays [point]
        Of the angles round the section.
    factor : float
        Stress concentration factor on the normal stress.
    curve : float array [5]
        Knee stress in Pa; 1/a and m above it; 1/a and m below it.
    lowest, bins_per_decade : float
        Lower edge in Pa and number per decade of the histogram bins.
    stack : float array [end, channel, capacity]
        Residues; channels are the points, then von Mises. Changed in place, like all that follow.
    depth : int array [end, channel]
    last : float array [end, channel]
    totals : float array [end, channel, 3]
        Damage, sum of range x count in Pa, largest range in Pa.
    count : int array [end, channel]
        Half cycles.
    histogram : int array [end, channel, bin]
        Half cycles per range bin.

    Returns
    -------
    int
        Longest residue; if it exceeds the capacity the arrays hold rubbish and the block must be
        counted again, from the old state, with more.
    """
    n, ends = axial.shape
    points, capacity = sine.size, stack.shape[2]
    room = capacity + SLICE + 2
    work, ranges, means = np.empty(room), np.empty(room), np.empty(room)
    halves = np.empty(room, dtype=np.int64)
    tile = np.empty((4, TILE, SLICE))
    signal = np.empty(SLICE)
    longest = 0
    for first in range(0, ends, TILE):
        width = min(TILE, ends - first)
        for start in range(0, n, SLICE):
            length = min(SLICE, n - start)
            for i in range(length):
                for k in range(width):
                    tile[0, k, i] = axial[start + i, first + k]
                    tile[1, k, i] = bending_y[start + i, first + k]
                    tile[2, k, i] = bending_z[start + i, first + k]
                    tile[3, k, i] = von_mises[start + i, first + k]
            for k in range(width):
                e = first + k
                for p in range(points + 1):
                    if p < points:
                        for i in range(length):
                            signal[i] = factor * (
                                tile[0, k, i] + tile[1, k, i] * sine[p] + tile[2, k, i] * cosine[p]
                            )
                    else:
                        for i in range(length):
                            signal[i] = tile[3, k, i]
                    residue = stack[e, p]
                    for j in range(depth[e, p]):
                        work[j] = residue[j]
                    new_depth, last[e, p], found = extract_cycles(
                        signal[:length], work, depth[e, p], last[e, p], ranges, means, halves
                    )
                    if new_depth > capacity:
                        return new_depth
                    longest = max(longest, new_depth)
                    depth[e, p] = new_depth
                    for j in range(new_depth):
                        residue[j] = work[j]
                    _book(
                        ranges, halves, found, curve, lowest, bins_per_decade,
                        totals[e, p], count[e, p : p + 1], histogram[e, p],
                    )  # fmt: skip
    return longest


@njit(cache=True, nogil=True)
def close_block(curve, lowest, bins_per_decade, stack, depth, last, totals, count, histogram):
    """Book the residues as if the stress ended here; they stay, `totals`, `count` and `histogram` change.

    Arguments as in :func:`count_block`; a histogram without bins is left out.
    """
    ends, channels, capacity = stack.shape
    work, ranges, means = np.empty(capacity + 2), np.empty(capacity + 2), np.empty(capacity + 2)
    halves = np.empty(capacity + 2, dtype=np.int64)
    for e in range(ends):
        for p in range(channels):
            found = close_residue(stack[e, p], depth[e, p], last[e, p], work, ranges, means, halves)
            _book(
                ranges, halves, found, curve, lowest, bins_per_decade,
                totals[e, p], count[e, p : p + 1], histogram[e, p],
            )  # fmt: skip


def warm_up() -> None:
    """Compile for the array types in use."""
    block = np.zeros((3, 1))
    sine, curve = np.zeros(8), np.ones(5)
    stack, depth, last = np.zeros((1, 9, 4)), np.zeros((1, 9), dtype=np.int64), np.zeros((1, 9))
    totals, count = np.zeros((1, 9, 3)), np.zeros((1, 9), dtype=np.int64)
    histogram = np.zeros((1, 9, 4), dtype=np.int32)
    results = stack, depth, last, totals, count, histogram
    count_block(block, block, block, block, sine, sine, 1.0, curve, 1.0, 1.0, *results)
    close_block(curve, 1.0, 1.0, *results)
