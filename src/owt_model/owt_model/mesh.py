"""The finite element mesh of a structure: nodes, beam elements, supports and the rigid interface.

Node order: joints as listed in the structure, then the internal nodes of each member, then the
transition-piece node, then the tower nodes from bottom to top. Element order: member by member from
the first joint to the second, then the tower from bottom to top. Both orders are part of the
interface: messages and result files use them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.structure import Structure

__all__ = ["DOF_FIXED", "DOF_TIED", "Mesh", "build_mesh"]

#: Entries of :attr:`Mesh.node_dof` for degrees of freedom that are not free.
DOF_FIXED = -1
DOF_TIED = -2


@dataclass(frozen=True)
class Mesh:
    """Beam elements between nodes; arrays in SI units, indices into nodes, elements and members.

    Attributes
    ----------
    node_dof : int array [node, 6]
        Number of the free degree of freedom, ``DOF_FIXED`` at supports, ``DOF_TIED`` at interface
        joints, whose motion is that of the rigid transition piece.
    element_member : int array [element]
        Member of the element, -1 for a tower element.
    member_node, member_element : int arrays [member, 2]
        First and last node, first and last element of each member.
    """

    structure: Structure
    node_name: tuple[str, ...]
    node_position: Float[np.ndarray, "node 3"]
    node_dof: Int[np.ndarray, "node 6"]
    element_node: Int[np.ndarray, "element 2"]
    element_member: Int[np.ndarray, " element"]
    element_diameter: Float[np.ndarray, " element"]
    element_thickness: Float[np.ndarray, " element"]
    element_youngs_modulus: Float[np.ndarray, " element"]
    element_shear_modulus: Float[np.ndarray, " element"]
    element_density: Float[np.ndarray, " element"]
    member_name: tuple[str, ...]
    member_node: Int[np.ndarray, "member 2"]
    member_element: Int[np.ndarray, "member 2"]
    member_flooded: Bool[np.ndarray, " member"]
    interface_node: Int[np.ndarray, " interface"]
    transition_piece: int
    tower_node: Int[np.ndarray, " tower_node"]

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.node_name)

    @property
    def n_elements(self) -> int:
        """Number of elements, tower included."""
        return len(self.element_member)

    @property
    def n_members(self) -> int:
        """Number of members, tower not included."""
        return len(self.member_name)

    @property
    def n_dof(self) -> int:
        """Number of free degrees of freedom, the six of the transition piece included."""
        return int(self.node_dof.max()) + 1

    @property
    def tower_top(self) -> int:
        """Node at the tower top; the transition piece where there is no tower."""
        return int(self.tower_node[-1]) if len(self.tower_node) else self.transition_piece

    @property
    def is_tower(self) -> Bool[np.ndarray, " element"]:
        """True for elements of the tower."""
        return np.asarray(self.element_member < 0)

    @property
    def end_element(self) -> Int[np.ndarray, " end"]:
        """Element at each member end; ends are ordered member 0 first, member 0 last, member 1 first, ..."""
        return self.member_element.reshape(-1)

    @property
    def end_name(self) -> tuple[str, ...]:
        """Name ``member:joint`` of each member end, in the order of :attr:`end_element`."""
        return tuple(
            f"{name}:{self.node_name[node]}"
            for name, nodes in zip(self.member_name, self.member_node, strict=True)
            for node in nodes
        )


def build_mesh(structure: Structure) -> Mesh:
    """Subdivide the members and the tower of `structure` into elements."""
    joint = {name: i for i, name in enumerate(structure.joints)}
    names = list(structure.joints)
    position = [np.array(p, dtype=float) for p in structure.joints.values()]
    sections = structure.sections
    nodes: list[tuple[int, int]] = []
    owner: list[int] = []
    properties: list[tuple[float, ...]] = []
    member_node, member_element = [], []
    n = structure.elements_per_member
    for m, (name, member) in enumerate(structure.members.items()):
        first, last = joint[member.joints[0]], joint[member.joints[1]]
        chain = [first]
        for i in range(1, n):
            chain.append(len(names))
            names.append(f"{name}.{i}")
            position.append(position[first] + (position[last] - position[first]) * (i / n))
        chain.append(last)
        section = sections[member.section]
        member_node.append((first, last))
        member_element.append((len(nodes), len(nodes) + n - 1))
        for a, b in pairwise(chain):
            nodes.append((a, b))
            owner.append(m)
            properties.append(
                (
                    section.diameter_m,
                    section.thickness_m,
                    section.youngs_modulus_pa,
                    section.shear_modulus_pa,
                    section.density_kg_m3,
                )
            )
    transition_piece = len(names)
    names.append("TP")
    position.append(np.array(structure.interface.reference_m, dtype=float))
    tower_node = _add_tower(structure, transition_piece, names, position, nodes, owner, properties)
    columns = np.array(properties, dtype=float).T.copy()
    return Mesh(
        structure=structure,
        node_name=tuple(names),
        node_position=np.array(position),
        node_dof=_number(structure, joint, len(names)),
        element_node=np.array(nodes, dtype=np.int64),
        element_member=np.array(owner, dtype=np.int64),
        element_diameter=columns[0],
        element_thickness=columns[1],
        element_youngs_modulus=columns[2],
        element_shear_modulus=columns[3],
        element_density=columns[4],
        member_name=tuple(structure.members),
        member_node=np.array(member_node, dtype=np.int64),
        member_element=np.array(member_element, dtype=np.int64),
        member_flooded=np.array([member.flooded for member in structure.members.values()], dtype=bool),
        interface_node=np.array([joint[name] for name in structure.interface.joints], dtype=np.int64),
        transition_piece=transition_piece,
        tower_node=np.array(tower_node, dtype=np.int64),
    )


def _add_tower(
    structure: Structure,
    transition_piece: int,
    names: list[str],
    position: list[Float[np.ndarray, " 3"]],
    nodes: list[tuple[int, int]],
    owner: list[int],
    properties: list[tuple[float, ...]],
) -> list[int]:
    """Append the tower; each element has the diameter and thickness at its middle."""
    tower = structure.tower
    if tower is None:
        return []
    base, below, added = position[transition_piece], transition_piece, []
    for i in range(tower.elements):
        s = (i + 0.5) / tower.elements
        diameter = tower.diameter_base_m + (tower.diameter_top_m - tower.diameter_base_m) * s
        thickness = (
            tower.thickness_base_m * (1 - s) * (1 - 2 * s)
            + 4 * tower.thickness_mid_m * s * (1 - s)
            + tower.thickness_top_m * s * (2 * s - 1)
        )
        above = len(names)
        names.append(f"tower.{i + 1}")
        position.append(base + np.array([0.0, 0.0, tower.height_m * (i + 1) / tower.elements]))
        nodes.append((below, above))
        owner.append(-1)
        properties.append(
            (diameter, thickness, tower.youngs_modulus_pa, tower.shear_modulus_pa, tower.density_kg_m3)
        )
        added.append(above)
        below = above
    return added


def _number(structure: Structure, joint: dict[str, int], n_nodes: int) -> Int[np.ndarray, "node 6"]:
    """Number the free degrees of freedom in node order."""
    state = np.zeros((n_nodes, 6), dtype=np.int64)
    for name, fixed in structure.supports.items():
        state[joint[name], np.array(fixed)] = DOF_FIXED
    for name in structure.interface.joints:
        state[joint[name]] = DOF_TIED
    free = state == 0
    state[free] = np.arange(np.count_nonzero(free))
    return state
