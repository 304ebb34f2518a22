"""A Chebyshev series whose coefficients and argument both change with time."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["series", "warm_up"]


@njit(cache=True, nogil=True, fastmath={"contract"})
def series(coefficient, argument, out):
    """Fill out [quantity, time] with sum_j coefficient[j, quantity, time] T_j(argument[time])."""
    n = argument.size
    older, newer = np.ones(n), argument.copy()
    for c in range(out.shape[0]):
        for t in range(n):
            out[c, t] = coefficient[0, c, t]
    for j in range(1, coefficient.shape[0]):
        for c in range(out.shape[0]):
            row = coefficient[j, c]
            for t in range(n):
                out[c, t] += row[t] * newer[t]
        for t in range(n):
            following = 2.0 * argument[t] * newer[t] - older[t]
            older[t] = newer[t]
            newer[t] = following


def warm_up() -> None:
    """Compile the kernels."""
    series(np.ones((2, 4, 3)), np.zeros(3), np.empty((4, 3)))
