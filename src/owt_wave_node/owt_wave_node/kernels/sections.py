"""Morison force per length at the stations of a straight run, in element axes.

Kinematics are [station, channel, time]: velocities, then accelerations, along the waves and upwards (four
channels) or along all three wave axes (six). Rows of `axes` are the element axes x, y, z in wave axes.
Coefficients per station: inertia and drag normal to the element, added mass and drag along it.
"""

from __future__ import annotations

import math

from numba import njit

__all__ = ["point_force", "sectional"]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _plane(motion, axes, coefficient, current, q_y, q_z):
    """Normal force where the water moves in the plane of x and z; element y is horizontal."""
    u, w, a, b = motion[0], motion[1], motion[2], motion[3]
    alpha, beta, gamma = axes[1, 0], axes[2, 0], axes[2, 2]
    inertia, drag, c_y, c_z = coefficient[0], coefficient[1], current[1], current[2]
    for t in range(q_y.size):
        v_y, v_z = alpha * u[t] + c_y, beta * u[t] + gamma * w[t] + c_z
        speed = drag * math.sqrt(v_y * v_y + v_z * v_z)
        q_y[t] = inertia * alpha * a[t] + speed * v_y
        q_z[t] = inertia * (beta * a[t] + gamma * b[t]) + speed * v_z


@njit(cache=True, nogil=True, fastmath={"contract"})
def _space(motion, axes, coefficient, current, q_y, q_z):
    """Normal force where the water moves in all directions."""
    u, v, w, a, b, c = motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]
    y_1, y_2, y_3 = axes[1, 0], axes[1, 1], axes[1, 2]
    z_1, z_2, z_3 = axes[2, 0], axes[2, 1], axes[2, 2]
    inertia, drag, c_y, c_z = coefficient[0], coefficient[1], current[1], current[2]
    for t in range(q_y.size):
        v_y = y_1 * u[t] + y_2 * v[t] + y_3 * w[t] + c_y
        v_z = z_1 * u[t] + z_2 * v[t] + z_3 * w[t] + c_z
        speed = drag * math.sqrt(v_y * v_y + v_z * v_z)
        q_y[t] = inertia * (y_1 * a[t] + y_2 * b[t] + y_3 * c[t]) + speed * v_y
        q_z[t] = inertia * (z_1 * a[t] + z_2 * b[t] + z_3 * c[t]) + speed * v_z


@njit(cache=True, nogil=True)
def _along(motion, axes, coefficient, current, q_x):
    """Force along the element: added mass, and drag on the velocity along it alone."""
    n = motion.shape[0] // 2
    x_1, x_2, x_3 = axes[0, 0], axes[0, 1] if n == 3 else axes[0, 2], axes[0, 2] if n == 3 else 0.0
    added, drag, c_x = coefficient[2], coefficient[3], current[0]
    for t in range(q_x.size):
        v_x = x_1 * motion[0, t] + x_2 * motion[1, t] + x_3 * motion[n - 1, t] + c_x
        a_x = x_1 * motion[n, t] + x_2 * motion[n + 1, t] + x_3 * motion[2 * n - 1, t]
        q_x[t] = added * a_x + drag * abs(v_x) * v_x


@njit(cache=True, nogil=True)
def sectional(motion, axes, coefficient, current, q):
    """Fill q [station, 2 or 3, time] with the force per length along y, z and, if asked for, x.

    Equation 4.64 corrected: the force across the element depends on the normal components only.

    Parameters
    ----------
    motion : [station, 4 or 6, time]
        m/s and m/s2.
    axes : [3, 3]
        Element axes x, y, z, by row, in wave axes.
    coefficient : [station, 4]
        rho Cm pi D^2 / 4 in kg/m and rho Cd D / 2 in kg/m2 across the element; the same along it.
    current : [station, 3]
        Velocity in m/s in element axes, added to that of the waves.
    """
    for k in range(motion.shape[0]):
        if motion.shape[1] == 4:
            _plane(motion[k], axes, coefficient[k], current[k], q[k, 0], q[k, 1])
        else:
            _space(motion[k], axes, coefficient[k], current[k], q[k, 0], q[k, 1])
        if q.shape[1] == 3:
            _along(motion[k], axes, coefficient[k], current[k], q[k, 2])


@njit(cache=True, nogil=True)
def point_force(motion, k, stride, part, t, axes, coefficient, current, out):
    """Fill out with the force per length along y, z, x at the share `part` of a segment from station k on.

    Kinematics and coefficients in between are linear (stride 1) or parabolas (stride 2, a station amid).
    """
    last, middle = k + stride, k + 1
    bend = 4.0 * part * (1.0 - part) if stride == 2 else 0.0
    l_0, l_2 = 1.0 - part - 0.5 * bend, part - 0.5 * bend
    n = motion.shape[1] // 2
    v_x = l_0 * current[k, 0] + bend * current[middle, 0] + l_2 * current[last, 0]
    v_y = l_0 * current[k, 1] + bend * current[middle, 1] + l_2 * current[last, 1]
    v_z = l_0 * current[k, 2] + bend * current[middle, 2] + l_2 * current[last, 2]
    a_x, a_y, a_z = 0.0, 0.0, 0.0
    for i in range(n):
        j = i if n == 3 else 2 * i
        speed = l_0 * motion[k, i, t] + bend * motion[middle, i, t] + l_2 * motion[last, i, t]
        rate = l_0 * motion[k, n + i, t] + bend * motion[middle, n + i, t] + l_2 * motion[last, n + i, t]
        v_x, a_x = v_x + axes[0, j] * speed, a_x + axes[0, j] * rate
        v_y, a_y = v_y + axes[1, j] * speed, a_y + axes[1, j] * rate
        v_z, a_z = v_z + axes[2, j] * speed, a_z + axes[2, j] * rate
    inertia = l_0 * coefficient[k, 0] + bend * coefficient[middle, 0] + l_2 * coefficient[last, 0]
    drag = l_0 * coefficient[k, 1] + bend * coefficient[middle, 1] + l_2 * coefficient[last, 1]
    drag *= math.sqrt(v_y * v_y + v_z * v_z)
    out[0], out[1] = inertia * a_y + drag * v_y, inertia * a_z + drag * v_z
    out[2] = coefficient[k, 2] * a_x + coefficient[k, 3] * abs(v_x) * v_x  # constant along a run
