"""Time integration methods as one-step recurrences of an oscillator of unit mass (thesis appendix F).

Every linear one-step method, and the exact solution under a load that is linear in a step, is

    s_1 = T s_0 + p f_0 + q f_1,   s = (x, v, a)

with T, p, q fixed by the method, the step h, the damping c and the stiffness k of the oscillator
x'' + c x' + k x = f. The coefficients are data; the loop over time is shared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.linalg import expm

from owt_model.errors import InputError

__all__ = ["METHODS", "Recurrence", "exact", "generalised_alpha", "newmark", "recurrence"]

Modes = Float[np.ndarray, " mode"]


@dataclass(frozen=True)
class Recurrence:
    """Coefficients of s_1 = transition s_0 + old f_0 + new f_1 for the state (x, v, a) of every mode."""

    transition: Float[np.ndarray, "3 3 mode"]
    old: Float[np.ndarray, "3 mode"]
    new: Float[np.ndarray, "3 mode"]

    def spectral_radius(self) -> Modes:
        """Largest modulus of the eigenvalues of the transition: above 1 the method blows up."""
        return np.asarray(np.abs(np.linalg.eigvals(self.transition.transpose(2, 0, 1))).max(axis=1))


def _one_step(
    stiffness: Modes,
    damping: Modes,
    h: float,
    *,
    gamma: float,
    beta: float,
    alpha_m: float = 0.0,
    alpha_f: float = 0.0,
) -> Recurrence:
    """Newmark's interpolation with the balance of forces taken between the two ends of the step.

    (1 - alpha_m) a_1 + alpha_m a_0 + (1 - alpha_f) (c v_1 + k x_1 - f_1) + alpha_f (c v_0 + k x_0 - f_0) = 0
    """
    c, k, one, zero = damping, stiffness, np.ones_like(damping), np.zeros_like(damping)
    # Free predictions of x and v at the end of the step, as rows acting on (x, v, a).
    x_free = np.array([one, h * one, h * h * (0.5 - beta) * one])
    v_free = np.array([zero, one, h * (1.0 - gamma) * one])
    weight = 1.0 - alpha_f
    effective = (1.0 - alpha_m) + weight * (gamma * h * c + beta * h * h * k)
    state = np.array([alpha_f * k, alpha_f * c, alpha_m * one])
    a_row = -(state + weight * (c * v_free + k * x_free)) / effective
    a_old, a_new = alpha_f / effective, weight / effective
    transition = np.array([x_free + beta * h * h * a_row, v_free + gamma * h * a_row, a_row])
    share = np.array([beta * h * h, gamma * h, 1.0])[:, None]
    return Recurrence(transition, share * a_old, share * a_new)


def newmark(stiffness: Modes, damping: Modes, h: float, *, gamma: float, beta: float) -> Recurrence:
    """Newmark's method [eq. F.3-F.10].

    Raises
    ------
    InputError
        If the step exceeds the stability limit of the highest mode.
    """
    limit = newmark_limit(stiffness, damping, gamma=gamma, beta=beta)
    if h > limit * (1.0 + 1e-9):
        raise InputError(
            "structure.dt_s",
            h,
            f"exceeds {limit:.3g} s, the stability limit of this integrator for the highest mode "
            f"({np.sqrt(stiffness.max()) / (2.0 * np.pi):.3g} Hz)",
            "Use a shorter step or an implicit integrator.",
        )
    return _one_step(stiffness, damping, h, gamma=gamma, beta=beta)


def newmark_limit(stiffness: Modes, damping: Modes, *, gamma: float, beta: float) -> float:
    """Largest stable step in s of Newmark's method; infinity where it is unconditionally stable.

    With r = gamma - 1/2 and s = gamma/2 - beta, omega h <= [zeta r + sqrt(s + zeta^2 r^2)] / s; without
    damping and with beta = 0 that is sqrt(2 / gamma) [F.2].
    """
    if 2.0 * beta >= gamma >= 0.5:
        return np.inf
    omega = np.sqrt(stiffness)
    excess = 0.5 * damping / omega * (gamma - 0.5)
    bound = 0.5 * gamma - beta
    return float(((excess + np.sqrt(bound + excess**2)) / bound / omega).min())


def generalised_alpha(stiffness: Modes, damping: Modes, h: float, *, rho_infinity: float) -> Recurrence:
    """Chung and Hulbert's generalised-alpha method: second order, damps what the step does not resolve.

    Parameters
    ----------
    rho_infinity : float
        Factor per step on the amplitude of infinitely fast modes, 0 to 1.
    """
    if not 0.0 <= rho_infinity <= 1.0:
        raise InputError("rho_infinity", rho_infinity, "must lie between 0 and 1", "Use for example 0.8.")
    alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0)
    alpha_f = rho_infinity / (rho_infinity + 1.0)
    return _one_step(
        stiffness,
        damping,
        h,
        gamma=0.5 - alpha_m + alpha_f,
        beta=0.25 * (1.0 - alpha_m + alpha_f) ** 2,
        alpha_m=alpha_m,
        alpha_f=alpha_f,
    )


def exact(stiffness: Modes, damping: Modes, h: float) -> Recurrence:
    """The exact solution for a load that is linear in the step, at any step.

    The matrix exponential of the oscillator driven by a ramp gives x and v at the end of the step; the
    acceleration follows from the equation of motion.
    """
    modes = stiffness.size
    # State (x, v h, f_0 h^2, (f_1 - f_0) h^2) over a unit step: entries of size one for slow modes.
    matrix = np.zeros((modes, 4, 4))
    matrix[:, 0, 1] = 1.0
    matrix[:, 1, 0], matrix[:, 1, 1], matrix[:, 1, 2] = -stiffness * h * h, -damping * h, 1.0
    matrix[:, 2, 3] = 1.0
    e = expm(matrix).transpose(1, 2, 0)
    transition, old, new = np.zeros((3, 3, modes)), np.zeros((3, modes)), np.zeros((3, modes))
    scale = (1.0, h)
    for i in range(2):
        transition[i, 0], transition[i, 1] = e[i, 0] / scale[i], e[i, 1] * h / scale[i]
        new[i] = e[i, 3] * h * h / scale[i]
        old[i] = e[i, 2] * h * h / scale[i] - new[i]
    transition[2] = -stiffness * transition[0] - damping * transition[1]
    old[2] = -stiffness * old[0] - damping * old[1]
    new[2] = 1.0 - stiffness * new[0] - damping * new[1]
    return Recurrence(transition, old, new)


#: Integrators by the name that a case gives.
METHODS: dict[str, Callable[[Modes, Modes, float], Recurrence]] = {
    "newmark": lambda k, c, h: newmark(k, c, h, gamma=0.5, beta=0.25),
    "newmark-explicit": lambda k, c, h: newmark(k, c, h, gamma=0.5, beta=0.0),
    "generalised-alpha": lambda k, c, h: generalised_alpha(k, c, h, rho_infinity=0.8),
    "exact": exact,
}


def recurrence(method: str, stiffness: Modes, damping: Modes, h: float) -> Recurrence:
    """Coefficients of a named method.

    Raises
    ------
    InputError
        If the method is not known, or the step exceeds its stability limit.
    """
    if method not in METHODS:
        raise InputError(
            "structure.integrator", method, "is not known", f"Choose one of {', '.join(METHODS)}."
        )
    return METHODS[method](stiffness, damping, h)
