"""Fourier coefficients of elevation and velocity at points: single summation over pairs.

A real signal is sum_j Re(Y_j exp(i j w0 t)), w0 the spacing of the frequency grid, component m at j_m.
The vertical factors split, with K = k_m +- k_n, into

    cosh K(z+d) / cosh K d = [exp(K z) + exp(-K (z + 2 d))] / [1 + exp(-2 K d)]
    sinh K(z+d) / cosh K d = [exp(K z) - exp(-K (z + 2 d))] / [1 + exp(-2 K d)]

so that each pair costs a product of per-component factors: no transcendental function is evaluated per
pair. With consecutive j both m + n and m - n run contiguously with n, and rows add without scatter, four at
a time. Tables have zeros between their rows, and the factors zeros around them, so that no row has an end to
take care of: see :func:`spaced`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from owt_wave_node.kernels.simd import LANES, ROWS, add_rows

__all__ = ["GAP", "phasors", "second_order", "spaced", "warm_up"]

#: Exponent below the dominant pair from which a pair cannot change the sum in double precision.
NEGLIGIBLE = 40.0
#: Zeros between the rows of a table, and around the factors of components: more than four rows shifted by one
#: each and a vector can reach.
GAP = 12


@njit(cache=True, nogil=True)
def spaced(packed, size, shortest, out):
    """Copy rows of `shortest`, `shortest` + 1, ... numbers to `out` with a gap before each.

    Row m of the sums holds n = 0..m (shortest 1), row m of the differences l = m - n = 1..m (shortest 0);
    `out` has room for `size` + 4 rows and a gap, and holds zeros.
    """
    source, to = 0, GAP
    for m in range(size):
        count = m + shortest
        for i in range(count):
            out[to + i] = packed[source + i]
        source += count
        to += count + GAP


@njit(cache=True, nogil=True, inline="always")
def _add_four(table, row, grow, shift, e_re, e_im, start, a_re, a_im, m, low, high, out_re, out_im, to):
    """Add components m to m + 3 times entries `low` <= i < `high` of their rows to out[to + i].

    Entry i of the first row is table[row + i], with factor e[start + i]; each following row begins `grow`
    numbers later than the one before, `grow` grows by one, and lies `shift` entries and one factor behind.
    """
    a0, b0, a1, b1 = a_re[m], a_im[m], a_re[m + 1], a_im[m + 1]
    a2, b2, a3, b3 = a_re[m + 2], a_im[m + 2], a_re[m + 3], a_im[m + 3]
    first, second, third = grow - shift, 2 * grow + 1 - 2 * shift, 3 * grow + 3 - 3 * shift
    for i in range(low, high, LANES):
        at = row + i
        add_rows(
            table, e_re, e_im, start + i, out_re, out_im, to + i, at, at + first, at + second, at + third,
            a0, b0, a1, b1, a2, b2, a3, b3,
        )  # fmt: skip


@njit(cache=True, nogil=True, inline="always")
def _scatter_row(table, e_re, e_im, a, b, to, sign, start, out_re, out_im):
    """Add table * (a + i b) * e to entries start + sign * to of `out`."""
    for i in range(table.size):
        j = start + sign * to[i]
        t_re, t_im = table[i] * e_re[i], table[i] * e_im[i]
        out_re[j] += a * t_re - b * t_im
        out_im[j] += a * t_im + b * t_re


@njit(cache=True, nogil=True, inline="always")
def _sums(table, e_re, e_im, k, limit, j, dense, out_re, out_im):
    """Add the pairs k_m + k_n <= limit of exp(i (psi_m + psi_n)).

    Where the j are consecutive, four m at a time, some pairs beyond the limit included.
    """
    size, n_max = k.size, k.size - 1
    for m in range(0, size, ROWS if dense else 1):
        while n_max >= 0 and k[m] + k[n_max] > limit:
            n_max -= 1
        if n_max < 0:
            return
        row = m * (m + 1) // 2 + GAP * (m + 1)
        if dense:
            high = min(m + ROWS - 1, n_max) + ROWS
            _add_four(
                table, row, m + 1 + GAP, 1, e_re, e_im, GAP, e_re, e_im, GAP + m, 0, high,
                out_re, out_im, j[m] + j[0],
            )  # fmt: skip
        else:
            count = min(m, n_max) + 1
            _scatter_row(
                table[row : row + count], e_re[GAP : GAP + count], e_im[GAP : GAP + count], e_re[GAP + m],
                e_im[GAP + m], j, 1, j[m], out_re, out_im,
            )  # fmt: skip


@njit(cache=True, nogil=True, inline="always")
def _differences(
    table, e_re, e_im, back_re, back_im, k, first, last, limit, j, back_j, dense, out_re, out_im
):
    """Add the pairs m > n, first <= n < last, k_m - k_n <= limit, of exp(i (psi_m - psi_n)).

    `back` holds the conjugate factors of n in reverse order (index size - 1 - n), zero outside the range.
    Where the j are consecutive, four m at a time, some pairs beyond the limit included.
    """
    size, n_min = k.size, first
    for m in range(first + 1, size, ROWS if dense else 1):
        while n_min < m and k[m] - k[n_min] > limit:
            n_min += 1
        if n_min >= last:
            return
        row = m * (m - 1) // 2 + GAP * (m + 1)
        if dense:
            _add_four(
                table, row, m + GAP, 0, back_re, back_im, GAP + size - m, e_re, e_im, GAP + m,
                max(m - last, 0), m + ROWS - 1 - n_min, out_re, out_im, 1,
            )  # fmt: skip
        else:
            high = min(m, last) - 1
            if high < n_min:
                continue
            low, count, at = m - high - 1, high - n_min + 1, GAP + size - 1 - high
            _scatter_row(
                table[row + low : row + low + count], back_re[at : at + count], back_im[at : at + count],
                e_re[GAP + m], e_im[GAP + m], back_j[at - GAP : at - GAP + count], -1, j[m], out_re, out_im,
            )  # fmt: skip


@njit(cache=True, nogil=True)
def phasors(x, k, amplitude, out):
    """Fill out [point, component] with A exp(-i k x)."""
    for p in range(x.size):
        for m in range(k.size):
            out[p, m] = amplitude[m] * complex(math.cos(k[m] * x[p]), -math.sin(k[m] * x[p]))


@njit(cache=True, nogil=True, inline="always")
def _scaled(phasor, k, shift, height, first, last, e_re, e_im, back_re, back_im):
    """Factors phasor exp((k - shift) height) from component `first` on; conjugate inverses up to `last`."""
    size = k.size
    back_re[:], back_im[:] = 0.0, 0.0
    for m in range(first, size):
        e = math.exp((k[m] - shift) * height)
        e_re[GAP + m], e_im[GAP + m] = e * phasor[m].real, e * phasor[m].imag
        if m < last:
            at = GAP + size - 1 - m
            back_re[at], back_im[at] = phasor[m].real / e, -phasor[m].imag / e


@njit(cache=True, nogil=True)
def second_order(phasor, z, k, j, dense, depth, k_peak, blocks, image, table_sum, table_difference, out):
    """Add the second-order velocities [eq. 4.20, 4.21] to out [point, 2, j].

    Without `image`, at z = 0 and with the tables of the surface, the first of the two is the elevation
    [eq. 4.18] without its mean.

    Parameters
    ----------
    phasor : [point, component]
        A exp(-i k x).
    k_peak : float
        Wave number of the largest component, against which a pair is negligible.
    blocks : [bound]
        Bounds of ranges of n within which exp(2 k d) does not overflow.
    image : bool
        Whether the vertical factors have their second term, of the image below the bed.
    table_sum, table_difference : [entry]
        See :func:`spaced`.
    """
    size, n_j = k.size, out.shape[2]
    factor = np.zeros((4, size + 2 * GAP))
    sums, back_j = np.empty((4, n_j + GAP)), j[::-1].copy()
    for p in range(z.size):
        sums[:] = 0.0
        for term in range(2 if image else 1):
            height = z[p] if term == 0 else -(z[p] + 2.0 * depth)
            below = max(-height, 1e-300)
            g_re, g_im = sums[2 * term], sums[2 * term + 1]
            _scaled(phasor[p], k, 0.0, height, 0, 0, factor[0], factor[1], factor[2], factor[3])
            limit = (NEGLIGIBLE + 2.0 * k_peak * max(-z[p], 0.0)) / below
            _sums(table_sum, factor[0], factor[1], k, limit, j, dense, g_re, g_im)
            for i in range(blocks.size - 1):
                first, last = blocks[i], blocks[i + 1]
                _scaled(
                    phasor[p], k, k[first], height, first, last, factor[0], factor[1], factor[2], factor[3]
                )
                _differences(
                    table_difference, factor[0], factor[1], factor[2], factor[3], k, first, last,
                    NEGLIGIBLE / below, j, back_j, dense, g_re, g_im,
                )  # fmt: skip
        for i in range(n_j):
            out[p, 0, i] += complex(sums[0, i] + sums[2, i], sums[1, i] + sums[3, i])
            out[p, 1, i] += 1j * complex(sums[0, i] - sums[2, i], sums[1, i] - sums[3, i])


def warm_up() -> None:
    """Compile the kernels."""
    k, j, z = np.array([0.04, 0.05]), np.array([1, 2]), np.zeros(1)
    phasor, velocity = np.zeros((1, 2), dtype=complex), np.zeros((1, 2, 5), dtype=complex)
    table = np.zeros(200)
    spaced(np.ones(3), 2, 1, table)
    phasors(z, k, phasor[0], phasor)
    second_order(phasor, z, k, j, True, 50.0, 0.04, np.array([0, 2]), True, table, table, velocity)
