"""Newmark's average acceleration on uncoupled oscillators, many at once."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["average_acceleration", "warm_up"]


@njit(cache=True, nogil=True)
def average_acceleration(stiffness, damping, step, substeps, load, displacement, velocity, acceleration):
    """Integrate x'' + damping x' + stiffness x = load, the load linear between its samples [eq. F.3-F.10].

    `load` is [sample, mode]; the output arrays are [1 + substeps (samples - 1), mode] and hold the state at
    the first load sample in row 0. gamma = 1/2, beta = 1/4.
    """
    samples, modes = load.shape
    h, inverse = step, np.empty(modes)
    for j in range(modes):
        inverse[j] = 1.0 / (1.0 + 0.5 * h * damping[j] + 0.25 * h * h * stiffness[j])
    row = 0
    for i in range(1, samples):
        for k in range(1, substeps + 1):
            part = k / substeps
            for j in range(modes):
                force = load[i - 1, j] + part * (load[i, j] - load[i - 1, j])
                x, v, a = displacement[row, j], velocity[row, j], acceleration[row, j]
                v_free = v + 0.5 * h * a
                x_free = x + h * v + 0.25 * h * h * a
                new = (force - damping[j] * v_free - stiffness[j] * x_free) * inverse[j]
                displacement[row + 1, j] = x_free + 0.25 * h * h * new
                velocity[row + 1, j] = v_free + 0.5 * h * new
                acceleration[row + 1, j] = new
            row += 1


def warm_up() -> None:
    """Compile for the array types that the package uses."""
    one, load = np.ones(2), np.zeros((2, 2))
    out = [np.zeros((2, 2)) for _ in range(3)]
    average_acceleration(one, one, 0.1, 1, load, out[0], out[1], out[2])
