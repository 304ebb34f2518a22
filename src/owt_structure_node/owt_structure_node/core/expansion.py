"""Motion of all nodes from the free degrees of freedom: supports, rigid bodies, released member ends.

A node that follows another (:attr:`owt_model.mesh.Mesh.node_leader`) moves with it as a rigid body; a
released member end keeps rotations of its own about its free axes.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array, csr_array

from owt_model.mesh import DOF_TIED, Mesh

__all__ = ["expansion", "lever"]


def lever(offset: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "6 6"]:
    """Motion of a point of a rigid body, `offset` in m away from the one whose six motions are given."""
    x, y, z = offset
    rigid = np.eye(6)
    rigid[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return rigid


def expansion(mesh: Mesh) -> csr_array:
    """Return the sparse matrix [6 node, dof] from the free degrees of freedom to the motion of all nodes."""
    own = _own(mesh)
    followers = np.flatnonzero(mesh.node_leader != np.arange(mesh.n_nodes))
    if not len(followers):
        return own
    released = (mesh.node_dof[followers] >= 0).any(axis=1)
    # Released ends follow joints, which may follow in turn: joints first.
    follow = _follow(mesh, followers[~released])
    moved = csr_array(own + follow @ own)
    if not released.any():
        return moved
    return csr_array(moved + _follow(mesh, followers[released]) @ moved)


def _own(mesh: Mesh) -> csr_array:
    """Motion by each node's own degrees of freedom."""
    node, direction = np.nonzero(mesh.node_dof >= 0)
    column = mesh.node_dof[node, direction]
    turned = mesh.node_axes[node, direction % 3]
    plain = (turned == np.eye(3)[direction % 3]).all(axis=1) | (direction < 3)
    rows = [6 * node[plain] + direction[plain]]
    columns, values = [column[plain]], [np.ones(int(plain.sum()))]
    for i in range(3):
        rows.append(6 * node[~plain] + 3 + i)
        columns.append(column[~plain])
        values.append(turned[~plain, i])
    return _sparse(rows, columns, values, mesh.n_dof, mesh)


def _follow(mesh: Mesh, nodes: Int[np.ndarray, " follower"]) -> csr_array:
    """Motion of `nodes` by that of their leaders, rotations about their free axes left out."""
    rows: list[Int[np.ndarray, " _"]] = []
    columns: list[Int[np.ndarray, " _"]] = []
    values: list[Float[np.ndarray, " _"]] = []
    for node in nodes.tolist():
        leader = int(mesh.node_leader[node])
        rigid = lever(mesh.node_position[node] - mesh.node_position[leader])
        axes, tied = mesh.node_axes[node], mesh.node_dof[node, 3:] == DOF_TIED
        if not tied.all():
            rigid[3:, 3:] = axes[tied].T @ axes[tied]
        i, j = np.nonzero(rigid)
        rows.append(6 * node + i)
        columns.append(6 * leader + j)
        values.append(rigid[i, j])
    return _sparse(rows, columns, values, 6 * mesh.n_nodes, mesh)


def _sparse(
    rows: list[Int[np.ndarray, " _"]],
    columns: list[Int[np.ndarray, " _"]],
    values: list[Float[np.ndarray, " _"]],
    width: int,
    mesh: Mesh,
) -> csr_array:
    shape = (6 * mesh.n_nodes, width)
    if not rows:
        return csr_array(shape)
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(coo_array(entries, shape=shape))
