"""Damping that couples the modes: dashpots in the integration, in the decay of modes, in the balance of energy."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import Any
from unittest import mock

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eig, eigh, expm

from owt_model.config import parse_case
from owt_model.mesh import Mesh, build_mesh
from owt_model.pod import load_basis
from owt_model.structure import Structure, load_structure, parse_structure
from owt_model.structure_config import Damping, damping_ratio, rayleigh_fit
from owt_structure_node.core import damping as damping_module
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.damping import damped_modes, modal_damping
from owt_structure_node.core.eigen import eigen_report, log_decrement
from owt_structure_node.core.error_estimate import LOW_MODES, ErrorModel
from owt_structure_node.core.integrators import METHODS
from owt_structure_node.core.motion import MotionState, Oscillators, integrate, static_state
from owt_structure_node.core.response import build_modal_model
from owt_structure_node.core.response_model import build_response_model
from proofs.cases import relative
from proofs.frame import CLAMPED, TUBE
from proofs.registry import Proof

ALPHA, BETA, STRENGTH = 0.05, 1e-3, (8e4, 5e4, 3e4, 2e5, 4e5, 1e5)
TOP = (4e4, 3e4, 0.0, 0.0, 0.0, 2e5)
_ROOT = np.sqrt(STRENGTH)[:, None] * np.random.default_rng(1).standard_normal((6, 6))
#: From joint to ground, all directions coupled; from joint to an interface joint; from joint to tower top.
DASHPOTS: dict[str, Any] = {
    "ground": {"joints": ["m1"], "damping": (_ROOT @ _ROOT.T).tolist()},
    "pair": {"joints": ["m2", "h3"], "damping": list(STRENGTH)},
    "stay": {"joints": ["m3", "tower_top"], "damping": [5e4, 5e4, 2e4, 0.0, 0.0, 0.0]},
}


def tripod(dashpots: dict[str, Any]) -> Structure:
    """Three braced legs, nothing in them symmetric, under a tower of two elements: 36 free motions."""
    corner = {"1": (6.0, 0.5), "2": (-4.0, 5.0), "3": (-3.0, -6.0)}
    levels = {"f": (-20.0, 1.0), "m": (-8.0, 0.8), "h": (4.0, 0.6)}
    joints = {a + n: [s * x, s * y, z] for a, (z, s) in levels.items() for n, (x, y) in corner.items()}
    pairs = [(a + n, b + n) for a, b in ("fm", "mh") for n in corner]
    pairs += [(a + n, b + str(int(n) % 3 + 1)) for a, b in ("fm", "mh") for n in corner]
    heavy = {"inertia_kg_m2": [1e6, 2e6, 1.5e6, 0.0, 0.0, 0.0]}
    data = {
        "name": "tripod",
        "elements_per_member": 1,
        "mudline_z_m": -20.0,
        "sections": {"tube": TUBE},
        "joints": joints,
        "members": {f"{a}{b}": {"joints": [a, b], "section": "tube"} for a, b in pairs},
        "supports": {f"f{n}": CLAMPED for n in corner},
        "interface": {"joints": [f"h{n}" for n in corner], "reference_m": [0.3, -0.2, 5.0]},
        "transition_piece": heavy | {"mass_kg": 2e5},
        "tower": {key: TUBE[key] for key in ("youngs_modulus_pa", "shear_modulus_pa", "density_kg_m3")}
        | {"height_m": 40.0, "elements": 2, "diameter_base_m": 4.0, "diameter_top_m": 3.0}
        | dict.fromkeys(("thickness_base_m", "thickness_mid_m", "thickness_top_m"), 0.025),
        "rotor_nacelle": heavy | {"mass_kg": 1e5},
        "dashpots": dashpots,
    }
    return parse_structure(data, source="tripod")


def crossed(vector: np.ndarray) -> np.ndarray:
    """Matrix of the cross product with a vector."""
    return np.asarray(np.cross(vector, np.eye(3)).T)


@dataclass(frozen=True)
class Plant:
    """The frame in its own coordinates; damping by the dashpots written out, apart from Rayleigh's."""

    mesh: Mesh
    to_nodes: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    rayleigh: np.ndarray
    dashpots: np.ndarray

    @property
    def damping(self) -> np.ndarray:
        return self.rayleigh + self.dashpots


