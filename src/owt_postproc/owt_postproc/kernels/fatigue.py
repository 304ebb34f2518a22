"""Stress of hot spots from the stress of member ends, counted and summed to damage, many channels at once."""

from __future__ import annotations

import numpy as np
from numba import njit

from owt_postproc.kernels.rainflow import close_residue, extract_cycles
from owt_postproc.kernels.turning import keep_turning

__all__ = ["close_block", "count_block"]

#: Samples worked on at a time: what one channel needs of them stays in cache.
SLICE = 512


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


@njit(cache=True, nogil=True, fastmath={"contract"})
def _sum_terms(stress, begin, length, row, factor, first, stop, signal):
    """Sum the terms from `first` to before `stop`, one at least, three in each pass over the signal."""
    at = slice(begin, begin + length)
    head = (stop - first - 1) % 3 + 1
    a, p = stress[row[first], at], factor[first]
    if head == 1:
        for i in range(length):
            signal[i] = p * a[i]
    elif head == 2:
        b, q = stress[row[first + 1], at], factor[first + 1]
        for i in range(length):
            signal[i] = p * a[i] + q * b[i]
    else:
        b, q = stress[row[first + 1], at], factor[first + 1]
        c, r = stress[row[first + 2], at], factor[first + 2]
        for i in range(length):
            signal[i] = p * a[i] + q * b[i] + r * c[i]
    for term in range(first + head, stop, 3):
        a, p = stress[row[term], at], factor[term]
        b, q = stress[row[term + 1], at], factor[term + 1]
        c, r = stress[row[term + 2], at], factor[term + 2]
        for i in range(length):
            signal[i] += p * a[i] + q * b[i] + r * c[i]


@njit(cache=True, nogil=True)
def count_block(
    stress, first, last_channel, start, row, factor, curve, lowest, bins_per_decade,
    stack, depth, last, totals, count, histogram,
):  # fmt: skip
    """Count one block of stress in the channels from `first` to before `last_channel`.

    Parameters
    ----------
    stress : float array [row, sample]
        Finite stress in Pa.
    first, last_channel : int
        Channels to count; the others are left alone.
    start : int array [channel + 1]
        The terms of channel c are start[c] to start[c + 1], one at least.
    row, factor : int array, float array [term]
        A channel is the sum of factor times row of `stress` over its terms, in their order.
    curve : float array [channel, 5]
        Knee stress in Pa; 1/a and m above it; 1/a and m below it.
    lowest, bins_per_decade : float
        Lower edge in Pa and number per decade of the histogram bins.
    stack : float array [channel, capacity]
        Residues. Changed in place, like all that follow.
    depth : int array [channel]
    last : float array [channel]
    totals : float array [channel, 3]
        Damage, sum of range x count in Pa, largest range in Pa.
    count : int array [channel]
        Half cycles.
    histogram : int array [channel, bin]
        Half cycles per range bin.

    Returns
    -------
    int
        Longest residue; if it exceeds the capacity the arrays hold rubbish and the block must be
        counted again, from the old state, with more.
    """
    n, capacity = stress.shape[1], stack.shape[1]
    room = capacity + SLICE + 2
    work, ranges, means = np.empty(room), np.empty(room), np.empty(room)
    halves = np.empty(room, dtype=np.int64)
    signal, kept = np.empty(SLICE), np.empty(SLICE)
    longest = 0
    for begin in range(0, n, SLICE):
        length = min(SLICE, n - begin)
        for c in range(first, last_channel):
            _sum_terms(stress, begin, length, row, factor, start[c], start[c + 1], signal)
            residue = stack[c]
            for j in range(depth[c]):
                work[j] = residue[j]
            turns = keep_turning(signal[:length], kept)
            new_depth, last[c], found = extract_cycles(
                kept[:turns], work, depth[c], last[c], ranges, means, halves
            )
            if new_depth > capacity:
                return new_depth
            longest = max(longest, new_depth)
            depth[c] = new_depth
            for j in range(new_depth):
                residue[j] = work[j]
            _book(
                ranges, halves, found, curve[c], lowest, bins_per_decade,
                totals[c], count[c : c + 1], histogram[c],
            )  # fmt: skip
    return longest


@njit(cache=True, nogil=True)
def close_block(
    first, last_channel, curve, lowest, bins_per_decade, stack, depth, last, totals, count, histogram
):
    """Book the residues as if the stress ended here; they stay, `totals`, `count` and `histogram` change.

    Arguments as in :func:`count_block`; a histogram without bins is left out.
    """
    capacity = stack.shape[1]
    work, ranges, means = np.empty(capacity + 2), np.empty(capacity + 2), np.empty(capacity + 2)
    halves = np.empty(capacity + 2, dtype=np.int64)
    for c in range(first, last_channel):
        found = close_residue(stack[c], depth[c], last[c], work, ranges, means, halves)
        _book(
            ranges, halves, found, curve[c], lowest, bins_per_decade,
            totals[c], count[c : c + 1], histogram[c],
        )  # fmt: skip


def warm_up() -> None:
    """Compile for the array types in use."""
    curve = np.ones((1, 5))
    stack, depth, last = np.zeros((1, 4)), np.zeros(1, dtype=np.int64), np.zeros(1)
    totals, count = np.zeros((1, 3)), np.zeros(1, dtype=np.int64)
    results = stack, depth, last, totals, count, np.zeros((1, 4), dtype=np.int32)
    start, row = np.array([0, 1]), np.array([0])
    count_block(np.zeros((1, 3)), 0, 1, start, row, np.ones(1), curve, 1.0, 1.0, *results)
    close_block(0, 1, curve, 1.0, 1.0, *results)
