"""Section forces at member ends to stress, with the fixed-end forces of the load between its samples."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["add_fixed_end", "end_stress", "warm_up"]


@njit(cache=True, nogil=True)
def add_fixed_end(force, fixed, column, substeps):
    """Add fixed-end forces, linear between their samples, to end forces.

    `force` is [1 + substeps (samples - 1), end, 6], its row 0 at the first sample of `fixed`
    [sample, element, 12]; `column` [end, 2] is the element in `fixed` (or -1) and the first of its six
    components.
    """
    samples, ends = fixed.shape[0], force.shape[1]
    for e in range(ends):
        source, first = column[e, 0], column[e, 1]
        if source < 0:
            continue
        for c in range(6):
            force[0, e, c] += fixed[0, source, first + c]
        row = 1
        for i in range(1, samples):
            for k in range(1, substeps + 1):
                part = k / substeps
                for c in range(6):
                    before = fixed[i - 1, source, first + c]
                    force[row, e, c] += before + part * (fixed[i, source, first + c] - before)
                row += 1


@njit(cache=True, nogil=True)
def end_stress(force, sign, section, axial, bending_y, bending_z, von_mises):
    """Stress from the forces [sample, end, 6] on the ends of elements [eq. 4.70-4.79].

    `sign` [end] is -1 at the first and +1 at the second node of the element; `section` [end, 4] holds
    1/A, r/I, r/J and the factor of the resultant shear force in eq. 4.77.
    """
    samples, ends = force.shape[0], force.shape[1]
    for i in range(samples):
        for e in range(ends):
            s = sign[e]
            per_area, per_modulus, per_torsion, per_shear = section[e]
            normal = s * force[i, e, 0] * per_area
            about_y, about_z = force[i, e, 4] * per_modulus, force[i, e, 5] * per_modulus
            axial[i, e] = normal
            bending_y[i, e] = s * about_y
            bending_z[i, e] = -s * about_z
            sigma = np.sqrt(about_y * about_y + about_z * about_z) + normal
            resultant = np.sqrt(force[i, e, 1] ** 2 + force[i, e, 2] ** 2)
            tau = abs(force[i, e, 3]) * per_torsion + resultant * per_shear
            von_mises[i, e] = np.sqrt(sigma * sigma + 3.0 * tau * tau)


def warm_up() -> None:
    """Compile for the array types that the package uses."""
    force, fixed = np.zeros((2, 1, 6)), np.zeros((2, 1, 12))
    add_fixed_end(force, fixed, np.zeros((1, 2), dtype=np.int64), 1)
    out = [np.zeros((2, 1)) for _ in range(4)]
    end_stress(force, np.ones(1), np.ones((1, 4)), out[0], out[1], out[2], out[3])
