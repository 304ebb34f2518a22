"""Reduced models of the jacket: Guyan, Craig-Bampton, and Craig-Bampton augmented with load vectors.

The boundary is the transition-piece node; the tower stays unreduced (thesis 3.5 to 3.7). With internal
degrees of freedom i and boundary b::

    u_i = Psi u_b + Phi eta + Phi_MTA zeta          [eq. 3.54; the basis 3.55]

``CB00`` is Guyan's static reduction, ``CBnn`` keeps nn fixed-interface modes Phi, ``CBnnMmm`` adds mm
modal truncation augmentation vectors, ``Mmm`` has those only; :mod:`owt_model.reduction_name` lists all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.sparse import csc_array

from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.reduction_name import ReductionName, parse_reduction
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import DOF_NAME, Assembly
from owt_structure_node.core.damping import all_vectors
from owt_structure_node.core.modes import Factor, factorise, lowest_modes
from owt_structure_node.core.mta import Augmentation, augment
from owt_structure_node.core.sim import StaticImprovement

__all__ = [
    "GuyanModel",
    "Interior",
    "Reduction",
    "guyan",
    "interface_loads",
    "load_vectors",
    "reduce",
    "solve_interior",
]


@dataclass(frozen=True)
class Reduction:
    """A basis of the assembled structure and its matrices.

    Attributes
    ----------
    shapes : float array [dof, coordinate]
        u = shapes q. Coordinates: transition piece (6), fixed-interface modes, augmentation vectors,
        tower (6 per node).
    stiffness, mass : float arrays [coordinate, coordinate]
        shapes' K shapes and shapes' M shapes.
    fixed_interface : float array [mode]
        omega^2 of the fixed-interface modes kept, in rad2/s2.
    pseudo : float array [vector]
        sigma^2 of the augmentation vectors (eq. 3.42), in rad2/s2.
    notes : tuple of str
        What the basis has less than was asked for, one line each.
    improvement : StaticImprovement, optional
        Static response of what the basis leaves out, where asked for.
    """

    name: str
    shapes: Float[np.ndarray, "dof coordinate"]
    stiffness: Float[np.ndarray, "coordinate coordinate"]
    mass: Float[np.ndarray, "coordinate coordinate"]
    coordinate_name: tuple[str, ...]
    fixed_interface: Float[np.ndarray, " mode"]
    pseudo: Float[np.ndarray, " vector"]
    notes: tuple[str, ...] = ()
    improvement: StaticImprovement | None = None


@dataclass(frozen=True)
class Interior:
    """What bases of one structure share: static reduction and lowest fixed-interface modes."""

    static: GuyanModel
    omega_squared: Float[np.ndarray, " mode"]
    modes: Float[np.ndarray, "internal mode"]


@dataclass(frozen=True)
class GuyanModel:
    """Static reduction of the jacket to its boundary [eq. 3.19-3.22].

    Attributes
    ----------
    constraint : float array [internal, 6]
        Static constraint modes Psi.
    stiffness, mass : float arrays [6, 6]
        At the transition-piece node; its own mass is not included.
    factor : Factor
        Factorised internal stiffness K_ii.
    """

    constraint: Float[np.ndarray, "internal 6"]
    stiffness: Float[np.ndarray, "6 6"]
    mass: Float[np.ndarray, "6 6"]
    factor: Factor


def guyan(assembly: Assembly) -> GuyanModel:
    """Reduce the jacket statically to the transition-piece node.

    Raises
    ------
    ComputationError
        If the jacket's stiffness is singular with the interface held.
    """
    i, b = slice(0, assembly.internal), slice(assembly.internal, assembly.internal + 6)
    stiffness, mass = assembly.jacket_stiffness, assembly.jacket_mass
    factor = factorise(csc_array(stiffness[i, i]))
    constraint = -factor.solve(stiffness[i, b].toarray())
    shapes = np.concatenate([constraint, np.eye(6)])
    ib = slice(0, assembly.internal + 6)
    k_bb = shapes.T @ (stiffness[ib, ib] @ shapes)
    m_bb = shapes.T @ (mass[ib, ib] @ shapes)
    return GuyanModel(constraint, 0.5 * (k_bb + k_bb.T), 0.5 * (m_bb + m_bb.T), factor)


def solve_interior(assembly: Assembly, modes: int) -> Interior:
    """Reduce the jacket statically and find its `modes` lowest modes with the interface held.

    Raises
    ------
    ComputationError
        If the factorisation or the eigenvalue problem fails.
    """
    n = assembly.internal
    k_ii, m_ii = assembly.jacket_stiffness[:n, :n], assembly.jacket_mass[:n, :n]
    return Interior(guyan(assembly), *lowest_modes(csc_array(k_ii), csc_array(m_ii), modes))


def reduce(
    assembly: Assembly,
    reduction: str,
    basis: LoadBasis | None = None,
    *,
    interior: Interior | None = None,
) -> Reduction:
    """Build the basis of a reduced model and project onto it [eq. 3.55-3.57].

    Vectors that the loads cannot give, or that depend on others, are left out, with a note. Dashpots inside
    the jacket add vectors of their own, whatever the reduction.

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    reduction : str
        As :mod:`owt_model.reduction_name` lists; ``full`` and ``auto`` have no basis and are refused here.
    basis : LoadBasis, optional
        Load vectors for the augmentation.
    interior : Interior, optional
        Of this structure, with at least as many modes, where it is known.

    Raises
    ------
    InputError
        If the reduction asks for more modes than the structure has, for load vectors without a basis, or for
        vectors only, of which none remain.
    ComputationError
        If a factorisation or an eigenvalue problem fails.
    """
    name = parse_reduction(reduction)
    _check(name, assembly, reduction, basis)
    n_i = assembly.internal
    if interior is None:
        interior = solve_interior(assembly, name.fixed_interface_modes)
    static, kept_modes = interior.static, slice(0, name.fixed_interface_modes)
    omega2, phi = interior.omega_squared[kept_modes], interior.modes[:, kept_modes]
    k_ii = csc_array(assembly.jacket_stiffness[:n_i, :n_i])
    m_ii = csc_array(assembly.jacket_mass[:n_i, :n_i])
    loads = _augmenting_loads(name, assembly, static, basis)
    added = augment(static.factor, k_ii, m_ii, phi, loads, name.order)
    sigma2 = added.sigma_squared
    if not (len(sigma2) or reduction.startswith("CB")):
        raise InputError(
            "structure.reduction",
            reduction,
            "has no vector left: the loads do not act inside the jacket, or do not change in time",
            "Use CBnn.",
        )
    n_q = 6 + len(omega2) + len(sigma2)
    n_upper = assembly.mesh.n_dof - n_i
    shapes = np.zeros((assembly.mesh.n_dof, n_q + n_upper - 6))
    shapes[:n_i, :6] = static.constraint
    shapes[:n_i, 6 : 6 + len(omega2)] = phi
    shapes[:n_i, 6 + len(omega2) : n_q] = added.vectors
    shapes[n_i : n_i + 6, :6] = np.eye(6)
    shapes[n_i + 6 :, n_q:] = np.eye(n_upper - 6)
    stiffness = shapes.T @ (assembly.stiffness @ shapes)
    mass = shapes.T @ (assembly.mass @ shapes)
    improvement = None
    if name.static_improvement:
        kept = shapes[:n_i, 6:n_q] / np.sqrt(np.concatenate([omega2, sigma2]))
        improvement = StaticImprovement(assembly, static.factor, kept)
    return Reduction(
        name=reduction,
        shapes=shapes,
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=0.5 * (mass + mass.T),
        coordinate_name=_names(assembly, len(omega2), len(sigma2)),
        fixed_interface=omega2,
        pseudo=sigma2,
        notes=_notes(name, reduction, basis, added, _inner_dashpots(assembly).shape[1]),
        improvement=improvement,
    )


def interface_loads(assembly: Assembly, static: GuyanModel) -> Float[np.ndarray, "internal 6"]:
    """Inertia forces inside the jacket per interface acceleration: Y = -M_ii Psi - M_ib [eq. 3.49]."""
    i, b = slice(0, assembly.internal), slice(assembly.internal, assembly.internal + 6)
    mass = assembly.jacket_mass
    return np.asarray(-(mass[i, i] @ static.constraint) - mass[i, b].toarray())


def _augmenting_loads(
    name: ReductionName, assembly: Assembly, static: GuyanModel, basis: LoadBasis | None
) -> Float[np.ndarray, "internal load"]:
    """[F Y] of eq. 3.53, F first, since it matters most; and what dashpots inside the jacket do to it."""
    loads = [_inner_dashpots(assembly)]
    if name.load_vectors and basis is not None:
        loads.append(load_vectors(assembly, basis)[: assembly.internal, : name.load_vectors])
    if name.interface_vectors:
        loads.append(interface_loads(assembly, static))
    return np.hstack(loads)


def _inner_dashpots(assembly: Assembly) -> Float[np.ndarray, "internal direction"]:
    """Forces of the dashpots inside the jacket, whose static response a basis needs to feel them.

    Low modes alone hold the ends of a dashpot between two braces almost at rest to each other.
    """
    vectors = all_vectors(assembly.mesh, Damping()) @ assembly.expansion
    inside = vectors.toarray()[:, : assembly.internal].T
    return np.ascontiguousarray(inside[:, inside.any(axis=0)])


def _notes(
    name: ReductionName, reduction: str, basis: LoadBasis | None, added: Augmentation, dashpots: int
) -> tuple[str, ...]:
    """What became of the vectors that were asked for."""
    given = min(name.load_vectors, 0 if basis is None else len(basis.vectors))
    asked = (name.load_vectors + 6 * name.interface_vectors + dashpots) * (name.order + 1)
    reasons = []
    if given < name.load_vectors:
        reasons.append(f"the loads have {given} independent shapes")
    if added.unloaded:
        reasons.append(f"{added.unloaded} of their shapes do not load the inside of the jacket")
    if added.dependent:
        reasons.append(f"{added.dependent} depend on modes or on other vectors")
    more: tuple[str, ...] = ()
    if dashpots:
        most = dashpots * (name.order + 1)
        more = (f"{reduction} has up to {most} more vectors, for dashpots inside the jacket",)
    if not reasons:
        return more
    kept = len(added.sigma_squared)
    return (*more, f"{reduction} has {kept} of {asked} augmentation vectors: {'; '.join(reasons)}")


def load_vectors(assembly: Assembly, basis: LoadBasis) -> Float[np.ndarray, "dof vector"]:
    """Spatial load vectors over the free degrees of freedom: F of eq. 3.38.

    Raises
    ------
    InputError
        If the basis belongs to another structure or to nodes that this one does not have.
    """
    mesh = assembly.mesh
    if basis.model_hash != mesh.structure.content_hash:
        raise InputError(
            "load_basis.model_hash",
            basis.model_hash,
            f"is not that of structure {mesh.structure.name}",
            "Compute the load basis for the same structure.",
        )
    if len(basis.node) and not (basis.node.min() >= 0 and basis.node.max() < mesh.n_nodes):
        raise InputError(
            "load_basis.node", int(basis.node.max()), f"must be a node of the mesh ({mesh.n_nodes})", ""
        )
    if not np.isfinite(basis.vectors).all():
        raise InputError("load_basis.vectors", "NaN or inf", "must be finite", "Check the loads.")
    nodal = np.zeros((mesh.n_nodes, 6, len(basis.vectors)))
    nodal[basis.node] = np.moveaxis(basis.vectors, 0, -1)
    return np.asarray(assembly.expansion.T @ nodal.reshape(6 * mesh.n_nodes, -1))


def _check(name: ReductionName, assembly: Assembly, reduction: str, basis: LoadBasis | None) -> None:
    if name.full or name.auto:
        raise InputError("structure.reduction", reduction, "has no reduction basis", "Use CBnn or Mmm.")
    if name.fixed_interface_modes > assembly.internal:
        raise InputError(
            "structure.reduction",
            reduction,
            f"asks for {name.fixed_interface_modes} modes, the jacket has {assembly.internal} internal "
            "degrees of freedom",
            "Use fewer, or full.",
        )
    if name.load_vectors and basis is None:
        raise InputError(
            "structure.reduction",
            reduction,
            f"needs {name.load_vectors} load vectors, no load basis is given",
            "Give the load basis of a sea state.",
        )


def _names(assembly: Assembly, n_modes: int, n_vectors: int) -> tuple[str, ...]:
    mesh = assembly.mesh
    names = [f"TP.{direction}" for direction in DOF_NAME]
    names += [f"CB.{i + 1:02d}" for i in range(n_modes)]
    names += [f"MTA.{i + 1:02d}" for i in range(n_vectors)]
    names += [f"{mesh.node_name[node]}.{direction}" for node in mesh.tower_node for direction in DOF_NAME]
    return tuple(names)
