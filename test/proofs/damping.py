"""Damping that couples the modes: dashpots in integration, decays and balance of energy; Rayleigh's fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np
from scipy.linalg import cho_factor, cho_solve, expm

from owt_model import structure_config
from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.parts import Dashpot
from owt_model.structure import Structure, load_structure
from owt_model.structure_config import Damping, rayleigh_fit
from owt_structure_node.core import damping as damping_module
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.damping import ModalDamping, damped_modes, modal_damping
from owt_structure_node.core.eigen import eigen_report, log_decrement
from owt_structure_node.core.integrators import METHODS
from owt_structure_node.core.motion import MotionState, Oscillators, integrate, static_state
from owt_structure_node.core.response_model import build_response_model
from proofs.cases import relative
from proofs.frame import CLAMPED, TUBE, mast
from proofs.registry import Proof

ALPHA, BETA, TOP = 0.05, 1e-3, (4e4, 3e4, 0.0, 0.0, 0.0, 2e5)
STRENGTH = [8e4, 5e4, 3e4, 2e5, 4e5, 1e5]
_ROOT = np.sqrt(STRENGTH)[:, None] * np.random.default_rng(1).standard_normal((6, 6))
#: From joint to ground, all directions coupled; from joint to an interface joint; from joint to tower top.
DASHPOTS: dict[str, Any] = {
    "ground": {"joints": ["m1"], "damping": (_ROOT @ _ROOT.T).tolist()},
    "pair": {"joints": ["m2", "h3"], "damping": STRENGTH},
    "stay": {"joints": ["m3", "tower_top"], "damping": [5e4, 5e4, 2e4, 0.0, 0.0, 0.0]},
}
OTHER_PAIR = DASHPOTS | {"pair": DASHPOTS["pair"] | {"joints": ["m1", "h3"]}}


def tripod(dashpots: dict[str, Any]) -> Structure:
    """Three braced legs, nothing in them symmetric, under a tower of two elements: 36 free motions."""
    corner = {"1": (6.0, 0.5), "2": (-4.0, 5.0), "3": (-3.0, -6.0)}
    level = {"f": (-20.0, 1.0), "m": (-8.0, 0.8), "h": (4.0, 0.6)}
    pairs = [(a + n, b + n) for a, b in ("fm", "mh") for n in corner]
    pairs += [(a + n, b + str(int(n) % 3 + 1)) for a, b in ("fm", "mh") for n in corner]
    heavy = {"mass_kg": 1e5, "inertia_kg_m2": [1e6, 2e6, 1.5e6, 0.0, 0.0, 0.0]}
    tower = {"height_m": 40.0, "elements": 2, "diameter_base_m": 4.0, "diameter_top_m": 3.0}
    tower |= {f"thickness_{at}_m": 0.025 for at in ("base", "mid", "top")}
    return mast(
        1,
        joints={a + n: [s * x, s * y, z] for a, (z, s) in level.items() for n, (x, y) in corner.items()},
        members={a + b: {"joints": [a, b], "section": "tube"} for a, b in pairs},
        supports={f"f{n}": CLAMPED for n in corner},
        interface={"joints": [f"h{n}" for n in corner], "reference_m": [0.3, -0.2, 5.0]},
        transition_piece=heavy,
        tower=tower | {key: value for key, value in TUBE.items() if "_pa" in key or "density" in key},
        rotor_nacelle=heavy,
        dashpots=dashpots,
    )


@cache
def plant() -> SimpleNamespace:
    """Matrices of the frame over its free motions; damping by the dashpots written out, Rayleigh's apart."""
    assembly = assemble(build_mesh(tripod(DASHPOTS)))
    mesh, nodes = assembly.mesh, assembly.expansion.toarray()
    top, size = mesh.n_nodes - 1, len(nodes)
    of_nodes = np.diag([*[0.0] * (size - 6), *TOP])
    for dashpot in DASHPOTS.values():
        *first, last = (top if j == "tower_top" else mesh.node_name.index(j) for j in dashpot["joints"])
        motion = np.eye(6, size, 6 * last)
        for i in first:  # u_last - (u_first + theta_first x r)
            motion -= np.eye(6, size, 6 * i)
            arm = mesh.node_position[last] - mesh.node_position[i]
            motion[:3, 6 * i + 3 : 6 * i + 6] -= np.cross(np.eye(3), arm).T
        given = np.array(dashpot["damping"])
        of_nodes += motion.T @ (given if given.ndim == 2 else np.diag(given)) @ motion
    m, k = assembly.mass.toarray(), assembly.stiffness.toarray()
    rayleigh, dashpots = ALPHA * m + BETA * k, nodes.T @ of_nodes @ nodes
    return SimpleNamespace(nodes=nodes, m=m, k=k, rayleigh=rayleigh, dashpots=dashpots)


