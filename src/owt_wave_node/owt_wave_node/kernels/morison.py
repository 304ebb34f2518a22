"""Morison forces on a run of stations of one element, integrated against its shape functions.

Rows of an element's equivalent nodal loads: Fy1, Mz1, Fy2, Mz2, Fz1, My1, Fz2, My2 in element axes, and
Fx1, Fx2 where the force along the element is asked for.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = [
    "GAUSS",
    "WEIGHT",
    "add_stations",
    "add_to_node",
    "hermite",
    "segment_weights",
    "station_weights",
    "warm_up",
]

#: Samples per pass, so that the work arrays stay in the first-level cache.
BLOCK = 256
#: Three-point Gauss rule on (0, 1), exact for the products of cubic shapes and parabolic forces.
GAUSS = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))
WEIGHT = (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)


@njit(cache=True, nogil=True)
def hermite(s, length, out):
    """Shape functions at s = x / length [thesis 4.2.3]: four of bending, two of axial displacement."""
    out[0] = 1.0 - 3.0 * s * s + 2.0 * s * s * s
    out[1] = length * (s - 2.0 * s * s + s * s * s)
    out[2] = 3.0 * s * s - 2.0 * s * s * s
    out[3] = length * (s * s * s - s * s)
    out[4] = 1.0 - s
    out[5] = s


@njit(cache=True, nogil=True)
def segment_weights(place, length, stride, constant, out):
    """Fill out [segment, node, shape]: nodal loads per unit force per length at a node [eq. 4.66].

    Integrals of the shape functions times the linear hats (stride 1) or the parabolas through three nodes
    (stride 2); with `constant` the mean of the ends acts at the middle of the segment.

    Parameters
    ----------
    place : [station]
        Positions x / length along the element, of the nodes amid too.
    """
    shape = np.empty(6)
    for k in range(out.shape[0]):
        out[k] = 0.0
        first = place[stride * k]
        span = place[stride * k + stride] - first
        if constant:
            hermite(first + 0.5 * span, length, shape)
            for i in range(6):
                out[k, 0, i] = out[k, stride, i] = 0.5 * abs(span) * length * shape[i]
            continue
        for g in range(3):
            x = GAUSS[g]
            hermite(first + span * x, length, shape)
            for i in range(6):
                value = WEIGHT[g] * abs(span) * length * shape[i]
                if stride == 1:
                    out[k, 0, i] += value * (1.0 - x)
                    out[k, 1, i] += value * x
                else:
                    out[k, 0, i] += value * (1.0 - x) * (1.0 - 2.0 * x)
                    out[k, 1, i] += value * 4.0 * x * (1.0 - x)
                    out[k, 2, i] += value * x * (2.0 * x - 1.0)


@njit(cache=True, nogil=True)
def station_weights(weights, out):
    """Fill out [station, shape] with the sums of weights [segment, node, shape] at the stations."""
    stride = weights.shape[1] - 1
    out[:] = 0.0
    for s in range(weights.shape[0]):
        for j in range(stride + 1):
            for i in range(out.shape[1]):
                out[stride * s + j, i] += weights[s, j, i]


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_stations(q, weights, rows):
    """Add the equivalent nodal loads of stations that always are wet to rows [row, time].

    Parameters
    ----------
    q : [station, 2 or 3, time]
        Force per length in N/m, from :func:`owt_wave_node.kernels.sections.sectional`.
    weights : [station, shape]
        Sums of what :func:`segment_weights` gives.
    """
    size, n = q.shape[0], q.shape[2]
    for start in range(0, n, BLOCK):
        stop = min(start + BLOCK, n)
        for i in range(rows.shape[0]):
            row, axis = rows[i, start:stop], i // 4
            shape = i % 4 if i < 8 else i - 4
            turn = -1.0 if axis == 1 and i % 2 == 1 else 1.0  # My turns z towards x
            # Four stations between a load and a store of the row.
            for k in range(0, size - 3, 4):
                f_0, f_1 = turn * weights[k, shape], turn * weights[k + 1, shape]
                f_2, f_3 = turn * weights[k + 2, shape], turn * weights[k + 3, shape]
                q_0, q_1 = q[k, axis, start:stop], q[k + 1, axis, start:stop]
                q_2, q_3 = q[k + 2, axis, start:stop], q[k + 3, axis, start:stop]
                for t in range(row.size):
                    row[t] = row[t] + f_0 * q_0[t] + f_1 * q_1[t] + f_2 * q_2[t] + f_3 * q_3[t]
            for k in range(size - size % 4, size):
                f, force = turn * weights[k, shape], q[k, axis, start:stop]
                for t in range(row.size):
                    row[t] += f * force[t]


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_to_node(rows, side, axes, out):
    """Add the loads of one end (0 or 1) of an element, turned to global axes, to out [6, time]."""
    f_y, m_z, f_z, m_y = rows[2 * side], rows[2 * side + 1], rows[4 + 2 * side], rows[5 + 2 * side]
    for c in range(3):
        y, z = axes[1, c], axes[2, c]
        force, moment = out[c], out[3 + c]
        for t in range(force.size):
            force[t] += y * f_y[t] + z * f_z[t]
            moment[t] += y * m_y[t] + z * m_z[t]
    if rows.shape[0] == 10:
        for c in range(3):
            x, f_x, force = axes[0, c], rows[8 + side], out[c]
            for t in range(force.size):
                force[t] += x * f_x[t]


def warm_up() -> None:
    """Compile the kernels."""
    weights, rows = np.empty((1, 2, 6)), np.zeros((1, 8, 2))
    hermite(0.5, 1.0, np.empty(6))
    segment_weights(np.array([0.0, 1.0]), 1.0, 1, False, weights)
    station_weights(weights, np.empty((2, 6)))
    add_stations(np.ones((2, 2, 2)), weights[0], rows[0])
    add_to_node(rows[0], 0, np.eye(3), np.zeros((6, 2)))
