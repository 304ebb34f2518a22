"""Second-order transfer functions of pairs of components travelling in one direction.

Written so that nothing cancels and nothing overflows at any depth: with q = exp(-2 k d),

    k^2 - R^2       = 4 k^2 q / (1 + q)^2                    (= k^2 / cosh^2 k d)
    k_m k_n - R_m R_n = k_m k_n (e_m + e_n - e_m e_n),  e = 2 q / (1 + q)    (= 1 - tanh k d)

Pairs (m, n) are packed row by row: sums n = 0..m at m (m + 1) / 2 + n, differences l = m - n = 1..m at
m (m - 1) / 2 + l - 1.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["potential_minus", "potential_plus", "tables", "transfer_pair", "warm_up"]


@njit(cache=True, nogil=True)
def potential_plus(k_m, k_n, omega_m, omega_n, depth, gravity):
    """D+ in rad2/m2 [eq. 4.14] and k_m k_n - R_m R_n."""
    s_m, s_n = omega_m / math.sqrt(gravity), omega_n / math.sqrt(gravity)
    q_m, q_n = math.exp(-2.0 * k_m * depth), math.exp(-2.0 * k_n * depth)
    e_m, e_n = 2.0 * q_m / (1.0 + q_m), 2.0 * q_n / (1.0 + q_n)
    c_m, c_n = 4.0 * k_m * k_m * q_m / (1.0 + q_m) ** 2, 4.0 * k_n * k_n * q_n / (1.0 + q_n) ** 2
    product = k_m * k_n * (e_m + e_n - e_m * e_n)
    s, k = s_m + s_n, k_m + k_n
    above = s * (s_n * c_m + s_m * c_n) + 2.0 * s * s * product
    return above / (s * s - k * math.tanh(k * depth)), product


@njit(cache=True, nogil=True)
def potential_minus(k_m, k_n, omega_m, omega_n, depth, gravity):
    """D- in rad2/m2 [eq. 4.13] and k_m k_n - R_m R_n; D- = 0 for two equal components."""
    s_m, s_n = omega_m / math.sqrt(gravity), omega_n / math.sqrt(gravity)
    q_m, q_n = math.exp(-2.0 * k_m * depth), math.exp(-2.0 * k_n * depth)
    e_m, e_n = 2.0 * q_m / (1.0 + q_m), 2.0 * q_n / (1.0 + q_n)
    product = k_m * k_n * (e_m + e_n - e_m * e_n)
    if omega_m == omega_n:
        return 0.0, product
    c_m, c_n = 4.0 * k_m * k_m * q_m / (1.0 + q_m) ** 2, 4.0 * k_n * k_n * q_n / (1.0 + q_n) ** 2
    s, k = s_m - s_n, abs(k_m - k_n)
    above = s * (s_n * c_m - s_m * c_n) + 2.0 * s * s * (2.0 * k_m * k_n - product)
    return above / (s * s - k * math.tanh(k * depth)), product


@njit(cache=True, nogil=True)
def transfer_pair(k_m, k_n, omega_m, omega_n, depth, gravity):
    """D+, D- in rad2/m2 and B+, B- in 1/m of one pair [eq. 4.13, 4.14, 4.19 corrected]."""
    s_m, s_n = omega_m / math.sqrt(gravity), omega_n / math.sqrt(gravity)
    d_plus, product = potential_plus(k_m, k_n, omega_m, omega_n, depth, gravity)
    d_minus, _ = potential_minus(k_m, k_n, omega_m, omega_n, depth, gravity)
    b_plus = 0.25 * ((d_plus - product) / (s_m * s_n) + s_m * s_m + s_n * s_n)
    b_minus = 0.25 * ((d_minus - product) / (s_m * s_n) + (s_m - s_n) ** 2)
    return d_plus, d_minus, b_plus, b_minus


@njit(cache=True, nogil=True)
def tables(k, omega, depth, gravity, velocity_sum, velocity_difference, surface_sum, surface_difference):
    """Fill the packed tables of all pairs m >= n (sums) and m > n (differences), mirrored pairs included.

    The velocity tables hold, for amplitudes of 1 m, the factor before
    [exp(K z) +- exp(-K (z + 2 d))], K = k_m +- k_n, in the horizontal (+) and vertical (-) velocity.
    """
    for m in range(k.size):
        sums, differences = m * (m + 1) // 2, m * (m - 1) // 2
        for n in range(m + 1):
            d_plus, d_minus, b_plus, b_minus = transfer_pair(k[m], k[n], omega[m], omega[n], depth, gravity)
            twice = 1.0 if m == n else 2.0
            common = 0.25 * twice * gravity * gravity / (omega[m] * omega[n])
            wave = k[m] + k[n]
            value = common * d_plus / (omega[m] + omega[n]) * wave / (1.0 + math.exp(-2.0 * wave * depth))
            velocity_sum[sums + n] = value if abs(value) > 1e-200 else 0.0
            surface_sum[sums + n] = twice * b_plus
            if n < m:
                wave = k[m] - k[n]
                velocity_difference[differences + m - n - 1] = (
                    common * d_minus / (omega[m] - omega[n]) * wave / (1.0 + math.exp(-2.0 * wave * depth))
                )
                surface_difference[differences + m - n - 1] = twice * b_minus


def warm_up() -> None:
    """Compile the kernels."""
    k, omega = np.array([0.04, 0.05]), np.array([0.6, 0.7])
    tables(k, omega, 50.0, 9.81, np.empty(3), np.empty(1), np.empty(3), np.empty(1))