def history(samples: int) -> np.ndarray:
    """Random forces and moments at all nodes [sample, 6 node]."""
    return np.random.default_rng(4).standard_normal((samples, len(plant().nodes))) * 1e5


def oscillators(variant: str, method: str, h: float, substeps: int = 5) -> tuple[Oscillators, np.ndarray]:
    """The frame as the code makes it of a case, unreduced; motion of the nodes in each mode."""
    damping = {"alpha": ALPHA, "beta": BETA, "tower_top": TOP}
    structure = {"reduction": "full", "integrator": method, "dt_s": h, "damping": damping}
    case = parse_case({"time": {"dt_s": substeps * h, "n": 100_000}, "structure": structure})
    mesh = build_mesh(tripod(OTHER_PAIR if variant == "other pair" else DASHPOTS))
    lever = (lambda offset: np.eye(6)) if variant == "no arm" else damping_module.lever
    with mock.patch.object(damping_module, "lever", lever):
        model = build_response_model(case, mesh, None)
    system = model.oscillators
    if variant == "diagonal":
        rate = ModalDamping(system.damping, system.directions).diagonal
        system = replace(system, damping=rate, coupling=None)
    elif variant == "doubled":
        system = replace(system, coupling=np.sqrt(2.0) * system.directions)
    return system, model.node_basis.reshape(len(plant().nodes), -1)


# --- integration --------------------------------------------------------------------------------------

#: gamma, beta, alpha_m, alpha_f of the methods, rho = 0.8; and a step in s, below 2 / omega of the explicit.
TEXTBOOK = {
    "newmark": (0.5, 0.25, 0.0, 0.0, 0.02),
    "newmark-explicit": (0.5, 0.0, 0.0, 0.0, 0.0025),
    "generalised-alpha": (0.5 + 1.0 / 9.0, 0.25 * (10.0 / 9.0) ** 2, 1.0 / 3.0, 4.0 / 9.0, 0.02),
}


def in_matrices(method: str, load: np.ndarray) -> np.ndarray:
    """Displacement, velocity, acceleration [3, step, motion] by full matrices, at rest under the first load.

    Newmark (1959), Chung and Hulbert (1993): M a + C v + K u = f, its terms between the ends of a step.
    """
    gamma, beta, alpha_m, alpha_f, h = TEXTBOOK[method]
    m, c, k = plant().m, plant().rayleigh + plant().dashpots, plant().k
    factor = cho_factor((1.0 - alpha_m) * m + (1.0 - alpha_f) * (gamma * h * c + beta * h * h * k))
    u = np.linalg.solve(k, load[0])
    v = a = np.zeros_like(u)
    rows = []
    for f_0, f_1 in pairwise(load):
        u_free, v_free = u + h * v + h * h * (0.5 - beta) * a, v + h * (1.0 - gamma) * a
        right = (1.0 - alpha_f) * (f_1 - c @ v_free - k @ u_free) + alpha_f * (f_0 - c @ v - k @ u)
        a = cho_solve(factor, right - alpha_m * (m @ a))
        u, v = u_free + beta * h * h * a, v_free + gamma * h * a
        rows.append((u, v, a))
    return np.array(rows).transpose(1, 0, 2)


def finer(load: np.ndarray, n: int) -> np.ndarray:
    """Loads that are linear in between, n times as often."""
    at = np.arange(n * (len(load) - 1) + 1) / n
    return np.column_stack([np.interp(at, np.arange(len(load)), column) for column in load.T])


