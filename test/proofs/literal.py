"""The second-order equations as they stand: both sums over all pairs, numpy, no symmetry used.

Independent of the code but for the components. Switches give what the thesis prints where that is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from owt_wave_node.core.sea import Waves

__all__ = ["Literal"]


@dataclass(frozen=True)
class Literal:
    """Equations 4.6 to 4.24 for waves of one direction, at the first `n_times` samples.

    Attributes
    ----------
    printed_b : bool
        B+- of eq. 4.19 as printed, with the signs of R_m R_n exchanged.
    unsigned : bool
        u2 of eq. 4.24 as printed, with |k_m - k_n| instead of k_m - k_n.
    no_d_minus : bool
        D- = 0 for all pairs instead of equal ones only.
    """

    waves: Waves
    n_times: int
    printed_b: bool = False
    unsigned: bool = False
    no_d_minus: bool = False

    def _phasors(self, x: float) -> np.ndarray:
        """A exp(i (omega t - k x)) [time, component]."""
        w = self.waves
        t = w.dt * np.arange(self.n_times)
        return w.amplitude * np.exp(1j * (np.outer(t, w.omega) - w.wavenumber * x))

    def _pairs(self, sign: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """k of the pair, D [eq. 4.13, 4.14] and B [eq. 4.19], [m, n]."""
        w = self.waves
        k, r = w.wavenumber, w.omega**2 / w.gravity
        s, c = np.sqrt(r), (k / np.cosh(np.minimum(k * w.depth, 300.0))) ** 2  # k^2 - R^2
        k_m, k_n, s_m, s_n, r_m, r_n = k[:, None], k[None], s[:, None], s[None], r[:, None], r[None]
        kk = np.abs(k_m + sign * k_n)
        ss = s_m + sign * s_n
        above = ss * (s_n * c[:, None] + sign * s_m * c[None])
        above = above + 2.0 * ss**2 * (k_m * k_n - sign * r_m * r_n)
        below = ss**2 - kk * np.tanh(kk * w.depth)
        equal = (sign < 0) & np.eye(k.size, dtype=bool)
        d = np.where(equal, 0.0, above / np.where(equal, 1.0, below))
        if sign < 0 and self.no_d_minus:
            d = 0.0 * d
        product = k_m * k_n - (-sign if self.printed_b else sign) * r_m * r_n
        return kk, d, 0.25 * ((d - product) / np.sqrt(r_m * r_n) + r_m + r_n)

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First- and second-order elevation [point, time]."""
        plus, minus = self._pairs(1)[2], self._pairs(-1)[2]
        first, second = [], []
        for x in place[:, 0]:
            v = self._phasors(x)
            first.append(v.real.sum(axis=1))
            second.append(((v @ plus * v) + (v @ minus * v.conj())).real.sum(axis=1))
        return np.array(first), np.array(second)

    def first(self, place: np.ndarray) -> np.ndarray:
        """u, w, du, dw of the first order at or below still water [point, 4, time]."""
        w, out = self.waves, []
        k, d = w.wavenumber, w.depth
        for x, _, z in place:
            v = self._phasors(x) * (w.gravity * k / w.omega)
            u, up = (
                v * (np.cosh(k * (z + d)) / np.cosh(k * d)),
                1j * v * (np.sinh(k * (z + d)) / np.cosh(k * d)),
            )
            rate = 1j * w.omega
            out.append([q.real.sum(axis=1) for q in (u, up, rate * u, rate * up)])
        return np.array(out)

    def second(self, place: np.ndarray) -> np.ndarray:
        """u, w, du, dw of the second order at or below still water [point, 4, time]."""
        w = self.waves
        omega_m, omega_n = w.omega[:, None], w.omega[None]
        b = 0.25 * w.gravity**2 / (omega_m * omega_n)
        out = np.zeros((len(place), 4, self.n_times))
        for sign in (1, -1):
            kk, d, _ = self._pairs(sign)
            rate = omega_m + sign * omega_n
            potential = b * np.where(rate == 0.0, 0.0, d / np.where(rate == 0.0, 1.0, rate))
            signed = kk if self.unsigned else w.wavenumber[:, None] + sign * w.wavenumber[None]
            for p, (x, _, z) in enumerate(place):
                v = self._phasors(x)
                other = v if sign > 0 else v.conj()
                # cosh K(z+d) / cosh Kd and sinh K(z+d) / cosh Kd without overflow
                up, down = np.exp(kk * z), np.exp(-kk * (z + 2.0 * w.depth))
                scale = potential / (1.0 + np.exp(-2.0 * kk * w.depth))
                u, vertical = scale * signed * (up + down), 1j * scale * kk * (up - down)
                for i, factor in enumerate((u, vertical, 1j * rate * u, 1j * rate * vertical)):
                    out[p, i] += np.einsum("tm,mn,tn->t", v, factor, other, optimize=True).real
        return out
