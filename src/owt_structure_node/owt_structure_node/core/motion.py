"""Motion of the modal equations (thesis appendix F): oscillators, their state, the driver over blocks.

Rayleigh damping is proportional, so that the assembled reduced model splits exactly into single oscillators;
a method on the coupled system and on each mode gives the same numbers, and a scalar recurrence
(:mod:`~owt_structure_node.core.integrators`) replaces the matrix solve. Dashpots couple the oscillators in a
few directions (:mod:`~owt_structure_node.core.damping`): their force at the end of a step comes from one
small system, factorised once, whatever the method. The exact recurrence is exact but for that force, which is
linear in a step there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_structure_node.core.integrators import Recurrence, recurrence
from owt_structure_node.kernels.recurrence import advance

__all__ = ["Motion", "MotionState", "Oscillators", "integrate", "integrate_from", "static_state"]


@dataclass(frozen=True)
class Oscillators:
    """Oscillators of unit modal mass: x'' + (diag(damping) + G G') x' + diag(stiffness) x = f.

    Attributes
    ----------
    stiffness : float array [mode]
        Squares of the undamped angular frequencies in rad2/s2.
    damping : float array [mode]
        2 zeta omega in 1/s.
    step : float
        Integration step in s.
    substeps : int
        Integration steps per load step.
    method : str
        Name of the integrator, one of :data:`~owt_structure_node.core.integrators.METHODS`.
    coupling : float array [mode, direction], optional
        G of the dashpots in s^-1/2, where dashpots couple the oscillators.
    """

    stiffness: Float[np.ndarray, " mode"]
    damping: Float[np.ndarray, " mode"]
    step: float
    substeps: int
    method: str = "newmark"
    coupling: Float[np.ndarray, "mode direction"] | None = None

    def __post_init__(self) -> None:
        if not (self.step > 0.0 and self.substeps >= 1):
            raise InputError(
                "structure.dt_s", self.step, "must be > 0 s and divide the load step", "Use 0.02."
            )

    @cached_property
    def recurrence(self) -> Recurrence:
        """What the method does in one step."""
        return recurrence(self.method, self.stiffness, self.damping, self.step)

    @cached_property
    def directions(self) -> Float[np.ndarray, "mode direction"]:
        """G, without columns where nothing couples the oscillators."""
        if self.coupling is None:
            return np.zeros((len(self.stiffness), 0))
        return np.ascontiguousarray(self.coupling)

    @cached_property
    def feedback(self) -> Float[np.ndarray, "direction direction"]:
        """Inverse of I + G' diag(q) G, q the velocity that a unit load at the end of a step causes there."""
        g = self.directions
        return np.linalg.inv(np.eye(g.shape[1]) + g.T @ (self.recurrence.new[1][:, None] * g))


@dataclass(frozen=True)
class MotionState:
    """Where the oscillators are after a block: all that the next block needs.

    Attributes
    ----------
    displacement, velocity, acceleration : float arrays [mode]
    load : float array [mode]
        Modal load at that time.
    dashpot : float array [mode], optional
        Modal force of the dashpots then; from the velocity where left out.
    """

    displacement: Float[np.ndarray, " mode"]
    velocity: Float[np.ndarray, " mode"]
    acceleration: Float[np.ndarray, " mode"]
    load: Float[np.ndarray, " mode"]
    dashpot: Float[np.ndarray, " mode"] | None = None


@dataclass(frozen=True)
class Motion:
    """Modal displacements, velocities and accelerations [sample, mode]."""

    displacement: Float[np.ndarray, "sample mode"]
    velocity: Float[np.ndarray, "sample mode"]
    acceleration: Float[np.ndarray, "sample mode"]


def static_state(system: Oscillators, load: Float[np.ndarray, " mode"]) -> MotionState:
    """Return the state of rest under a constant modal load: a start without transient."""
    zero = np.zeros_like(load)
    return MotionState(load / system.stiffness, zero, zero.copy(), load.copy())


def integrate(
    system: Oscillators, state: MotionState, load: Float[np.ndarray, "sample mode"]
) -> tuple[MotionState, Motion]:
    """Integrate over load samples that follow the one in `state`; the load is linear in between.

    Parameters
    ----------
    system : Oscillators
        What to integrate.
    state : MotionState
        State at the time of the load sample before the first of `load`.
    load : float array [sample, mode]
        Modal loads at the load step, ``system.substeps`` integration steps apart.

    Returns
    -------
    MotionState, Motion
        State at the last load sample; motion at every integration step after `state`, which is
        ``substeps`` rows per load sample. Cutting a record into blocks does not change a bit of it.
    """
    last, motion = integrate_from(system, state, load)
    return last, Motion(motion.displacement[1:], motion.velocity[1:], motion.acceleration[1:])


def integrate_from(
    system: Oscillators, state: MotionState, load: Float[np.ndarray, "sample mode"]
) -> tuple[MotionState, Motion]:
    """Like :func:`integrate`; row 0 of the motion is `state`."""
    samples = np.concatenate([state.load[None], load])
    rows = 1 + system.substeps * len(load)
    x, v, a = (np.empty((rows, load.shape[1])) for _ in range(3))
    x[0], v[0], a[0] = state.displacement, state.velocity, state.acceleration
    rule, g = system.recurrence, system.directions
    carried = g @ (g.T @ state.velocity) if state.dashpot is None else state.dashpot
    force = carried.copy()
    by_direction = np.ascontiguousarray(g.T)
    advance(
        rule.transition, rule.old, rule.new, system.substeps, samples,
        g, by_direction, system.feedback, force, x, v, a,
    )  # fmt: skip
    last = MotionState(x[-1].copy(), v[-1].copy(), a[-1].copy(), samples[-1].copy(), force)
    return last, Motion(x, v, a)
