"""Morison forces on a run of stations of one element, integrated against its shape functions.

Rows of an element's equivalent nodal loads: Fy1, Mz1, Fy2, Mz2, Fz1, My1, Fz2, My2 in element axes.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["add_to_node", "run_loads", "segment_weights", "warm_up"]

#: Samples per pass, so that the work arrays stay in the first-level cache.
BLOCK = 256
#: Three-point Gauss rule on (0, 1), exact for the products of cubic shapes and linear forces.
GAUSS = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))
WEIGHT = (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)


@njit(cache=True, nogil=True)
def _hermite(s, length, out):
    """Shape functions of bending at s = x / length [thesis 4.2.3]: translations and rotations in turn."""
    out[0] = 1.0 - 3.0 * s * s + 2.0 * s * s * s
    out[1] = length * (s - 2.0 * s * s + s * s * s)
    out[2] = 3.0 * s * s - 2.0 * s * s * s
    out[3] = length * (s * s * s - s * s)


@njit(cache=True, nogil=True)
def segment_weights(place, length, out):
    """Fill out [segment, end, shape] in m: integrals of shape times linear hat over each segment [eq. 4.66].

    `place` are the stations' positions x / length along the element.
    """
    shape = np.empty(4)
    for k in range(place.size - 1):
        out[k] = 0.0
        span = place[k + 1] - place[k]
        for g in range(3):
            _hermite(place[k] + span * GAUSS[g], length, shape)
            for i in range(4):
                value = WEIGHT[g] * abs(span) * length * shape[i]
                out[k, 0, i] += value * (1.0 - GAUSS[g])
                out[k, 1, i] += value * GAUSS[g]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _sectional(motion, k, start, count, alpha, beta, gamma, inertia, drag, q_y, q_z):
    """Morison force per length in element y and z [eq. 4.64, corrected: normal components only]."""
    u, w = motion[k, 0, start : start + count], motion[k, 1, start : start + count]
    a, b = motion[k, 2, start : start + count], motion[k, 3, start : start + count]
    for t in range(count):
        v_y, v_z = alpha * u[t], beta * u[t] + gamma * w[t]
        speed = drag * math.sqrt(v_y * v_y + v_z * v_z)
        q_y[t] = inertia * alpha * a[t] + speed * v_y
        q_z[t] = inertia * (beta * a[t] + gamma * b[t]) + speed * v_z


@njit(cache=True, nogil=True)
def _up_to_surface(motion, wet, dry, t, part, alpha, beta, gamma, inertia, drag):
    """Sectional force where the surface crosses, a fraction `part` of the way from station wet to dry."""
    u = motion[wet, 0, t] + part * (motion[dry, 0, t] - motion[wet, 0, t])
    w = motion[wet, 1, t] + part * (motion[dry, 1, t] - motion[wet, 1, t])
    a = motion[wet, 2, t] + part * (motion[dry, 2, t] - motion[wet, 2, t])
    b = motion[wet, 3, t] + part * (motion[dry, 3, t] - motion[wet, 3, t])
    v_y, v_z = alpha * u, beta * u + gamma * w
    speed = drag * math.sqrt(v_y * v_y + v_z * v_z)
    return inertia * alpha * a + speed * v_y, inertia * (beta * a + gamma * b) + speed * v_z


@njit(cache=True, nogil=True, fastmath={"contract"})
def run_loads(motion, z, eta, surface, axes, inertia, drag, place, length, weights, rows):
    """Add the equivalent nodal loads of a run of stations to rows [8, time].

    Parameters
    ----------
    motion : [station, 4, time]
        u, w in m/s, du/dt, dw/dt in m/s2, u along the waves.
    z, eta : [station], [station, time]
        Levels of stations and surface in m; eta is not read unless `surface`.
    surface : bool
        Whether the surface can reach the run; if not, all of it is wet and the weights are constant.
    axes : [3]
        Components of element y along the waves, and of element z along the waves and upwards.
    inertia, drag : float
        rho Cm pi D^2 / 4 in kg/m and rho Cd D / 2 in kg/m2.
    place, length : [station], float
        Positions x / length of the stations along the element, and its length in m.
    weights : [segment, end, shape]
        See :func:`segment_weights`.
    """
    size, n = motion.shape[0], motion.shape[2]
    alpha, beta, gamma = axes[0], axes[1], axes[2]
    q = np.empty((size, 2, BLOCK))
    total = np.zeros((size, 4))
    for k in range(size - 1):
        total[k] += weights[k, 0]
        total[k + 1] += weights[k, 1]
    shape, sign = np.empty(4), np.array([1.0, -1.0, 1.0, -1.0])
    for start in range(0, n, BLOCK):
        count = min(BLOCK, n - start)
        for k in range(size):
            _sectional(motion, k, start, count, alpha, beta, gamma, inertia, drag, q[k, 0], q[k, 1])
        if not surface:
            for i in range(4):
                row_y, row_z = rows[i, start : start + count], rows[4 + i, start : start + count]
                for k in range(size):
                    q_y, q_z, f_y, f_z = q[k, 0], q[k, 1], total[k, i], sign[i] * total[k, i]
                    for t in range(count):
                        row_y[t] += f_y * q_y[t]
                        row_z[t] += f_z * q_z[t]
            continue
        for k in range(size - 1):
            for t in range(count):
                h_l, h_r = eta[k, start + t] - z[k], eta[k + 1, start + t] - z[k + 1]
                if h_l >= 0.0 and h_r >= 0.0:
                    for i in range(4):
                        left, right = weights[k, 0, i], weights[k, 1, i]
                        rows[i, start + t] += left * q[k, 0, t] + right * q[k + 1, 0, t]
                        rows[4 + i, start + t] += sign[i] * (left * q[k, 1, t] + right * q[k + 1, 1, t])
                elif h_l >= 0.0 or h_r >= 0.0:
                    wet, dry = (k, k + 1) if h_l >= 0.0 else (k + 1, k)
                    part = max(h_l, h_r) / abs(h_l - h_r)
                    end_y, end_z = _up_to_surface(
                        motion, wet, dry, start + t, part, alpha, beta, gamma, inertia, drag
                    )
                    span = part * (place[dry] - place[wet])
                    for g in range(3):
                        _hermite(place[wet] + span * GAUSS[g], length, shape)
                        f_y = q[wet, 0, t] + GAUSS[g] * (end_y - q[wet, 0, t])
                        f_z = q[wet, 1, t] + GAUSS[g] * (end_z - q[wet, 1, t])
                        for i in range(4):
                            value = WEIGHT[g] * abs(span) * length * shape[i]
                            rows[i, start + t] += value * f_y
                            rows[4 + i, start + t] += sign[i] * value * f_z


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_to_node(rows, side, axis_y, axis_z, out):
    """Add the loads of one end (0 or 1) of an element, turned to global axes, to out [6, time]."""
    f_y, m_z, f_z, m_y = rows[2 * side], rows[2 * side + 1], rows[4 + 2 * side], rows[5 + 2 * side]
    for c in range(3):
        y, z = axis_y[c], axis_z[c]
        force, moment = out[c], out[3 + c]
        for t in range(force.size):
            force[t] += y * f_y[t] + z * f_z[t]
            moment[t] += y * m_y[t] + z * m_z[t]


def warm_up() -> None:
    """Compile the kernels."""
    motion, eta, rows, three = np.ones((2, 4, 2)), np.ones((2, 2)), np.zeros((8, 2)), np.ones(3)
    place, weights = np.array([0.0, 1.0]), np.empty((1, 2, 4))
    segment_weights(place, 1.0, weights)
    run_loads(motion, place, eta, True, three, 1.0, 1.0, place, 1.0, weights, rows)
    add_to_node(rows, 0, three, three, np.zeros((6, 2)))
