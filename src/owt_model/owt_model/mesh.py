"""The finite element mesh of a structure: nodes, beam elements, supports and the rigid interface.

Node order: joints as listed in the structure, then the own nodes of each member, then the
transition-piece node, then the tower nodes from bottom to top. A member's own nodes are those inside it
and, at a released end, one on the joint, ``member:joint``: it moves with the joint but for the free
rotations, which are degrees of freedom of its own about :attr:`Mesh.node_axes`. Nodal loads, masses and
section forces at a released end need nothing else. Element order: member by member from
the first joint to the second, then the tower from bottom to top. Both orders are part of the
interface: messages and result files use them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.axes import rotation
from owt_model.structure import Member, Release, Section, Structure, Tower

__all__ = ["DOF_FIXED", "DOF_TIED", "Mesh", "build_mesh"]

#: Entries of :attr:`Mesh.node_dof` for degrees of freedom that are not free.
DOF_FIXED = -1
DOF_TIED = -2


@dataclass(frozen=True)
class Mesh:
    """Beam elements between nodes; arrays in SI units, indices into nodes, elements and members.

    Attributes
    ----------
    structure : Structure
        What the mesh was made from.
    node_name : tuple of str [node]
        Joint, ``member.i``, ``TP`` or ``tower.i``.
    node_position : float array [node, 3]
        x, y, z in m, z up from still water.
    node_dof : int array [node, 6]
        Number of the free degree of freedom, ``DOF_FIXED`` at supports, ``DOF_TIED`` where the node
        follows :attr:`node_leader`.
    node_leader : int array [node]
        Node that this one follows as a rigid body, itself where it follows none: the transition piece for
        interface joints, a joint for the others of its rigid link and for released member ends.
    node_axes : float array [node, 3, 3]
        Directions, as rows, of the rotational degrees of freedom of a released end; of any other node those
        of the global axes.
    element_node : int array [element, 2]
        First and last node.
    element_member : int array [element]
        Member of the element, -1 for a tower element.
    element_diameter, element_thickness : float arrays [element]
        Outer diameter and wall thickness in m; where they vary, those at its middle.
    element_youngs_modulus, element_shear_modulus : float arrays [element]
        Pa.
    element_density : float array [element]
        Density of the wall in kg/m3.
    member_name : tuple of str [member]
        In the order of the structure.
    member_node, member_element : int arrays [member, 2]
        First and last joint, first and last element of each member.
    member_flooded : bool array [member]
        True where water fills the member up to the free surface of the structure's `flooding`.
    interface_node : int array [interface]
        Joints tied to the transition piece.
    transition_piece : int
        Node of the transition piece.
    tower_node : int array [tower_node]
        Nodes of the tower above the transition piece, bottom to top; empty without a tower.
    """

    structure: Structure
    node_name: tuple[str, ...]
    node_position: Float[np.ndarray, "node 3"]
    node_dof: Int[np.ndarray, "node 6"]
    node_leader: Int[np.ndarray, " node"]
    node_axes: Float[np.ndarray, "node 3 3"]
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
    def element_length(self) -> Float[np.ndarray, " element"]:
        """Length of each element in m."""
        ends = self.node_position[self.element_node]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

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


class _Builder:
    """Nodes and elements, in the order in which they are added."""

    def __init__(self, structure: Structure) -> None:
        self.joint = {name: i for i, name in enumerate(structure.joints)}
        self.name = list(structure.joints)
        self.position = [np.array(p, dtype=float) for p in structure.joints.values()]
        self.released: dict[int, tuple[int, Release, Float[np.ndarray, "3 3"]]] = {}
        self.ends: list[tuple[int, int]] = []
        self.owner: list[int] = []
        self.properties: list[tuple[float, ...]] = []

    def node(self, name: str, position: Float[np.ndarray, " 3"]) -> int:
        """Add a node; returns its index."""
        self.name.append(name)
        self.position.append(position)
        return len(self.name) - 1

    def end(self, name: str, member: Member, side: int) -> int:
        """Node of a member's end: its joint, or a new node on it where the end is released."""
        joint, release = member.joints[side], member.releases[side]
        leader = self.joint[joint]
        if release is None:
            return leader
        ends = [self.position[self.joint[j]][None] for j in member.joints]
        node = self.node(f"{name}:{joint}", self.position[leader])
        self.released[node] = (leader, release, _release_axes(release, rotation(*ends)[0]))
        return node

    def element(
        self, first: int, last: int, owner: int, wall: tuple[float, float], material: Section | Tower
    ) -> int:
        """Add an element of diameter and thickness `wall` between two nodes; returns its index."""
        self.ends.append((first, last))
        self.owner.append(owner)
        self.properties.append(
            (*wall, material.youngs_modulus_pa, material.shear_modulus_pa, material.density_kg_m3)
        )
        return len(self.ends) - 1

    def member(self, m: int, name: str, member: Member, structure: Structure) -> list[int]:
        """Add a member and its elements, each as it is at its middle; returns its first and last element."""
        count = structure.elements_per_member
        begin, end = (self.position[self.joint[j]] for j in member.joints)
        nodes = [self.end(name, member, 0)]
        nodes += [self.node(f"{name}.{i}", begin + (end - begin) * (i / count)) for i in range(1, count)]
        nodes.append(self.end(name, member, 1))
        section = structure.sections[member.section]
        last = structure.sections[member.section_last or member.section]
        added = []
        for i, (a, b) in enumerate(pairwise(nodes)):
            s = (i + 0.5) / count
            wall = (
                section.diameter_m + (last.diameter_m - section.diameter_m) * s,
                section.thickness_m + (last.thickness_m - section.thickness_m) * s,
            )
            added.append(self.element(a, b, m, wall, section))
        return [added[0], added[-1]]

    def tower(self, tower: Tower, base: int) -> list[int]:
        """Add the tower upon node `base`, each element as it is at its middle; returns its nodes."""
        nodes = [base]
        for i in range(tower.elements):
            rise = np.array([0.0, 0.0, tower.height_m * (i + 1) / tower.elements])
            nodes.append(self.node(f"tower.{i + 1}", self.position[base] + rise))
            middle = (i + 0.5) / tower.elements
            wall = (tower.diameter_at(middle), tower.thickness_at(middle))
            self.element(nodes[-2], nodes[-1], -1, wall, tower)
        return nodes[1:]


