"""Fourier coefficients of elevation and velocity at points: single summation over pairs.

A real signal is sum_j Re(Y_j exp(i j w0 t)), w0 the spacing of the frequency grid, component m at j_m.
The vertical factors split, with K = k_m +- k_n, into

    cosh K(z+d) / cosh K d = [exp(K z) + exp(-K (z + 2 d))] / [1 + exp(-2 K d)]
    sinh K(z+d) / cosh K d = [exp(K z) - exp(-K (z + 2 d))] / [1 + exp(-2 K d)]

so that each pair costs a product of per-component factors: no transcendental function is evaluated per
pair. With consecutive j both m + n and m - n run contiguously with n, and rows add without scatter.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["second_elevation", "second_velocity", "warm_up"]

#: Exponent below the dominant pair from which a pair cannot change the sum in double precision.
NEGLIGIBLE = 40.0


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_row(table, e_re, e_im, a, b, out_re, out_im):
    """Add table * (a + i b) * e to `out`, all of one length."""
    for i in range(table.size):
        t_re, t_im = table[i] * e_re[i], table[i] * e_im[i]
        out_re[i] += a * t_re - b * t_im
        out_im[i] += a * t_im + b * t_re


@njit(cache=True, nogil=True, fastmath={"contract"})
def _scatter_row(table, e_re, e_im, a, b, to, sign, start, out_re, out_im):
    """Add table * (a + i b) * e to entries start + sign * to of `out`."""
    for i in range(table.size):
        j = start + sign * to[i]
        t_re, t_im = table[i] * e_re[i], table[i] * e_im[i]
        out_re[j] += a * t_re - b * t_im
        out_im[j] += a * t_im + b * t_re


@njit(cache=True, nogil=True)
def _sums(table, e_re, e_im, k, limit, j, dense, out_re, out_im):
    """Add the pairs k_m + k_n <= limit of exp(i (psi_m + psi_n))."""
    n_max = k.size - 1
    for m in range(k.size):
        a, b = e_re[m], e_im[m]
        while n_max >= 0 and k[m] + k[n_max] > limit:
            n_max -= 1
        count = min(m, n_max) + 1
        if count <= 0:
            return
        if a == 0.0 and b == 0.0:
            continue
        row = m * (m + 1) // 2
        if dense:
            to = j[m] + j[0]
            _add_row(
                table[row : row + count], e_re[:count], e_im[:count], a, b,
                out_re[to : to + count], out_im[to : to + count],
            )  # fmt: skip
        else:
            _scatter_row(table[row : row + count], e_re, e_im, a, b, j, 1, j[m], out_re, out_im)


@njit(cache=True, nogil=True)
def _differences(
    table, e_re, e_im, back_re, back_im, k, first, last, limit, j, back_j, dense, out_re, out_im
):
    """Add the pairs m > n, first <= n < last, k_m - k_n <= limit, of exp(i (psi_m - psi_n)).

    `back` holds the conjugate factors of n in reverse order (index size - 1 - n).
    """
    size, n_min = k.size, first
    for m in range(first + 1, size):
        a, b = e_re[m], e_im[m]
        while n_min < m and k[m] - k[n_min] > limit:
            n_min += 1
        high = min(m, last) - 1
        if n_min >= last:
            return
        if high < n_min or (a == 0.0 and b == 0.0):
            continue
        low_l, count = m - high, high - n_min + 1
        row = m * (m - 1) // 2 + low_l - 1
        at = size - 1 - high
        if dense:
            _add_row(
                table[row : row + count], back_re[at : at + count], back_im[at : at + count], a, b,
                out_re[low_l : low_l + count], out_im[low_l : low_l + count],
            )  # fmt: skip
        else:
            _scatter_row(
                table[row : row + count], back_re[at : at + count], back_im[at : at + count], a, b,
                back_j[at : at + count], -1, j[m], out_re, out_im,
            )  # fmt: skip


@njit(cache=True, nogil=True)
def _phases(x, k, amplitude, out_re, out_im):
    """A exp(-i k x)."""
    for m in range(k.size):
        c, s = math.cos(k[m] * x), math.sin(k[m] * x)
        re, im = amplitude[m].real, amplitude[m].imag
        out_re[m], out_im[m] = re * c + im * s, im * c - re * s


@njit(cache=True, nogil=True)
def second_velocity(x, z, k, j, dense, amplitude, depth, k_peak, blocks, table_sum, table_difference, out):
    """Add the second-order velocities [eq. 4.20, 4.21] to out [point, 2, j].

    `blocks` are the bounds of ranges of n within which exp(2 k d) does not overflow; `k_peak` is the wave
    number of the largest component, against which a pair is negligible.
    """
    size = k.size
    n_j = out.shape[2]
    x_re, x_im, e_re, e_im = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    f_re, f_im, back_re, back_im = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    back_j = j[::-1].copy()
    g_re, g_im, h_re, h_im = np.empty(n_j), np.empty(n_j), np.empty(n_j), np.empty(n_j)
    for p in range(x.size):
        up, down = z[p], z[p] + 2.0 * depth
        depth_p = max(-up, 1e-300)
        _phases(x[p], k, amplitude, x_re, x_im)
        g_re[:], g_im[:], h_re[:], h_im[:] = 0.0, 0.0, 0.0, 0.0
        for m in range(size):
            e, f = math.exp(k[m] * up), math.exp(-k[m] * down)
            e_re[m], e_im[m] = e * x_re[m], e * x_im[m]
            f_re[m], f_im[m] = f * x_re[m], f * x_im[m]
        base = NEGLIGIBLE + 2.0 * k_peak * max(-up, 0.0)
        _sums(table_sum, e_re, e_im, k, base / depth_p, j, dense, g_re, g_im)
        _sums(table_sum, f_re, f_im, k, base / down, j, dense, h_re, h_im)
        for i in range(blocks.size - 1):
            first, last = blocks[i], blocks[i + 1]
            shift = k[first]
            for m in range(first, size):
                e, f = math.exp((k[m] - shift) * up), math.exp(-(k[m] - shift) * down)
                e_re[m], e_im[m] = e * x_re[m], e * x_im[m]
                f_re[m], f_im[m] = f * x_re[m], f * x_im[m]
            for n in range(first, last):
                e = math.exp(-(k[n] - shift) * up)
                back_re[size - 1 - n], back_im[size - 1 - n] = e * x_re[n], -e * x_im[n]
            limit = NEGLIGIBLE / depth_p
            _differences(
                table_difference, e_re, e_im, back_re, back_im, k, first, last, limit, j, back_j, dense,
                g_re, g_im,
            )  # fmt: skip
            for n in range(first, last):
                f = math.exp((k[n] - shift) * down)
                back_re[size - 1 - n], back_im[size - 1 - n] = f * x_re[n], -f * x_im[n]
            _differences(
                table_difference, f_re, f_im, back_re, back_im, k, first, last, NEGLIGIBLE / down, j, back_j,
                dense, h_re, h_im,
            )  # fmt: skip
        for i in range(n_j):
            out[p, 0, i] += complex(g_re[i] + h_re[i], g_im[i] + h_im[i])
            out[p, 1, i] += 1j * complex(g_re[i] - h_re[i], g_im[i] - h_im[i])


@njit(cache=True, nogil=True)
def second_elevation(x, k, j, dense, amplitude, set_down, table_sum, table_difference, out):
    """Add the second-order elevation [eq. 4.18], mean `set_down` included, to out [point, j]."""
    size = k.size
    n_j = out.shape[1]
    x_re, x_im, back_re, back_im = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    back_j = j[::-1].copy()
    g_re, g_im = np.empty(n_j), np.empty(n_j)
    for p in range(x.size):
        _phases(x[p], k, amplitude, x_re, x_im)
        for n in range(size):
            back_re[size - 1 - n], back_im[size - 1 - n] = x_re[n], -x_im[n]
        g_re[:], g_im[:] = 0.0, 0.0
        _sums(table_sum, x_re, x_im, k, np.inf, j, dense, g_re, g_im)
        _differences(
            table_difference, x_re, x_im, back_re, back_im, k, 0, size, np.inf, j, back_j, dense, g_re, g_im
        )
        for i in range(n_j):
            out[p, i] += complex(g_re[i], g_im[i])
        out[p, 0] += set_down


def warm_up() -> None:
    """Compile the kernels."""
    k, x, j, amplitude = np.array([0.04, 0.05]), np.zeros(1), np.array([1, 2]), np.ones(2, dtype=complex)
    velocity = np.zeros((1, 2, 5), dtype=complex)
    for dense in (True, False):
        second_velocity(
            x, x - 1.0, k, j, dense, amplitude, 50.0, 0.04, np.array([0, 2]), np.ones(3), np.ones(1), velocity
        )
        second_elevation(x, k, j, dense, amplitude, -0.1, np.ones(3), np.ones(1), velocity[0])
