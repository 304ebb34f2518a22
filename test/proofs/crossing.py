"""Seas of waves in all directions, and both orders of them written out as double sums over all pairs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.sea import Waves

__all__ = ["ANGLE", "MULTIPLE", "BothSums", "crossing", "off_grid", "sea", "seas"]

G = 9.81
STEPS = 300


def sea(
    multiple: list[float],
    direction_deg: list[float],
    *,
    depth: float = 50.0,
    order: int = 2,
    stretching: str = "taylor",
) -> Waves:
    """Components at multiples of the spacing of 300 samples of 0.2 s, of 1 m to 0.1 m."""
    m = np.array(multiple, dtype=float)
    omega = 2.0 * np.pi / (STEPS * 0.2) * m
    return Waves(
        omega=omega,
        wavenumber=wavenumber(omega, water_depth=depth, gravity=G),
        angle=np.deg2rad(direction_deg),
        amplitude=4.0 / m * np.exp(1j * np.sqrt(np.arange(m.size)) * 5.0),
        depth=depth,
        gravity=G,
        order=order,
        stretching=stretching,
        dt=0.2,
        n=STEPS,
    )


MULTIPLE = [4, 5, 6, 7, 7, 8, 9, 9, 11, 13, 18, 25]
ANGLE = [-40, 12, 0, 25, -155, 60, 33, 33 + 180, -9, 140, -75, 5]


def seas() -> list[Waves]:
    """Twelve waves of all directions, pairs of one frequency, one opposite; and twelve of one direction."""
    between = [m + 0.37 * np.sin(7.0 * i) for i, m in enumerate(MULTIPLE)]
    return [
        *(sea(MULTIPLE, ANGLE, depth=depth) for depth in (50.0, 20.0, 9.0, 400.0)),
        sea(between, ANGLE),
        sea(MULTIPLE, [20.0] * len(MULTIPLE)),
    ]


def crossing() -> Waves:
    return seas()[0]


def off_grid() -> Waves:
    return seas()[4]


@dataclass(frozen=True)
class BothSums:
    """The equations of Sharma and Dean written out over all pairs, numpy, no symmetry used.

    Attributes
    ----------
    scalar_norm : bool
        | |k_m| - |k_n| | and |k_m| + |k_n| in place of the lengths of the vectors.
    no_dot : bool
        k_m k_n in place of the dot product of the vectors.
    exchanged : bool
        Signs of R_m R_n exchanged between the sum and the difference.
    coming_from : bool
        Directions that the waves come from.
    """

    waves: Waves
    scalar_norm: bool = False
    no_dot: bool = False
    exchanged: bool = False
    coming_from: bool = False

    @property
    def vectors(self) -> np.ndarray:
        """Wave-number vectors [component, 2]."""
        w = self.waves
        turn = -1.0 if self.coming_from else 1.0
        return turn * w.wavenumber[:, None] * np.column_stack([np.cos(w.angle), np.sin(w.angle)])

    def phasors(self, place: np.ndarray) -> np.ndarray:
        """A exp(i (omega t - k.x)) [time, component]."""
        w = self.waves
        t = w.dt * np.arange(w.n)
        return np.asarray(w.amplitude * np.exp(1j * (np.outer(t, w.omega) - self.vectors @ place[:2])))

    def pairs(self, sign: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Vector [m, n, 2] and length of k_m +- k_n, D and B, [m, n]."""
        w, vector = self.waves, self.vectors
        k, r, s = w.wavenumber, w.omega**2 / w.gravity, w.omega / np.sqrt(w.gravity)
        sech = (k / np.cosh(np.minimum(k * w.depth, 300.0))) ** 2  # k^2 - R^2
        both = vector[:, None] + sign * vector[None]
        length = np.sqrt((both**2).sum(axis=2))
        if self.scalar_norm:
            length = np.abs(k[:, None] + sign * k[None])
        dot = np.outer(k, k) if self.no_dot else vector @ vector.T
        inner = dot - (-sign if self.exchanged else sign) * np.outer(r, r)
        ss = s[:, None] + sign * s[None]
        above = ss * (s[None] * sech[:, None] + sign * s[:, None] * sech[None]) + 2.0 * ss**2 * inner
        below = ss**2 - length * np.tanh(length * w.depth)
        flat = ss == 0.0
        d = np.where(flat, 0.0, above / np.where(flat, 1.0, below))
        b = 0.25 * ((d - inner) / np.outer(s, s) + r[:, None] + r[None])
        return both, length, d, b

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First- and second-order elevation [point, time]."""
        plus, minus = self.pairs(1)[3], self.pairs(-1)[3]
        v = [self.phasors(p) for p in place]
        return (
            np.array([p.real.sum(axis=1) for p in v]),
            np.array([((p @ plus * p) + (p @ minus * p.conj())).real.sum(axis=1) for p in v]),
        )

    def first(self, place: np.ndarray) -> np.ndarray:
        """u, v, w and their rates of the first order, Taylor expanded above still water [point, 6, time]."""
        w, out = self.waves, []
        k, d = w.wavenumber, w.depth
        unit = self.vectors / k[:, None]
        for p in place:
            z, above = min(p[2], 0.0), max(p[2], 0.0)
            up, down, scale = np.exp(k * z), np.exp(-k * (z + 2 * d)), 1.0 / (1.0 + np.exp(-2.0 * k * d))
            c, s = (up + down) * scale, (up - down) * scale
            v = self.phasors(p) * (w.gravity * k / w.omega)
            level = v * (c + above * k * s)
            channels = [level * unit[:, 0], level * unit[:, 1], 1j * v * (s + above * k * c)]
            out.append([q.real.sum(axis=1) for q in (*channels, *(1j * w.omega * q for q in channels))])
        return np.array(out)

    def second(self, place: np.ndarray) -> np.ndarray:
        """u, v, w and their rates of the second order, of still water above it [point, 6, time]."""
        w = self.waves
        b = 0.25 * w.gravity**2 / np.outer(w.omega, w.omega)
        out = np.zeros((len(place), 6, w.n))
        for sign in (1, -1):
            vector, length, d, _ = self.pairs(sign)
            rate = w.omega[:, None] + sign * w.omega[None]
            potential = b * np.where(rate == 0.0, 0.0, d / np.where(rate == 0.0, 1.0, rate))
            potential = potential / (1.0 + np.exp(-2.0 * length * w.depth))
            for p, here in enumerate(place):
                v = self.phasors(here)
                other, z = (v if sign > 0 else v.conj()), min(here[2], 0.0)
                up, down = np.exp(length * z), np.exp(-length * (z + 2.0 * w.depth))
                level = potential * (up + down)
                channels = [
                    level * vector[..., 0],
                    level * vector[..., 1],
                    1j * potential * length * (up - down),
                ]
                for i, factor in enumerate((*channels, *(1j * rate * q for q in channels))):
                    out[p, i] += np.einsum("tm,mn,tn->t", v, factor, other, optimize=True).real
        return out
