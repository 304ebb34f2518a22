"""Rainflow counting (ASTM E1049-85, 5.4.4 and 5.4.5) of one series, of many, of one that comes in blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_model.parallel import map_threads, slices
from owt_postproc.core.cycles import Cycles
from owt_postproc.kernels import rainflow as kernel

__all__ = ["RainflowStream", "rainflow", "rainflow_batch"]

REMEDY = "Give one series of finite real numbers."
#: Channels that are copied together, so that their samples are read from memory once.
GROUP = 16


def rainflow(series: Any, *, closed: bool = False) -> Cycles:
    """Count the rainflow cycles of `series`, its two ends included as turning points.

    Parameters
    ----------
    series : array_like [n]
        Finite real numbers. Samples equal to their neighbour change nothing.
    closed : bool
        Whether the record repeats for ever, so that its residue closes to full cycles.

    Returns
    -------
    ranges, means, counts : float arrays [cycle]
        Range (maximum minus minimum) and mean of each cycle in the unit of `series`; count 1.0, or 0.5 for
        half a cycle. The cycles stand in the order in which they close while the series is read; the half
        cycles that are left at its end follow from the oldest to the newest. All three are empty for
        a constant series and for fewer than two samples.

    Raises
    ------
    InputError
        If `series` is not one-dimensional, not real, or holds NaN or inf.

    Notes
    -----
    ASTM E1049-85 (2017), section 5.4.4; the four-point method with its residue taken as half cycles
    gives the same counts. The sum of range x count equals half the total variation of the series.

    With `closed` the counts are those of section 5.4.5 for repeating histories, where the record is read
    from its largest peak round to the same peak: full cycles only, the same wherever the period is cut. The
    way from the last sample back to the first is part of the total variation then.

    Examples
    --------
    >>> ranges, means, counts = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> [(float(r), float(c)) for r, c in zip(ranges, counts)]
    [(3.0, 0.5), (4.0, 0.5), (4.0, 1.0), (8.0, 0.5), (9.0, 0.5), (8.0, 0.5), (6.0, 0.5)]
    >>> rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2], closed=True).ranges.tolist()
    [4.0, 3.0, 7.0, 9.0]
    """
    stream = RainflowStream(closed=closed)
    first = stream.push(series)
    return first.joined(stream.finish())


def rainflow_batch(series: Any, *, closed: bool = False) -> list[Cycles]:
    """Count many series of the same length, on several threads.

    Parameters
    ----------
    series : array_like [sample, channel]
        Finite real numbers.
    closed : bool
        As of :func:`rainflow`.

    Returns
    -------
    list of Cycles [channel]
        What :func:`rainflow` gives for each column, whatever the number of threads.

    Raises
    ------
    InputError
        If `series` is not two-dimensional, not real, or holds NaN or inf, naming channel and sample.
    """
    values = _real(series)
    if values.ndim != 2:
        raise InputError(
            "series", f"array of shape {values.shape}", "must be [sample, channel]", "Give columns."
        )

    def count(channels: slice) -> list[Cycles]:
        rows = np.ascontiguousarray(values[:, channels].T, dtype=np.float64)
        found = []
        for i, row in enumerate(rows):
            _check_finite(row, channels.start + i)
            stream = RainflowStream(closed=closed)
            first = stream._push(row)
            found.append(first.joined(stream.finish()))
        return found

    return [cycles for part in map_threads(count, slices(values.shape[1], GROUP)) for cycles in part]


class RainflowStream:
    """Counts a series that comes in blocks; keeps the residue only, so that memory does not grow with time.

    The cycles of all pushes followed by those of :meth:`finish` are those of :func:`rainflow` on the whole
    series, wherever it was cut.

    Parameters
    ----------
    closed : bool
        As of :func:`rainflow`.

    Examples
    --------
    >>> stream = RainflowStream()
    >>> found = [stream.push([-2, 1, -3, 5]), stream.push([-1, 3, -4, 4, -2]), stream.finish()]
    >>> [float(r) for cycles in found for r in cycles.ranges]
    [3.0, 4.0, 4.0, 8.0, 9.0, 8.0, 6.0]
    """

    def __init__(self, *, closed: bool = False) -> None:
        self._closed = closed
        self._stack = np.empty(0)
        self._last = 0.0
        self.samples = 0

    @property
    def residue(self) -> Float[np.ndarray, " point"]:
        """Turning points that no closed cycle has taken, the last sample included."""
        if not self._stack.size or self._last == self._stack[-1]:
            return self._stack.copy()
        return np.append(self._stack, self._last)

    def push(self, block: Any) -> Cycles:
        """Count the next samples; return the cycles that they close.

        Raises
        ------
        InputError
            If `block` is not one-dimensional, not real, or holds NaN or inf; nothing is counted then.
        """
        values = _real(block).astype(np.float64, order="C")
        if values.ndim != 1:
            raise InputError("series", f"array of shape {values.shape}", "must be one-dimensional", REMEDY)
        _check_finite(values)
        return self._push(values)

    def _push(self, values: Float[np.ndarray, " n"]) -> Cycles:
        kept = self._stack.size
        room = kept + values.size + 2
        stack, ranges, means = np.empty(room), np.empty(room), np.empty(room)
        halves = np.empty(room, dtype=np.int64)
        stack[:kept] = self._stack
        depth, self._last, found = kernel.extract_cycles(
            values, stack, kept, self._last, ranges, means, halves, self._closed
        )
        self._stack = stack[:depth].copy()
        self.samples += values.size
        return _cycles(ranges, means, halves, found)

    def finish(self) -> Cycles:
        """Return the cycles of the residue if the series ended here; the stream may go on all the same."""
        room = self._stack.size + 3
        ranges, means, halves = np.empty(room), np.empty(room), np.empty(room, dtype=np.int64)
        if self._closed:
            found = kernel.close_loop(self._stack, self._stack.size, self._last, ranges, means, halves)
        else:
            found = kernel.close_residue(
                self._stack, self._stack.size, self._last, np.empty(room), ranges, means, halves
            )
        return _cycles(ranges, means, halves, found)


def _cycles(ranges: Any, means: Any, halves: Any, found: int) -> Cycles:
    return Cycles(ranges[:found].copy(), means[:found].copy(), 0.5 * halves[:found])


def _real(series: Any) -> np.ndarray:
    try:
        values = np.asarray(series)
        if values.dtype.kind not in "fiub" and values.size:
            raise TypeError
    except (TypeError, ValueError):
        raise InputError("series", series, "must hold real numbers", REMEDY) from None
    return values if values.dtype.kind in "fiub" else values.astype(np.float64)


def _check_finite(values: Float[np.ndarray, " n"], channel: int | None = None) -> None:
    if not np.isfinite(values).all():
        at = int(np.flatnonzero(~np.isfinite(values))[0])
        where = f"series[{at}]" if channel is None else f"series, channel {channel}, sample {at}"
        raise InputError(where, float(values[at]), "must be finite", REMEDY)
