"""Inverse Fourier transforms of few coefficients to many samples, two real signals at a time.

A record of n samples is split into P interleaved ones of B samples, t = P q + p:

    x[P q + p] = sum_j (Z_j exp(2 pi i j p / n)) exp(2 pi i j q / B)

so that P transforms of length B are left, whose inputs are the coefficients times a table; frequencies that
agree modulo B are added. The transforms advance together, p fastest in memory: every step works on
consecutive numbers with one factor, and the last one writes samples in their order. Z_j combines two real
signals, one of which comes out in the real and one in the imaginary part.

A plan is the tuple (radices, turn_re, turn_im, factor_re, factor_im) of a
:class:`~owt_wave_node.core.transform.Transform`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from owt_wave_node.kernels.simd import LANES, butterfly, twist, twist_add

__all__ = ["to_time", "warm_up"]


@njit(cache=True, nogil=True, inline="always")
def _stage(radix, groups, s, to, to_group, to_step, w, w_group, f_re, f_im, x_re, x_im, y_re, y_im):
    """One step of a self-sorting transform [Stockham]: groups of s numbers, radix of them from far apart.

    Group i is put at to + i to_group, its parts to_step apart, times the factors at w + i w_group.
    """
    step = groups * s
    for i in range(groups):
        at, into, factor = i * s, to + i * to_group, w + i * w_group
        if radix == 4:
            for q in range(0, s, LANES):
                butterfly(4, x_re, x_im, at + q, step, f_re, f_im, factor, y_re, y_im, into + q, to_step)
        elif radix == 5:
            for q in range(0, s, LANES):
                butterfly(5, x_re, x_im, at + q, step, f_re, f_im, factor, y_re, y_im, into + q, to_step)
        elif radix == 3:
            for q in range(0, s, LANES):
                butterfly(3, x_re, x_im, at + q, step, f_re, f_im, factor, y_re, y_im, into + q, to_step)
        else:
            for q in range(0, s, LANES):
                butterfly(2, x_re, x_im, at + q, step, f_re, f_im, factor, y_re, y_im, into + q, to_step)


@njit(cache=True, nogil=True, inline="always")
def _load(t_re, t_im, start, lanes, length, a_re, a_im, b_re, b_im, x_re, x_im):
    """Coefficients j >= 0 (a) and -j (b) times the table, into x [length, lanes]."""
    n_j = a_re.size
    alone = min(n_j - 1, (length - 1) // 2)  # up to here no two frequencies share a place
    for q in range(0, lanes, LANES):
        twist(t_re[0], t_im[0], start + q, a_re[0], a_im[0], a_re[0], a_im[0], x_re, x_im, q, q)
    for j in range(1, alone + 1):
        for q in range(0, lanes, LANES):
            twist(
                t_re[j], t_im[j], start + q, a_re[j], a_im[j], b_re[j], b_im[j], x_re, x_im,
                j * lanes + q, (length - j) * lanes + q,
            )  # fmt: skip
    for i in range((alone + 1) * lanes, (length - alone) * lanes):
        x_re[i], x_im[i] = 0.0, 0.0
    for j in range(alone + 1, n_j):
        to = j % length
        back = (length - to) % length
        for q in range(0, lanes, LANES):
            # One after the other: the two places may be the same.
            twist_add(
                t_re[j], t_im[j], start + q, a_re[j], a_im[j], b_re[j], b_im[j], x_re, x_im,
                to * lanes + q, back * lanes + q,
            )  # fmt: skip


@njit(cache=True, nogil=True, inline="always")
def _pack(first, second, first_rate, second_rate, a_re, a_im, b_re, b_im):
    """Combine the coefficients of two real signals Re sum Y_j exp(i j w t), or of their time derivatives.

    A rate is the spacing w of a derivative, and 0 where the signal itself is meant.
    """
    for j in range(a_re.size):
        u, v = first[j], second[j]
        if first_rate > 0.0:
            u = complex(-first_rate * j * u.imag, first_rate * j * u.real)
        if second_rate > 0.0:
            v = complex(-second_rate * j * v.imag, second_rate * j * v.real)
        a_re[j], a_im[j] = 0.5 * (u.real - v.imag), 0.5 * (u.imag + v.real)
        b_re[j], b_im[j] = 0.5 * (u.real + v.imag), 0.5 * (v.real - u.imag)
    a_re[0], a_im[0] = a_re[0] + b_re[0], a_im[0] + b_im[0]


@njit(cache=True, nogil=True, inline="always")
def _transform(plan, lanes, a, work, y_re, y_im):
    """Both signals, in `lanes` of the interleaved records at a time so that the work arrays stay in cache."""
    radices, t_re, t_im, f_re, f_im = plan
    split = t_re.shape[1]
    length = y_re.size // split
    for start in range(0, split, lanes):
        _load(t_re, t_im, start, lanes, length, a[0], a[1], a[2], a[3], work[0], work[1])
        x_re, x_im, other_re, other_im = work[0], work[1], work[2], work[3]
        m, s, w = length, lanes, 0
        for i in range(radices.size):
            radix = radices[i]
            m //= radix
            last = i == radices.size - 1
            # The last step puts its `lanes` among every `split` samples; its factors are 1.
            groups, width = (s // lanes, lanes) if last else (m, s)
            y_r, y_i = (y_re, y_im) if last else (other_re, other_im)
            _stage(
                radix, groups, width, start if last else 0, split if last else radix * s,
                groups * split if last else s, w, 0 if last else radix - 1, f_re, f_im, x_re, x_im, y_r, y_i,
            )  # fmt: skip
            w += m * (radix - 1)
            s *= radix
            x_re, x_im, other_re, other_im = other_re, other_im, x_re, x_im


@njit(cache=True, nogil=True)
def to_time(spectra, index, spacing, lanes, plan, out):
    """Fill out [some, channel, time] with the signals Re sum_j Y_j exp(i j spacing t) of the rows `index`.

    `spectra` [row, signal, bin] holds Y. Channels beyond the signals are their time derivatives, in the same
    order; the number of channels is even.
    """
    size, n_j = spectra.shape[1], spectra.shape[2]
    a = np.empty((4, n_j))
    work = np.empty((4, out.shape[2] // plan[1].shape[1] * lanes))
    for p in range(index.size):
        source = spectra[index[p]]
        for c in range(0, out.shape[1], 2):
            first, second = (0.0 if c < size else spacing), (0.0 if c + 1 < size else spacing)
            _pack(source[c % size], source[(c + 1) % size], first, second, a[0], a[1], a[2], a[3])
            _transform(plan, lanes, a, work, out[p, c], out[p, c + 1])


def warm_up() -> None:
    """Compile the kernels."""
    one = np.ones((3, 4))
    plan = (np.array([2]), one, one, np.ones(4), np.ones(4))
    to_time(np.zeros((1, 2, 3), dtype=complex), np.array([0]), 0.1, 4, plan, np.empty((1, 4, 8)))
