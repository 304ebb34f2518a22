"""Members and joints as lines with walls: what the geometry of tubular joints follows from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.mesh import DOF_TIED, Mesh

__all__ = ["Frame", "frame_of_mesh", "tied_nodes"]


@dataclass(frozen=True)
class Frame:
    """Lines and walls of the members.

    Attributes
    ----------
    node_name : tuple of str [node]
    node_position : float array [node, 3]
        In m.
    node_tied : bool array [node]
        True where a node follows another as a rigid body.
    member_name : tuple of str [member]
    member_node : int array [member, 2]
        First and last joint.
    end_diameter, end_thickness : float arrays [end]
        Outer diameter and wall in m of the element at each member end: 2 m and 2 m + 1 of member m.
    """

    node_name: tuple[str, ...]
    node_position: Float[np.ndarray, "node 3"]
    node_tied: Bool[np.ndarray, " node"]
    member_name: tuple[str, ...]
    member_node: Int[np.ndarray, "member 2"]
    end_diameter: Float[np.ndarray, " end"]
    end_thickness: Float[np.ndarray, " end"]

    @property
    def n_ends(self) -> int:
        """Number of member ends."""
        return 2 * len(self.member_name)

    @property
    def end_node(self) -> Int[np.ndarray, " end"]:
        """Joint of each member end."""
        return self.member_node.reshape(-1)

    @cached_property
    def end_name(self) -> tuple[str, ...]:
        """Name ``member:joint`` of each member end."""
        names = (name for name in self.member_name for _ in range(2))
        return tuple(
            f"{name}:{self.node_name[node]}" for name, node in zip(names, self.end_node, strict=True)
        )

    def outwards(self, end: int) -> Float[np.ndarray, " 3"]:
        """Vector in m from the joint of an end to the other joint of its member."""
        member, side = divmod(end, 2)
        nodes = self.member_node[member]
        return np.asarray(self.node_position[nodes[1 - side]] - self.node_position[nodes[side]])


def tied_nodes(node_dof: Int[np.ndarray, "node 6"]) -> Bool[np.ndarray, " node"]:
    """Nodes whose displacement follows another's."""
    return np.asarray((node_dof[:, :3] == DOF_TIED).all(axis=1))


def frame_of_mesh(mesh: Mesh) -> Frame:
    """Lines and walls of a mesh."""
    return Frame(
        node_name=mesh.node_name,
        node_position=mesh.node_position,
        node_tied=tied_nodes(mesh.node_dof),
        member_name=mesh.member_name,
        member_node=mesh.member_node,
        end_diameter=mesh.element_diameter[mesh.end_element],
        end_thickness=mesh.element_thickness[mesh.end_element],
    )