def moved(variant: str, method: str, nodal: np.ndarray, h: float, substeps: int = 5) -> np.ndarray:
    """What the code gives, at the nodes [3, step, 6 node]."""
    system, shapes = oscillators(variant, method, h, substeps)
    load = nodal @ shapes
    motion = integrate(system, static_state(system, load[0]), load[1:])[1]
    return np.array([motion.displacement, motion.velocity, motion.acceleration]) @ shapes.T


def coupled_error(variant: str) -> float:
    """Worst of three methods in displacement, velocity and acceleration of all nodes, over the largest."""
    nodal, worst = history(41), 0.0
    for method, (*_, h) in TEXTBOOK.items():
        exact = in_matrices(method, finer(nodal, 5) @ plant().nodes) @ plant().nodes.T
        got = moved(variant, method, nodal, h)
        worst = max(worst, *(relative(one, other) for one, other in zip(got, exact, strict=True)))
    return worst


def slope_error(variant: str) -> float:
    """Deviation from the second order of the exact method with dashpots, step halved from 5 ms to 0.6 ms.

    Against the exponential of the matrix of displacement, velocity, load and its rise in a load step.
    """
    nodal, p, n = history(11), plant(), len(plant().m)
    zero, one, inverse = np.zeros((n, n)), np.eye(n), np.linalg.inv(p.m)
    first = [zero, one, zero, zero]
    second = [-inverse @ p.k, -inverse @ (p.rayleigh + p.dashpots), inverse, zero]
    step = expm(0.1 * np.block([first, second, [zero, zero, zero, 10.0 * one], [zero] * 4]))
    load = nodal @ p.nodes
    state, rows = np.concatenate([np.linalg.solve(p.k, load[0]), np.zeros(n)]), []
    for f_0, f_1 in pairwise(load):
        state = (step @ np.concatenate([state, f_0, f_1 - f_0]))[: 2 * n]
        rows.append(p.nodes @ state[:n])
    exact, steps = np.array(rows), (20, 40, 80, 160)
    errors = [relative(moved(variant, "exact", nodal, 0.1 / k, k)[0][k - 1 :: k], exact) for k in steps]
    return float(np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 2.0).max())


def cut_error(carried: Callable[[MotionState], MotionState]) -> float:
    """Share of the rows in which some bit differs between a record and the same in blocks, all methods."""
    nodal, differs = history(61), []
    for method in METHODS:
        system, shapes = oscillators("right", method, TEXTBOOK["newmark-explicit"][-1])
        load = nodal @ shapes
        rest = static_state(system, load[0])
        whole = integrate(system, rest, load[1:])[1]
        for cuts in ((1, 2, 3, 40, 61), tuple(range(1, 62))):
            state, parts = rest, []
            for a, b in pairwise(cuts):
                state, motion = integrate(system, state, load[a:b])
                state, parts = carried(state), [*parts, motion]
            for name in ("displacement", "velocity", "acceleration"):
                joined = np.concatenate([getattr(part, name) for part in parts])
                differs.append(np.mean((joined != getattr(whole, name)).any(axis=1)))
    return float(np.max(differs))


def balance_error(variant: str) -> float:
    """Largest gap in the balance of energy by average acceleration, over all that is dissipated.

    With w = (v_0 + v_1)/2 its formulas say u_1 - u_0 = h w and a_0 + a_1 = 2 (v_1 - v_0)/h. The mean of the
    balances of forces at both ends of a step, times h w, is then, with E = (v' M v + u' K u)/2,

        E_1 - E_0 + h w' C w = (f_0 + f_1)/2 . (u_1 - u_0).
    """
    h, nodal, p = TEXTBOOK["newmark"][-1], history(41), plant()
    motion = moved("right", "newmark", nodal, h) @ np.linalg.pinv(p.nodes).T
    f = finer(nodal, 5) @ p.nodes
    u = np.vstack([np.linalg.solve(p.k, f[0]), motion[0]])
    v = np.vstack([0.0 * u[0], motion[1]])

    def form(left: np.ndarray, matrix: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("td,td->t", left @ matrix, left))

    mean = v[1:] if variant == "late velocity" else 0.5 * (v[1:] + v[:-1])
    force = f[:-1] if variant == "early load" else 0.5 * (f[1:] + f[:-1])
    lost = {"rayleigh": h * form(mean, p.rayleigh), "dashpots": h * form(mean, p.dashpots)}
    gap = np.diff(0.5 * (form(v, p.m) + form(u, p.k))) - np.einsum("td,td->t", force, np.diff(u, axis=0))
    gap += sum(value for name, value in lost.items() if variant != f"no {name}")
    return float(np.abs(np.cumsum(gap)).max() / sum(lost.values()).sum())


