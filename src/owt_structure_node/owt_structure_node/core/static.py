"""The structure at rest under its own weight, and the geometric stiffness of its axial forces (P-delta).

Weights are those of wall, growth, flood water and lumped bodies; displaced water carries wet members as
Archimedes has it, so that the axial forces are effective ones, whose lateral effect includes that of the
pressures. Growth and water weigh along the members, also where ``extra_mass`` puts their inertia at joints.

Each element takes the axial force at its middle. The second-order motion of points on rigid bodies
(interface, rigid links, centres of gravity off their node) is counted with the force that acts there;
moments at rigid bodies are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_array

from owt_model.mesh import Mesh
from owt_model.parts import PointMass, StaticState
from owt_structure_node.core.elements import slope_matrix, tube_mass
from owt_structure_node.core.masses import body_matrix, weight_matrices
from owt_structure_node.core.modes import factorise

__all__ = ["Rest", "body_levers", "element_geometric", "follower_levers", "rest", "weights"]


@dataclass(frozen=True)
class Rest:
    """State at rest.

    Attributes
    ----------
    displacement : float array [node, 6]
        In m and rad.
    axial : float array [element]
        Axial force at the middle of each element in N, tension positive.
    handed_over : float array [node, 3]
        Force in N that each node that follows another hands over to it; zero elsewhere.
    """

    displacement: Float[np.ndarray, "node 6"]
    axial: Float[np.ndarray, " element"]
    handed_over: Float[np.ndarray, "node 3"]


def weights(
    mesh: Mesh, state: StaticState, transform: Float[np.ndarray, "element 12 12"]
) -> tuple[Float[np.ndarray, "element 12"], Float[np.ndarray, "node 6"]]:
    """Weight less buoyancy: equivalent nodal loads of each element in its axes, and all loads by node."""
    wall = (mesh.element_length, mesh.element_diameter, mesh.element_thickness, mesh.element_density)
    matrices = tube_mass(*wall, rotary_inertia=False) + weight_matrices(mesh, buoyancy=state.buoyancy)
    fall = np.zeros(12)
    fall[[2, 8]] = -state.gravity_m_s2
    load = (matrices @ (transform @ fall)[:, :, None])[:, :, 0]
    nodal = np.zeros((mesh.n_nodes, 6))
    of_element = (transform.transpose(0, 2, 1) @ load[:, :, None]).reshape(-1, 2, 6)
    np.add.at(nodal, mesh.element_node, of_element)
    for node, body in bodies(mesh):
        nodal[node] -= state.gravity_m_s2 * body_matrix(body)[:, 2]
    return load, nodal


def bodies(mesh: Mesh) -> list[tuple[int, PointMass]]:
    """Node and body of every lumped mass."""
    structure = mesh.structure
    index = {name: i for i, name in enumerate(mesh.node_name)}
    found = [(index[joint], body) for joint, body in structure.point_masses.items()]
    found.append((mesh.transition_piece, structure.transition_piece))
    if structure.rotor_nacelle is not None:
        found.append((mesh.tower_top, structure.rotor_nacelle))
    return found


def rest(
    mesh: Mesh,
    state: StaticState,
    expansion: csr_array,
    element_k: Float[np.ndarray, "element 12 12"],
    transform: Float[np.ndarray, "element 12 12"],
    node_stiffness: csr_array,
) -> Rest:
    """Solve for the state at rest of the elastic structure.

    Parameters
    ----------
    element_k : float array [element, 12, 12]
        Stiffness in element axes.
    transform : float array [element, 12, 12]
        From global to element axes.
    node_stiffness : sparse [6 node, 6 node]
        All stiffness, springs included.

    Raises
    ------
    ComputationError
        If the stiffness is singular.
    """
    load, nodal = weights(mesh, state, transform)
    stiffness = (expansion.T @ node_stiffness @ expansion).tocsc()
    motion = expansion @ factorise(stiffness).solve(expansion.T @ nodal.reshape(-1))
    ends = motion.reshape(-1, 6)[mesh.element_node].reshape(-1, 12)
    force = (element_k @ (transform @ ends[:, :, None]))[:, :, 0] - load
    residual = nodal - (node_stiffness @ motion).reshape(-1, 6)
    return Rest(
        displacement=motion.reshape(-1, 6),
        axial=0.5 * (force[:, 6] - force[:, 0]),
        handed_over=_hand_over(mesh, residual[:, :3]),
    )


def _hand_over(mesh: Mesh, residual: Float[np.ndarray, "node 3"]) -> Float[np.ndarray, "node 3"]:
    """Forces that followers hand over: those of released ends go through the joint that they sit on."""
    follows = mesh.node_leader != np.arange(mesh.n_nodes)
    handed = np.where(follows[:, None], residual, 0.0)
    released = follows & (mesh.node_dof >= 0).any(axis=1)
    passed_on = np.flatnonzero(released & follows[mesh.node_leader])
    np.add.at(handed, mesh.node_leader[passed_on], handed[passed_on])
    return handed


def element_geometric(mesh: Mesh, axial: Float[np.ndarray, " element"]) -> Float[np.ndarray, "element 12 12"]:
    """Geometric stiffness of each element in element axes under its axial force in N, tension positive."""
    return np.asarray(slope_matrix(mesh.element_length) * axial[:, None, None])


def follower_levers(mesh: Mesh, state: Rest) -> Float[np.ndarray, "node 6 6"]:
    """Geometric stiffness of the rigid bodies, at their leading nodes, under the forces handed over."""
    result = np.zeros((mesh.n_nodes, 6, 6))
    for node in np.flatnonzero(state.handed_over.any(axis=1)).tolist():
        leader = int(mesh.node_leader[node])
        offset = mesh.node_position[node] - mesh.node_position[leader]
        result[leader, 3:, 3:] += _lever(state.handed_over[node], offset)
    return result


def body_levers(mesh: Mesh, state: StaticState) -> Float[np.ndarray, "node 6 6"]:
    """Geometric stiffness of lumped bodies whose centre of gravity lies off their node."""
    result = np.zeros((mesh.n_nodes, 6, 6))
    for node, body in bodies(mesh):
        weight = np.array([0.0, 0.0, -body.mass_kg * state.gravity_m_s2])
        result[node, 3:, 3:] += _lever(weight, np.array(body.offset_m))
    return result


def _lever(force: Float[np.ndarray, " 3"], offset: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """Second derivative of -force . (theta x (theta x offset))/2, the work of a dead force on a lever."""
    cross = 0.5 * (np.outer(force, offset) + np.outer(offset, force))
    return np.asarray(float(force @ offset) * np.eye(3) - cross)
