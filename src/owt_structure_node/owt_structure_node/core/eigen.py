"""Frequencies, damping, masses and boundary stiffness of a structure, as `owt eigen` reports them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.linalg import eigh
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from owt_model.contracts import LoadBasis
from owt_model.errors import ComputationError, InputError
from owt_model.mesh import build_mesh
from owt_model.structure import Structure, with_weights
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import Assembly, assemble, element_transformation
from owt_structure_node.core.auto import Target, chosen_reduction
from owt_structure_node.core.damping import (
    DampedModes,
    all_vectors,
    check_modes,
    damped_modes,
    modal_damping,
    with_static_responses,
)
from owt_structure_node.core.modes import dense_modes, factorise, hertz, lowest_modes
from owt_structure_node.core.reduction import guyan, reduce
from owt_structure_node.core.static import weights

__all__ = ["eigen_report", "log_decrement"]

#: Share of the stiffness that the weights must take in some motion for a buckling factor to mean anything.
_RELIEF = 1e-9
#: Modes beyond those asked for that dashpots couple to them; the static response stands for the others.
_MORE_MODES = 40
#: What the report calls the modes with the transition piece held.
FIXED_INTERFACE = "fixed interface"

#: omega^2 in rad2/s2, shapes over the free degrees of freedom (those inside, interface held), and size.
Solution = tuple[Float[np.ndarray, " mode"], Float[np.ndarray, "dof mode"], int]


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
    static: bool = False,
    tolerance: float = 0.001,
    load_dt: float = 0.1,
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
        Rayleigh coefficients, ratios of modes, tower-top dashpot; the thesis' reference where omitted.
    basis : LoadBasis, optional
        Load vectors of a reduction with MTA vectors.
    static : bool
        Count the geometric stiffness of the weights, and report what it does.
    tolerance : float
        Estimated error in mean potential energy that the reduction ``auto`` allows.
    load_dt : float
        Time step in s of the loads that `basis` is of.

    Returns
    -------
    dict
        ``model``, ``model_hash``, ``reduction``, ``degrees_of_freedom``, ``mass_kg`` (steel and lumped
        bodies), ``masses_kg`` (by kind), ``frequencies_hz``, ``damped_frequencies_hz``, ``damping_ratio``,
        ``logdec_percent`` (None where overdamped), ``fixed_interface_frequencies_hz``, ``guyan_stiffness``,
        ``guyan_mass`` (of the jacket alone, 6 x 6, at the transition-piece node), ``not_supported`` (what
        an import left out), ``notes`` (on the reduction), with a basis ``pov_share`` (share of the variance
        of the loads of each vector), and with `static` ``static_state``: ``frequencies_hz`` and
        ``change_percent`` (without geometric stiffness, and what it changes), ``buckling_factor`` (of all
        weights; None where nothing buckles), ``weight_n`` (less buoyancy).

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
    if static:
        structure = with_weights(structure)
    assembly = assemble(
        build_mesh(structure),
        interface_held=fixed_interface and structure.free,
    )
    coupled = bool(structure.dashpots) or damping.tower_top is not None
    wanted = n_modes + (_MORE_MODES if coupled else 0)
    held = _lowest(assembly, FIXED_INTERFACE, None, wanted)

    def lowest(of: Assembly) -> Solution:
        loads = basis  # the weights leave nodes and loads as they are
        if basis is not None and of is not assembly:
            loads = replace(basis, model_hash=of.mesh.structure.content_hash)
        return _lowest(of, name, loads, wanted)

    static_model = guyan(assembly)
    name = reduction or "full"
    notes: tuple[str, ...] = ()
    if name != "full" and not fixed_interface:
        target = Target(tolerance, damping, load_dt)
        chosen, notes = chosen_reduction(assembly, name, basis, target)
        name = chosen.name
    if fixed_interface:
        name = FIXED_INTERFACE
    omega2, shapes, size = held if fixed_interface else lowest(assembly)
    decay = _decay(assembly, name, (omega2, shapes), damping, size)
    decrement = 100.0 * log_decrement(decay.ratio[:n_modes])
    omega2 = omega2[:n_modes]
    report: dict[str, Any] = {
        "model": structure.name,
        "model_hash": structure.content_hash,
        "reduction": name,
        "degrees_of_freedom": size,
        "mass_kg": assembly.structural_mass_kg,
        "masses_kg": dict(assembly.mass_kg),
        "frequencies_hz": hertz(omega2),
        "damped_frequencies_hz": decay.frequency_hz[:n_modes].tolist(),
        "damping_ratio": decay.ratio[:n_modes].tolist(),
        "logdec_percent": [value if np.isfinite(value) else None for value in decrement.tolist()],
        "fixed_interface_frequencies_hz": hertz(held[0][:n_modes]),
        "guyan_stiffness": static_model.stiffness.tolist(),
        "guyan_mass": static_model.mass.tolist(),
        "not_supported": list(structure.notes),
        "notes": list(notes),
    }
    if basis is not None:
        report["pov_share"] = (basis.singular_values**2 / max(basis.total_variance, 1e-300)).tolist()
    if static:
        report["static_state"] = _static_effect(assembly, omega2, lowest)
    return report


def _static_effect(
    assembly: Assembly,
    omega2: Float[np.ndarray, " mode"],
    lowest: Callable[[Assembly], Solution],
) -> dict[str, Any]:
    """What the weights do to the frequencies, and how far they are from buckling the structure."""
    structure = assembly.mesh.structure
    elastic = assemble(
        build_mesh(structure.model_copy(update={"static_state": None})),
    )
    without = lowest(elastic)[0][: len(omega2)]
    state = structure.static_state
    assert state is not None  # --static gave it one
    return {
        "frequencies_hz": hertz(without),
        "change_percent": (100.0 * (np.sqrt(omega2 / without) - 1.0)).tolist(),
        "buckling_factor": _buckling_factor(elastic.stiffness, assembly.stiffness),
        "weight_n": -float(
            weights(assembly.mesh, state, element_transformation(assembly.mesh))[1][:, 2].sum()
        ),
    }


def _buckling_factor(elastic: csc_array, loaded: csc_array) -> float | None:
    """Smallest factor f > 0 for which K + f K_geometric is singular, None where there is none."""
    factor = factorise(elastic)
    size = elastic.shape[0]
    relief = csc_array(elastic - loaded)
    if size <= 60:
        share = float(eigh(relief.toarray(), elastic.toarray(), eigvals_only=True)[-1])
    else:
        inverse = LinearOperator((size, size), matvec=factor.solve, dtype=np.float64)
        start = np.random.default_rng(20211).standard_normal(size)
        try:
            found = eigsh(
                relief, k=1, M=elastic, Minv=inverse, which="LA", v0=start, return_eigenvectors=False
            )
        except ArpackError as error:
            raise ComputationError(f"the buckling iteration did not converge ({error})") from None
        share = float(found[0])
    return 1.0 / share if share > _RELIEF else None


def _lowest(of: Assembly, reduction: str, basis: LoadBasis | None, wanted: int) -> Solution:
    """Lowest modes: `wanted`, fewer where there are fewer, all of a reduced model."""
    if reduction == FIXED_INTERFACE:
        n = of.internal
        k_ii, m_ii = csc_array(of.jacket_stiffness[:n, :n]), csc_array(of.jacket_mass[:n, :n])
        return *lowest_modes(k_ii, m_ii, min(wanted, n)), n
    if reduction == "full":
        size = of.mesh.n_dof
        return *lowest_modes(of.stiffness, of.mass, min(wanted, size)), size
    reduced = reduce(of, reduction, basis)
    omega2, modes = dense_modes(reduced.stiffness, reduced.mass)
    return omega2, reduced.shapes @ modes, len(reduced.mass)


def _decay(
    assembly: Assembly,
    reduction: str,
    modes: tuple[Float[np.ndarray, " mode"], Float[np.ndarray, "dof mode"]],
    damping: Damping,
    size: int,
) -> DampedModes:
    """Damped decay of the modes; of those that are not known what dashpots need."""
    omega2, shapes = modes
    check_modes(damping, size)
    damping, n = damping.of_lowest(len(omega2)), len(shapes)
    dashpots = (all_vectors(assembly.mesh, damping) @ assembly.expansion).toarray()[:, :n]
    if reduction in ("full", FIXED_INTERFACE) and len(omega2) < n and dashpots.any():
        held = reduction == FIXED_INTERFACE
        k, m = (
            (assembly.jacket_stiffness, assembly.jacket_mass) if held else (assembly.stiffness, assembly.mass)
        )
        k, m = csc_array(k[:n, :n]), csc_array(m[:n, :n])
        omega2, shapes = with_static_responses(factorise(k), k, m, modes, dashpots[dashpots.any(axis=1)])
    return damped_modes(omega2, modal_damping(omega2, damping, dashpots @ shapes))
