"""Damping of the assembled model in its modes: Rayleigh, single modes, dashpots, drag.

In mass-normalised modes, diagonal in all but a few directions:

    C = diag(2 zeta omega) + G G'

Rayleigh damping and the ratios given to single modes make the diagonal. Dashpots couple the modes: each of
their directions gives one column of G, the root of its coefficient times the motion of its place in every
mode; so does the drag on the structure's own motion. A dashpot at the tower top has one to six columns where
C would have as many as there are modes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import LinAlgError, eig
from scipy.sparse import csc_array, csr_array, vstack

from owt_model.contracts import LoadBasis
from owt_model.errors import ComputationError, InputError
from owt_model.mesh import Mesh
from owt_model.structure_config import Damping
from owt_model.structure_names import TOWER_TOP
from owt_structure_node.core.expansion import lever
from owt_structure_node.core.modes import Factor, dense_modes

__all__ = [
    "DampedModes",
    "ModalDamping",
    "above_interface",
    "all_vectors",
    "check_modes",
    "damped_modes",
    "dashpot_vectors",
    "drag_vectors",
    "idle_dashpots",
    "lowest_damped",
    "modal_damping",
    "roots",
    "with_static_responses",
]

#: Share of the largest eigenvalue of a dashpot's matrix, on a unit diagonal, below which one is round-off.
_NEGLIGIBLE = 1e-14
#: Share of the largest singular value of G below which one is round-off.
_LAST_DIGIT = 1e-14
#: Negative damping ratio that is round-off.
_ROUND_OFF = 1e-9
#: Share of its energy that a static response must keep beside the modes to count.
_DEPENDENT = 1e-10


@dataclass(frozen=True)
class ModalDamping:
    """C = diag(rate) + coupling coupling' in mass-normalised modes.

    Attributes
    ----------
    rate : float array [mode]
        2 zeta omega in 1/s.
    coupling : float array [mode, direction]
        G in s^-1/2; no columns where nothing couples the modes.
    """

    rate: Float[np.ndarray, " mode"]
    coupling: Float[np.ndarray, "mode direction"]

    @property
    def diagonal(self) -> Float[np.ndarray, " mode"]:
        """Diagonal of C in 1/s: what is left of it where coupling is neglected."""
        return np.asarray(self.rate + (self.coupling**2).sum(axis=1))

    @property
    def dashpots(self) -> Float[np.ndarray, "mode direction"] | None:
        """`coupling`, None where nothing couples the modes."""
        return self.coupling if self.coupling.size else None


@dataclass(frozen=True)
class DampedModes:
    """Free decay of each mode, in the order of the undamped modes.

    Attributes
    ----------
    frequency_hz : float array [mode]
        Of the damped oscillation; 0 where nothing oscillates.
    ratio : float array [mode]
        Damping ratio -Re(lambda) / |lambda|; 1 or more of overdamped modes, and of those that strong dashpots
        have changed so much that none of the damped modes is named after them.
    """

    frequency_hz: Float[np.ndarray, " mode"]
    ratio: Float[np.ndarray, " mode"]


def modal_damping(
    omega_squared: Float[np.ndarray, " mode"],
    damping: Damping,
    dashpots: Float[np.ndarray, "direction mode"] | None = None,
) -> ModalDamping:
    """Damping of modes by Rayleigh coefficients, ratios of single modes, and dashpots.

    Parameters
    ----------
    omega_squared : float array [mode]
        Squares of the undamped angular frequencies in rad2/s2.
    damping : Damping
        Coefficients and ratios; a ratio replaces what Rayleigh gives its mode, dashpots come on top.
    dashpots : float array [direction, mode], optional
        Vectors of :func:`dashpot_vectors` and :func:`drag_vectors` times the motion of the nodes in each
        mass-normalised mode.

    Raises
    ------
    InputError
        If a ratio is given to a mode that there is not.
    """
    check_modes(damping, len(omega_squared))
    alpha, beta = damping.rayleigh
    rate = alpha + beta * omega_squared
    for mode, ratio in damping.mode_ratio.items():
        rate[mode] = 2.0 * ratio * np.sqrt(omega_squared[mode])
    none = np.zeros((len(rate), 0))
    return ModalDamping(rate, none if dashpots is None or not len(dashpots) else _compressed(dashpots.T))


def check_modes(damping: Damping, count: int) -> None:
    """Refuse a ratio of a mode beyond the `count` that there are.

    Raises
    ------
    InputError
        Naming the mode.
    """
    for mode in damping.mode_ratio:
        if mode >= count:
            raise InputError(
                "structure.damping.modes",
                mode + 1,
                f"is not one of {count} modes",
                "Count modes from 1, the lowest.",
            )


def _compressed(coupling: Float[np.ndarray, "mode direction"]) -> Float[np.ndarray, "mode kept"]:
    """G of the same G G' with the fewest columns: drag has three directions at every node.

    Parallel columns are merged, too: the small system of the integration would lose their digits.
    """
    if coupling.shape[1] <= 1:
        return np.ascontiguousarray(coupling)
    left, sigma, _ = np.linalg.svd(coupling, full_matrices=False)
    kept = sigma > _LAST_DIGIT * sigma[0]
    return np.ascontiguousarray(left[:, kept] * sigma[kept])


def roots(matrix: Float[np.ndarray, "size size"]) -> Float[np.ndarray, "direction size"]:
    """Vectors g of a positive semi-definite matrix sum g g'."""
    # On a unit diagonal: translations and rotations have different units.
    scale = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0.0)
    value, vector = np.linalg.eigh(matrix * inverse[:, None] * inverse)
    kept = value > _NEGLIGIBLE * max(float(value[-1]), 0.0)
    return np.asarray((vector[:, kept] * np.sqrt(value[kept])).T * scale)


