"""Exact derivatives of a wave field, and the equations of motion of a perturbation expansion.

The first order is linear in the complex amplitudes A, the second a quadratic form of them. A shift in space
or time only turns A, so that a derivative needs no small step: with A' = i omega A or -i k A it is q1(A') for
the first order and [q2(A + s A') - q2(A - s A')] / (2 s) for the second, at any s, to round-off. And q2(i A)
has the sum terms with the other sign: that separates sum and difference terms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from owt_wave_node.core.sea import Waves

__all__ = ["Flow", "Make", "chebyshev", "parts"]


class Flow(Protocol):
    """What is asked of a field here; places are [point, 3] in wave axes."""

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...
    def first(self, place: np.ndarray) -> np.ndarray: ...
    def second(self, place: np.ndarray) -> np.ndarray: ...


#: A field from its components.
Make = Callable[[Waves], Flow]


def parts(make: Make, waves: Waves, ask: Callable[[Flow], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Sum terms and difference terms of what `ask` takes from the second order."""
    one, other = (ask(make(replace(waves, amplitude=c * waves.amplitude))) for c in (1.0, 1j))
    return 0.5 * (one - other), 0.5 * (one + other)


def chebyshev(low: float, high: float, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of an interval and the matrix that differentiates there, to spectral accuracy."""
    j = np.arange(order + 1)
    x, weight = np.cos(np.pi * j / order), np.where((j == 0) | (j == order), 2.0, 1.0) * (-1.0) ** j
    gap = x[:, None] - x[None, :] + np.eye(order + 1)
    matrix = np.outer(weight, 1.0 / weight) / gap
    matrix -= np.diag(matrix.sum(axis=1))
    return low + 0.5 * (high - low) * (x + 1.0), matrix * 2.0 / (high - low)


@dataclass(frozen=True)
class Local:
    """Both orders at points, [point, ...], and their derivatives along t, x or y of the waves."""

    make: Make
    waves: Waves
    place: np.ndarray

    def _of(self, factor: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """eta1, eta2, first and second [point, axis and rate, time] for amplitudes times `factor`."""
        flow = self.make(replace(self.waves, amplitude=self.waves.amplitude * factor))
        motion = [self._in_space(part(self.place)) for part in (flow.first, flow.second)]
        return *flow.elevation(self.place), *motion

    def _in_space(self, motion: np.ndarray) -> np.ndarray:
        """[point, (u, v, w, du, dv, dw), time]; v is zero where the field is plane."""
        if motion.shape[1] == 6:
            return motion
        full = np.zeros((motion.shape[0], 6, motion.shape[2]))
        full[:, [0, 2, 3, 5]] = motion
        return full

    @cached_property
    def here(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """eta1, eta2, first, second."""
        return self._of(1.0)

    def along(self, axis: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The derivatives of :attr:`here` along "t", "x" or "y"."""
        k, angle = self.waves.wavenumber, self.waves.angle
        rate = {"t": 1j * self.waves.omega, "x": -1j * k * np.cos(angle), "y": -1j * k * np.sin(angle)}[axis]
        scale = 1.0 / np.abs(rate).max() if np.any(rate) else 1.0
        eta1, _, first, _ = self._of(rate)
        _, up_eta, _, up = self._of(1.0 + scale * rate)
        _, down_eta, _, down = self._of(1.0 - scale * rate)
        return eta1, (up_eta - down_eta) / (2.0 * scale), first, (up - down) / (2.0 * scale)


def at(*points: tuple[float, float, float]) -> np.ndarray:
    """Places [point, 3]."""
    return np.array(points, dtype=float)


def residual(terms: list[np.ndarray]) -> float:
    """Largest sum of the terms over the largest of them."""
    return float(np.abs(np.sum(terms, axis=0)).max() / max(np.abs(term).max() for term in terms))


def kinematic(make: Make, waves: Waves, x: float = 7.3, y: float = 0.0) -> float:
    """Residual of eta2_t + u1 eta1_x + v1 eta1_y = w2 + eta1 w1_z at still water, w1_z = -u1_x - v1_y."""
    local = Local(make, waves, at((x, y, 0.0)))
    eta1, _, first, second = local.here
    _, eta2_t, _, _ = local.along("t")
    eta1_x, _, first_x, _ = local.along("x")
    eta1_y, _, first_y, _ = local.along("y")
    return residual(
        [
            eta2_t,
            first[:, 0] * eta1_x,
            first[:, 1] * eta1_y,
            -second[:, 2],
            eta1 * (first_x[:, 0] + first_y[:, 1]),
        ]
    )


def dynamic(make: Make, waves: Waves, x: float = 7.3, y: float = 0.0) -> float:
    """Residual of the gradient of phi2_t + g eta2 + eta1 phi1_zt + |grad phi1|^2 / 2 = const at still water.

    phi_tx is the local acceleration along x: no potential is needed.
    """
    local = Local(make, waves, at((x, y, 0.0)))
    eta1, _, first, second = local.here
    worst = 0.0
    for axis, name in enumerate("xy"):
        if name == "y" and not np.any(waves.angle):
            continue
        eta1_s, eta2_s, first_s, _ = local.along(name)
        worst = max(
            worst,
            residual(
                [
                    second[:, 3 + axis],
                    waves.gravity * eta2_s,
                    eta1_s * first[:, 5] + eta1 * first_s[:, 5],
                    *(first[:, i] * first_s[:, i] for i in range(3)),
                ]
            ),
        )
    return worst


def potential_flow(make: Make, waves: Waves, *, order: int, low: float, high: float) -> float:
    """Divergence and all three components of the vorticity between two levels, over the largest gradient."""
    z, by_z = chebyshev(low, high, 20)
    local = Local(make, waves, np.column_stack([np.full_like(z, 2.0), np.full_like(z, -1.0), z]))
    part = 1 + order
    q, q_x, q_y = local.here[part], local.along("x")[part], local.along("y")[part]
    q_z = np.einsum("ij,jct->ict", by_z, q)
    checks = [[q_x[:, 0], q_y[:, 1], q_z[:, 2]], [q_z[:, 0], -q_x[:, 2]]]
    if np.any(waves.angle):
        checks += [[q_z[:, 1], -q_y[:, 2]], [q_y[:, 0], -q_x[:, 1]]]
    scale = max(np.abs(term).max() for terms in checks for term in terms)
    return max(float(np.abs(np.sum(terms, axis=0)).max() / scale) for terms in checks)


def rates(make: Make, waves: Waves, change: Callable[[np.ndarray, Local, int], np.ndarray]) -> float:
    """Error of the accelerations, as `change` makes them, as time derivatives of the velocities."""
    local = Local(make, waves, at((0.0, 3.0, -1.0), (3.7, 0.0, -27.0), (-8.0, 0.0, 1.5)))
    along = local.along("t")
    worst = 0.0
    for part in (2, 3):
        got, expected = change(local.here[part][:, 3:], local, part), along[part][:, :3]
        for axis in (0, 2):
            scale = np.abs(expected[:, axis]).max()
            worst = max(worst, float(np.abs(got[:, axis] - expected[:, axis]).max() / scale))
    return worst
