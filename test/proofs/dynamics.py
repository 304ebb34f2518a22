"""Beam elements and time integration: exactness, rates and orders, conservation."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import cache, partial
from itertools import pairwise
from typing import Any
from unittest import mock

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from owt_model.axes import rotation
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import Structure
from owt_structure_node.core import assembly as assembly_module
from owt_structure_node.core import elements, recovery
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.integrators import METHODS, newmark
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.motion import MotionState, Oscillators, integrate
from owt_structure_node.core.recovery import end_force_map
from proofs.cases import relative
from proofs.frame import CLAMPED, EA, EI, GJ, LINE, D, E, G, T, bending, mast
from proofs.registry import Proof

Replaced = tuple[tuple[Any, str, Callable[..., Any]], ...]


def swapped(names: Replaced) -> ExitStack:
    """Put wrong functions in the places of the code's own."""
    stack = ExitStack()
    for module, name, wrong in names:
        stack.enter_context(mock.patch.object(module, name, wrong))
    return stack


# --- elements -----------------------------------------------------------------------------------------

STRAIN, MOMENT = 1e-3, np.array([3e5, -2e5, 4e5])


def chain(seed: int) -> tuple[Structure, np.ndarray]:
    """Four members of any direction in a row, one of them upright, clamped at their foot; joints."""
    turn = np.random.default_rng(seed).standard_normal((4, 3)) * [4.0, 4.0, 7.0]
    turn[1, :2] = 0.0
    place = np.concatenate([np.zeros((1, 3)), turn.cumsum(axis=0)])
    names = [f"J{i}" for i in range(5)]
    members = {f"M{i}": {"joints": names[i : i + 2], "section": "tube"} for i in range(4)}
    return framed(dict(zip(names, place.tolist(), strict=True)), members), place


def framed(joints: dict[str, Any], members: dict[str, Any]) -> Structure:
    """A structure that the first joint holds, with its interface on the last one."""
    *_, last = joints
    supports, interface = {next(iter(joints)): CLAMPED}, {"joints": [last], "reference_m": joints[last]}
    return mast(1, joints=joints, members=members, supports=supports, interface=interface)


def curved(mesh: Mesh, place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Load and motion [node, 6], end forces [end, 6]: a chain under an end moment, of constant curvature."""
    nodal, motion = np.zeros((mesh.n_nodes, 6)), np.zeros((mesh.n_nodes, 6))
    nodal[mesh.transition_piece, 3:] = MOMENT
    u, turn, force = np.zeros(3), np.zeros(3), []
    for i, (a, b) in enumerate(pairwise(place)):
        along, length = (b - a) / np.linalg.norm(b - a), np.linalg.norm(b - a)
        twist = MOMENT @ along * along
        curvature = twist / GJ + (MOMENT - twist) / EI
        for node in np.unique(mesh.element_node[mesh.element_member == i]):
            s = np.linalg.norm(mesh.node_position[node] - a)
            motion[node, :3] = u + np.cross(turn * s + curvature * s**2 / 2.0, along)
            motion[node, 3:] = turn + curvature * s
        u = u + np.cross(turn * length + curvature * length**2 / 2.0, along)
        turn = turn + curvature * length
        local = np.concatenate([np.zeros(3), rotation(a, b) @ MOMENT])
        force += [-local, local]
    motion[mesh.transition_piece] = np.concatenate([u, turn])
    return nodal, motion, np.array(force)


def swollen(mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same of a frame that grows about its first joint: constant strain in every member."""
    nodal, motion = np.zeros((mesh.n_nodes, 6)), np.zeros((mesh.n_nodes, 6))
    for first, last in mesh.member_node:
        along = mesh.node_position[last] - mesh.node_position[first]
        pull = STRAIN * EA * along / np.linalg.norm(along)
        nodal[last, :3] += pull
        nodal[first, :3] -= pull
    motion[:, :3] = STRAIN * (mesh.node_position - mesh.node_position[0])
    force = np.zeros((2 * mesh.n_members, 6))
    force[:, 0] = np.tile([-STRAIN * EA, STRAIN * EA], mesh.n_members)
    return nodal, motion, force


def patch_error(wrong: Replaced) -> float:
    """Displacements of all nodes and forces at member ends: three meshes of three chains and frames each."""
    worst = 0.0
    for seed in range(3):
        bent, place = chain(seed)
        corner = np.random.default_rng(10 + seed).uniform(-10.0, 10.0, (5, 3))
        pairs = [(a, b) for b in range(5) for a in range(b)]
        members = {f"M{a}{b}": {"joints": [f"J{a}", f"J{b}"], "section": "tube"} for a, b in pairs}
        grown = framed({f"J{i}": corner[i].tolist() for i in range(5)}, members)
        for structure, state in ((bent, partial(curved, place=place)), (grown, swollen)):
            for count, beam in ((1, "euler-bernoulli"), (3, "timoshenko"), (5, "euler-bernoulli")):
                mesh = build_mesh(structure.model_copy(update={"elements_per_member": count, "beam": beam}))
                with swapped(wrong):
                    assembly = assemble(mesh)
                    nodal, motion, force = state(mesh)
                    u = factorise(assembly.stiffness).solve(assembly.expansion.T @ nodal.reshape(-1))
                    found = end_force_map(assembly, u[:, None])[0]
                worst = max(worst, relative((assembly.expansion @ u).reshape(-1, 6), motion))
                worst = max(worst, relative(found, force))
    return worst


OWN_AXES, OWN_STIFFNESS = assembly_module.element_transformation, elements.stiffness
LEFT_HANDED = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0] * 2)
TURNED: Replaced = tuple(
    (module, "element_transformation", lambda mesh: OWN_AXES(mesh).transpose(0, 2, 1))
    for module in (assembly_module, recovery)
)