def _places(mesh: Mesh) -> dict[str, int]:
    """Node of every name that a dashpot may have."""
    return {name: i for i, name in enumerate(mesh.node_name)} | {TOWER_TOP: mesh.tower_top}


def dashpot_vectors(
    mesh: Mesh,
    damping: Damping,
    tower_top: Float[np.ndarray, "more 6"] | None = None,
) -> Float[np.ndarray, "direction motion"]:
    """Vectors g [direction, 6 node] of the dashpots of structure and case: the damping matrix is sum g g'.

    Parameters
    ----------
    mesh : Mesh
        With the dashpots of its structure.
    damping : Damping
        With the dashpot at the tower top.
    tower_top : float array [more, 6], optional
        Further ones there, such as the aerodynamic damping of the rotor.
    """
    rows: list[Float[np.ndarray, " motion"]] = []
    index = _places(mesh)

    def add(place: int, other: int | None, directions: Float[np.ndarray, "direction 6"]) -> None:
        for g in directions:
            row = np.zeros((mesh.n_nodes, 6))
            row[place] = g
            if other is not None:  # the other end, carried rigidly to this one
                row[other] -= lever(mesh.node_position[place] - mesh.node_position[other]).T @ g
            rows.append(row.reshape(-1))

    for dashpot in mesh.structure.dashpots.values():
        *others, place = (index[joint] for joint in dashpot.joints)
        add(place, others[0] if others else None, roots(np.array(dashpot.matrix)))
    if damping.tower_top is not None:
        add(mesh.tower_top, None, roots(np.diag(damping.tower_top)))
    if tower_top is not None:
        add(mesh.tower_top, None, tower_top)
    return np.array(rows).reshape(len(rows), 6 * mesh.n_nodes)