@cache
def plant() -> Plant:
    assembly = assemble(build_mesh(tripod(DASHPOTS)))
    mesh, to_nodes = assembly.mesh, assembly.expansion.toarray()
    mass, stiffness = assembly.mass.toarray(), assembly.stiffness.toarray()
    of_nodes = np.zeros((6 * mesh.n_nodes, 6 * mesh.n_nodes))
    of_nodes[-6:, -6:] = np.diag(TOP)  # the tower top is the last node
    for dashpot in DASHPOTS.values():
        *first, last = (
            mesh.n_nodes - 1 if name == "tower_top" else mesh.node_name.index(name)
            for name in dashpot["joints"]
        )
        relative_motion = np.zeros((6, 6 * mesh.n_nodes))
        relative_motion[:, 6 * last : 6 * last + 6] = np.eye(6)
        for i in first:  # u_last - u_first - theta_first x r
            arm = crossed(mesh.node_position[last] - mesh.node_position[i])
            relative_motion[:, 6 * i : 6 * i + 6] = -np.eye(6)
            relative_motion[:3, 6 * i + 3 : 6 * i + 6] = arm
        given = np.array(dashpot["damping"])
        of_nodes += relative_motion.T @ (given if given.ndim == 2 else np.diag(given)) @ relative_motion
    return Plant(
        mesh,
        to_nodes,
        mass,
        stiffness,
        ALPHA * mass + BETA * stiffness,
        to_nodes.T @ of_nodes @ to_nodes,
    )


def history(samples: int) -> np.ndarray:
    """Random forces and moments at all nodes [sample, 6 node]."""
    rng = np.random.default_rng(4)
    return rng.standard_normal((samples, 6 * plant().mesh.n_nodes)) * 1e5


WRONG_STRUCTURE = {
    "none": {},
    "other pair": DASHPOTS | {"pair": DASHPOTS["pair"] | {"joints": ["m1", "h3"]}},
}


def oscillators(variant: str, method: str, h: float, substeps: int = 5) -> tuple[Oscillators, np.ndarray]:
    """The frame as the code makes it of a case, unreduced; motion of the nodes in each mode."""
    structure = {"reduction": "full", "integrator": method, "dt_s": h}
    structure["damping"] = {"alpha": ALPHA, "beta": BETA} | ({} if variant == "none" else {"tower_top": TOP})
    case = parse_case({"time": {"dt_s": substeps * h, "n": 100_000}, "structure": structure})
    mesh = build_mesh(tripod(WRONG_STRUCTURE.get(variant, DASHPOTS)))
    off = (lambda offset: np.eye(6)) if variant == "no arm" else damping_module.lever
    with mock.patch.object(damping_module, "lever", off):
        model = build_response_model(case, mesh, None)
    system = model.oscillators
    if variant == "diagonal" and system.coupling is not None:
        rate = system.damping + (system.coupling**2).sum(axis=1)
        system = replace(system, damping=rate, coupling=None)
    if variant == "doubled" and system.coupling is not None:
        system = replace(system, coupling=np.sqrt(2.0) * system.coupling)
    return system, model.node_basis.reshape(6 * mesh.n_nodes, -1)


# --- integration --------------------------------------------------------------------------------------

#: gamma, beta, alpha_m, alpha_f of the methods, rho = 0.8; and a step in s, below 2 / omega of the explicit.
TEXTBOOK = {
    "newmark": (0.5, 0.25, 0.0, 0.0, 0.02),
    "newmark-explicit": (0.5, 0.0, 0.0, 0.0, 0.0025),
    "generalised-alpha": (0.5 + 1.0 / 9.0, 0.25 * (10.0 / 9.0) ** 2, 1.0 / 3.0, 4.0 / 9.0, 0.02),
}


def in_matrices(method: str, load: np.ndarray) -> np.ndarray:
    """Displacement, velocity, acceleration [3, step, dof] by the full matrices, from rest under the first load.

    Newmark (1959), Chung and Hulbert (1993): M a + C v + K u = f with each term between the ends of the step.
    """
    gamma, beta, alpha_m, alpha_f, h = TEXTBOOK[method]
    m, c, k = plant().mass, plant().damping, plant().stiffness
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