def mirrored(*section: Any) -> np.ndarray:
    """Element stiffness for rotations about y that are left-handed."""
    return np.asarray(OWN_STIFFNESS(*section) * LEFT_HANDED[:, None] * LEFT_HANDED)


# --- Timoshenko's beam --------------------------------------------------------------------------------

SHORT = 12.0
NU = np.array([E / (2.0 * G) - 1.0])
KGA = float(elements.shear_coefficient(D, T, NU)[0]) * G * EA / E


def short_mast(elements_: int, **more: Any) -> Structure:
    """A mast of ten diameters."""
    foot, head = [0.0, 0.0, 0.0], [0.0, 0.0, SHORT]
    interface = {"joints": ["B"], "reference_m": head}
    return mast(elements_, joints={"A": foot, "B": head}, interface=interface, beam="timoshenko", **more)


def shear_deflection(wrong: Replaced) -> float:
    """Deflection and slope of all nodes of three meshes under a force across the top."""
    force, worst = 1e5, 0.0
    for count in (1, 3, 8):
        with swapped(wrong):
            assembly = assemble(build_mesh(short_mast(count)))
        load = np.zeros(assembly.mesh.n_dof)
        load[assembly.internal] = force
        found = (assembly.expansion @ factorise(assembly.stiffness).solve(load)).reshape(-1, 6)
        z = assembly.mesh.node_position[:, 2]
        exact = force * (SHORT * z**2 / 2.0 - z**3 / 6.0) / EI + force * z / KGA
        slope = force * (SHORT * z - z**2 / 2.0) / EI
        worst = max(worst, relative(found[:, 0], exact), relative(found[:, 4], slope))
    return worst


@cache
def timoshenko(rotary: bool, count: int = 2) -> np.ndarray:
    """Lowest circular frequencies of the clamped mast, from the transfer matrix of Timoshenko's equations."""

    def free_end(omega: float) -> float:
        rate = np.array([
            [0.0, 1.0, 0.0, 1.0 / KGA],  # deflection, rotation, moment, shear force, per height
            [0.0, 0.0, 1.0 / EI, 0.0],
            [0.0, -rotary * LINE / EA * EI * omega**2, 0.0, -1.0],
            [-LINE * omega**2, 0.0, 0.0, 0.0],
        ])  # fmt: skip
        scale = np.array([1.0, 1.0 / SHORT, SHORT / EI, SHORT**2 / EI])
        return float(np.linalg.det(expm(scale[:, None] * rate / scale * SHORT)[2:, 2:]))

    grid = np.linspace(1.0, 1200.0, 1200)
    value = np.array([free_end(omega) for omega in grid])
    change = np.flatnonzero(value[1:] * value[:-1] < 0.0)[:count]
    return np.array([brentq(free_end, grid[i], grid[i + 1], xtol=1e-10, rtol=1e-14) for i in change])


