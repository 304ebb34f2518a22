"""Reduced models: augmentation vectors, static improvement, decomposition of loads, estimated errors."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from scipy.sparse import csc_array

from owt_model.contracts import LoadBasis
from owt_model.mesh import build_mesh
from owt_model.pod import clustered_basis, load_basis
from owt_model.structure import load_structure
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import Assembly, assemble
from owt_structure_node.core.error_estimate import ErrorModel
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.recovery import end_force_map
from owt_structure_node.core.reduction import Reduction, guyan, interface_loads, load_vectors, reduce
from proofs.registry import Proof

DT = 0.1


@cache
def jacket() -> Assembly:
    """The OC4 jacket of the thesis."""
    return assemble(build_mesh(load_structure("oc4-thesis")))


@cache
def history() -> np.ndarray:
    """Loads of eight shapes on the nodes below water, sizes and frequencies apart, and a mean."""
    rng = np.random.default_rng(2)
    shapes = rng.standard_normal((8, len(nodes()), 6)) * [1e5, 1e5, 1e5, 1e4, 1e4, 1e4]
    phase = 0.02 * np.pi * DT * np.arange(1000)[:, None] * np.arange(4, 12)
    return np.tensordot(np.cos(phase) * 0.6 ** np.arange(8), shapes, axes=1) + 0.5 * shapes[1]


@cache
def nodes() -> np.ndarray:
    mesh = jacket().mesh
    inside = np.arange(mesh.n_nodes) < mesh.transition_piece
    free = (mesh.node_dof >= 0).all(axis=1)
    return np.flatnonzero(inside & free & (mesh.node_position[:, 2] < 0.0))[::3]


@cache
def basis() -> LoadBasis:
    return load_basis(history(), nodes(), 8, model_hash=jacket().mesh.structure.content_hash)


def forces(nodal: np.ndarray) -> np.ndarray:
    """Loads at the free degrees of freedom [dof, sample]."""
    mesh = jacket().mesh
    full = np.zeros((len(nodal), mesh.n_nodes, 6))
    full[:, nodes()] = nodal
    return np.asarray(jacket().expansion.T @ full.reshape(len(nodal), -1).T)


def functions(reduced: Reduction) -> tuple[np.ndarray, np.ndarray]:
    """What a basis keeps inside the jacket, and the squares of its (pseudo-)frequencies."""
    square = np.concatenate([reduced.fixed_interface, reduced.pseudo])
    return reduced.shapes[: jacket().internal, 6 : 6 + len(square)], square


def relative(found: Any, expected: Any) -> float:
    return float(np.abs(np.asarray(found) - expected).max() / np.abs(expected).max())


# --- augmentation vectors -----------------------------------------------------------------------------


def moment_error(name: str) -> float:
    """Coefficients of the response in powers of frequency: (K^-1 M)^k K^-1 f on the jacket, interface held.

    A basis with vectors of orders 0 to j gives the first j + 1 of them exactly.
    """
    n = jacket().internal
    k, m = (csc_array(a[:n, :n]) for a in (jacket().jacket_stiffness, jacket().jacket_mass))
    reduced = reduce(jacket(), name, basis())
    size = len(reduced.fixed_interface) + len(reduced.pseudo)
    inside, square = (
        reduced.shapes[:n, 6 : 6 + size],
        np.concatenate([reduced.fixed_interface, reduced.pseudo]),
    )
    load = load_vectors(jacket(), basis())[:n] @ np.arange(1.0, 9.0)
    exact, coordinate, worst = factorise(k).solve(load), inside.T @ load / square, 0.0
    for _ in range(3):
        worst = max(worst, relative(inside @ coordinate, exact))
        exact, coordinate = factorise(k).solve(np.asarray(m @ exact)), coordinate / square
    return worst


def orthogonality_error(variant: str) -> float:
    """Eq. 3.44 of modes and vectors together, in K scaled to one."""
    n = jacket().internal
    reduced = reduce(jacket(), "CB10M08j1Y", basis())
    size = len(reduced.fixed_interface) + len(reduced.pseudo)
    inside, square = (
        reduced.shapes[:n, 6 : 6 + size],
        np.concatenate([reduced.fixed_interface, reduced.pseudo]),
    )
    if variant == "neither projected nor through the interaction problem":
        raw = factorise(csc_array(jacket().jacket_stiffness[:n, :n])).solve(
            load_vectors(jacket(), basis())[:n]
        )
        mass = np.einsum("dv,dv->v", raw, jacket().jacket_mass[:n, :n] @ raw)
        inside = np.hstack([inside[:, :10], raw / np.sqrt(mass)])
        square = np.einsum("dv,dv->v", inside, jacket().jacket_stiffness[:n, :n] @ inside)
    unit = inside / np.sqrt(square)
    errors = [
        np.abs(inside.T @ (jacket().jacket_mass[:n, :n] @ inside) - np.eye(len(square))).max(),
        np.abs(unit.T @ (jacket().jacket_stiffness[:n, :n] @ unit) - np.eye(len(square))).max(),
    ]
    return float(max(errors))


def interface_error(name: str) -> float:
    """Quasi-static motion inside the jacket under accelerations of the interface, K_ii^-1 Y."""
    reduced = reduce(jacket(), name, basis())
    load = interface_loads(jacket(), guyan(jacket()))
    size = len(reduced.fixed_interface) + len(reduced.pseudo)
    inside, square = (
        reduced.shapes[: jacket().internal, 6 : 6 + size],
        np.concatenate([reduced.fixed_interface, reduced.pseudo]),
    )
    exact = guyan(jacket()).factor.solve(load)
    return relative(inside @ (inside.T @ load / square[:, None]), exact)


def guyan_error(loaded: str) -> float:
    """Static displacement of CB00 under loads on the transition piece and the tower, or inside as well."""
    rng, n = np.random.default_rng(3), jacket().internal
    load = np.zeros(jacket().mesh.n_dof)
    load[n if loaded == "above" else 0 :] = rng.standard_normal(len(load) - (n if loaded == "above" else 0))
    reduced = reduce(jacket(), "CB00")
    found = reduced.shapes @ np.linalg.solve(reduced.stiffness, reduced.shapes.T @ load)
    return relative(found, factorise(jacket().stiffness).solve(load))


def improvement_error(variant: str) -> float:
    """Member-end forces under a static load, with and without the static improvement."""
    nodal = history()[:1]
    load = forces(nodal)
    name = {"modes counted twice": "CB00+SIM"}.get(variant, "CB10+SIM")
    reduced = reduce(jacket(), "CB10+SIM")
    shift = reduced.shapes @ np.linalg.solve(reduced.stiffness, reduced.shapes.T @ load)
    exact = end_force_map(jacket(), factorise(jacket().stiffness).solve(load))[0]
    found = end_force_map(jacket(), shift)[0]
    improvement = reduce(jacket(), name).improvement
    assert improvement is not None
    if variant != "without":
        found = found + improvement.map(nodes()).forces(nodal.reshape(1, -1)).reshape(-1, 6)
    return relative(found, exact)


# --- loads --------------------------------------------------------------------------------------------


def cluster_error(variant: str) -> float:
    """Largest share of a case's loads that two vectors miss: one case of each shape, sizes 1 to 1000."""
    shapes = np.linalg.qr(np.random.default_rng(4).standard_normal((24, 2)))[0].T.reshape(2, 4, 6)
    time = np.random.default_rng(5).standard_normal((2, 300, 1, 1))
    noise = 1e-2 * np.random.default_rng(6).standard_normal((2, 300, 4, 6))
    cases = [size * (time[i] * shapes[i] + noise[i]) for i, size in enumerate((1.0, 1000.0))]
    if variant == "right":
        vectors = clustered_basis(cases, np.arange(4), 2, model_hash="").vectors
    else:
        vectors = load_basis(np.concatenate(cases), np.arange(4), 2, model_hash="").vectors
    flat, worst = vectors.reshape(2, -1), 0.0
    for case in cases:
        snapshots = (case - case.mean(axis=0)).reshape(300, -1)
        left = snapshots - snapshots @ flat.T @ flat
        worst = max(worst, float(np.linalg.norm(left) / np.linalg.norm(snapshots)))
    return worst


