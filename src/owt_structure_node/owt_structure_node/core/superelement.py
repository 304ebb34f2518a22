"""A reduced jacket as a superelement: what leaves the project, and what comes back under a tower.

The jacket without transition piece and tower is reduced to the coordinates of a basis that lie below the
interface (eq. 3.55): the transition-piece node, fixed-interface modes, augmentation vectors. The upper part
of a structure stands on it by the six degrees of freedom that both share (primal assembly, eq. 3.6-3.10).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_array

from owt_model.errors import InputError
from owt_model.reduction_name import parse_reduction
from owt_model.structure_config import Damping
from owt_model.superelement import INTERFACE, Superelement
from owt_structure_node.core.assembly import DOF_NAME, Assembly
from owt_structure_node.core.damping import above_interface, all_vectors
from owt_structure_node.core.modes import dense_modes
from owt_structure_node.core.reduction import Reduction

__all__ = [
    "PROPORTIONAL",
    "Attached",
    "attach",
    "check_reduction",
    "frequencies",
    "jacket_basis",
    "jacket_superelement",
    "project_loads",
    "rayleigh_coefficients",
]

#: Coupling of modes by damping, relative to their own, that counts as round-off of the digits in a file.
PROPORTIONAL = 1e-6
Matrix = Float[np.ndarray, "dof dof"]


def check_reduction(reduction: str) -> None:
    """Refuse what a superelement cannot carry; ``auto`` may choose a basis for one.

    Raises
    ------
    InputError
        If the reduction has no basis, or static improvement.
    """
    name = parse_reduction(reduction)
    if name.full:
        raise InputError(
            "structure.reduction",
            reduction,
            "has no basis: a superelement is a reduced model",
            "Use CBnn or CBnnMmm.",
        )
    if name.static_improvement:
        raise InputError(
            "structure.reduction",
            reduction,
            "has a static improvement, which acts in the recovery of stresses: no superelement carries it",
            "Leave +SIM out, or keep load vectors (Mmm), which move with the interface.",
        )


def jacket_basis(assembly: Assembly, reduction: Reduction) -> Float[np.ndarray, "dof coordinate"]:
    """Columns of a reduction basis that lie below the interface, and the six of the interface.

    Raises
    ------
    InputError
        As :func:`check_reduction`.
    """
    check_reduction(reduction.name)
    size = INTERFACE + len(reduction.fixed_interface) + len(reduction.pseudo)
    assert reduction.shapes.shape == (assembly.mesh.n_dof, len(reduction.coordinate_name))
    return reduction.shapes[:, :size]


def jacket_superelement(
    assembly: Assembly,
    reduction: Reduction,
    loads: Float[np.ndarray, "sample coordinate"],
    *,
    dt: float,
    alpha: float,
    beta: float,
    dashpots: csr_array | None = None,
    elevation: Float[np.ndarray, " sample"] | None = None,
    comments: tuple[str, ...] = (),
) -> Superelement:
    """Project the jacket on the basis: its own matrices, C = alpha M + beta K and dashpots.

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    reduction : Reduction
        From :func:`owt_structure_node.core.reduction.reduce`.
    loads : float array [sample, coordinate]
        From :func:`project_loads`.
    dt : float
        Their time step in s.
    alpha, beta : float
        Rayleigh coefficients in 1/s and s.
    dashpots : sparse [direction, 6 node], optional
        Vectors g over the motion of all nodes; C holds g g' of each that acts below the tower. Those on the
        tower alone belong to it.
    elevation : float array [sample], optional
        Surface elevation in m.
    comments : tuple of str

    Raises
    ------
    InputError
        As :func:`check_reduction`, as :class:`owt_model.superelement.Superelement`, and if a dashpot joins
        jacket and tower.
    """
    shapes = jacket_basis(assembly, reduction)
    mass, stiffness = (
        _symmetric(shapes.T @ (matrix @ shapes))
        for matrix in (assembly.jacket_mass, assembly.jacket_stiffness)
    )
    damping = alpha * mass + beta * stiffness
    if dashpots is not None and dashpots.shape[0]:
        on_tower, below = above_interface(assembly.mesh, dashpots)
        if (on_tower & below).any():
            raise InputError(
                "dashpots",
                list(assembly.mesh.structure.dashpots),
                "join jacket and tower, which no matrix of the jacket alone can hold",
                "Leave such dashpots out, and give them in the tool that reads the file.",
            )
        motion = dashpots[below] @ (assembly.expansion @ shapes)
        damping = damping + _symmetric(motion.T @ motion)
    return Superelement(mass, stiffness, damping, dt, loads, elevation, comments)


def project_loads(
    assembly: Assembly,
    reduction: Reduction,
    node: Int[np.ndarray, " loaded"],
    nodal: Float[np.ndarray, "sample loaded 6"],
) -> Float[np.ndarray, "sample coordinate"]:
    """Generalised loads of nodal loads on the jacket.

    Parameters
    ----------
    assembly, reduction
        As for :func:`jacket_superelement`.
    node, nodal : arrays
        As in :class:`owt_model.contracts.LoadBlock`.

    Raises
    ------
    InputError
        As :func:`check_reduction`; if a node of the tower is loaded.
    """
    mesh = assembly.mesh
    above = np.isin(node, mesh.tower_node)
    if nodal[:, above].any():
        loaded = node[above][nodal[:, above].any(axis=(0, 2))]
        raise InputError(
            "nodal loads",
            [mesh.node_name[i] for i in loaded.tolist()],
            "act on the tower, which is no part of a superelement of the jacket",
            "Leave them out, and apply them to the tower.",
        )
    motion = (assembly.expansion @ jacket_basis(assembly, reduction)).reshape(mesh.n_nodes, 6, -1)
    return np.asarray(nodal.reshape(len(nodal), -1) @ motion[node].reshape(6 * len(node), -1))


@dataclass(frozen=True)
class Attached:
    """A superelement with the upper part of a structure on it.

    Attributes
    ----------
    stiffness, mass, damping : float arrays [coordinate, coordinate]
        Coordinates: those of the superelement, then the tower's, 6 per node.
    upper_stiffness, upper_mass, upper_damping : float arrays [upper, upper]
        The upper part alone: transition piece, tower, rotor-nacelle.
    upper : int array [upper]
        Its coordinates: the six of the interface, then the tower's.
    top : int array [6]
        Coordinates of the tower top, those of the interface where there is no tower.
    coordinate_name : tuple of str
    """

    stiffness: Float[np.ndarray, "coordinate coordinate"]
    mass: Float[np.ndarray, "coordinate coordinate"]
    damping: Float[np.ndarray, "coordinate coordinate"]
    upper_stiffness: Float[np.ndarray, "upper upper"]
    upper_mass: Float[np.ndarray, "upper upper"]
    upper_damping: Float[np.ndarray, "upper upper"]
    upper: Int[np.ndarray, " upper"]
    top: Int[np.ndarray, " 6"]
    coordinate_name: tuple[str, ...]


def attach(element: Superelement, assembly: Assembly, *, alpha: float, beta: float) -> Attached:
    """Set the upper part of a structure on a superelement, its dashpots at the tower top included.

    Parameters
    ----------
    element : Superelement
        Takes the place of the structure's own jacket; its interface is the transition-piece node.
    assembly : Assembly
        The structure that the upper part is taken from.
    alpha, beta : float
        Rayleigh coefficients of the upper part in 1/s and s.
    """
    mesh, n = assembly.mesh, element.n_dof
    held = slice(assembly.internal, None)
    stiffness = assembly.upper_stiffness[held, held].toarray()
    mass = assembly.upper_mass[held, held].toarray()
    vectors = all_vectors(mesh, Damping())
    on_tower, below = above_interface(mesh, vectors)
    g = (vectors[on_tower & ~below] @ assembly.expansion[:, held]).toarray()
    damping = alpha * mass + beta * stiffness + g.T @ g
    size = n + len(mass) - INTERFACE
    upper = np.concatenate([np.arange(INTERFACE), np.arange(n, size)])

    def whole(
        below: Float[np.ndarray, "lower lower"], above: Float[np.ndarray, "above above"]
    ) -> Float[np.ndarray, "coordinate coordinate"]:
        matrix = np.zeros((size, size))
        matrix[:n, :n] = below
        matrix[np.ix_(upper, upper)] += above
        return matrix

    names = [f"TP.{direction}" for direction in DOF_NAME]
    names += [f"Q.{i + 1:02d}" for i in range(n - INTERFACE)]
    names += [f"{mesh.node_name[node]}.{direction}" for node in mesh.tower_node for direction in DOF_NAME]
    return Attached(
        stiffness=whole(element.stiffness, stiffness),
        mass=whole(element.mass, mass),
        damping=whole(element.damping, damping),
        upper_stiffness=stiffness,
        upper_mass=mass,
        upper_damping=damping,
        upper=upper,
        top=upper[-INTERFACE:],
        coordinate_name=tuple(names),
    )


def frequencies(stiffness: Matrix, mass: Matrix) -> Float[np.ndarray, " mode"]:
    """Natural frequencies in Hz, ascending; none of a system without degrees of freedom.

    With the interface held those of ``element.stiffness[6:, 6:]``, free those of ``element.stiffness``, under
    a tower those of :class:`Attached`.

    Raises
    ------
    ComputationError
        If stiffness or mass is not positive definite.
    """
    if not len(mass):
        return np.zeros(0)
    return np.asarray(np.sqrt(dense_modes(stiffness, mass)[0]) / (2.0 * np.pi))


def rayleigh_coefficients(element: Superelement) -> tuple[float, float]:
    """Alpha in 1/s and beta in s of a superelement whose damping is alpha M + beta K.

    Raises
    ------
    InputError
        If no coefficients give its damping matrix to the digits of a file.
    ComputationError
        If its stiffness or mass is not positive definite.
    """
    omega2, shapes = dense_modes(element.stiffness, element.mass)
    modal = shapes.T @ element.damping @ shapes
    rate = modal.diagonal()
    if not modal.any():
        return 0.0, 0.0
    if rate.min() > 0.0:
        # Relative to each mode's own rate; columns of one size for the solver.
        columns = np.stack([1.0 / rate, omega2 / rate], axis=1)
        size = np.abs(columns).max(axis=0)
        alpha, beta = (np.linalg.lstsq(columns / size, np.ones(len(rate)), rcond=None)[0] / size).tolist()
        worst = float(np.abs((modal - np.diag(alpha + beta * omega2)) / np.sqrt(np.outer(rate, rate))).max())
        if worst <= PROPORTIONAL:
            return alpha, beta
    raise InputError(
        "damping matrix",
        "not Rayleigh's",
        "is no sum alpha M + beta K, so that the damping of the tower is not known from it",
        "Give alpha and beta of the tower.",
    )


def _symmetric(matrix: Matrix) -> Matrix:
    return np.asarray(0.5 * (matrix + matrix.T))
