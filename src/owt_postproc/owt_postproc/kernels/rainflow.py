"""Rainflow counting of one channel (ASTM E1049-85, section 5.4.4), sample by sample.

The state of a channel is the *residue*, the turning points that no closed cycle has taken yet, and the
last sample, which becomes a turning point once the signal turns. A channel without samples has an
empty residue. Nothing else is remembered, so cutting the signal into pieces changes no cycle.

Where the record repeats for ever, no range holds its first point: nothing is half a cycle, the first turning
points stay in the residue as well (four-point rule), and at the end it is closed to a loop.
"""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["close_loop", "close_residue", "extract_cycles"]


@njit(cache=True, nogil=True)
def _push(stack, depth, value, ranges, means, halves, found, repeats):
    """Append a turning point and take out every cycle that it closes; returns (depth, found)."""
    stack[depth] = value
    depth += 1
    while depth >= 3:
        inner = abs(stack[depth - 2] - stack[depth - 3])
        if abs(stack[depth - 1] - stack[depth - 2]) < inner:
            break
        if repeats and (depth == 3 or abs(stack[depth - 3] - stack[depth - 4]) < inner):
            break
        ranges[found] = inner
        means[found] = 0.5 * (stack[depth - 2] + stack[depth - 3])
        if depth == 3:  # the range holds the first point: half a cycle, and the next point is first
            halves[found] = 1
            stack[0] = stack[1]
            stack[1] = stack[2]
            depth = 2
        else:
            halves[found] = 2
            stack[depth - 3] = stack[depth - 1]
            depth -= 2
        found += 1
    return depth, found


@njit(cache=True, nogil=True)
def extract_cycles(signal, stack, depth, last, ranges, means, halves, repeats=False):
    """Count the samples of `signal` on top of a residue.

    Parameters
    ----------
    signal : float array [n]
        Finite samples.
    stack : float array [>= depth + n + 1]
        The residue in its first `depth` places; changed in place.
    depth, last : int, float
        Length of the residue and last sample so far; `last` has no meaning where `depth` is 0.
    ranges, means : float arrays [>= depth + n + 1]
        Receive the cycles closed, in the order in which they close.
    halves : int array [>= depth + n + 1]
        Receives 2 for a full cycle, 1 for half a cycle.
    repeats : bool
        Whether the record repeats for ever: full cycles only.

    Returns
    -------
    depth, last, found : int, float, int
        The new state and the number of cycles found.
    """
    found = 0
    first = 0
    n = signal.size
    if depth == 0:
        if n == 0:
            return 0, last, 0
        stack[0] = signal[0]
        last = signal[0]
        depth = 1
        first = 1
    point = stack[depth - 1]  # the signal has gone from here to `last` without a turn
    for i in range(first, n):
        value = signal[i]
        if ((last > point) & (value < last)) | ((last < point) & (value > last)):
            # As _push, which costs four times as much here: a call for every turning point.
            stack[depth] = last
            depth += 1
            outer = abs(last - point)
            while depth >= 3:
                inner = abs(stack[depth - 2] - stack[depth - 3])
                if outer < inner:
                    break
                if repeats and (depth == 3 or abs(stack[depth - 3] - stack[depth - 4]) < inner):
                    break
                ranges[found] = inner
                means[found] = 0.5 * (stack[depth - 2] + stack[depth - 3])
                if depth == 3:
                    halves[found] = 1
                    stack[0] = stack[1]
                    stack[1] = last
                    depth = 2
                else:
                    halves[found] = 2
                    stack[depth - 3] = last
                    depth -= 2
                    outer = abs(last - stack[depth - 2])
                found += 1
            point = last
        last = value
    return depth, last, found


@njit(cache=True, nogil=True)
def close_residue(residue, depth, last, stack, ranges, means, halves):
    """Cycles that remain if the signal ended here: those that its last sample closes, then half cycles.

    `residue` is left as it is; `stack` (length >= depth + 1) is work space. Returns the number found.
    """
    if depth == 0:
        return 0
    for i in range(depth):
        stack[i] = residue[i]
    found = 0
    if last != stack[depth - 1]:
        depth, found = _push(stack, depth, last, ranges, means, halves, found, False)
    for i in range(1, depth):
        ranges[found] = abs(stack[i] - stack[i - 1])
        means[found] = 0.5 * (stack[i] + stack[i - 1])
        halves[found] = 1
        found += 1
    return found


@njit(cache=True, nogil=True)
def close_loop(residue, depth, last, ranges, means, halves):
    """Cycles of a residue whose record repeats for ever: those of one loop from its largest peak back to it.

    `ranges`, `means` and `halves` (length >= depth + 3) receive full cycles. Returns the number found.
    """
    if depth == 0:
        return 0
    n = depth if last == residue[depth - 1] else depth + 1
    loop, stack = np.empty(n + 1), np.empty(n + 3)
    top = 0
    for i in range(n):
        stack[i] = residue[i] if i < depth else last
        if stack[i] > stack[top]:
            top = i
    for i in range(n + 1):
        loop[i] = stack[(top + i) % n]
    depth, last, found = extract_cycles(loop, stack, 0, 0.0, ranges, means, halves)
    found += close_residue(
        stack, depth, last, np.empty(depth + 1), ranges[found:], means[found:], halves[found:]
    )
    # Half cycles here are the ways from the largest peak to a valley and back, one after the other.
    kept, is_way_back = 0, False
    for j in range(found):
        if halves[j] == 1:
            is_way_back = not is_way_back
            if is_way_back:
                continue
        ranges[kept], means[kept], halves[kept] = ranges[j], means[j], 2
        kept += 1
    return kept


def warm_up() -> None:
    """Compile for the array types in use."""
    series = np.array([0.0, 1.0, 0.0, 2.0])
    stack, ranges, means = np.zeros(8), np.zeros(8), np.zeros(8)
    halves = np.zeros(8, dtype=np.int64)
    depth, last, _ = extract_cycles(series, stack, 0, 0.0, ranges, means, halves)
    close_residue(stack, depth, last, np.zeros(8), ranges, means, halves)
    depth, last, _ = extract_cycles(series, stack, 0, 0.0, ranges, means, halves, True)
    close_loop(stack, depth, last, ranges, means, halves)