def drag_vectors(mesh: Mesh, basis: LoadBasis | None) -> csr_array:
    """Vectors g [direction, 6 node] of the drag on the structure's own motion: three at every loaded node.

    Raises
    ------
    InputError
        If the damping does not fit the nodes of the basis or of the mesh.
    """
    if basis is None or not len(basis.damping):
        return csr_array((0, 6 * mesh.n_nodes))
    if len(basis.damping) != len(basis.node) or basis.node.max() >= mesh.n_nodes:
        raise InputError(
            "load_basis.damping",
            len(basis.damping),
            f"must be one matrix for each of {len(basis.node)} nodes of the mesh",
            "Give the damping of the loaded nodes.",
        )
    value, vector = np.linalg.eigh(basis.damping)
    root = (vector * np.sqrt(np.maximum(value, 0.0))[:, None, :]).transpose(0, 2, 1)
    column = 6 * np.repeat(basis.node, 9).reshape(-1, 3, 3) + np.arange(3)
    kept = value.reshape(-1) > 0.0
    entries, columns = root.reshape(-1, 3)[kept], column.reshape(-1, 3)[kept]
    start = 3 * np.arange(len(entries) + 1)
    return csr_array(
        (entries.reshape(-1), columns.reshape(-1), start), shape=(len(entries), 6 * mesh.n_nodes)
    )


def idle_dashpots(mesh: Mesh, expansion: csr_array) -> tuple[str, ...]:
    """Names of the dashpots of which no end can move: they sit on fixed joints, and do nothing."""
    index = _places(mesh)
    moves = np.add.reduceat(np.diff(expansion.indptr), 6 * np.arange(mesh.n_nodes)) > 0
    return tuple(
        name
        for name, dashpot in mesh.structure.dashpots.items()
        if not moves[[index[joint] for joint in dashpot.joints]].any()
    )


def all_vectors(
    mesh: Mesh,
    damping: Damping,
    basis: LoadBasis | None = None,
    tower_top: Float[np.ndarray, "more 6"] | None = None,
) -> csr_array:
    """Vectors of :func:`dashpot_vectors` and :func:`drag_vectors` together."""
    return csr_array(
        vstack([csr_array(dashpot_vectors(mesh, damping, tower_top)), drag_vectors(mesh, basis)])
    )


def above_interface(
    mesh: Mesh, vectors: csr_array
) -> tuple[Bool[np.ndarray, " direction"], Bool[np.ndarray, " direction"]]:
    """Tell which vectors act on the tower, and which below it, the transition piece included."""
    node = np.zeros(mesh.n_nodes, dtype=bool)
    node[mesh.tower_node] = True
    acts = abs(vectors)
    on_tower, below = (acts @ np.repeat(place, 6).astype(float) for place in (node, ~node))
    return on_tower > 0.0, below > 0.0


def with_static_responses(
    factor: Factor,
    stiffness: csc_array,
    mass: csc_array,
    modes: tuple[Float[np.ndarray, " mode"], Float[np.ndarray, "dof mode"]],
    vectors: Float[np.ndarray, "direction dof"],
) -> tuple[Float[np.ndarray, " more"], Float[np.ndarray, "dof more"]]:
    """Lowest modes and, in place of all others, the static response to dashpots that they leave out.

    A dashpot inside a jacket acts on motions that its lowest modes hardly have.

    Parameters
    ----------
    factor : Factor
        Of the stiffness.
    stiffness, mass : sparse [dof, dof]
    modes : omega^2 [mode] in rad2/s2, shapes [dof, mode]
        Mass-normalised.
    vectors : float array [direction, dof]
        Forces of the dashpots per unit rate.
    """
    omega2, shapes = modes
    left = factor.solve(np.ascontiguousarray(vectors.T))
    left = left / np.sqrt(np.maximum(np.einsum("dv,dv->v", left, stiffness @ left), 1e-300))
    left -= shapes @ (shapes.T @ (mass @ left))
    value, turn = np.linalg.eigh(left.T @ (stiffness @ left))
    kept = value > _DEPENDENT
    left = left @ (turn[:, kept] / np.sqrt(value[kept]))
    left -= shapes @ (shapes.T @ (mass @ left))
    if not left.shape[1]:
        return omega2, shapes
    more, amplitude = dense_modes(left.T @ (stiffness @ left), left.T @ (mass @ left))
    return np.concatenate([omega2, more]), np.hstack([shapes, left @ amplitude])


