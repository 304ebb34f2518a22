"""Rainflow counting of one series (ASTM E1049-85, section 5.4.4)."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_postproc.kernels import rainflow as kernel

__all__ = ["rainflow"]


def rainflow(
    series: Any,
) -> tuple[Float[np.ndarray, " cycle"], Float[np.ndarray, " cycle"], Float[np.ndarray, " cycle"]]:
    """Count the rainflow cycles of `series`, its two ends included as turning points.

    Parameters
    ----------
    series : array_like [n]
        Finite real numbers. Samples equal to their neighbour change nothing.

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

    Examples
    --------
    >>> ranges, means, counts = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> [(float(r), float(c)) for r, c in zip(ranges, counts)]
    [(3.0, 0.5), (4.0, 0.5), (4.0, 1.0), (8.0, 0.5), (9.0, 0.5), (8.0, 0.5), (6.0, 0.5)]
    """
    values = _as_series(series)
    room = values.size + 1
    stack, ranges, means = np.empty(room), np.empty(room), np.empty(room)
    halves = np.empty(room, dtype=np.int64)
    depth, last, closed = kernel.extract_cycles(values, stack, 0, 0.0, ranges, means, halves)
    tail = kernel.close_residue(
        stack, depth, last, np.empty(depth + 1), ranges[closed:], means[closed:], halves[closed:]
    )
    found = closed + tail
    return ranges[:found].copy(), means[:found].copy(), 0.5 * halves[:found]


def _as_series(series: Any) -> Float[np.ndarray, " n"]:
    remedy = "Give one series of finite real numbers."
    try:
        values = np.asarray(series)
        if values.dtype.kind not in "fiub" and values.size:
            raise TypeError
        values = values.astype(np.float64, order="C")
    except (TypeError, ValueError):
        raise InputError("series", series, "must hold real numbers", remedy) from None
    if values.ndim != 1:
        raise InputError("series", f"array of shape {values.shape}", "must be one-dimensional", remedy)
    if not np.isfinite(values).all():
        at = int(np.flatnonzero(~np.isfinite(values))[0])
        raise InputError(f"series[{at}]", float(values[at]), "must be finite", remedy)
    return values
