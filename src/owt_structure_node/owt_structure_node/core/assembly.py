"""Sparse stiffness and mass of the whole structure, with supports and the rigid transition piece.

Two parts share the six degrees of freedom of the transition-piece node (primal assembly, eq. 3.6-3.10):
the jacket with everything that sits on its members and joints, and the upper part with transition
piece, tower and rotor-nacelle assembly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import block_diag, coo_array, csc_array, csr_array

from owt_model.axes import rotation
from owt_model.errors import ComputationError, InputError
from owt_model.mesh import Mesh
from owt_model.parts import StaticState
from owt_structure_node.core.elements import shear_parameter, stiffness, tube_mass
from owt_structure_node.core.expansion import expansion
from owt_structure_node.core.masses import body_matrix, distributed_mass, joint_mass
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.static import Rest, body_levers, element_geometric, follower_levers, rest
from owt_structure_node.core.supports import check_releases, check_supports, spring_stiffness

__all__ = ["DOF_NAME", "Assembly", "assemble", "element_stiffness", "element_transformation"]

DOF_NAME = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Assembly:
    """Matrices over the free degrees of freedom of the mesh, in the order of :attr:`Mesh.node_dof`.

    Attributes
    ----------
    expansion : sparse [6 node, dof]
        Motion of all nodes from the free degrees of freedom
        (:mod:`owt_structure_node.core.expansion`). Its transpose takes nodal loads to them.
    jacket_stiffness, jacket_mass, upper_stiffness, upper_mass : sparse [dof, dof]
        In N/m, N, N m and kg, kg m, kg m2.
    internal : int
        Number of degrees of freedom inside the jacket; the transition piece's follow, then the tower's.
    mass_kg : dict
        Totals by kind.
    """

    mesh: Mesh
    expansion: csr_array
    jacket_stiffness: csc_array
    jacket_mass: csc_array
    upper_stiffness: csc_array
    upper_mass: csc_array
    internal: int
    mass_kg: dict[str, float]

    @property
    def stiffness(self) -> csc_array:
        """Stiffness of jacket and upper part together."""
        return csc_array(self.jacket_stiffness + self.upper_stiffness)

    @property
    def mass(self) -> csc_array:
        """Mass of jacket and upper part together."""
        return csc_array(self.jacket_mass + self.upper_mass)

    @property
    def structural_mass_kg(self) -> float:
        """Steel and lumped bodies; without growth, flood water and added mass."""
        wet = ("marine_growth", "flood_water", "added_mass")
        return sum(mass for kind, mass in self.mass_kg.items() if kind not in wet)


def element_transformation(mesh: Mesh) -> Float[np.ndarray, "element 12 12"]:
    """Matrices that take the 12 end displacements of each element from global to element axes."""
    ends = mesh.node_position[mesh.element_node]
    axes = rotation(ends[:, 0], ends[:, 1])
    result = np.zeros((mesh.n_elements, 12, 12))
    for i in range(0, 12, 3):
        result[:, i : i + 3, i : i + 3] = axes
    return result


def element_stiffness(mesh: Mesh) -> Float[np.ndarray, "element 12 12"]:
    """Stiffness matrices in element axes; the tower is Euler-Bernoulli always, and as stiff as it is."""
    length = mesh.element_length
    section = (mesh.element_diameter, mesh.element_thickness)
    modulus = (mesh.element_youngs_modulus, mesh.element_shear_modulus)
    shear = np.zeros(mesh.n_elements)
    if mesh.structure.beam == "timoshenko":
        shear = np.where(mesh.is_tower, 0.0, shear_parameter(length, *section, *modulus))
    factor = np.where(mesh.is_tower, 1.0, mesh.structure.jacket_stiffness_factor)
    return np.asarray(factor[:, None, None] * stiffness(length, *section, *modulus, shear))


def assemble(mesh: Mesh, *, interface_held: bool = False) -> Assembly:
    """Assemble stiffness and mass of `mesh`.

    Parameters
    ----------
    mesh : Mesh
        From :func:`owt_model.mesh.build_mesh`.
    interface_held : bool
        Accept a structure that only the interface holds: for what is done with the interface fixed.

    Raises
    ------
    InputError
        If supports or releases leave a part of the structure free to move, or if it buckles under its
        own weight.
    """
    check_supports(mesh, interface_held=interface_held)
    nodes = expansion(mesh)
    transform = element_transformation(mesh)
    tower = mesh.is_tower
    local_k = element_stiffness(mesh)
    local_m, node_mass, totals = _masses(mesh)
    element_k = transform.transpose(0, 2, 1) @ local_k @ transform
    element_m = transform.transpose(0, 2, 1) @ local_m @ transform
    jacket_body, upper_body = _bodies(mesh, node_mass)

    def reduce(matrix: csr_array) -> csc_array:
        reduced = csc_array(nodes.T @ matrix @ nodes)
        return csc_array(0.5 * (reduced + reduced.T))

    members = csr_array(_scatter(mesh, element_k, ~tower) + spring_stiffness(mesh))
    upper = _scatter(mesh, element_k, tower)
    internal = int(mesh.node_dof[mesh.transition_piece, 0])
    moving = slice(internal if interface_held else None)
    check_releases(mesh, nodes[:, moving], reduce(csr_array(members + upper))[moving, moving])
    state = mesh.structure.static_state
    if state is not None and state.p_delta:
        at_rest = rest(mesh, state, nodes, local_k, transform, csr_array(members + upper))
        more = _geometric(mesh, state, at_rest, transform)
        members, upper = csr_array(members + more[0]), csr_array(upper + more[1])
    assembly = Assembly(
        mesh=mesh,
        expansion=nodes,
        jacket_stiffness=reduce(members),
        jacket_mass=reduce(csr_array(_scatter(mesh, element_m, ~tower) + jacket_body)),
        upper_stiffness=reduce(upper),
        upper_mass=reduce(csr_array(_scatter(mesh, element_m, tower) + upper_body)),
        internal=internal,
        mass_kg=totals,
    )
    if state is not None and state.p_delta:
        _check_stable(assembly, state)
    return assembly


def _geometric(
    mesh: Mesh, state: StaticState, at_rest: Rest, transform: Float[np.ndarray, "element 12 12"]
) -> tuple[csr_array, csr_array]:
    """Geometric stiffness over all nodes, of the jacket and of what stands on it."""
    local = element_geometric(mesh, at_rest.axial)
    matrices = transform.transpose(0, 2, 1) @ local @ transform
    lever = body_levers(mesh, state)
    upper = np.zeros(mesh.n_nodes, dtype=bool)
    upper[[mesh.transition_piece, *mesh.tower_node]] = True
    on_jacket = follower_levers(mesh, at_rest) + np.where(upper[:, None, None], 0.0, lever)
    above = np.where(upper[:, None, None], lever, 0.0)
    return (
        csr_array(_scatter(mesh, matrices, ~mesh.is_tower) + csr_array(block_diag(list(on_jacket)))),
        csr_array(_scatter(mesh, matrices, mesh.is_tower) + csr_array(block_diag(list(above)))),
    )


def _check_stable(assembly: Assembly, state: StaticState) -> None:
    try:
        factorise(assembly.stiffness)
    except ComputationError:
        raise InputError(
            "static_state.gravity_m_s2",
            state.gravity_m_s2,
            f"is more than {assembly.mesh.structure.name} carries: it buckles under its own weight",
            "Check masses and sections, or leave p_delta out.",
        ) from None


def _masses(
    mesh: Mesh,
) -> tuple[Float[np.ndarray, "element 12 12"], Float[np.ndarray, " node"], dict[str, float]]:
    """Element masses in element axes, point masses at nodes in kg, and totals by kind."""
    structure, length, tower = mesh.structure, mesh.element_length, mesh.is_tower
    wall = (length, mesh.element_diameter, mesh.element_thickness, mesh.element_density)
    lumped = structure.mass == "lumped"
    steel = tube_mass(*wall, rotary_inertia=False, lumped=lumped)
    if structure.rotary_inertia:
        steel[~tower] = tube_mass(*wall, rotary_inertia=True, lumped=lumped)[~tower]
    extra = distributed_mass(mesh) if structure.extra_mass == "distributed" else joint_mass(mesh)
    each = steel[:, 0, 0] + steel[:, 6, 6] + 2.0 * steel[:, 0, 6]
    totals = {
        "members": float(each[~tower].sum()),
        "joints": sum((body.mass_kg for body in structure.point_masses.values()), 0.0),
        "transition_piece": structure.transition_piece.mass_kg,
        "tower": float(each[tower].sum()),
        "rotor_nacelle": structure.rotor_nacelle.mass_kg if structure.rotor_nacelle else 0.0,
        **extra.total_kg,
    }
    return steel + extra.element, extra.node, totals


def _bodies(mesh: Mesh, node_mass: Float[np.ndarray, " node"]) -> tuple[csr_array, csr_array]:
    """Lumped masses at all nodes, 6 node by 6 node: on the jacket, and above it."""
    structure = mesh.structure
    index = {name: i for i, name in enumerate(mesh.node_name)}
    jacket = np.zeros((mesh.n_nodes, 6, 6))
    jacket[:, :3, :3] += node_mass[:, None, None] * np.eye(3)
    for joint, body in structure.point_masses.items():
        jacket[index[joint]] += body_matrix(body)
    upper = np.zeros((mesh.n_nodes, 6, 6))
    upper[mesh.transition_piece] += body_matrix(structure.transition_piece)
    if structure.rotor_nacelle is not None:
        upper[mesh.tower_top] += body_matrix(structure.rotor_nacelle)
    return csr_array(block_diag(list(jacket))), csr_array(block_diag(list(upper)))


def _scatter(
    mesh: Mesh, matrices: Float[np.ndarray, "element 12 12"], chosen: Bool[np.ndarray, " element"]
) -> csr_array:
    """Sum element matrices in global axes into a matrix over all nodes, 6 node by 6 node."""
    dof: Int[np.ndarray, "element 12"] = (
        6 * mesh.element_node[chosen][:, :, None] + np.arange(6, dtype=np.int64)
    ).reshape(-1, 12)
    rows = np.repeat(dof, 12, axis=1).reshape(-1)
    columns = np.tile(dof, (1, 12)).reshape(-1)
    size = 6 * mesh.n_nodes
    return csr_array(coo_array((matrices[chosen].reshape(-1), (rows, columns)), shape=(size, size)))
