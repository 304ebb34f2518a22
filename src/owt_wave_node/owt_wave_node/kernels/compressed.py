"""Pairs of components as moments in K = k_m +- k_n: what they share at every point, summed once.

With s = K / h - 1 in [-1, 1] a pair of amplitude a adds a T_q(s) to the moments q of its frequency. The
tables of a component are, by row, k, s = sqrt(R) = omega / sqrt(g), e = 1 - tanh kd, c = k^2 / cosh^2 kd,
1 / s and exp(-2kd), see :mod:`owt_wave_node.kernels.transfer`. Moments are [row, part, q] with the parts
velocity (real, imaginary) and elevation (real, imaginary).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["finish", "gather_rows", "product", "spread_pairs", "spread_rows", "warm_up"]

#: Pairs whose polynomials are raised together: their work arrays stay in the innermost cache.
CHUNK = 256
#: Bins of a table that are worked through together.
BLOCK = 512


@njit(cache=True, nogil=True, error_model="numpy")
def _factors(table, m, n, sign, depth, gravity):
    """K, and the factors of velocity and elevation of the pair m, n [eq. 4.13, 4.14, 4.19, 4.24].

    Both count the pair and its mirror; the factor of the velocity is that before exp(Kz) +- exp(-K(z+2d)).
    One division is left: with q = exp(-2Kd), D = above (1 + q) / [s^2 (1 + q) - K (1 - q)].
    """
    k_m, k_n, s_m, s_n = table[0, m], table[0, n], table[1, m], table[1, n]
    product = k_m * k_n * (table[2, m] + table[2, n] - table[2, m] * table[2, n])
    s, k = s_m + sign * s_n, k_m + sign * k_n
    if sign > 0.0:
        q, twice_product, rest = table[5, m] * table[5, n], product, s_m * s_m + s_n * s_n
    else:
        q = math.exp(-2.0 * k * depth) if k * depth < 20.0 else 0.0
        twice_product, rest = 2.0 * k_m * k_n - product, s * s
    above = s * (s_n * table[3, m] + sign * s_m * table[3, n]) + 2.0 * s * s * twice_product
    inverse = above / (s * (s * s * (1.0 + q) - k * (1.0 - q)))
    common = (0.25 if m == n else 0.5) * table[4, m] * table[4, n]
    velocity = common * math.sqrt(gravity) * k * inverse
    surface = common * (inverse * s * (1.0 + q) - product + rest * s_m * s_n)
    return k, velocity, surface


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"})
def _raise(count, s, weight, low, high, out):
    """Add the moments of `count` pairs: weight [part, pair], out [part, q], q even in number."""
    for i in range(count):
        low[i], high[i] = 1.0, s[i]
    for q in range(0, out.shape[1], 2):
        a, b, c, d, e, f, g, h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            t, u = low[i], high[i]
            a += t * weight[0, i]
            b += t * weight[1, i]
            c += t * weight[2, i]
            d += t * weight[3, i]
            e += u * weight[0, i]
            f += u * weight[1, i]
            g += u * weight[2, i]
            h += u * weight[3, i]
            t = 2.0 * s[i] * u - t
            low[i], high[i] = t, 2.0 * s[i] * t - u
        out[0, q] += a
        out[1, q] += b
        out[2, q] += c
        out[3, q] += d
        out[0, q + 1] += e
        out[1, q + 1] += f
        out[2, q + 1] += g
        out[3, q + 1] += h


@njit(cache=True, nogil=True)
def _first_from(ascending, bound):
    """Index of the first number not below `bound`."""
    low, high = 0, ascending.size
    while low < high:
        middle = (low + high) // 2
        if ascending[middle] < bound:
            low = middle + 1
        else:
            high = middle
    return low


@njit(cache=True, nogil=True, error_model="numpy")
def gather_rows(first, last, j, at, table, a_re, a_im, depth, gravity, half, out, power):
    """Moments of the rows first <= r < last of a frequency grid: all pairs with j_m +- j_n = r.

    `at` gives the component of a multiple j, or -1; `half` is half the range of K. `power` [2] gains the sums
    of the squared amplitudes of velocity and elevation.
    """
    s, weight = np.empty(CHUNK), np.empty((4, CHUNK))
    low, high = np.empty(CHUNK), np.empty(CHUNK)
    for row in range(first, last):
        count = 0
        for side in range(2):
            sign = 1.0 - 2.0 * side
            if side == 1 and row == 0:
                continue  # D- of a component with itself is 0, its set-down is added elsewhere
            bound = (row + 1) // 2 if side == 0 else row + j[0]
            for m in range(_first_from(j, bound), j.size):
                other = row - j[m] if side == 0 else j[m] - row
                if other < 0:
                    break
                n = at[other]
                if n < 0 or n > m:
                    continue
                k, velocity, surface = _factors(table, m, n, sign, depth, gravity)
                re = a_re[m] * a_re[n] - sign * a_im[m] * a_im[n]
                im = a_im[m] * a_re[n] + sign * a_re[m] * a_im[n]
                s[count] = k / half - 1.0
                weight[0, count], weight[1, count] = velocity * re, velocity * im
                weight[2, count], weight[3, count] = surface * re, surface * im
                energy = re * re + im * im
                power[0] += velocity * velocity * energy
                power[1] += surface * surface * energy
                count += 1
                if count == CHUNK:
                    _raise(count, s, weight, low, high, out[row])
                    count = 0
        _raise(count, s, weight, low, high, out[row])


@njit(cache=True, nogil=True)
def _bell(x, width, shape):
    """Kernel exp(shape (sqrt(1 - (2x/width)^2) - 1)) of the spreading."""
    u = 1.0 - (2.0 * x / width) ** 2
    return math.exp(shape * (math.sqrt(u) - 1.0)) if u > 0.0 else 0.0


@njit(cache=True, nogil=True, fastmath={"contract"})
def _spread(y, s, v_re, v_im, e_re, e_im, first, last, bottom, width, shape, poly, out):
    """Add one pair at place y on the grid to the rows first <= r < last, row r lying at r + bottom."""
    poly[0], poly[1] = 1.0, s
    for q in range(2, poly.size):
        poly[q] = 2.0 * s * poly[q - 1] - poly[q - 2]
    start = math.ceil(y - 0.5 * width) - bottom
    for row in range(max(start, first), min(start + width, last)):
        b = _bell(y - (row + bottom), width, shape)
        for q in range(poly.size):
            t = b * poly[q]
            out[row, 0, q] += t * v_re
            out[row, 1, q] += t * v_im
            out[row, 2, q] += t * e_re
            out[row, 3, q] += t * e_im


@njit(cache=True, nogil=True, error_model="numpy")
def spread_pairs(
    first, last, bottom, spacing, width, shape, table, a_re, a_im, depth, gravity, half, out, power
):
    """Moments of the rows first <= r < last of pairs at any frequency, spread over `width` rows each.

    Row r lies at the frequency (r + bottom) spacing. A pair counts in `power` where its first row lies.
    """
    poly = np.empty(out.shape[2])
    root = math.sqrt(gravity)
    reach = 0.5 * width
    low, high = (first + bottom - reach) * spacing, (last + bottom + reach) * spacing
    for m in range(table.shape[1]):
        for side in range(2):
            sign = 1.0 - 2.0 * side
            for n in range(m + 1 - side):
                total = root * (table[1, m] + sign * table[1, n])
                if total < low or total > high:
                    continue
                k, velocity, surface = _factors(table, m, n, sign, depth, gravity)
                re = a_re[m] * a_re[n] - sign * a_im[m] * a_im[n]
                im = a_im[m] * a_re[n] + sign * a_re[m] * a_im[n]
                y = total / spacing
                _spread(
                    y, k / half - 1.0, velocity * re, velocity * im, surface * re, surface * im,
                    first, last, bottom, width, shape, poly, out,
                )  # fmt: skip
                if first <= math.floor(y) - bottom < last:
                    energy = re * re + im * im
                    power[0] += velocity * velocity * energy
                    power[1] += surface * surface * energy


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread_rows(omega, rows, time, start, weight, out):
    """Spread rows [row, q] at the frequencies `omega`, moved to `time`, over the grid of a window.

    Row r adds to the bins from `start` [row] on, times `weight` [row, bin]. `out` is [bin, part, q], real and
    imaginary.
    """
    size = rows.shape[1]
    turned = np.empty((2, size))
    for r in range(omega.size):
        c, s = math.cos(omega[r] * time), math.sin(omega[r] * time)
        for q in range(size):
            value = rows[r, q]
            turned[0, q] = value.real * c - value.imag * s
            turned[1, q] = value.real * s + value.imag * c
        for b in range(weight.shape[1]):
            factor = weight[r, b]
            for part in range(2):
                _add_scaled(factor, turned[part], out[start[r] + b, part])


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_scaled(factor, x, out):
    """Add factor * x."""
    for i in range(out.size):
        out[i] += factor * x[i]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_three(a, b, c, d, e, f, x, y, z, u, v, w, out):
    """Add six rows, each times its factor; with more of them the compiler would not vectorise."""
    for i in range(out.size):
        out[i] += a * x[i] + b * y[i] + c * z[i] + d * u[i] + e * v[i] + f * w[i]


@njit(cache=True, nogil=True)
def product(factor, table, out):
    """Product of factor [row, q] with the table [part, q, bin], real and imaginary, into out [row, bin].

    The number of q is a multiple of 3. A block of the table stays in the second-level cache; sums run in the
    order of q, whatever the number of threads.
    """
    n_q, n_bins = table.shape[1], table.shape[2]
    for start in range(0, n_bins, BLOCK):
        count = min(BLOCK, n_bins - start)
        re, im = np.empty((n_q, count)), np.empty((n_q, count))
        to_re, to_im = np.empty(count), np.empty(count)
        for q in range(n_q):
            for i in range(count):
                re[q, i], im[q, i] = table[0, q, start + i], table[1, q, start + i]
        for row in range(factor.shape[0]):
            for i in range(count):
                to_re[i], to_im[i] = 0.0, 0.0
            for q in range(0, n_q, 3):
                a, b, d = factor[row, q].real, factor[row, q + 1].real, factor[row, q + 2].real
                e, f, g = factor[row, q].imag, factor[row, q + 1].imag, factor[row, q + 2].imag
                x, y, z, u, v, w = re[q], re[q + 1], re[q + 2], im[q], im[q + 1], im[q + 2]
                _add_three(a, b, d, -e, -f, -g, x, y, z, u, v, w, to_re)
                _add_three(e, f, g, a, b, d, x, y, z, u, v, w, to_im)
            for i in range(count):
                out[row, start + i] = complex(to_re[i], to_im[i])


@njit(cache=True, nogil=True, fastmath={"contract"})
def finish(series, step, divide, rate, n_derived, out):
    """Divide every `step`-th sample of series [point, channel, time] by the window into `out`.

    The last `n_derived` channels are derivatives of the first: (g / w)' = g' / w - (w' / w) g / w.
    """
    plain = out.shape[1] - n_derived
    for p in range(out.shape[0]):
        for c in range(plain):
            for i in range(divide.size):
                out[p, c, i] = series[p, c, i * step] * divide[i]
        for c in range(n_derived):
            for i in range(divide.size):
                out[p, plain + c, i] = series[p, plain + c, i * step] * divide[i] - rate[i] * out[p, c, i]


def warm_up() -> None:
    """Compile the kernels."""
    table, a, power = np.full((6, 2), 0.1), np.ones(2), np.zeros(2)
    table[:, 1] = 0.2
    j, at, out = np.array([1, 2]), np.array([-1, 0, 1]), np.zeros((5, 4, 2))
    gather_rows(0, 5, j, at, table, a, a, 50.0, 9.81, 1.0, out, power)
    spread_pairs(0, 5, -2, 0.1, 2, 5.0, table, a, a, 50.0, 9.81, 1.0, out, power)
    rows = np.zeros((2, 3), dtype=complex)
    spread_rows(a, rows, 0.0, j, np.ones((2, 2)), np.zeros((9, 2, 3)))
    product(np.ones((1, 3), dtype=complex), np.ones((2, 3, 3)), np.empty((1, 3), dtype=complex))
    finish(np.zeros((1, 4, 3)), 1, np.ones(3), np.ones(3), 2, np.zeros((1, 4, 3)))
