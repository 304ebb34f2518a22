"""Frequencies, damping, masses and boundary stiffness of a structure, as `owt eigen` reports them."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.sparse import csc_array

from owt_model.config import Damping
from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.structure import Structure
from owt_structure_node.core.assembly import Assembly, assemble
from owt_structure_node.core.modes import dense_modes, lowest_modes
from owt_structure_node.core.reduction import guyan, reduce
from owt_structure_node.core.response import modal_damping

__all__ = ["eigen_report", "log_decrement"]


def log_decrement(damping_ratio: Float[np.ndarray, " mode"]) -> Float[np.ndarray, " mode"]:
    """Logarithmic decrement 2 pi zeta / sqrt(1 - zeta^2); infinite where nothing oscillates."""
    zeta = np.minimum(damping_ratio, 1.0)
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * np.pi * zeta / np.sqrt(1.0 - zeta**2))


def eigen_report(
    structure: Structure,
    reduction: str | None = None,
    *,
    fixed_interface: bool = False,
    n_modes: int = 20,
    damping: Damping | None = None,
    basis: LoadBasis | None = None,
    jacket_stiffness_factor: float = 1.0,
) -> dict[str, Any]:
    """Solve the eigenvalue problem of a structure and report it as plain data.

    Parameters
    ----------
    structure : Structure
        With or without a tower; without, the transition-piece node is free.
    reduction : str, optional
        Reduction of the jacket; None or ``full`` for the unreduced structure.
    fixed_interface : bool
        Report the modes with the transition piece held as ``frequencies_hz``.
    n_modes : int
        Number of frequencies in each list, fewer where there are fewer.
    damping : Damping, optional
        Rayleigh coefficients; the thesis' reference where omitted.
    basis : LoadBasis, optional
        Load vectors of a reduction with MTA vectors.
    jacket_stiffness_factor : float
        Factor on the stiffness of the members (frequency model: 0.37).

    Returns
    -------
    dict
        ``model``, ``model_hash``, ``reduction``, ``degrees_of_freedom``, ``mass_kg`` (steel and lumped
        bodies), ``masses_kg`` (by kind), ``frequencies_hz``, ``damping_ratio``, ``logdec_percent`` (None
        where overdamped), ``fixed_interface_frequencies_hz``, ``guyan_stiffness``, ``guyan_mass`` (of the
        jacket alone, 6 x 6, at the transition-piece node).

    Raises
    ------
    InputError
        If the structure is a mechanism or the reduction does not fit it.
    ComputationError
        If an eigenvalue problem fails.
    """
    if n_modes < 1:
        raise InputError("n_modes", n_modes, "must be at least 1", "Ask for 20.")
    damping = Damping() if damping is None else damping
    assembly = assemble(build_mesh(structure), jacket_stiffness_factor=jacket_stiffness_factor)
    static = guyan(assembly)
    held = _fixed_interface(assembly, n_modes)
    if fixed_interface:
        omega2, size = held, assembly.internal
    elif reduction is None or reduction == "full":
        size = assembly.mesh.n_dof
        omega2, _ = lowest_modes(assembly.stiffness, assembly.mass, min(n_modes, size))
    else:
        reduced = reduce(assembly, reduction, basis)
        omega2, size = dense_modes(reduced.stiffness, reduced.mass)[0][:n_modes], len(reduced.mass)
    _, zeta = modal_damping(omega2, damping.alpha, damping.beta)
    decrement = 100.0 * log_decrement(zeta)
    return {
        "model": structure.name,
        "model_hash": structure.content_hash,
        "reduction": "fixed interface" if fixed_interface else reduction or "full",
        "degrees_of_freedom": size,
        "mass_kg": assembly.structural_mass_kg,
        "masses_kg": dict(assembly.mass_kg),
        "frequencies_hz": _hertz(omega2),
        "damping_ratio": zeta.tolist(),
        "logdec_percent": [value if np.isfinite(value) else None for value in decrement.tolist()],
        "fixed_interface_frequencies_hz": _hertz(held),
        "guyan_stiffness": static.stiffness.tolist(),
        "guyan_mass": static.mass.tolist(),
    }


def _fixed_interface(assembly: Assembly, n_modes: int) -> Float[np.ndarray, " mode"]:
    n = assembly.internal
    k_ii = csc_array(assembly.jacket_stiffness[:n, :n])
    m_ii = csc_array(assembly.jacket_mass[:n, :n])
    return lowest_modes(k_ii, m_ii, min(n_modes, n))[0]


def _hertz(omega_squared: Float[np.ndarray, " mode"]) -> list[float]:
    frequency: list[float] = (np.sqrt(omega_squared) / (2.0 * np.pi)).tolist()
    return frequency