def finer(load: np.ndarray, substeps: int) -> np.ndarray:
    """Samples of loads that are linear in between."""
    at = np.arange(substeps * (len(load) - 1) + 1) / substeps
    before = np.minimum(at.astype(int), len(load) - 2)
    share = (at - before)[:, None]
    return (1.0 - share) * load[before] + share * load[before + 1]


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
        exact = in_matrices(method, finer(nodal, 5) @ plant().to_nodes) @ plant().to_nodes.T
        got = moved(variant, method, nodal, h)
        worst = max(worst, *(relative(one, other) for one, other in zip(got, exact, strict=True)))
    return worst


def exponential(damping: np.ndarray, nodal: np.ndarray, h: float) -> np.ndarray:
    """Displacement of the nodes under loads linear in a step: exponential of the matrix of state and load.

    In modes and with displacements times omega, so that the matrix is close to a normal one.
    """
    square, shapes = eigh(plant().stiffness, plant().mass)
    omega, n = np.sqrt(square), len(square)
    matrix = np.zeros((4 * n, 4 * n))
    matrix[:n, n : 2 * n] = np.diag(omega)
    matrix[n : 2 * n, :n], matrix[n : 2 * n, n : 2 * n] = -np.diag(omega), -shapes.T @ damping @ shapes
    matrix[n : 2 * n, 2 * n : 3 * n] = np.eye(n)
    matrix[2 * n : 3 * n, 3 * n :] = np.eye(n) / h
    step, load = expm(h * matrix), nodal @ plant().to_nodes @ shapes
    state, rows = np.concatenate([load[0] / omega, np.zeros(n)]), []
    for f_0, f_1 in pairwise(load):
        state = (step @ np.concatenate([state, f_0, f_1 - f_0]))[: 2 * n]
        rows.append(state[:n] / omega)
    return np.array(rows) @ (plant().to_nodes @ shapes).T


def slope_error(variant: str) -> float:
    """Deviation from the second order, of the exact method with dashpots as the step is halved three times."""
    nodal, dt = history(11), 0.1
    exact = exponential(plant().damping, nodal, dt)
    errors = [relative(moved(variant, "exact", nodal, dt / n, n)[0][n - 1 :: n], exact) for n in STEPS]
    return float(np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 2.0).max())


#: Integration steps per load step of 0.1 s: those of the second order, from where dashpots are resolved on.
STEPS = (20, 40, 80, 160)


def exactness_error(variant: tuple[str, str]) -> float:
    """Error of a method at the load step of 0.1 s, without dashpots."""
    name, method = variant
    exact = exponential(plant().rayleigh, history(60), 0.1)
    return relative(moved(name, method, history(60), 0.1, 1)[0], exact)


def cut_error(variant: str) -> float:
    """Share of the rows in which some bit differs between a record and the same in blocks: all methods."""
    nodal, differs, rows = history(61), 0, 0
    for method in METHODS:
        system, shapes = oscillators("right", method, TEXTBOOK["newmark-explicit"][-1])
        load = nodal @ shapes
        rest = static_state(system, load[0])
        end, whole = integrate(system, rest, load[1:])
        for cuts in ((1, 2, 3, 40, 61), tuple(range(1, 62)), (1, 61)):
            state, parts = rest, []
            for a, b in pairwise(cuts):
                state, motion = integrate(system, state, load[a:b])
                parts.append(np.hstack([motion.displacement, motion.velocity, motion.acceleration]))
                if variant == "anew":
                    state = replace(state, dashpot=None)
                elif variant == "forgotten":
                    state = replace(state, dashpot=np.zeros_like(load[0]))
            other = np.hstack([whole.displacement, whole.velocity, whole.acceleration])
            differs += int((np.vstack(parts) != other).any(axis=1).sum())
            differs += not np.array_equal(state.displacement, end.displacement)
            rows += len(other) + 1
    return differs / rows


