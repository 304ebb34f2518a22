"""General transfer functions of pairs against the printed formulas in 150 digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np

from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.kernels.directional import transfer_pair
from proofs.registry import Proof

__all__ = ["PROOFS"]

G = 9.81


@dataclass(frozen=True)
class Exact:
    """Both transfer functions in 150 digits, as printed: whatever cancels there does not matter."""

    depth: Decimal
    gravity: Decimal

    def tanh(self, x: Decimal) -> Decimal:
        q = (-2 * x).exp()
        return (1 - q) / (1 + q)

    def wavenumber(self, omega: Decimal, start: Decimal) -> Decimal:
        """Newton's method on g k tanh kd = omega^2."""
        k = start
        for _ in range(7):
            t = self.tanh(k * self.depth)
            miss = self.gravity * k * t - omega**2
            k -= miss / (self.gravity * (t + k * self.depth * (1 - t * t)))
        return k

    def cosine(self, angle: Decimal) -> Decimal:
        total, term = Decimal(1), Decimal(1)
        for j in range(2, 200, 2):
            term *= -angle * angle / (j * (j - 1))
            total += term
        return total

    def pair(self, k_m: float, k_n: float, omega_m: float, omega_n: float, angle: float) -> list[Decimal]:
        """D+, D-, B+, B-."""
        w_m, w_n = Decimal(omega_m), Decimal(omega_n)
        k, n = self.wavenumber(w_m, Decimal(k_m)), self.wavenumber(w_n, Decimal(k_n))
        r_m, r_n = w_m**2 / self.gravity, w_n**2 / self.gravity
        s_m, s_n, dot = r_m.sqrt(), r_n.sqrt(), k * n * self.cosine(Decimal(angle))
        d, b = [], []
        for sign in (1, -1):
            length, s = (k * k + n * n + 2 * sign * dot).sqrt(), s_m + sign * s_n
            inner = dot - sign * r_m * r_n
            above = s * (s_n * (k * k - r_m**2) + sign * s_m * (n * n - r_n**2)) + 2 * s * s * inner
            d.append(above / (s * s - length * self.tanh(length * self.depth)))
            b.append(((d[-1] - inner) / (s_m * s_n) + r_m + r_n) / 4)
        return [*d, *b]


def as_printed(k_m, k_n, omega_m, omega_n, angle, depth, gravity):  # type: ignore[no-untyped-def]
    """The transfer functions as printed, in double precision."""
    k, omega = np.array([k_m, k_n]), np.array([omega_m, omega_n])
    r, s = omega**2 / gravity, omega / np.sqrt(gravity)
    found = []
    for sign in (1, -1):
        length = np.sqrt(k[0] ** 2 + k[1] ** 2 + 2 * sign * k[0] * k[1] * np.cos(angle))
        inner, ss = k[0] * k[1] * np.cos(angle) - sign * r[0] * r[1], s[0] + sign * s[1]
        above = (
            ss * (s[1] * (k[0] ** 2 - r[0] ** 2) + sign * s[0] * (k[1] ** 2 - r[1] ** 2)) + 2 * ss**2 * inner
        )
        d = above / (ss**2 - length * np.tanh(length * depth))
        found.append((d, 0.25 * ((d - inner) / (s[0] * s[1]) + r[0] + r[1])))
    return found[0][0], found[1][0], found[0][1], found[1][1]


def digits(pair: Callable[..., tuple[float, ...]]) -> float:
    """Largest relative error of D+-, B+-: deep and shallow water, pairs nearly equal and nearly opposite.

    B+ of opposite waves passes through zero: of B+- relative to (R_m + R_n) / 4 at least.
    """
    worst = 0.0
    for depth in (3.0, 50.0, 300.0):
        for omega_n, ratio in ((0.5, 1.001), (0.5, 1.7), (1.5, 1.001), (1.5, 1.3)):
            omega = omega_n * np.array([ratio, 1.0])
            k = wavenumber(omega, water_depth=depth, gravity=G)
            for angle in (0.0, 1e-3, 0.7, np.pi - 1e-3):
                with localcontext() as context:
                    context.prec = 150
                    exact = Exact(Decimal(depth), Decimal(G)).pair(*k.tolist(), *omega.tolist(), angle)
                got = pair(*k.tolist(), *omega.tolist(), angle, depth, G)
                least = float((omega**2).sum()) / (4.0 * G)
                for a, e, scale in zip(got, map(float, exact), (0.0, 0.0, least, least), strict=False):
                    worst = max(worst, abs(a - e) / max(abs(e), scale))
    return worst


PROOFS = (
    Proof(
        key="directional-digits",
        claim="transfer functions lose no digits: deep, shallow, nearly equal, nearly opposite",
        against="the printed formulas in 150 digits; frequencies 0.1 % and directions 1e-3 rad apart",
        error=digits,
        right=transfer_pair,
        wrong={"as printed, in double precision": as_printed},
        allowed=1e-11,
        reason="wave numbers 0.1 % apart, each known to 2e-16, and a denominator of their difference",
    ),
)
