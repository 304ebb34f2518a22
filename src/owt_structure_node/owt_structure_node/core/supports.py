"""Elastic supports, and the refusal of structures that can move freely.

A part without releases can only move as a whole: a geometric check, with no threshold on stiffness. With
released member ends or springs between joints the stiffness itself is searched for a motion that strains
nothing.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import block_diag, coo_array, csc_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from owt_model.errors import InputError
from owt_model.mesh import DOF_FIXED, Mesh
from owt_structure_node.core.expansion import lever
from owt_structure_node.core.modes import factorise

__all__ = ["check_releases", "check_supports", "spring_stiffness"]

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
#: Stiffness relative to the diagonal that keeps a mechanism's factorisation finite.
_SHIFT = 1e-13


def check_supports(mesh: Mesh, *, interface_held: bool = False) -> None:
    """Refuse a mesh of which a connected part is a mechanism, with the interface held or free.

    All members are joined rigidly, so that a part can only move as a whole; it cannot where its
    supports resist all six rigid motions.

    Raises
    ------
    InputError
        Naming a joint of the part and the motion that nothing resists.
    """
    part = _parts(mesh)
    for i in range(int(part.max()) + 1):
        if interface_held and part[mesh.transition_piece] == i:
            continue
        _check_part(mesh, np.flatnonzero(part == i))


def _parts(mesh: Mesh) -> Int[np.ndarray, " node"]:
    """Number of the connected part to which each node belongs."""
    tie = np.stack([np.arange(mesh.n_nodes), mesh.node_leader], axis=1)
    index = {name: i for i, name in enumerate(mesh.node_name)}
    sprung = [[index[joint] for joint in spring.joints] for spring in mesh.structure.joint_springs.values()]
    pairs = np.concatenate([mesh.element_node, tie, np.array(sprung, dtype=np.int64).reshape(-1, 2)])
    size = mesh.n_nodes
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    return np.asarray(connected_components(graph, directed=False)[1]).astype(np.int64)


def _check_part(mesh: Mesh, nodes: Int[np.ndarray, " part_node"]) -> None:
    name = mesh.node_name[nodes[0]]
    held = {mesh.node_name[i] for i in nodes[(mesh.node_dof[nodes] == DOF_FIXED).any(axis=1)]}
    held |= {mesh.node_name[i] for i in nodes} & set(mesh.structure.support_springs)
    if not held:
        raise InputError(
            "supports",
            [*mesh.structure.supports, *mesh.structure.support_springs],
            f"must hold every part of the structure: nothing connects joint {name} to a support",
            "Connect it by members, support it, or hold the interface (--fixed-interface).",
        )
    centre = mesh.node_position[nodes].mean(axis=0)
    size = max(float(np.abs(mesh.node_position[nodes] - centre).max()), 1e-30)
    rows = [
        row
        for node in nodes
        if mesh.node_name[node] in held
        for row in _resisted(mesh, int(node), (mesh.node_position[node] - centre) / size, size)
    ]
    _, strength, motions = np.linalg.svd(np.array(rows), full_matrices=True)
    strength = np.concatenate([strength, np.zeros(6 - len(strength))])[:6] if len(rows) < 6 else strength
    if strength[5] <= _FREE * strength[0]:
        motion = _MOTION[int(np.abs(motions[-1]).argmax())]
        raise InputError(
            "supports",
            sorted(held),
            f"must resist every motion: the part of joint {name} is free to move {motion}",
            "Fix more degrees of freedom.",
        )


def _resisted(
    mesh: Mesh, node: int, place: Float[np.ndarray, " 3"], size: float
) -> list[Float[np.ndarray, " 6"]]:
    """Rigid motions, in units of `size` and rad about the part's centre, that a support resists."""
    directions = [np.eye(6)[i] for i in np.flatnonzero(mesh.node_dof[node] == DOF_FIXED)]
    spring = mesh.structure.support_springs.get(mesh.node_name[node])
    if spring is not None:
        matrix = np.array(spring.matrix)
        scale = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
        values, vectors = np.linalg.eigh(matrix / scale[:, None] / scale)
        directions += [v * scale for value, v in zip(values, vectors.T, strict=True) if value > _FREE]
    rows = []
    for v in directions:
        row = np.concatenate([size * v[:3], size * np.cross(place, v[:3]) + v[3:]])
        rows.append(row / np.linalg.norm(row))
    return rows


