"""Energies of oscillators, summed over the modes."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["modal_energies", "warm_up"]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def modal_energies(displacement, velocity, stiffness, potential, kinetic):
    """Potential x' K x / 2 and kinetic v' v / 2 of each row [row, mode] of the motion of unit masses."""
    rows, modes = displacement.shape
    for i in range(rows):
        x, v = displacement[i], velocity[i]
        strained, moving = 0.0, 0.0
        for j in range(modes):
            strained += stiffness[j] * x[j] * x[j]
            moving += v[j] * v[j]
        potential[i], kinetic[i] = 0.5 * strained, 0.5 * moving


def warm_up() -> None:
    """Compile for the array types that the package uses."""
    motion, out = np.zeros((1, 2)), np.zeros(1)
    modal_energies(motion, motion, np.ones(2), out, out.copy())