# --- decay --------------------------------------------------------------------------------------------


@cache
def decays() -> np.ndarray:
    """Complex eigenvalues in 1/s of the frame by its full matrices, one of each pair."""
    p, one = plant(), np.eye(len(plant().m))
    second = [-np.linalg.solve(p.m, p.k), -np.linalg.solve(p.m, p.rayleigh + p.dashpots)]
    value = np.linalg.eigvals(np.block([[0.0 * one, one], second]))
    return np.asarray(sorted(value[value.imag > 1e-6 * np.abs(value)], key=np.imag))


def decay_error(variant: str) -> float:
    """Distance of the ten slowest oscillations from the complex eigenvalues, over their modulus."""
    system, _ = oscillators(variant, "newmark", 0.02)
    found = damped_modes(system.stiffness, ModalDamping(system.damping, system.directions))
    turn = np.sqrt(system.stiffness) if variant == "undamped" else 2.0 * np.pi * found.frequency_hz
    pairs = [w * (1j - z / np.sqrt(1.0 - z**2)) for w, z in zip(turn, found.ratio, strict=True) if z < 1.0]
    return float(np.abs(np.array(sorted(pairs, key=np.imag))[:10] / decays()[:10] - 1.0).max())


# --- Rayleigh, and the thesis' models -----------------------------------------------------------------


def fit_error(ratio: Callable[[float], float]) -> float:
    """Decrements in percent that fits give back at their two modes, and those given to single modes."""
    worst, omega_squared = 0.0, np.array([2.4, 7.0, 43.0, 145.0, 1600.0]) ** 2
    hertz = np.sqrt(omega_squared) / (2.0 * np.pi)
    for first, last, low, high in ((0, 1, 5.0, 5.1), (0, 4, 30.0, 400.0), (3, 1, 0.7, 0.5)):
        with mock.patch.object(structure_config, "damping_ratio", ratio):
            fit = ((hertz[first], low), (hertz[last], high))
            single = Damping(fit=fit, modes=((3.0, 12.5),))
            found = damped_modes(omega_squared, modal_damping(omega_squared, single))
        got = 100.0 * log_decrement(found.ratio)[[first, last, 2]]
        worst = max(worst, relative(got / [low, high, 12.5], np.ones(3)))
    return worst


#: Rows of table B.3 of the thesis, reference model: first and last frequency in Hz, decrements in percent.
ROWS = ((0.381, 6.382), (5.049, 25.447))


def thesis_fit_error(variant: tuple[tuple[float, float], tuple[float, float]]) -> float:
    """Coefficients that the first and the last row give, relative to those of the thesis' damping."""
    alpha, beta = rayleigh_fit(*variant)
    return max(abs(alpha / 0.027 - 1.0), abs(beta / 0.0020 - 1.0))


#: Decrements in percent of the first ten modes of the thesis' damping model (table B.3).
PRINTED = (29.951, 30.131, 5.855, 6.242, 5.812, 8.617, 9.521, 13.079, 15.011, 15.13)
DASHPOT = {"tower_top": (6.1e4, 6.1e4, 0.0, 0.0, 0.0, 0.0)}


def pattern_error(variant: tuple[dict[str, Any], str]) -> float:
    """Largest deviation of ten decrements from the printed ones; the dashpot may stand at the interface."""
    (damping, place), structure = variant, load_structure("oc4-thesis")
    if place:
        quarter = tuple(0.25 * c for c in DASHPOT["tower_top"])
        legs = {joint: Dashpot(joints=(joint,), damping=quarter) for joint in structure.interface.joints}
        structure = structure.model_copy(update={"dashpots": legs})
    report = eigen_report(structure, damping=Damping(**damping))
    return float(np.abs(np.array(report["logdec_percent"][:10]) / PRINTED - 1.0).max())