def build_mesh(structure: Structure) -> Mesh:
    """Subdivide the members and the tower of `structure` into elements."""
    made = _Builder(structure)
    members = structure.members.values()
    member_element = [
        made.member(m, name, member, structure) for m, (name, member) in enumerate(structure.members.items())
    ]
    transition_piece = made.node("TP", np.array(structure.interface.reference_m, dtype=float))
    tower_node = [] if structure.tower is None else made.tower(structure.tower, transition_piece)
    leader, axes = _leaders(structure, made, transition_piece)
    diameter, thickness, youngs, shear, density = np.array(made.properties, dtype=float).T.copy()
    return Mesh(
        structure=structure,
        node_name=tuple(made.name),
        node_position=np.array(made.position),
        node_dof=_number(structure, made, leader),
        node_leader=leader,
        node_axes=axes,
        element_node=np.array(made.ends, dtype=np.int64),
        element_member=np.array(made.owner, dtype=np.int64),
        element_diameter=diameter,
        element_thickness=thickness,
        element_youngs_modulus=youngs,
        element_shear_modulus=shear,
        element_density=density,
        member_name=tuple(structure.members),
        member_node=np.array([[made.joint[j] for j in member.joints] for member in members], dtype=np.int64),
        member_element=np.array(member_element, dtype=np.int64),
        member_flooded=np.array([member.flooded for member in members], dtype=bool),
        interface_node=np.array([made.joint[name] for name in structure.interface.joints], dtype=np.int64),
        transition_piece=transition_piece,
        tower_node=np.array(tower_node, dtype=np.int64),
    )


def _release_axes(release: Release, member: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3 3"]:
    """Directions about which the end turns: the member's own axes, or a hinge and two across it."""
    if release.hinge is None:
        return member
    hinge = np.array(release.hinge) / np.linalg.norm(release.hinge)
    other = np.eye(3)[int(np.abs(hinge).argmin())]
    across = np.cross(hinge, other) / np.linalg.norm(np.cross(hinge, other))
    return np.array([hinge, across, np.cross(hinge, across)])


def _leaders(
    structure: Structure, made: _Builder, transition_piece: int
) -> tuple[Int[np.ndarray, " node"], Float[np.ndarray, "node 3 3"]]:
    """Which node each follows, chains resolved to their last, and the axes of the rotations."""
    leader = np.arange(len(made.name), dtype=np.int64)
    for name, of in structure.rigid_groups().items():
        leader[made.joint[name]] = made.joint[of]
    tied = [made.joint[joint] for joint in structure.interface.joints]
    leader[np.isin(leader, tied)] = transition_piece
    axes = np.tile(np.eye(3), (len(leader), 1, 1))
    for node, (joint, _, directions) in made.released.items():
        leader[node], axes[node] = joint, directions
    return leader, axes


def _number(
    structure: Structure, made: _Builder, leader: Int[np.ndarray, " node"]
) -> Int[np.ndarray, "node 6"]:
    """Number the free degrees of freedom in node order."""
    state = np.zeros((len(leader), 6), dtype=np.int64)
    for name, fixed in structure.supports.items():
        state[made.joint[name], np.array(fixed)] = DOF_FIXED
    state[leader != np.arange(len(leader))] = DOF_TIED
    for node, (_, release, _) in made.released.items():
        about = "x" if release.hinge is not None else release.about
        state[node, [3 + "xyz".index(axis) for axis in about]] = 0
    free = state == 0
    state[free] = np.arange(np.count_nonzero(free))
    return state
