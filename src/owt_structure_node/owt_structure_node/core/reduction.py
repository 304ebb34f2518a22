"""Reduced models of the jacket: Guyan, Craig-Bampton, and Craig-Bampton augmented with load vectors.

The boundary is the transition-piece node; the tower stays unreduced (thesis 3.5 to 3.7). With internal
degrees of freedom i and boundary b::

    u_i = Psi u_b + Phi eta + Phi_MTA zeta          [eq. 3.54; the basis 3.55]

``CB00`` is Guyan's static reduction, ``CBnn`` keeps nn fixed-interface modes Phi, ``CBnnMmm`` adds mm
modal truncation augmentation vectors, ``Mmm`` has those only, ``full`` is no reduction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.linalg import eigh
from scipy.sparse import csc_array

from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.reduction_name import ReductionName, parse_reduction
from owt_structure_node.core.assembly import DOF_NAME, Assembly
from owt_structure_node.core.modes import Factor, factorise, lowest_modes

__all__ = ["GuyanModel", "Reduction", "guyan", "load_vectors", "mta_vectors", "reduce"]

#: Smallest eigenvalue of the normalised Gram matrix at which load vectors count as independent.
_INDEPENDENT = 1e-12


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
    """

    name: str
    shapes: Float[np.ndarray, "dof coordinate"]
    stiffness: Float[np.ndarray, "coordinate coordinate"]
    mass: Float[np.ndarray, "coordinate coordinate"]
    coordinate_name: tuple[str, ...]
    fixed_interface: Float[np.ndarray, " mode"]
    pseudo: Float[np.ndarray, " vector"]


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


def reduce(assembly: Assembly, reduction: str, basis: LoadBasis | None = None) -> Reduction:
    """Build the basis of a reduced model and project onto it [eq. 3.55-3.57].

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    reduction : str
        ``CBnn``, ``CBnnMmm`` or ``Mmm``; ``full`` has no basis and is refused here.
    basis : LoadBasis, optional
        Load vectors for the augmentation.

    Raises
    ------
    InputError
        If the reduction asks for more than the structure or the basis has.
    ComputationError
        If a factorisation or an eigenvalue problem fails.
    """
    name = parse_reduction(reduction)
    _check(name, assembly, reduction, basis)
    n_i = assembly.internal
    static = guyan(assembly)
    k_ii = csc_array(assembly.jacket_stiffness[:n_i, :n_i])
    m_ii = csc_array(assembly.jacket_mass[:n_i, :n_i])
    omega2, phi = lowest_modes(k_ii, m_ii, name.fixed_interface_modes)
    sigma2, phi_mta = np.zeros(0), np.zeros((n_i, 0))
    if name.load_vectors:
        assert basis is not None  # _check refused it otherwise
        vectors = load_vectors(assembly, basis)[:n_i, : name.load_vectors]
        sigma2, phi_mta = mta_vectors(static.factor, k_ii, m_ii, phi, vectors, reduction)
    n_q = 6 + len(omega2) + len(sigma2)
    n_upper = assembly.mesh.n_dof - n_i
    shapes = np.zeros((assembly.mesh.n_dof, n_q + n_upper - 6))
    shapes[:n_i, :6] = static.constraint
    shapes[:n_i, 6 : 6 + len(omega2)] = phi
    shapes[:n_i, 6 + len(omega2) : n_q] = phi_mta
    shapes[n_i : n_i + 6, :6] = np.eye(6)
    shapes[n_i + 6 :, n_q:] = np.eye(n_upper - 6)
    stiffness = shapes.T @ (assembly.stiffness @ shapes)
    mass = shapes.T @ (assembly.mass @ shapes)
    return Reduction(
        name=reduction,
        shapes=shapes,
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=0.5 * (mass + mass.T),
        coordinate_name=_names(assembly, len(omega2), len(sigma2)),
        fixed_interface=omega2,
        pseudo=sigma2,
    )


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


