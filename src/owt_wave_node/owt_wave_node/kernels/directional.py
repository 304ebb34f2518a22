"""Second order of components that travel in different directions (Sharma and Dean 1981).

With R = k tanh k d, s = sqrt(R), theta the angle between two components and K+- = |k_m +- k_n| as vectors,

    D+- = {(s_m +- s_n) [s_n (k_m^2 - R_m^2) +- s_m (k_n^2 - R_n^2)] + 2 (s_m +- s_n)^2 (k_m.k_n -+ R_m R_n)}
          / {(s_m +- s_n)^2 - K+- tanh K+- d}
    B+- = 1/4 {[D+- - (k_m.k_n -+ R_m R_n)] / (s_m s_n) + R_m + R_n}

written so that nothing cancels and nothing overflows at any depth or angle: with q = exp(-2 k d) and
e = 2 q / (1 + q) = 1 - tanh k d,

    k^2 - R^2         = 4 k^2 q / (1 + q)^2
    k_m.k_n - R_m R_n = k_m k_n (e_m + e_n - e_m e_n - 2 sin^2 theta/2)
    k_m.k_n + R_m R_n = k_m k_n (2 cos^2 theta/2 - e_m - e_n + e_m e_n)
    K-^2 = (k_m - k_n)^2 + 4 k_m k_n sin^2 theta/2,   K+^2 = (k_m - k_n)^2 + 4 k_m k_n cos^2 theta/2

Both denominators vanish only where two components coincide. At equal frequencies the difference potential is
not forced, and D- / (omega_m - omega_n) tends to zero: the flow has no steady part, the elevation has.

Pairs (m, n) are packed row by row: sums n = 0..m at m (m + 1) / 2 + n, differences n = 0..m - 1 at
m (m - 1) / 2 + n.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["elevation", "level_velocity", "tables", "transfer_pair", "warm_up"]

#: A pair this much weaker than the strongest at its level cannot change the sum in double precision.
NEGLIGIBLE = 1e-20
#: Exponent below which exp(-x) counts as zero.
UNDERFLOW = 700.0
#: Of the exponential: 1 / ln 2, 1.5 2^52, ln 2 in two parts, and 1 / n! from n = 12 to 0.
LOG2_E, SHIFT = 1.0 / math.log(2.0), 1.5 * 2.0**52
LN2_HIGH, LN2_LOW = float.fromhex("0x1.62e42fee00000p-1"), float.fromhex("0x1.a39ef35793c76p-33")
TAYLOR = tuple(1.0 / math.factorial(n) for n in range(12, -1, -1))


@njit(cache=True, nogil=True)
def transfer_pair(k_m, k_n, omega_m, omega_n, angle, depth, gravity):
    """D+, D- in rad2/m2, B+, B- in 1/m and K+, K- in rad/m of two components `angle` rad apart.

    D- of two components of one frequency is 0; of one component with itself this is a choice of the Bernoulli
    constant, of different directions it is the limit.
    """
    s_m, s_n = omega_m / math.sqrt(gravity), omega_n / math.sqrt(gravity)
    q_m, q_n = math.exp(-2.0 * k_m * depth), math.exp(-2.0 * k_n * depth)
    e_m, e_n = 2.0 * q_m / (1.0 + q_m), 2.0 * q_n / (1.0 + q_n)
    c_m, c_n = 4.0 * k_m * k_m * q_m / (1.0 + q_m) ** 2, 4.0 * k_n * k_n * q_n / (1.0 + q_n) ** 2
    sine, cosine = math.sin(0.5 * angle) ** 2, math.cos(0.5 * angle) ** 2
    e, product = e_m + e_n - e_m * e_n, k_m * k_n
    inner_plus, inner_minus = product * (e - 2.0 * sine), product * (2.0 * cosine - e)
    wave_plus = math.sqrt((k_m - k_n) ** 2 + 4.0 * product * cosine)
    wave_minus = math.sqrt((k_m - k_n) ** 2 + 4.0 * product * sine)
    s = s_m + s_n
    above = s * (s_n * c_m + s_m * c_n) + 2.0 * s * s * inner_plus
    d_plus = above / (s * s - wave_plus * math.tanh(wave_plus * depth))
    s, d_minus = s_m - s_n, 0.0
    if s != 0.0:
        above = s * (s_n * c_m - s_m * c_n) + 2.0 * s * s * inner_minus
        d_minus = above / (s * s - wave_minus * math.tanh(wave_minus * depth))
    # R_m + R_n - (k_m.k_n + R_m R_n) / (s_m s_n), written so that nothing cancels in deep water.
    b_plus = 0.25 * ((d_plus - inner_plus) / (s_m * s_n) + s_m * s_m + s_n * s_n)
    b_minus = 0.25 * ((d_minus - inner_plus) / (s_m * s_n) + s * s)
    return d_plus, d_minus, b_plus, b_minus, wave_plus, wave_minus


@njit(cache=True, nogil=True)
def tables(
    first, last, k, omega, angle, depth, gravity,
    velocity_sum, velocity_difference, surface_sum, surface_difference,
):  # fmt: skip
    """Fill rows first <= m < last of the packed tables, mirrored pairs included.

    The velocity tables hold, for amplitudes of 1 m, the factor before
    (vector k_m +- k_n) [exp(K z) + exp(-K (z + 2 d))] in the horizontal velocity.
    """
    for m in range(first, last):
        sums, differences = m * (m + 1) // 2, m * (m - 1) // 2
        for n in range(m + 1):
            d_plus, d_minus, b_plus, b_minus, wave_plus, wave_minus = transfer_pair(
                k[m], k[n], omega[m], omega[n], angle[m] - angle[n], depth, gravity
            )
            twice = 1.0 if m == n else 2.0
            common = 0.25 * twice * gravity * gravity / (omega[m] * omega[n])
            value = common * d_plus / (omega[m] + omega[n]) / (1.0 + math.exp(-2.0 * wave_plus * depth))
            velocity_sum[sums + n] = value if abs(value) > 1e-200 else 0.0
            surface_sum[sums + n] = twice * b_plus
            if n < m:
                value = 0.0
                if d_minus != 0.0:
                    value = common * d_minus / (omega[m] - omega[n])
                    value /= 1.0 + math.exp(-2.0 * wave_minus * depth)
                velocity_difference[differences + n] = value
                surface_difference[differences + n] = twice * b_minus


@njit(cache=True, nogil=True)
def _slots(m, count, sign, listed, j, slots, at):
    """Slots of the pairs (m, n), n < count, at which their frequency omega_m + sign omega_n is kept."""
    start = m * (m + 1) // 2 if sign > 0 else m * (m - 1) // 2
    for n in range(count):
        at[n] = slots[start + n] if listed else j[m] + sign * j[n]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _exponential(x, turns, powers, out):
    """exp(x) for -700 <= x <= 700, in loops that the compiler turns into vector instructions.

    x = k ln 2 + r: adding 1.5 2^52 leaves the integer k in the last bits, from where it is moved to those of
    an exponent; exp(r) is Taylor's polynomial. `turns` and `powers` are work arrays, of float and int.
    """
    bits, scale = turns.view(np.int64), powers.view(np.float64)
    for n in range(x.size):
        turns[n] = x[n] * LOG2_E + SHIFT
    for n in range(x.size):
        powers[n] = (bits[n] + 1023) << 52
    for n in range(x.size):
        k = turns[n] - SHIFT
        r = (x[n] - k * LN2_HIGH) - k * LN2_LOW
        p = 1.0 / 6227020800.0
        for c in TAYLOR:
            p = p * r + c
        out[n] = p * scale[n]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _row(table, m, count, sign, k_x, k_y, height, z, depth, strongest, work, powers, rows):
    """Factors of u, v and -i w of the pairs (m, n), n < count, at level z, into rows [3, n].

    `height` are the moduli of the amplitudes; `strongest` is the largest velocity among the pairs so far.
    Returns the range of n outside which pairs are negligible, and the new `strongest`.
    """
    start = m * (m + 1) // 2 if sign > 0 else m * (m - 1) // 2
    factor, wave, turns = table[start : start + count], work[0, :count], work[1, :count]
    exponent, here, image = work[2, :count], work[3, :count], work[4, :count]
    row_x, row_y, row_w = rows[0, :count], rows[1, :count], rows[2, :count]
    for n in range(count):
        row_x[n], row_y[n] = k_x[m] + sign * k_x[n], k_y[m] + sign * k_y[n]
    for n in range(count):
        wave[n] = math.sqrt(row_x[n] * row_x[n] + row_y[n] * row_y[n])
        exponent[n] = max(wave[n] * z, -UNDERFLOW)
    _exponential(exponent, turns, powers[:count], here)
    for n in range(count):
        exponent[n] = max(-2.0 * wave[n] * (z + depth), -UNDERFLOW)
    _exponential(exponent, turns, powers[:count], image)
    for n in range(count):
        value = factor[n] * here[n]
        both = value * (1.0 + image[n])
        row_x[n], row_y[n], row_w[n] = row_x[n] * both, row_y[n] * both, wave[n] * (value - value * image[n])
    for n in range(count):
        strongest = max(strongest, _largest(rows, n) * height[m] * height[n])
    floor = strongest * NEGLIGIBLE
    low, high = 0, count
    while high > 0 and _largest(rows, high - 1) * height[m] * height[high - 1] <= floor:
        high -= 1
    while low < high and _largest(rows, low) * height[m] * height[low] <= floor:
        low += 1
    return low, high, strongest


@njit(cache=True, nogil=True)
def _largest(rows, n):
    """Bound on the horizontal factor; the vertical one is smaller."""
    return abs(rows[0, n]) + abs(rows[1, n])


@njit(cache=True, nogil=True, fastmath={"contract"})
def _product(re, im, sign, a, b, out_re, out_im):
    """(a + i b) (re + i sign im)."""
    for n in range(re.size):
        out_re[n], out_im[n] = a * re[n] - sign * b * im[n], sign * a * im[n] + b * re[n]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add(row, re, im, out_re, out_im):
    """Add row * (re + i im) to `out`, all of one length."""
    for n in range(row.size):
        out_re[n] += row[n] * re[n]
        out_im[n] += row[n] * im[n]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _scatter(rows, re, im, low, high, at, out):
    """Add rows * (re + i im), low <= n < high, to the entries `at` of out [channel, re and im, slot]."""
    for n in range(low, high):
        to = at[n]
        for c in range(3):
            out[c, 0, to] += rows[c, n] * re[n]
            out[c, 1, to] += rows[c, n] * im[n]


@njit(cache=True, nogil=True)
def _phases(x, y, k_x, k_y, amplitude, re, im):
    """A exp(-i k.x) at points; [point, component]."""
    for p in range(x.size):
        for m in range(k_x.size):
            phase = k_x[m] * x[p] + k_y[m] * y[p]
            value = amplitude[m] * complex(math.cos(phase), -math.sin(phase))
            re[p, m], im[p, m] = value.real, value.imag


@njit(cache=True, nogil=True)
def level_velocity(x, y, z, k_x, k_y, amplitude, depth, tables, listed, j, slots, out):
    """Add the second-order velocities in m/s of points at one level z to out [point, 3, slot].

    `x`, `y` [point], `z` and `depth` in m; `k_x`, `k_y` [component] in rad/m; `amplitude` [component],
    complex, in m. `tables` and `slots` are pairs (sums, differences); tables in 1/s, as :func:`tables` fills
    them. A pair is kept at the slot listed there, or where `listed` is false at j_m +- j_n.
    """
    points, size, n_slots = x.size, k_x.size, out.shape[2]
    re, im = np.empty((points, size)), np.empty((points, size))
    _phases(x, y, k_x, k_y, amplitude, re, im)
    height = np.abs(amplitude)
    rows, at = np.empty((3, size)), np.empty(size, dtype=np.int64)
    work, powers = np.empty((5, size)), np.empty(size, dtype=np.int64)
    p_re, p_im = np.empty(size), np.empty(size)
    # Where j are consecutive both j_m + j_n and size - (j_m - j_n) run with n, and rows add without scatter.
    dense = not listed and j[0] > 0
    for m in range(1, size):
        dense = dense and j[m] == j[m - 1] + 1
    total, back = np.zeros((points, 3, 2, n_slots)), np.zeros((points, 3, 2, size + 1 if dense else 0))
    strongest = 0.0
    for m in range(size):
        for sign, table, slot in ((1, tables[0], slots[0]), (-1, tables[1], slots[1])):
            count = m + 1 if sign > 0 else m
            low, high, strongest = _row(
                table, m, count, sign, k_x, k_y, height, z, depth, strongest, work, powers, rows
            )
            if not dense:
                _slots(m, count, sign, listed, j, slot, at)
            for p in range(points):
                _product(
                    re[p, low:high], im[p, low:high], sign, re[p, m], im[p, m], p_re[low:high], p_im[low:high]
                )
                if not dense:
                    _scatter(rows, p_re, p_im, low, high, at, total[p])
                    continue
                to, start = (total[p], j[m] + j[0]) if sign > 0 else (back[p], size - m)
                for c in range(3):
                    _add(
                        rows[c, low:high], p_re[low:high], p_im[low:high],
                        to[c, 0, start + low : start + high], to[c, 1, start + low : start + high],
                    )  # fmt: skip
    for p in range(points):
        for c in range(3):
            turn = 1.0 if c < 2 else 1j  # w is a quarter of a period away
            for i in range(n_slots):
                out[p, c, i] += turn * complex(total[p, c, 0, i], total[p, c, 1, i])
            for i in range(1, back.shape[3]):
                out[p, c, size - i] += turn * complex(back[p, c, 0, i], back[p, c, 1, i])


@njit(cache=True, nogil=True)
def elevation(x, y, k_x, k_y, amplitude, set_down, tables, listed, j, slots, out):
    """Add the second-order elevation in m, mean `set_down` in m included, to out [point, slot].

    `tables` are those of the surface, in 1/m; all else as in :func:`level_velocity`.
    """
    points, size = x.size, k_x.size
    re, im = np.empty((points, size)), np.empty((points, size))
    _phases(x, y, k_x, k_y, amplitude, re, im)
    at = np.empty(size, dtype=np.int64)
    for m in range(size):
        for sign, table, slot in ((1, tables[0], slots[0]), (-1, tables[1], slots[1])):
            count = m + 1 if sign > 0 else m
            start = m * (m + 1) // 2 if sign > 0 else m * (m - 1) // 2
            _slots(m, count, sign, listed, j, slot, at)
            for p in range(points):
                here = complex(re[p, m], im[p, m])
                for n in range(count):
                    out[p, at[n]] += table[start + n] * here * complex(re[p, n], sign * im[p, n])
    for p in range(points):
        out[p, 0] += set_down


def warm_up() -> None:
    """Compile the kernels."""
    k, omega, x = np.array([0.04, 0.05]), np.array([0.6, 0.7]), np.zeros(1)
    amplitude, j, slots = np.ones(2, dtype=complex), np.array([1, 2]), np.zeros(3, dtype=np.int32)
    factors, angle = (np.ones(3), np.ones(1)), np.zeros(2)
    tables(0, 2, k, omega, angle, 50.0, 9.81, *factors, np.empty(3), np.empty(1))
    velocity, height = np.zeros((1, 3, 5), dtype=complex), np.zeros((1, 5), dtype=complex)
    level_velocity(x, x, -1.0, k, k, amplitude, 50.0, factors, False, j, (slots, slots), velocity)
    elevation(x, x, k, k, amplitude, -0.1, factors, False, j, (slots, slots), height)
