"""Refuses structures that can move as a rigid body: a geometric check, no threshold on stiffness."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from owt_model.errors import InputError
from owt_model.mesh import DOF_FIXED, Mesh

__all__ = ["check_supports"]

_MOTION = (
    "along x",
    "along y",
    "along z",
    "about x",
    "about y",
    "about z",
)
#: Singular value, relative to the largest, below which a rigid motion counts as unresisted.
_FREE = 1e-9


def check_supports(mesh: Mesh) -> None:
    """Refuse a mesh of which a connected part is a mechanism.

    All members are joined rigidly, so that a part can only move as a whole; it cannot where its
    supports resist all six rigid motions.

    Raises
    ------
    InputError
        Naming a joint of the part and the motion that nothing resists.
    """
    part = _parts(mesh)
    for i in range(int(part.max()) + 1):
        _check_part(mesh, np.flatnonzero(part == i))


def _parts(mesh: Mesh) -> Int[np.ndarray, " node"]:
    """Number of the connected part to which each node belongs."""
    tie = np.stack([mesh.interface_node, np.full_like(mesh.interface_node, mesh.transition_piece)], axis=1)
    pairs = np.concatenate([mesh.element_node, tie])
    size = mesh.n_nodes
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    return np.asarray(connected_components(graph, directed=False)[1]).astype(np.int64)


def _check_part(mesh: Mesh, nodes: Int[np.ndarray, " part_node"]) -> None:
    name = mesh.node_name[nodes[0]]
    fixed_node, fixed_direction = np.nonzero(mesh.node_dof[nodes] == DOF_FIXED)
    if not len(fixed_node):
        raise InputError(
            "supports",
            list(mesh.structure.supports),
            f"must hold every part of the structure: nothing connects joint {name} to a support",
            "Connect it by members, or support it.",
        )
    position = mesh.node_position[nodes] - mesh.node_position[nodes].mean(axis=0)
    position = position / max(float(np.abs(position).max()), 1e-30)
    rows = np.zeros((len(fixed_node), 6))
    for row, node, direction in zip(rows, fixed_node, fixed_direction, strict=True):
        unit = np.eye(3)[direction % 3]
        if direction < 3:
            row[:3], row[3:] = unit, np.cross(position[node], unit)
        else:
            row[3:] = unit
    _, strength, motions = np.linalg.svd(rows, full_matrices=True)
    strength = np.concatenate([strength, np.zeros(6 - len(strength))])[:6]
    if strength[-1] <= _FREE * strength[0]:
        motion = _MOTION[int(np.abs(motions[-1]).argmax())]
        raise InputError(
            "supports",
            sorted({mesh.node_name[nodes[i]] for i in fixed_node}),
            f"must resist every motion: the part of joint {name} is free to move {motion}",
            "Fix more degrees of freedom.",
        )
