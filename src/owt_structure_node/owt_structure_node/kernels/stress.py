"""Section forces at member ends to stress, with the fixed-end forces of the load between its samples."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["end_stress", "end_stress_rows", "warm_up"]


@njit(cache=True, nogil=True, fastmath={"contract"})
def end_stress(force, fixed, substeps, sign, section, axial, bending_y, bending_z, von_mises):
    """Stress from the forces on the ends of elements [eq. 4.70-4.79].

    `force` [1 + substeps (samples - 1), 6, end] lacks the fixed-end forces `fixed` [sample, 6, end], linear
    between their samples. `sign` [end] is -1 at the first and +1 at the second node of the element;
    `section` [4, end] holds 1/A, r/I, r/J and the factor of the resultant shear force in eq. 4.77.
    """
    rows, ends = force.shape[0], force.shape[2]
    for i in range(rows):
        interval = max(i - 1, 0) // substeps
        part = (i - interval * substeps) / substeps
        f, before = force[i], fixed[interval]
        after = fixed[min(interval + 1, len(fixed) - 1)]
        n_out, y_out, z_out, out = axial[i], bending_y[i], bending_z[i], von_mises[i]
        for e in range(ends):
            n = f[0, e] + before[0, e] + part * (after[0, e] - before[0, e])
            v_y = f[1, e] + before[1, e] + part * (after[1, e] - before[1, e])
            v_z = f[2, e] + before[2, e] + part * (after[2, e] - before[2, e])
            m_x = f[3, e] + before[3, e] + part * (after[3, e] - before[3, e])
            m_y = f[4, e] + before[4, e] + part * (after[4, e] - before[4, e])
            m_z = f[5, e] + before[5, e] + part * (after[5, e] - before[5, e])
            normal = sign[e] * n * section[0, e]
            about_y, about_z = m_y * section[1, e], m_z * section[1, e]
            sigma = np.sqrt(about_y * about_y + about_z * about_z) + normal
            tau = abs(m_x) * section[2, e] + np.sqrt(v_y * v_y + v_z * v_z) * section[3, e]
            n_out[e] = normal
            y_out[e] = sign[e] * about_y
            z_out[e] = -sign[e] * about_z
            out[e] = np.sqrt(sigma * sigma + 3.0 * tau * tau)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _less_carried(force, carried, part, out):
    """Take off the carried load between its samples; `part` are the shares of an interval passed."""
    substeps, row = part.size, 0
    if substeps == 5:  # the usual ratio of the steps, unrolled: a third faster
        p, q, r, s = part[0], part[1], part[2], part[3]
        for i in range(carried.size - 1):
            before, rise = carried[i], carried[i + 1] - carried[i]
            out[row] = force[row] - (before + p * rise)
            out[row + 1] = force[row + 1] - (before + q * rise)
            out[row + 2] = force[row + 2] - (before + r * rise)
            out[row + 3] = force[row + 3] - (before + s * rise)
            out[row + 4] = force[row + 4] - carried[i + 1]
            row += 5
        return
    for i in range(carried.size - 1):
        before, rise = carried[i], carried[i + 1] - carried[i]
        for k in range(substeps):
            out[row] = force[row] - (before + part[k] * rise)
            row += 1


@njit(cache=True, nogil=True, fastmath={"contract"})
def end_stress_rows(
    force, carried, lead, substeps, sign, section, work, axial, bending_y, bending_z, von_mises
):
    """The same with time last: `force` [6 end, row], the results [end, row].

    `carried` [6 end, sample] are equivalent nodal loads, minus the fixed-end forces. The first `lead` rows
    (0 or 1) are at the first sample, the others follow it, `substeps` per interval. `work` is [6, row].
    """
    rows = force.shape[1]
    part = np.empty(substeps)
    for k in range(substeps):
        part[k] = (k + 1) / substeps
    for e in range(sign.size):
        for c in range(6):
            if lead:
                work[c, 0] = force[6 * e + c, 0] - carried[6 * e + c, 0]
            _less_carried(force[6 * e + c, lead:], carried[6 * e + c], part, work[c, lead:])
        per_area, per_inertia, per_torsion, shear = section[0, e], section[1, e], section[2, e], section[3, e]
        s = sign[e]
        n_out, y_out, z_out, out = axial[e], bending_y[e], bending_z[e], von_mises[e]
        for i in range(rows):
            normal = s * work[0, i] * per_area
            about_y, about_z = work[4, i] * per_inertia, work[5, i] * per_inertia
            sigma = np.sqrt(about_y * about_y + about_z * about_z) + normal
            resultant = np.sqrt(work[1, i] * work[1, i] + work[2, i] * work[2, i])
            tau = abs(work[3, i]) * per_torsion + resultant * shear
            n_out[i] = normal
            y_out[i] = s * about_y
            z_out[i] = -s * about_z
            out[i] = np.sqrt(sigma * sigma + 3.0 * tau * tau)


def warm_up() -> None:
    """Compile for the array types that the package uses."""
    force, out = np.zeros((2, 6, 1)), [np.zeros((2, 1)) for _ in range(4)]
    end_stress(force, force, 1, np.ones(1), np.ones((4, 1)), out[0], out[1], out[2], out[3])
    rows, out = np.zeros((6, 2)), [np.zeros((1, 2)) for _ in range(4)]
    end_stress_rows(rows, rows, 1, 1, np.ones(1), np.ones((4, 1)), rows, out[0], out[1], out[2], out[3])
