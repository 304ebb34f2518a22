"""Direct sums over components of any frequency: exact, and slow for many components.

Per point the second order is a quadratic form of the first-order phasors
V_m = A_m exp(i (omega_m t - k_m x)): the sum terms are Re(V^T K V), the difference terms
Re(V^T K conj(V)), with real matrices K. The symmetry of K gives their time derivatives:
2 Re(dV^T K V) and 2 Re(dV^T K conj(V)).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_model.parallel import slices
from owt_wave_node.core.field import Field, Kinematics, Place, Prepared, Profile, Series
from owt_wave_node.core.profile import first_order_profile, second_order_level
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.transfer import pair_tables, set_down

__all__ = ["DirectField"]

#: Numbers per work array of a block of times.
BLOCK = 2**20

Matrix = Float[np.ndarray, "m m"]


class DirectField:
    """Any components, summed directly."""

    def __init__(self, waves: Waves) -> None:
        self.waves = waves
        self.n_axes, self.n = 2, waves.n
        self.wavenumber = k = waves.wavenumber
        self._sum, self._difference = k[:, None] + k[None, :], np.abs(k[:, None] - k[None, :])
        if waves.order == 2:
            tables = pair_tables(waves)
            self._velocity_plus, self._surface_plus = (
                self._symmetric(t) for t in (tables.velocity_sum, tables.surface_sum)
            )
            self._velocity_minus, self._surface_minus = (
                self._mirrored(t) for t in (tables.velocity_difference, tables.surface_difference)
            )

    def _symmetric(self, packed: Float[np.ndarray, " pair"]) -> Matrix:
        """Unpack the table of the sums; a pair and its mirror share the doubled factor."""
        size = self.waves.omega.size
        out = np.zeros((size, size))
        out[np.tril_indices(size)] = packed
        return np.asarray(0.5 * (out + out.T))

    def _mirrored(self, packed: Float[np.ndarray, " pair"]) -> Matrix:
        """Unpack the table of the differences, zero on the diagonal."""
        size = self.waves.omega.size
        out = np.zeros((size, size))
        m, n = np.tril_indices(size, -1)
        out[m, n] = packed[m * (m - 1) // 2 + m - n - 1]
        return np.asarray(0.5 * (out + out.T))

    def _phasors(self) -> list[tuple[slice, Complex[np.ndarray, "time m"]]]:
        """Blocks of times and exp(i omega t) there."""
        waves = self.waves
        step = max(1, BLOCK // waves.omega.size)
        return [
            (rows, np.exp(1j * np.outer(np.arange(rows.start, rows.stop) * waves.dt, waves.omega)))
            for rows in slices(waves.n, step)
        ]

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m [eq. 4.6, 4.18]."""
        waves, x = self.waves, place[:, 0]
        first, second = np.zeros((x.size, waves.n)), np.zeros((x.size, waves.n))
        here = waves.amplitude * np.exp(-1j * x[:, None] * waves.wavenumber)
        for rows, phasor in self._phasors():
            first[:, rows] = (phasor @ here.T).real.T
            if waves.order == 2:
                for p in range(x.size):
                    v = phasor * here[p]
                    second[p, rows] = (
                        np.einsum("tm,tm->t", v, _real_product(v, self._surface_plus))
                        + np.einsum("tm,tm->t", v, _real_product(v.conj(), self._surface_minus))
                    ).real + set_down(waves)
        return first, second

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics [eq. 4.8-4.11], stretched above still water."""
        waves = self.waves
        profile = first_order_profile(
            waves.wavenumber, place[:, 2].copy(), water_depth=waves.depth, stretching=waves.stretching
        )
        return self.shaped(place, *profile)

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors instead of those of a level."""
        waves, x = self.waves, place[:, 0]
        speed = waves.gravity * waves.wavenumber / waves.omega * waves.amplitude
        here = speed * np.exp(-1j * x[:, None] * waves.wavenumber)
        u, w = here * horizontal, 1j * here * vertical
        rate = 1j * waves.omega
        coefficients = np.stack([u, w, rate * u, rate * w], axis=1)  # [point, 4, m]
        out = np.empty((x.size, 4, waves.n))
        for rows, phasor in self._phasors():
            out[:, :, rows] = (coefficients @ phasor.T).real
        return out

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics [eq. 4.20-4.23]; zero at order 1."""
        waves, x, z = self.waves, place[:, 0], place[:, 2].copy()
        out = np.zeros((x.size, 4, waves.n))
        if waves.order == 1:
            return out
        here = waves.amplitude * np.exp(-1j * x[:, None] * waves.wavenumber)
        level = second_order_level(z, waves.stretching)
        sign = np.sign(waves.omega[None, :] - waves.omega[:, None])  # of K^T: n multiplies V, m conj(V)
        for p in range(x.size):
            up, down = (np.exp(k * level[p]) for k in (self._sum, self._difference))
            up_image, down_image = (
                np.exp(-k * (level[p] + 2.0 * waves.depth)) for k in (self._sum, self._difference)
            )
            plus_u, plus_w = self._velocity_plus * (up + up_image), self._velocity_plus * (up - up_image)
            minus_u = self._velocity_minus * (down + down_image)
            minus_w = sign * self._velocity_minus * (down - down_image)
            for rows, phasor in self._phasors():
                v = phasor * here[p]
                conjugate = v.conj()
                u = v * (_real_product(v, plus_u) + _real_product(conjugate, minus_u))
                w = 1j * v * (_real_product(v, plus_w) + _real_product(conjugate, minus_w))
                out[p, 0, rows], out[p, 1, rows] = u.sum(axis=1).real, w.sum(axis=1).real
                out[p, 2, rows] = -2.0 * (u.imag @ waves.omega)
                out[p, 3, rows] = -2.0 * (w.imag @ waves.omega)
        return out

    def window(self, start: int, count: int) -> Field:
        """Return the field over `count` samples from `start`: a shift of the phases."""
        waves = self.waves
        turned = waves.amplitude * np.exp(1j * waves.omega * (start * waves.dt))
        return DirectField(replace(waves, amplitude=turned, n=count))

    def prepare(self, place: Place) -> Prepared:
        """Remember the points."""
        return _DirectPrepared(self, place)


class _DirectPrepared:
    def __init__(self, field: DirectField, place: Place) -> None:
        self._field, self._place = field, place

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        place = self._place[index]
        total = self._field.first(place)
        total += self._field.second(place)
        return total


def _real_product(v: Complex[np.ndarray, "t m"], matrix: Matrix) -> Complex[np.ndarray, "t m"]:
    """Product of a complex and a real matrix without making the latter complex."""
    return np.asarray((v.real @ matrix) + 1j * (v.imag @ matrix))