def shear_rate(variant: tuple[str, bool]) -> float:
    """Deviation from 2 of the rate at which two frequencies converge with the element length."""
    beam, rotary = variant
    off = [
        np.abs(bending(short_mast(n, rotary_inertia=rotary).model_copy(update={"beam": beam}), 2)
               / timoshenko(rotary) - 1.0)
        for n in (8, 16)
    ]  # fmt: skip
    return float(np.abs(np.log2(off[0] / off[1]) - 2.0).max())


# --- time integration ---------------------------------------------------------------------------------

OMEGA, ZETA, DRIVE = 2.0, 0.02, 3.1


def oscillator(method: str | float, omega2: float, damping: float, load: np.ndarray, h: float) -> np.ndarray:
    """Displacement and velocity [time, 2] from rest under loads; a number for `method` is Newmark's gamma."""
    gamma = method if isinstance(method, float) else 0.5
    beta = 0.25 * (gamma + 0.5) ** 2
    damped = {"wrong": lambda k, c, h: newmark(k, c, h, gamma=gamma, beta=beta)}
    with mock.patch.dict(METHODS, damped):
        name = method if isinstance(method, str) else "wrong"
        system = Oscillators(np.array([omega2]), np.array([damping]), h, 1, name)
        zero, first = np.zeros(1), load[:1].copy()
        motion = integrate(system, MotionState(zero, zero, first, first), load[1:, None])[1]
    moved = np.column_stack([motion.displacement[:, 0], motion.velocity[:, 0]])
    return np.concatenate([np.zeros((1, 2)), moved])


def order_error(method: str | float) -> float:
    """Deviation from 2 of the slope of the error over the step, log against log, under cos(drive t)."""
    steps, errors = (0.08, 0.04, 0.02, 0.01), []
    for h in steps:
        time = h * np.arange(round(6.0 / h) + 1)
        amplitude = 1.0 / (OMEGA**2 - DRIVE**2 + 2j * ZETA * OMEGA * DRIVE)
        root = -ZETA * OMEGA + 1j * OMEGA * np.sqrt(1.0 - ZETA**2)
        # forced part and a free one, c e^(root t), that cancels it and its velocity at the start
        real = -amplitude.real
        free = real + 1j * (-(1j * DRIVE * amplitude).real - root.real * real) / -root.imag
        exact = (amplitude * np.exp(1j * DRIVE * time) + free * np.exp(root * time)).real
        found = oscillator(method, OMEGA**2, 2.0 * ZETA * OMEGA, np.cos(DRIVE * time), h)
        errors.append(np.abs(found[:, 0] - exact).max())
    return float(abs(np.polyfit(np.log(steps), np.log(errors), 1)[0] - 2.0))


def ramp_error(method: str) -> float:
    """Error under random loads that are linear in steps of 0.3 s, against the sum of responses to ramps."""
    load, h, worst = np.random.default_rng(1).standard_normal(60), 0.3, 0.0
    load[0] = 0.0
    time = h * np.arange(60)
    for omega, zeta in ((3.0, 0.02), (0.2, 0.1), (140.0, 0.01)):
        fast = omega * np.sqrt(1.0 - zeta**2)
        exact = np.zeros((60, 2))
        for start, bend in zip(time[:-1], np.diff(load, 2, prepend=0.0) / h, strict=True):
            t = np.maximum(time - start, 0.0)
            decay, c, s = np.exp(-zeta * omega * t), np.cos(fast * t), np.sin(fast * t)
            x = t - 2.0 * zeta / omega + decay * (2.0 * zeta / omega * c + (2.0 * zeta**2 - 1.0) / fast * s)
            v = 1.0 - decay * (c + zeta * omega / fast * s)
            exact += bend / omega**2 * np.column_stack([x, v])
        found = oscillator(method, omega**2, 2.0 * zeta * omega, load, h)
        worst = max(worst, *(relative(found[:, i], exact[:, i]) for i in range(2)))
    return worst


