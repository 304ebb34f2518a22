"""Morison forces on a run that the water surface can cross, integrated up to the surface."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from owt_wave_node.kernels.morison import GAUSS, WEIGHT, hermite
from owt_wave_node.kernels.sections import point_force, sectional

__all__ = ["surface_loads", "warm_up"]

#: Samples that are looked at together: in most of them a segment is wet, or dry, from end to end.
BLOCK = 64


@njit(cache=True, nogil=True)
def _crossing(h_0, h_1, h_2, stride):
    """Share of a segment at which the surface lies, from the water's height over its stations.

    Linear in between, or on the parabola of the three: a change of sign leaves one root inside.
    """
    if stride == 1:
        return h_0 / (h_0 - h_2)
    b, c = -3.0 * h_0 + 4.0 * h_1 - h_2, 2.0 * (h_0 - 2.0 * h_1 + h_2)
    q = -0.5 * (b + math.copysign(math.sqrt(b * b - 4.0 * c * h_0), b))
    root = h_0 / q
    return root if 0.0 <= root <= 1.0 else q / c


@njit(cache=True, nogil=True)
def _partly_wet(
    motion,
    k,
    stride,
    constant,
    wet,
    part,
    t,
    axes,
    coefficient,
    current,
    q,
    place,
    length,
    shape,
    force,
    rows,
):
    """Add to rows the load of a segment that is wet from station `wet` to the share `part` of it.

    The last wet node lies on the surface: its force comes from the kinematics there.
    """
    begin = 0.0 if wet == k else 1.0
    reach = part - begin
    for i in range(q.shape[1]):
        force[0, i] = q[wet, i, t]
    for j in range(2, 2 - stride, -1):  # the node on the surface, and the one amid where there is one
        point_force(motion, k, stride, begin + 0.5 * j * reach, t, axes, coefficient, current, force[j])
    span = place[k + stride] - place[k]
    for g in range(1 if constant else 3):
        x, weight = (0.5, 1.0) if constant else (GAUSS[g], WEIGHT[g])
        hermite(place[k] + span * (begin + reach * x), length, shape)
        weight *= abs(reach * span) * length
        for i in range(q.shape[1]):
            f = (1.0 - x) * force[0, i] + x * force[2, i]
            if stride == 2:  # a parabola: the middle's distance from the line
                f += 4.0 * x * (1.0 - x) * (force[1, i] - 0.5 * (force[0, i] + force[2, i]))
            f *= weight
            if i == 2:
                rows[8, t] += shape[4] * f
                rows[9, t] += shape[5] * f
                continue
            turn = 1.0 if i == 0 else -1.0  # My turns z towards x
            rows[4 * i, t] += shape[0] * f
            rows[4 * i + 1, t] += turn * shape[1] * f
            rows[4 * i + 2, t] += shape[2] * f
            rows[4 * i + 3, t] += turn * shape[3] * f


@njit(cache=True, nogil=True)
def _wet(weights, k, q, t, rows):
    """Add the load of a segment that is wet from end to end."""
    for j in range(weights.shape[0]):
        y, z = q[k + j, 0, t], q[k + j, 1, t]
        f_1, f_2, f_3, f_4 = weights[j, 0], weights[j, 1], weights[j, 2], weights[j, 3]
        rows[0, t] += f_1 * y
        rows[1, t] += f_2 * y
        rows[2, t] += f_3 * y
        rows[3, t] += f_4 * y
        rows[4, t] += f_1 * z
        rows[5, t] -= f_2 * z
        rows[6, t] += f_3 * z
        rows[7, t] -= f_4 * z
        if rows.shape[0] == 10:
            rows[8, t] += weights[j, 4] * q[k + j, 2, t]
            rows[9, t] += weights[j, 5] * q[k + j, 2, t]


@njit(cache=True, nogil=True)
def _all_wet(weights, k, q, start, stop, rows):
    """Add the load of a segment that is wet from end to end at all samples from `start` to `stop`."""
    for j in range(weights.shape[0]):
        for i in range(rows.shape[0]):
            axis, shape = i // 4, i % 4 if i < 8 else i - 4
            f = -weights[j, shape] if axis == 1 and i % 2 == 1 else weights[j, shape]  # My turns z towards x
            row, unit = rows[i, start:stop], q[k + j, axis, start:stop]
            for t in range(row.size):
                row[t] += f * unit[t]


@njit(cache=True, nogil=True)
def surface_loads(q, motion, z, eta, rule, stride, axes, coefficient, current, place, length, weights, rows):
    """Add the equivalent nodal loads of a run, wet up to the surface, to rows [row, time].

    Parameters
    ----------
    q, motion, axes, coefficient, current
        See :func:`owt_wave_node.kernels.sections.sectional`.
    z, eta : [station], [station, time]
        Levels of stations and surface in m; plus infinity where a station always is wet.
    rule : int
        0: the last wet node moves with the surface. 1: so it does, and the mean force of the wet part acts at
        its middle (constant distribution). 2: a segment is wet where its middle is.
    stride : int
        Stations per segment: 1, or 2 with a station amid each.
    place, length : [station], float
        Positions x / length of the stations along the element, and its length in m.
    weights : [segment, node, shape]
        See :func:`owt_wave_node.kernels.morison.segment_weights`.
    """
    shape, force, n = np.empty(6), np.empty((3, 3)), motion.shape[2]
    for s in range(weights.shape[0]):
        k = stride * s
        last = k + stride
        for start in range(0, n, BLOCK):
            stop = min(start + BLOCK, n)
            wet = 0
            for t in range(start, stop):
                wet += (eta[k, t] >= z[k]) + (eta[last, t] >= z[last])
            if rule != 2 and wet == 2 * (stop - start):
                _all_wet(weights[s], k, q, start, stop, rows)
                continue
            if rule != 2 and wet == 0:
                continue
            for t in range(start, stop):
                h_0, h_2 = eta[k, t] - z[k], eta[last, t] - z[last]
                if rule == 2:
                    h_0 = h_2 = eta[k + 1, t] - z[k + 1] if stride == 2 else 0.5 * (h_0 + h_2)
                if h_0 >= 0.0 and h_2 >= 0.0:
                    _wet(weights[s], k, q, t, rows)
                elif h_0 >= 0.0 or h_2 >= 0.0:
                    part = _crossing(h_0, eta[k + 1, t] - z[k + 1], h_2, stride)
                    _partly_wet(
                        motion, k, stride, rule == 1, k if h_0 >= 0.0 else last, part, t, axes, coefficient,
                        current, q, place, length, shape, force, rows,
                    )  # fmt: skip


def warm_up() -> None:
    """Compile the kernels."""
    motion, axes, coefficient, current = np.ones((2, 4, 2)), np.eye(3), np.ones((2, 4)), np.zeros((2, 3))
    place, q = np.array([0.0, 1.0]), np.empty((2, 2, 2))
    sectional(motion, axes, coefficient, current, q)
    surface_loads(
        q, motion, place, np.full((2, 2), 0.5), 0, 1, axes, coefficient, current, place, 1.0,
        np.ones((1, 2, 6)), np.zeros((8, 2)),
    )  # fmt: skip
