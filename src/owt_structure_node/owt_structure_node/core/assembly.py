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
from owt_model.errors import InputError
from owt_model.mesh import DOF_TIED, Mesh
from owt_structure_node.core.elements import shear_parameter, stiffness, tube_mass
from owt_structure_node.core.masses import body_matrix, distributed_mass, joint_mass
from owt_structure_node.core.supports import check_supports

__all__ = ["DOF_NAME", "Assembly", "assemble", "element_stiffness", "element_transformation"]

DOF_NAME = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Assembly:
    """Matrices over the free degrees of freedom of the mesh, in the order of :attr:`Mesh.node_dof`.

    Attributes
    ----------
    expansion : sparse [6 node, dof]
        Motion of all nodes from the free degrees of freedom: supports stay, interface joints follow
        the transition piece. Its transpose takes nodal loads to the free degrees of freedom.
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
    """Stiffness matrices in element axes; the tower is Euler-Bernoulli always."""
    length = mesh.element_length
    section = (mesh.element_diameter, mesh.element_thickness)
    modulus = (mesh.element_youngs_modulus, mesh.element_shear_modulus)
    shear = np.zeros(mesh.n_elements)
    if mesh.structure.beam == "timoshenko":
        shear = np.where(mesh.is_tower, 0.0, shear_parameter(length, *section, *modulus))
    return stiffness(length, *section, *modulus, shear)


def assemble(mesh: Mesh, *, jacket_stiffness_factor: float = 1.0) -> Assembly:
    """Assemble stiffness and mass of `mesh`.

    Parameters
    ----------
    mesh : Mesh
        From :func:`owt_model.mesh.build_mesh`.
    jacket_stiffness_factor : float
        Factor on the stiffness of the members, not on the tower (the thesis' frequency model has 0.37).

    Raises
    ------
    InputError
        If the supports leave a part of the structure free to move.
    """
    check_supports(mesh)
    transform = element_transformation(mesh)
    tower = mesh.is_tower
    local_k = element_stiffness(mesh)
    local_k[~tower] *= jacket_stiffness_factor
    local_m, node_mass, totals = _masses(mesh)
    element_k = transform.transpose(0, 2, 1) @ local_k @ transform
    element_m = transform.transpose(0, 2, 1) @ local_m @ transform
    expansion = _expansion(mesh)
    jacket_body, upper_body = _bodies(mesh, node_mass)

    def reduce(matrix: csr_array) -> csc_array:
        reduced = csc_array(expansion.T @ matrix @ expansion)
        return csc_array(0.5 * (reduced + reduced.T))

    return Assembly(
        mesh=mesh,
        expansion=expansion,
        jacket_stiffness=reduce(_scatter(mesh, element_k, ~tower)),
        jacket_mass=reduce(csr_array(_scatter(mesh, element_m, ~tower) + jacket_body)),
        upper_stiffness=reduce(_scatter(mesh, element_k, tower)),
        upper_mass=reduce(csr_array(_scatter(mesh, element_m, tower) + upper_body)),
        internal=int(mesh.node_dof[mesh.transition_piece, 0]),
        mass_kg=totals,
    )


def _masses(
    mesh: Mesh,
) -> tuple[Float[np.ndarray, "element 12 12"], Float[np.ndarray, " node"], dict[str, float]]:
    """Element masses in element axes, point masses at nodes in kg, and totals by kind."""
    structure, length, tower = mesh.structure, mesh.element_length, mesh.is_tower
    wall = (length, mesh.element_diameter, mesh.element_thickness, mesh.element_density)
    steel = tube_mass(*wall, rotary_inertia=False)
    if structure.rotary_inertia:
        steel[~tower] = tube_mass(*wall, rotary_inertia=True)[~tower]
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


def _expansion(mesh: Mesh) -> csr_array:
    """Motion of all nodes from the free degrees of freedom."""
    node, direction = np.nonzero(mesh.node_dof >= 0)
    rows, columns = [6 * node + direction], [mesh.node_dof[node, direction]]
    values = [np.ones(len(node))]
    reference = mesh.node_position[mesh.transition_piece]
    boundary = mesh.node_dof[mesh.transition_piece]
    for joint in mesh.interface_node:
        if not (mesh.node_dof[joint] == DOF_TIED).all():
            raise InputError(
                "interface.joints", mesh.node_name[joint], "must be tied fully", "Check the mesh."
            )
        x, y, z = mesh.node_position[joint] - reference
        rigid = np.eye(6)
        rigid[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        i, j = np.nonzero(rigid)
        rows.append(6 * joint + i)
        columns.append(boundary[j])
        values.append(rigid[i, j])
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(coo_array(entries, shape=(6 * mesh.n_nodes, mesh.n_dof)))