def lowest_damped(
    omega_squared: Float[np.ndarray, " mode"], damping: ModalDamping, count: int
) -> DampedModes:
    """Free decay of the first `count` of very many modes; of the others their static response to dashpots."""
    kept, others = slice(0, count), slice(count, None)
    g, left = damping.coupling, damping.coupling[others]
    if not left.any():
        return damped_modes(omega_squared[kept], ModalDamping(damping.rate[kept], g[kept]))
    # Ritz vectors in the space of the modes left out, where K is diagonal and M is one.
    own, rate = omega_squared[others], damping.rate[others]
    vectors = left / own[:, None]
    vectors, _ = np.linalg.qr(vectors[:, np.einsum("mv,mv->v", vectors, left) > 0.0])
    more, turn = np.linalg.eigh(vectors.T @ (own[:, None] * vectors))
    vectors = vectors @ turn
    found = damped_modes(
        np.concatenate([omega_squared[kept], more]),
        ModalDamping(
            np.concatenate([damping.rate[kept], (vectors**2).T @ rate]),
            np.concatenate([g[kept], vectors.T @ left]),
        ),
    )
    return DampedModes(found.frequency_hz[kept], found.ratio[kept])


def damped_modes(omega_squared: Float[np.ndarray, " mode"], damping: ModalDamping) -> DampedModes:
    """Frequency and ratio of each mode's free decay: eigenvalues of the damped system.

    Where dashpots couple the modes, each complex mode is named after the undamped one that it is mostly made
    of.

    Raises
    ------
    ComputationError
        If the eigenvalue problem fails.
    """
    omega = np.sqrt(omega_squared)
    ratio = damping.diagonal / (2.0 * omega)
    if damping.coupling.shape[1]:
        # Here: its import takes 0.1 s, and most models have nothing that couples.
        from scipy.optimize import linear_sum_assignment

        try:
            value, vector = eig(_state_matrix(omega_squared, damping))
        except LinAlgError as error:
            raise ComputationError(f"the damped eigenvalue problem failed ({error})") from None
        # One of each pair; displacements on the scale of velocities, so that none outweighs the other.
        swings = value.imag > 1e-9 * np.abs(value)
        share = np.abs(vector[: len(omega), swings] * omega[:, None]) ** 2
        share += np.abs(vector[len(omega) :, swings]) ** 2
        mode, pair = linear_sum_assignment(share / share.sum(axis=0), maximize=True)
        found = value[swings][pair]
        lowest = float((-found.real / np.abs(found)).min(initial=0.0))
        if lowest < -_ROUND_OFF:
            raise ComputationError(
                f"the damped eigenvalue problem lost its digits (damping ratio {lowest:.2g}): dashpots of "
                "very different strength. Replace the strongest by supports or members."
            )
        ratio = np.maximum(ratio, 1.0)  # what finds no pair is named after no mode that oscillates
        ratio[mode], frequency = -found.real / np.abs(found), np.zeros(len(omega))
        frequency[mode] = found.imag / (2.0 * np.pi)
        return DampedModes(frequency, ratio)
    return DampedModes(omega * np.sqrt(np.maximum(1.0 - ratio**2, 0.0)) / (2.0 * np.pi), ratio)


def _state_matrix(
    omega_squared: Float[np.ndarray, " mode"], damping: ModalDamping
) -> Float[np.ndarray, "state state"]:
    """Matrix of (x, v)' for free vibration in the modes."""
    n = len(omega_squared)
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -np.diag(omega_squared)
    matrix[n:, n:] = -np.diag(damping.rate) - damping.coupling @ damping.coupling.T
    return matrix