PROOFS = (
    Proof(
        key="dashpots-in-matrices",
        claim="Modes coupled by dashpots move as the full matrices make the frame move",
        against="Newmark's and Chung and Hulbert's methods written out for M, C and K, one factorisation",
        error=coupled_error,
        right="right",
        wrong={
            "coupling neglected": "diagonal",
            "dashpots doubled": "doubled",
            "dashpot of another pair": "other pair",
            "pair without its arm": "no arm",
        },
        allowed=1e-10,
        reason="round-off of 200 steps, the explicit ones close to their limit",
    ),
    Proof(
        key="dashpots-second-order",
        claim="Exact integration but for the force of dashpots, linear in a step, is of second order",
        against="exponential of the full state matrix, slopes over four steps",
        error=slope_error,
        right="right",
        wrong={"coupling neglected": "diagonal", "dashpots doubled": "doubled"},
        allowed=0.15,
        reason="terms of higher order at the longest step",
    ),
    Proof(
        key="dashpots-in-blocks",
        claim="Blocks of a record with dashpots give the bits of the whole, for every integrator",
        against="the same record in one piece, share of the samples that differ",
        error=cut_error,
        right=lambda state: state,
        wrong={
            "force anew from the velocity": lambda state: replace(state, dashpot=None),
            "force forgotten": lambda state: replace(state, dashpot=np.zeros_like(state.load)),
        },
        allowed=0.0,
        reason="the same operations in the same order",
    ),
    Proof(
        key="dashpots-energy",
        claim="Work of the loads is energy gained and lost, to Rayleigh damping and dashpots, step by step",
        against="identity of the average acceleration, over all that is lost",
        error=balance_error,
        right="right",
        wrong={
            "dashpots left out": "no dashpots",
            "Rayleigh left out": "no rayleigh",
            "velocity at the step's end": "late velocity",
            "load at the step's start": "early load",
        },
        allowed=1e-11,
        reason="round-off of 200 steps",
    ),
    Proof(
        key="damped-modes",
        claim="Frequencies and ratios of modes coupled by dashpots",
        against="complex eigenvalues of the full state matrix of the frame, ten oscillations",
        error=decay_error,
        right="right",
        wrong={
            "coupling neglected": "diagonal",
            "dashpots doubled": "doubled",
            "undamped frequency": "undamped",
        },
        allowed=1e-10,
        reason="round-off of the eigenvalue problems",
    ),
    Proof(
        key="rayleigh-fit",
        claim="A fit gives both modes, and a single mode gets, the decrement asked for",
        against="decrements of 0.5 to 400 % of five oscillators",
        error=fit_error,
        right=structure_config.damping_ratio,
        wrong={"delta = 2 pi zeta": lambda decrement: decrement / (2.0 * np.pi)},
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="rayleigh-of-the-thesis",
        claim="Two rows of the thesis' table B.3 give its alpha = 0.027 1/s and beta = 0.0020 s",
        against="coefficients of its reference model",
        error=thesis_fit_error,
        right=ROWS,
        wrong={
            "rows of the frequency model": ((0.281, 4.012), (5.07, 19.288)),
            "decrement of the second row": (ROWS[0], (5.03, 25.447)),
        },
        allowed=2e-3,
        reason="frequencies are printed to 0.001 Hz, half of which is 1.3e-3 of the first",
    ),
    Proof(
        key="damping-model-of-the-thesis",
        claim="A dashpot of 6.1e4 N s/m at the tower top makes the thesis' damping model of Rayleigh's",
        against="table B.3, logarithmic decrements of ten modes",
        error=pattern_error,
        right=(DASHPOT, ""),
        wrong={
            "at the transition piece": ({}, "interface"),
            "on the first two modes only": ({"modes": ((1.0, 29.951), (2.0, 30.131))}, ""),
            "Rayleigh alone": ({}, ""),
        },
        allowed=0.02,
        reason="1.3 % in modes 3 and 4, whose fitted shapes are not the thesis' own; c has two digits",
    ),
)