# --- estimated error ----------------------------------------------------------------------------------


def residual_error(variant: str) -> float:
    """Static part of the estimate against 1 - E[f' K_r^-1 f] / E[f' K^-1 f] over the whole history."""
    loads = forces(history())
    energy = np.einsum("dt,dt->t", loads, factorise(jacket().stiffness).solve(loads)).mean()
    still = replace(basis(), spectrum=np.zeros((0, 0)))
    if variant == "no mean":
        still = replace(still, mean=np.zeros_like(still.mean))
    if variant == "sigma for sigma squared":
        root = np.sqrt(still.singular_values * still.singular_values[0])
        still = replace(still, singular_values=root, total_variance=float((root**2).sum()))
    model, worst = ErrorModel(jacket(), still, damping=Damping(), dt=DT), 0.0
    for name in ("CB00", "CB10", "M04"):
        reduced = reduce(jacket(), name, basis())
        small = reduced.shapes.T @ loads
        kept = np.einsum("dt,dt->t", small, np.linalg.solve(reduced.stiffness, small)).mean()
        expected = 1.0 - kept / energy
        worst = max(worst, abs(model.estimate(reduced).static / expected - 1.0))
    return worst


PROOFS = (
    Proof(
        key="mta-moments",
        claim="Augmentation vectors of orders 0 to 2 give three terms of the response in powers of frequency",
        against="(K^-1 M)^k K^-1 f, k = 0, 1, 2, of the OC4 jacket, interface held (eq. 3.37)",
        error=moment_error,
        right="CB10M08j2",
        wrong={"order 0 only": "CB10M08", "modes only": "CB40"},
        allowed=1e-6,
        reason="three solves with a stiffness of condition 1e9 or so",
    ),
    Proof(
        key="mta-orthogonality",
        claim="Modes and augmentation vectors of two orders are orthonormal in mass and stiffness",
        against="identity (eq. 3.44)",
        error=orthogonality_error,
        right="right",
        wrong={"static responses as they are": "neither projected nor through the interaction problem"},
        allowed=1e-7,
        reason="round-off of the interaction problem, whose pseudo-frequencies span three decades",
    ),
    Proof(
        key="mta-interface",
        claim="Interface-acceleration vectors give the quasi-static motion under interface accelerations",
        against="K_ii^-1 Y of the OC4 jacket (eq. 3.50)",
        error=interface_error,
        right="CB10M08Y",
        wrong={"load vectors only": "CB10M08", "modes only": "CB40"},
        allowed=1e-7,
        reason="round-off of two solves",
    ),
    Proof(
        key="guyan-boundary-loads",
        claim="Guyan's reduction is exact for static loads on the interface and above",
        against="static displacement of the unreduced OC4 model",
        error=guyan_error,
        right="above",
        wrong={"loads inside as well": "everywhere"},
        allowed=1e-7,
        reason="round-off of two solves",
    ),
    Proof(
        key="static-improvement",
        claim="Static improvement makes the member-end forces under any static load exact",
        against="end forces K_e u_e of the unreduced OC4 model",
        error=improvement_error,
        right="right",
        wrong={"without it": "without", "static response of the modes not taken away": "modes counted twice"},
        allowed=1e-7,
        reason="round-off of two solves",
    ),
    Proof(
        key="clustered-pod",
        claim="A clustered basis serves a small sea state as well as one a thousand times larger",
        against="share of either's loads outside two vectors, noise of 1 %",
        error=cluster_error,
        right="right",
        wrong={"snapshots not normalised": "plain"},
        allowed=0.1,
        reason="noise of 1 % in 24 components, over a shape of unit norm: 5 %",
    ),
    Proof(
        key="static-residual",
        claim="The static part of the error estimate needs the moments of the loads only",
        against="static residual 1 - E[f' K_r^-1 f] / E[f' K^-1 f] summed over the history",
        error=residual_error,
        right="right",
        wrong={"mean load left out": "no mean", "shares by sigma": "sigma for sigma squared"},
        allowed=1e-5,
        reason="difference of energies, of which the smallest is a hundredth of the whole",
    ),
)
