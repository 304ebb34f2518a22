"""The same work done the plain way, with numpy alone: what the kernels are measured against."""

from __future__ import annotations

from itertools import pairwise

import numpy as np


def second_order_double_sum(
    t: np.ndarray, x: float, z: float, *, omega: np.ndarray, k: np.ndarray, a: np.ndarray, phase: np.ndarray,
    depth: float, gravity: float,
) -> np.ndarray:  # fmt: skip
    """Second-order horizontal velocity in m/s at one point: all pairs, one time after the other."""
    r = omega**2 / gravity
    s, b = np.sqrt(r), a * gravity / omega
    deep = k**2 / np.cosh(k * depth) ** 2
    s_m, s_n, k_m, k_n, r_m, r_n = s[:, None], s[None], k[:, None], k[None], r[:, None], r[None]
    amplitude = []
    for sign in (1.0, -1.0):
        kappa = np.abs(k_m + sign * k_n)
        root = s_m + sign * s_n
        numerator = root * (s_n * deep[:, None] + sign * s_m * deep[None])
        numerator = numerator + 2.0 * root**2 * (k_m * k_n - sign * r_m * r_n)
        with np.errstate(invalid="ignore", divide="ignore"):
            d = numerator / (root**2 - kappa * np.tanh(kappa * depth)) / (omega[:, None] + sign * omega[None])
        if sign < 0:
            np.fill_diagonal(d, 0.0)
        profile = np.cosh(kappa * (z + depth)) / np.cosh(kappa * depth)
        amplitude.append(0.25 * b[:, None] * b[None] * profile * d * (k_m + sign * k_n))
    result = np.empty_like(t)
    for i, time in enumerate(t):
        psi = omega * time - k * x - phase
        result[i] = (amplitude[0] * np.cos(psi[:, None] + psi[None])).sum()
        result[i] += (amplitude[1] * np.cos(psi[:, None] - psi[None])).sum()
    return result


def newmark_coupled(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, load: np.ndarray, h: float
) -> np.ndarray:
    """Displacements by implicit Newmark on the coupled system with one inverted matrix [eq. F.5-F.8]."""
    inverse = np.linalg.inv(mass + 0.5 * h * damping + 0.25 * h**2 * stiffness)
    q = np.linalg.solve(stiffness, load[0])
    v = np.zeros_like(q)
    a = np.linalg.solve(mass, load[0] - stiffness @ q)
    out = np.empty_like(load)
    out[0] = q
    for i in range(1, len(load)):
        q_new, v_new = q + h * v + 0.25 * h**2 * a, v + 0.5 * h * a
        a = inverse @ (load[i] - damping @ v_new - stiffness @ q_new)
        q, v = q_new + 0.25 * h**2 * a, v_new + 0.5 * h * a
        out[i] = q
    return out


def rainflow_half_cycles(series: np.ndarray) -> list[tuple[float, float]]:
    """Ranges and counts by the three-point rule of ASTM E1049, in plain Python."""
    keep = np.flatnonzero(np.diff(np.sign(np.diff(series)))) + 1
    turning = [float(series[0]), *series[keep].tolist(), float(series[-1])]
    stack: list[float] = []
    cycles: list[tuple[float, float]] = []
    for value in turning:
        stack.append(value)
        while len(stack) >= 3:
            x, y = abs(stack[-1] - stack[-2]), abs(stack[-2] - stack[-3])
            if x < y:
                break
            if len(stack) == 3:
                cycles.append((y, 0.5))
                del stack[0]
            else:
                cycles.append((y, 1.0))
                del stack[-3:-1]
    cycles += [(abs(b - a), 0.5) for a, b in pairwise(stack)]
    return cycles