def energy_drift(gamma: float) -> float:
    """Largest change of the energy of free vibration in 10,000 steps of 0.02 s, from 0.1 Hz to 100 Hz."""
    worst = 0.0
    for hertz in (0.1, 1.0, 10.0, 100.0):
        load = np.zeros(10_000)
        load[0] = 1.0  # sets the motion off: an acceleration at the start
        x, v = oscillator(gamma, (2.0 * np.pi * hertz) ** 2, 0.0, load, 0.02)[1:].T
        energy = (2.0 * np.pi * hertz * x) ** 2 + v**2
        worst = max(worst, float(np.abs(energy / energy[0] - 1.0).max()))
    return worst


PROOFS = (
    Proof(
        key="frame-patch-test",
        claim="Frames of any orientation and mesh give constant curvature, twist and strain exactly",
        against="motion of all nodes and forces at member ends, closed form; 1, 3 and 5 elements a member",
        error=patch_error,
        right=(),
        wrong={
            "element axes turned the other way": TURNED,
            "left-handed rotation about y": ((assembly_module, "stiffness", mirrored),),
            "I for J in torsion": ((elements, "polar_inertia", elements.bending_inertia),),
        },
        allowed=1e-8,
        reason="round-off of the solution; a chain of four members has a condition of 1e6",
    ),
    Proof(
        key="timoshenko-statics",
        claim="Timoshenko elements give deflection and slope at every node exactly, 1, 3 and 8 of them",
        against="P (L z^2/2 - z^3/6)/EI + P z/kGA, a mast of ten diameters",
        error=shear_deflection,
        right=(),
        wrong={
            "Euler-Bernoulli": ((assembly_module, "shear_parameter", lambda length, *_: 0.0 * length),),
            "the whole area in shear": ((elements, "shear_coefficient", lambda d, *_: np.ones_like(d)),),
        },
        allowed=1e-9,
        reason="round-off of the solution",
    ),
    Proof(
        key="timoshenko-rate",
        claim="Frequencies of Timoshenko elements converge with the second power: their mass knows no shear",
        against="Timoshenko's equations by transfer matrix, a mast of ten diameters; 8 and 16 elements",
        error=shear_rate,
        right=("timoshenko", False),
        wrong={
            "Euler-Bernoulli": ("euler-bernoulli", False),
            "rotary inertia of slopes for that of rotations": ("timoshenko", True),
        },
        allowed=0.15,
        reason="band of an observed rate",
    ),
    Proof(
        key="newmark-order",
        claim="Newmark's average acceleration is of second order",
        against="exact motion of a damped oscillator under a harmonic load, slope over four steps",
        error=order_error,
        right="newmark",
        wrong={"gamma 0.6": 0.6},
        allowed=0.15,
        reason="band of an observed order",
    ),
    Proof(
        key="generalised-alpha-order",
        claim="The generalised-alpha method is of second order",
        against="exact motion of a damped oscillator under a harmonic load, slope over four steps",
        error=order_error,
        right="generalised-alpha",
        wrong={"gamma 0.6": 0.6},
        allowed=0.15,
        reason="band of an observed order",
    ),
    Proof(
        key="exact-integrator",
        claim="The exact integrator has no error for loads linear in a step, however long",
        against="sum of closed-form responses to ramps; steps of 0.01 to 7 periods",
        error=ramp_error,
        right="exact",
        wrong={"average acceleration": "newmark", "generalised-alpha": "generalised-alpha"},
        allowed=1e-10,
        reason="round-off of 60 steps",
    ),
    Proof(
        key="energy-of-free-vibration",
        claim="Average acceleration keeps the energy of undamped free vibration, resolved or not",
        against="energy at the start, 10,000 steps of 0.02 s, 0.1 to 100 Hz",
        error=energy_drift,
        right=0.5,
        wrong={"gamma 0.6": 0.6},
        allowed=1e-9,
        reason="round-off that grows with the steps",
    ),
)