def spring_stiffness(mesh: Mesh) -> csr_array:
    """Stiffness of supports, of springs between joints and in released ends, over all nodes."""
    index = {name: i for i, name in enumerate(mesh.node_name)}
    blocks = np.zeros((mesh.n_nodes, 6, 6))
    for joint, spring in mesh.structure.support_springs.items():
        blocks[index[joint]] += np.array(spring.matrix)
    result = csr_array(block_diag(list(blocks)))
    for link in mesh.structure.joint_springs.values():
        a, b = (index[joint] for joint in link.joints)
        relative = np.hstack([-lever(mesh.node_position[b] - mesh.node_position[a]), np.eye(6)])
        result = result + _between(a, b, relative.T @ np.array(link.matrix) @ relative, mesh)
    for name, member in mesh.structure.members.items():
        for joint, release in zip(member.joints, member.releases, strict=True):
            if release is None or release.stiffness_nm_rad == 0.0:
                continue
            node, leader = index[f"{name}:{joint}"], index[joint]
            # All three rotations: those that are not free do not differ.
            turn = np.diag([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
            couple = release.stiffness_nm_rad * np.kron([[1.0, -1.0], [-1.0, 1.0]], turn)
            result = result + _between(leader, node, couple, mesh)
    return csr_array(result)


def _between(first: int, last: int, matrix: Float[np.ndarray, "12 12"], mesh: Mesh) -> csr_array:
    """Stiffness of two nodes among all."""
    dof = np.concatenate([6 * first + np.arange(6), 6 * last + np.arange(6)])
    size = 6 * mesh.n_nodes
    entries = (matrix.reshape(-1), (np.repeat(dof, 12), np.tile(dof, 12)))
    return csr_array(coo_array(entries, shape=(size, size)))


def check_releases(mesh: Mesh, expansion: csr_array, stiffness: csc_array) -> None:
    """Refuse a structure whose released ends or springs let a part move freely.

    Inverse iteration finds the softest motion; it is free where its stiffness, relative to the diagonal's,
    is round-off.

    Raises
    ------
    InputError
        Naming the joint or member end that moves most, and its direction.
    """
    members = mesh.structure.members.values()
    if not mesh.structure.joint_springs and all(member.releases == (None, None) for member in members):
        return
    diagonal = stiffness.diagonal()
    loose = np.flatnonzero(diagonal <= 0.0)
    if len(loose):
        raise _moves_freely(mesh, np.asarray(expansion[:, loose[0]].todense()).reshape(-1, 6))
    factor = factorise(csc_array(stiffness + diags_array(_SHIFT * diagonal)))
    motion = np.random.default_rng(4).standard_normal(len(diagonal)) / np.sqrt(diagonal)
    for _ in range(4):
        motion = factor.solve(diagonal * motion)
        motion /= np.sqrt(motion @ (diagonal * motion))
    if motion @ (stiffness @ motion) < 10.0 * _SHIFT:
        raise _moves_freely(mesh, (expansion @ motion).reshape(-1, 6))


def _moves_freely(mesh: Mesh, motion: Float[np.ndarray, "node 6"]) -> InputError:
    """Error for a free motion of all nodes."""
    size = float(mesh.element_length.mean())
    amount = np.abs(motion * np.array([1.0, 1.0, 1.0, size, size, size]))
    node, direction = np.unravel_index(int(amount.argmax()), amount.shape)
    return InputError(
        "releases and joint_springs",
        mesh.node_name[int(node)],
        f"moves freely {_MOTION[int(direction)]}: the structure is a mechanism",
        "Release less (a bar of a truss keeps its torsion at one end, about: yz), or add stiffness.",
    )