def mta_vectors(
    factor: Factor,
    stiffness: csc_array,
    mass: csc_array,
    modes: Float[np.ndarray, "internal mode"],
    loads: Float[np.ndarray, "internal vector"],
    reduction: str = "Mmm",
) -> tuple[Float[np.ndarray, " vector"], Float[np.ndarray, "internal vector"]]:
    """First-order modal truncation augmentation vectors: j = 0 of eq. 3.53, then eq. 3.42 and 3.43.

    Parameters
    ----------
    factor : Factor
        Of the internal stiffness.
    stiffness, mass : sparse [internal, internal]
        K_ii and M_ii.
    modes : float array [internal, mode]
        Fixed-interface modes, mass-normalised, to which the vectors are made orthogonal.
    loads : float array [internal, vector]
        Load vectors F.
    reduction : str
        Its name, for the error message.

    Returns
    -------
    sigma_squared : float array [vector]
        Squares of the pseudo-frequencies, ascending, in rad2/s2.
    vectors : float array [internal, vector]
        Orthonormal as eq. 3.44: V' M V = 1, V' K V = sigma^2, Phi' M V = 0.

    Raises
    ------
    InputError
        If the vectors are not independent of each other and of the modes.
    """
    static = factor.solve(loads)
    energy = np.sqrt(np.einsum("dv,dv->v", loads, static))
    if not (energy > 0.0).all():
        raise InputError(
            "structure.reduction",
            reduction,
            f"uses load vector {int(energy.argmin())}, which does not load the inside of the jacket",
            "Use fewer MTA vectors.",
        )
    static = static / energy
    for _ in range(2):  # twice, so that the orthogonality holds to round-off
        static = static - modes @ (modes.T @ (mass @ static))
    k_small = static.T @ (stiffness @ static)
    independence = float(np.linalg.eigvalsh(0.5 * (k_small + k_small.T))[0])
    if not independence > _INDEPENDENT:
        raise InputError(
            "structure.reduction",
            reduction,
            f"has load vectors that depend on each other or on the modes (smallest eigenvalue of their Gram "
            f"matrix {independence:.1e}, at least {_INDEPENDENT:.0e} needed)",
            "Use fewer MTA vectors or fixed-interface modes, or a richer load history.",
        )
    m_small = static.T @ (mass @ static)
    # The flexible end of the pencil is the interesting one: solve M y = (1/sigma^2) K y, K well scaled.
    inverse, y = eigh(0.5 * (m_small + m_small.T), 0.5 * (k_small + k_small.T))
    order = np.argsort(-inverse)
    vectors = static @ (y[:, order] / np.sqrt(inverse[order]))
    return 1.0 / inverse[order], np.ascontiguousarray(vectors)


def _check(name: ReductionName, assembly: Assembly, reduction: str, basis: LoadBasis | None) -> None:
    if name.full:
        raise InputError("structure.reduction", reduction, "has no reduction basis", "Use CBnn or Mmm.")
    wanted = name.fixed_interface_modes + name.load_vectors
    if wanted > assembly.internal:
        raise InputError(
            "structure.reduction",
            reduction,
            f"asks for {wanted} modes and vectors, the jacket has {assembly.internal} internal degrees of "
            "freedom",
            "Use fewer, or full.",
        )
    given = 0 if basis is None else len(basis.vectors)
    if name.load_vectors > given:
        raise InputError(
            "structure.reduction",
            reduction,
            f"needs {name.load_vectors} load vectors, {given} are given",
            "Give a load basis with as many vectors.",
        )


def _names(assembly: Assembly, n_modes: int, n_vectors: int) -> tuple[str, ...]:
    mesh = assembly.mesh
    names = [f"TP.{direction}" for direction in DOF_NAME]
    names += [f"CB.{i + 1:02d}" for i in range(n_modes)]
    names += [f"MTA.{i + 1:02d}" for i in range(n_vectors)]
    names += [f"{mesh.node_name[node]}.{direction}" for node in mesh.tower_node for direction in DOF_NAME]
    return tuple(names)
