"""Response of a superelement under a tower to the loads of its record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_model.errors import ComputationError, InputError
from owt_model.superelement import INTERFACE, Superelement
from owt_structure_node.core.damping import ModalDamping, roots
from owt_structure_node.core.modes import dense_modes
from owt_structure_node.core.motion import Motion, MotionState, Oscillators, integrate, static_state
from owt_structure_node.core.superelement import PROPORTIONAL, Attached, Matrix

__all__ = ["Decoupled", "InterfaceResponse", "decouple", "respond"]

#: Load samples that are integrated at a time.
_BLOCK = 500


@dataclass(frozen=True)
class Decoupled:
    """Undamped modes of a system, and its damping in them.

    Attributes
    ----------
    omega_squared : float array [mode]
        In rad2/s2, ascending.
    shapes : float array [coordinate, mode]
        Mass-normalised.
    damping : ModalDamping
        Diagonal where it is proportional, to the digits of a file; else as a whole.
    """

    omega_squared: Float[np.ndarray, " mode"]
    shapes: Float[np.ndarray, "coordinate mode"]
    damping: ModalDamping


def decouple(stiffness: Matrix, mass: Matrix, damping: Matrix) -> Decoupled:
    """Split a system into oscillators, coupled by damping that is not proportional.

    Raises
    ------
    InputError
        If the damping is negative in some direction: it would drive the system.
    ComputationError
        If stiffness or mass is not positive definite.
    """
    omega2, shapes = dense_modes(stiffness, mass)
    modal = shapes.T @ damping @ shapes
    modal = 0.5 * (modal + modal.T)
    lowest, highest = np.linalg.eigvalsh(modal)[[0, -1]]
    if lowest < -PROPORTIONAL * max(float(highest), 0.0) or highest < 0.0:
        raise InputError(
            "damping matrix",
            float(lowest),
            "is its lowest eigenvalue in the modes, in 1/s; none may be negative",
            "Check signs and units of the damping.",
        )
    size = len(modal)
    if _coupling(modal) <= PROPORTIONAL:
        return Decoupled(omega2, shapes, ModalDamping(modal.diagonal().copy(), np.zeros((size, 0))))
    return Decoupled(omega2, shapes, ModalDamping(np.zeros(size), np.ascontiguousarray(roots(modal).T)))


def _coupling(modal: Matrix) -> float:
    """Largest |c_ij| / sqrt(c_ii c_jj) off the diagonal."""
    own = np.sqrt(np.maximum(modal.diagonal(), 0.0))
    bound = np.outer(own, own)
    away = np.abs(modal - np.diag(modal.diagonal()))
    share = np.divide(away, bound, out=np.where(away > 0.0, np.inf, 0.0), where=bound > 0.0)
    return float(share.max())


@dataclass(frozen=True)
class InterfaceResponse:
    """Motion at the interface and the tower top, and the force between them and below.

    Attributes
    ----------
    dt : float
        Time step in s.
    interface, top : Motion
        Of the six degrees of freedom [sample, 6] in m, rad and their rates.
    force : float array [sample, 6]
        Force in N and moment in N m of the substructure on what stands on it, the transition piece's body
        included: f_C of ExtPtfm.
    """

    dt: float
    interface: Motion
    top: Motion
    force: Float[np.ndarray, "sample 6"]


def respond(
    element: Superelement, attached: Attached, *, step: float | None = None, method: str = "newmark"
) -> InterfaceResponse:
    """Motion under the loads of the superelement, from rest under their first sample.

    Parameters
    ----------
    element, attached
        A superelement, and itself with an upper part.
    step : float, optional
        Integration step in s, a whole part of that of the loads, which are linear in between; theirs by
        default.
    method : str
        Name of the integrator, one of :data:`~owt_structure_node.core.integrators.METHODS`.

    Raises
    ------
    InputError
        If the damping is negative somewhere, or the step does not divide that of the loads.
    ComputationError
        If the response is not finite.
    """
    substeps = _substeps(element.dt, element.dt if step is None else step)
    modes = decouple(attached.stiffness, attached.mass, attached.damping)
    damping = modes.damping
    system = Oscillators(
        modes.omega_squared, damping.rate, element.dt / substeps, substeps, method, damping.dashpots
    )
    projection = modes.shapes[: element.n_dof]
    above = modes.shapes[attached.upper]
    maps = [matrix[:INTERFACE] @ above for matrix in _upper_matrices(attached)]
    rows = substeps * (len(element.loads) - 1) + 1
    out = [np.empty((rows, INTERFACE)) for _ in range(7)]
    state = static_state(system, element.loads[0] @ projection)
    at_rest = Motion(state.displacement[None], state.velocity[None], state.acceleration[None])
    _store(out, slice(0, 1), at_rest, modes.shapes, attached.top, maps)
    for first in range(1, len(element.loads), _BLOCK):
        load = element.loads[first : first + _BLOCK] @ projection
        state, motion = integrate(system, state, load)
        start = substeps * (first - 1) + 1
        _store(out, slice(start, start + substeps * len(load)), motion, modes.shapes, attached.top, maps)
    _check_finite(state)
    return InterfaceResponse(system.step, Motion(*out[:3]), Motion(*out[3:6]), out[6])


def _upper_matrices(attached: Attached) -> tuple[Matrix, Matrix, Matrix]:
    return attached.upper_stiffness, attached.upper_damping, attached.upper_mass


def _store(
    out: list[Float[np.ndarray, "row 6"]],
    rows: slice,
    motion: Motion,
    shapes: Float[np.ndarray, "coordinate mode"],
    top: Int[np.ndarray, " 6"],
    maps: list[Float[np.ndarray, "6 mode"]],
) -> None:
    """Write what is kept of a block of modal motion into rows of `out`."""
    parts = (motion.displacement, motion.velocity, motion.acceleration)
    for i, part in enumerate(parts):
        out[i][rows] = part @ shapes[:INTERFACE].T
        out[3 + i][rows] = part @ shapes[top].T
    out[6][rows] = sum(part @ matrix.T for part, matrix in zip(parts, maps, strict=True))


def _substeps(load_step: float, step: float) -> int:
    """Integration steps per load step."""
    ratio = load_step / step if step > 0.0 else 0.0
    if not (ratio > 0.5 and abs(ratio - round(ratio)) <= 1e-6 * ratio):
        raise InputError(
            "dt",
            step,
            f"must be > 0 s and divide the step of the loads, {load_step:g} s",
            "For example 0.02.",
        )
    return round(ratio)


def _check_finite(state: MotionState) -> None:
    if not (np.isfinite(state.displacement).all() and np.isfinite(state.acceleration).all()):
        raise ComputationError("response: not finite; the loads are too large to integrate")