def balance_error(variant: str) -> float:
    """Largest gap in the balance of energy by average acceleration, over all that is dissipated.

    With w = (v_0 + v_1)/2 its two formulas give u_1 - u_0 = h w and a_0 + a_1 = 2 (v_1 - v_0)/h. The mean of
    the balances of forces at both ends, times h w, is then

        (E_1 - E_0) + h w' C w = (f_0 + f_1)/2 . (u_1 - u_0),   E = (v' M v + u' K u)/2.
    """
    h, nodal = TEXTBOOK["newmark"][-1], history(41)
    system, shapes = oscillators("right", "newmark", h)
    load = nodal @ shapes
    start = static_state(system, load[0])
    motion = integrate(system, start, load[1:])[1]
    to_free = np.linalg.pinv(plant().to_nodes) @ shapes
    u = np.vstack([start.displacement, motion.displacement]) @ to_free.T
    v = np.vstack([start.velocity, motion.velocity]) @ to_free.T
    f = finer(nodal, 5) @ plant().to_nodes
    energy = 0.5 * (np.einsum("td,td->t", v @ plant().mass, v) + np.einsum("td,td->t", u @ plant().stiffness, u))
    mean = v[1:] if variant == "late velocity" else 0.5 * (v[1:] + v[:-1])
    force = f[:-1] if variant == "early load" else 0.5 * (f[1:] + f[:-1])
    lost = {
        "rayleigh": h * np.einsum("td,td->t", mean @ plant().rayleigh, mean),
        "dashpots": h * np.einsum("td,td->t", mean @ plant().dashpots, mean),
    }
    work, total = np.einsum("td,td->t", force, np.diff(u, axis=0)), sum(lost.values()).sum()
    counted = sum(value for name, value in lost.items() if variant != f"no {name}")
    return float(np.abs(np.cumsum(np.diff(energy) + counted - work)).max() / total)


# --- decay --------------------------------------------------------------------------------------------

COUNT = 10


@cache
def decays() -> tuple[np.ndarray, np.ndarray]:
    """Complex eigenvalues in 1/s and shapes of the frame by its full matrices, one of each pair."""
    p, n = plant(), plant().mesh.n_dof
    square = np.vstack([np.hstack([-p.damping, -p.stiffness]), np.eye(n, 2 * n)])
    value, vector = eig(square, np.kron([[1, 0], [0, 0]], p.mass) + np.kron([[0, 0], [0, 1]], np.eye(n)))
    swings = value.imag > 1e-6 * np.abs(value)
    order = np.argsort(value[swings].imag)
    return value[swings][order], vector[n:, swings][:, order]


def decay_error(variant: str) -> float:
    """Distance of the code's slowest oscillations from the complex eigenvalues, over their modulus."""
    system, _ = oscillators(variant, "newmark", 0.02)
    found = damped_modes(system.stiffness, damping_module.ModalDamping(system.damping, system.directions))
    frequency, ratio = found.frequency_hz, found.ratio
    if variant == "undamped frequency":
        frequency = np.sqrt(system.stiffness) / (2.0 * np.pi)
    order = [i for i in np.argsort(frequency) if ratio[i] < 1.0][:COUNT]
    turn = 2.0 * np.pi * frequency[order]
    got = turn * (1j - ratio[order] / np.sqrt(1.0 - ratio[order] ** 2))
    return float(np.abs(got / decays()[0][:COUNT] - 1.0).max())


def simulated_error(variant: str) -> float:
    """Logarithmic decrement of four decays in time, each started in its shape, against the code's own.

    Samples of one decay obey x_2 = 2 e^(-s h) cos(w h) x_1 - e^(-2 s h) x_0, which a fit gives s and w from.
    """
    model = build_modal_model(plant().mesh, "full")
    system, h = oscillators("right", "exact", 0.002, 1)[0], 0.002
    reported = eigen_report(tripod(DASHPOTS), damping=Damping(alpha=ALPHA, beta=BETA, tower_top=TOP))
    percent, worst = np.array(reported["logdec_percent"], dtype=float), 0.0
    of_report = np.argsort(reported["damped_frequencies_hz"])
    for i in range(4):
        value, shape = decays()[0][i], model.shapes.T @ plant().mass @ decays()[1][:, i]
        x, v, a = ((value**k * shape).real for k in range(3))
        start = MotionState(x, v, a, 0.0 * x)
        samples = integrate(system, start, np.zeros((1000, len(x))))[1].displacement[:, i]
        old, new = np.column_stack([samples[1:-1], samples[:-2]]), samples[2:]
        twice, square = np.linalg.lstsq(old, new, rcond=None)[0]
        modulus = np.sqrt(-square)
        decrement = -2.0 * np.pi * np.log(modulus) / np.arccos(0.5 * twice / modulus)
        given = 0.01 * percent[of_report[i]]
        if variant == "ratio":
            given = damping_ratio(given) * 2.0 * np.pi
        elif variant == "modes alone":
            given = float(log_decrement(system_diagonal()[of_report[i : i + 1]])[0])
        worst = max(worst, abs(given / decrement - 1.0))
    return worst
