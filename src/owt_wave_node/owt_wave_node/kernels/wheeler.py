"""First-order kinematics at a level that moves with the surface (Wheeler stretching), by direct sum."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["stretched", "warm_up"]

#: k d above which the image below the sea bed is below round-off.
DEEP = 40.0


@njit(cache=True, nogil=True)
def stretched(x, level, omega, k, amplitude, depth, gravity, start, dt, out):
    """Fill out [point, 4, time] with u, w, du/dt, dw/dt [eq. 4.8-4.11] at level [point, time] in m.

    `level` is the stretched coordinate z' of eq. 2.18; above still water (z' > 0, a point above the
    surface) the profile continues along its tangent. Times are (start + i) dt.
    """
    n = level.shape[1]
    c, s = np.empty((k.size, n)), np.empty((k.size, n))
    for m in range(k.size):
        for t in range(n):
            angle = omega[m] * ((start + t) * dt)
            c[m, t], s[m, t] = math.cos(angle), math.sin(angle)
    for p in range(x.size):
        out[p] = 0.0
        for m in range(k.size):
            phase = complex(math.cos(k[m] * x[p]), -math.sin(k[m] * x[p]))
            speed = gravity * k[m] / omega[m] * amplitude[m] * phase
            scale = 1.0 / (1.0 + math.exp(-2.0 * k[m] * depth))
            tanh = math.tanh(k[m] * depth)
            for t in range(n):
                z = min(level[p, t], 0.0)
                up = math.exp(k[m] * z)
                down = math.exp(-k[m] * (z + 2.0 * depth)) if k[m] * (z + depth) < DEEP else 0.0
                above = k[m] * max(level[p, t], 0.0)
                horizontal = (up + down) * scale + above * tanh
                vertical = (up - down) * scale + above
                real = speed.real * c[m, t] - speed.imag * s[m, t]
                imaginary = speed.real * s[m, t] + speed.imag * c[m, t]
                out[p, 0, t] += horizontal * real
                out[p, 1, t] -= vertical * imaginary
                out[p, 2, t] -= omega[m] * horizontal * imaginary
                out[p, 3, t] -= omega[m] * vertical * real


def warm_up() -> None:
    """Compile the kernels."""
    one = np.ones(1)
    stretched(one, np.ones((1, 2)), one, one, one.astype(complex), 50.0, 9.81, 0, 0.1, np.empty((1, 4, 2)))
