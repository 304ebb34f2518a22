"""Beams, springs, releases and rigid links: closed forms of structural mechanics."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from owt_model.mesh import build_mesh
from owt_model.section import area, bending_inertia, polar_inertia
from owt_model.structure import Structure, parse_structure
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.modes import factorise, lowest_modes
from owt_structure_node.core.recovery import end_force_map
from owt_structure_node.core.reduction import guyan
from proofs.registry import Proof

E, G, RHO = 2.1e11, 8.0769e10, 7850.0
D, T, LENGTH = np.array([1.2]), np.array([0.05]), 60.0
EA, EI, GJ = (
    E * float(area(D, T)[0]),
    E * float(bending_inertia(D, T)[0]),
    G * float(polar_inertia(D, T)[0]),
)
LINE = RHO * float(area(D, T)[0])
TUBE = {
    "diameter_m": 1.2,
    "thickness_m": 0.05,
    "youngs_modulus_pa": E,
    "shear_modulus_pa": G,
    "density_kg_m3": RHO,
}
CLAMPED = [True] * 6


def mast(elements: int = 16, member: dict[str, Any] | None = None, **more: Any) -> Structure:
    """A clamped vertical tube of 60 m; its top is the transition-piece node."""
    data: dict[str, Any] = {
        "name": "mast",
        "elements_per_member": elements,
        "mudline_z_m": 0.0,
        "sections": {"tube": TUBE},
        "joints": {"A": [0.0, 0.0, 0.0], "B": [0.0, 0.0, LENGTH]},
        "members": {"M": {"joints": ["A", "B"], "section": "tube"} | (member or {})},
        "supports": {"A": CLAMPED},
        "interface": {"joints": ["B"], "reference_m": [0.0, 0.0, LENGTH]},
    }
    return parse_structure(data | more, source="mast")


def bending(structure: Structure, count: int) -> np.ndarray:
    """Lowest `count` circular frequencies of bending, which come in pairs, in rad/s."""
    assembly = assemble(build_mesh(structure))
    return np.asarray(np.sqrt(lowest_modes(assembly.stiffness, assembly.mass, 2 * count)[0][::2]))


def beam_roots(equation: Any, brackets: list[tuple[float, float]]) -> np.ndarray:
    """Circular frequencies in rad/s of a uniform beam from the roots of its equation in beta L."""
    roots = [brentq(equation, a, b, xtol=1e-14, rtol=1e-14) for a, b in brackets]
    return np.array(roots) ** 2 * np.sqrt(EI / LINE) / LENGTH**2


FREE = beam_roots(lambda x: np.cos(x) * np.cosh(x) + 1.0, [(1.0, 3.0), (4.0, 6.0)])


def rate_from(expected: float) -> Any:
    """Deviation of the rate at which the frequencies of a cantilever converge with the element length."""

    def error(mass: str) -> float:
        off = [np.abs(bending(mast(n, mass=mass), 2) / FREE - 1.0) for n in (8, 16)]
        return float(np.abs(np.log2(off[0] / off[1]) - expected).max())

    return error


SPRING = 2.0 * EI / LENGTH


def sprung_root(kind: str) -> float:
    """Error of two frequencies of a cantilever on a rotational spring of 2 EI/L."""

    def equation(x: float) -> float:
        s, c, sh, ch = np.sin(x), np.cos(x), np.sinh(x), np.cosh(x)
        ratio = SPRING * LENGTH / EI
        # w = a (cos - cosh) + b sin + c sinh: w(0) = 0; spring at 0; no moment and no shear at L
        rows = [[2.0 * x, ratio, ratio], [-c - ch, -s, sh], [s - sh, -c, ch]]
        return float(np.linalg.det(np.array(rows)))

    exact = beam_roots(equation, [(0.8, 1.87), (3.93, 4.69)])
    held = [True, True, True, False, False, True]
    if kind == "diagonal":
        more: dict[str, Any] = {"support_springs": {"A": {"stiffness": [0.0, 0.0, 0.0, SPRING, SPRING, 0.0]}}}
    elif kind == "matrix":
        more = {"support_springs": {"A": {"stiffness": np.diag([0.0] * 3 + [SPRING] * 2 + [0.0]).tolist()}}}
    elif kind == "clamped":
        more, held = {}, CLAMPED
    else:
        more = {"support_springs": {"A": {"stiffness": [0.0, 0.0, 0.0, 2 * SPRING, 2 * SPRING, 0.0]}}}
    return float(np.abs(bending(mast(supports={"A": held}, **more), 2) / exact - 1.0).max())


def sprung(kinds: tuple[str, ...]) -> float:
    """Largest error of several ways to give the spring."""
    return max(sprung_root(kind) for kind in kinds)


def coupled_spring(coupling: float) -> float:
    """Error of the tip's flexibility above a 6 x 6 spring that couples shear and rotation."""
    k_x, k_ry, couple = 4e6, 9e8, -3e7
    matrix = np.diag([k_x, 4e6, 8e8, 9e8, k_ry, 5e8])
    matrix[0, 4] = matrix[4, 0] = coupling * couple
    structure = mast(4, supports={}, support_springs={"A": {"stiffness": matrix.tolist()}})
    assembly = assemble(build_mesh(structure))
    load = np.zeros(assembly.mesh.n_dof)
    load[assembly.internal] = 1.0
    found = factorise(assembly.stiffness).solve(load)[assembly.internal]
    base = np.linalg.solve([[k_x, couple], [couple, k_ry]], [1.0, LENGTH])  # shear 1, moment L about y
    exact = base[0] + base[1] * LENGTH + LENGTH**3 / (3.0 * EI)
    return float(abs(found / exact - 1.0))


def beside(member: dict[str, Any], elements: int) -> Structure:
    """Mast between two clamped joints, the interface on a stub beside its foot; the mast is member 0."""
    return mast(
        elements,
        joints={"A": [0.0, 0.0, 0.0], "B": [0.0, 0.0, LENGTH], "C": [0.5, 0.0, 0.0]},
        members={
            "M": {"joints": ["A", "B"], "section": "tube"} | member,
            "N": {"joints": ["A", "C"], "section": "tube"},
        },
        supports={"A": CLAMPED, "B": CLAMPED},
        interface={"joints": ["C"], "reference_m": [0.5, 0.0, 0.0]},
    )


def held_beam(released: tuple[str | None, str | None]) -> float:
    """Error of the frequencies of a beam that is clamped below and pinned above."""
    exact = beam_roots(lambda x: np.tan(x) - np.tanh(x), [(3.5, 4.5), (6.7, 7.4)])
    ends = dict(zip(("release_first", "release_last"), released, strict=True))
    member = {key: {"about": about} for key, about in ends.items() if about}
    found = eigen_report(beside(member, 16), fixed_interface=True, n_modes=4)["frequencies_hz"]
    return float(np.abs(2.0 * np.pi * np.array(found)[::2] / exact - 1.0).max())


def propped(release: str | None) -> float:
    """Error of both end moments and of the prop's force under a uniform load q: q L^2/8, 0 and 3 q L/8."""
    member: dict[str, Any] = {"release_last": {"about": release}} if release else {}
    assembly = assemble(build_mesh(beside(member, 1)))
    mesh, q = assembly.mesh, 1e4
    # Element axes: y is global y. Fixed-end forces of a clamped element under q along y.
    fixed = np.zeros(12)
    fixed[[1, 7]] = -q * LENGTH / 2.0
    fixed[[5, 11]] = -q * LENGTH**2 / 12.0, q * LENGTH**2 / 12.0
    nodal = np.zeros((mesh.n_nodes, 6))
    for side, node in enumerate(mesh.element_node[0]):
        nodal[node, 1] = -fixed[1 + 6 * side]
        nodal[node, 3] = fixed[5 + 6 * side]  # local z is global -x
    u = np.zeros(mesh.n_dof)
    n = assembly.internal
    if n:
        load = (assembly.expansion.T @ nodal.reshape(-1))[:n]
        u[:n] = factorise(assembly.stiffness[:n, :n].tocsc()).solve(load)
    ends = end_force_map(assembly, u[:, None])[0, :2] + fixed.reshape(2, 6)
    found = np.array([ends[0, 5], ends[1, 5], ends[1, 1] * LENGTH])
    exact = np.array([-q * LENGTH**2 / 8.0, 0.0, -3.0 * q * LENGTH**2 / 8.0])
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def hinge(direction: list[float]) -> float:
    """Error of the tip's flexibilities above a base that turns on a sprung hinge about a level direction."""
    member = {"release_first": {"hinge": direction, "stiffness_nm_rad": SPRING}}
    assembly = assemble(build_mesh(mast(2, member=member)))
    axis = np.array([0.6, 0.8, 0.0])
    along = np.cross(axis, [0.0, 0.0, 1.0])  # the way in which the hinge lets the tip go
    straight = LENGTH**3 / (3.0 * EI)
    exact = straight * np.eye(2) + LENGTH**2 / SPRING * np.outer(along, along)[:2, :2]
    load = np.zeros((assembly.mesh.n_dof, 2))
    load[assembly.internal + np.arange(2), np.arange(2)] = 1.0
    found = factorise(assembly.stiffness).solve(load)[assembly.internal : assembly.internal + 2]
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def hexapod(releases: tuple[str | None, str | None]) -> float:
    """Error of the stiffness of a platform on six pinned bars: sum of EA/L s s' over their screws s."""
    angle = np.radians([0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
    foot = np.column_stack([9.0 * np.cos(angle), 9.0 * np.sin(angle), np.zeros(6)])
    turned = angle + np.radians([35.0, -35.0] * 3)
    head = np.column_stack([4.0 * np.cos(turned), 4.0 * np.sin(turned), np.full(6, 12.0)])
    reference = np.array([0.0, 0.0, 13.0])
    ends = dict(zip(("release_first", "release_last"), releases, strict=True))
    release = {key: {"about": about} for key, about in ends.items() if about}
    structure = mast(
        1,
        joints={f"F{i}": foot[i].tolist() for i in range(6)} | {f"H{i}": head[i].tolist() for i in range(6)},
        members={f"M{i}": {"joints": [f"F{i}", f"H{i}"], "section": "tube"} | release for i in range(6)},
        supports={f"F{i}": CLAMPED for i in range(6)},
        interface={"joints": [f"H{i}" for i in range(6)], "reference_m": reference.tolist()},
    )
    exact = np.zeros((6, 6))
    for i in range(6):
        bar = head[i] - foot[i]
        unit = bar / np.linalg.norm(bar)
        screw = np.concatenate([unit, np.cross(head[i] - reference, unit)])
        exact += EA / np.linalg.norm(bar) * np.outer(screw, screw)
    found = guyan(assemble(build_mesh(structure))).stiffness
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def rigid_top(link: str) -> float:
    """Error of the deflection of a mast under a force at the end of a rigid arm 7 m up and 3 m aside."""
    up, aside = 7.0, 3.0
    arm = [0.0, aside, LENGTH + up]
    if link == "link":
        more: dict[str, Any] = {
            "joints": {"A": [0.0, 0.0, 0.0], "B": [0.0, 0.0, LENGTH], "C": arm},
            "rigid_links": {"R": {"joints": ["B", "C"]}},
            "interface": {"joints": ["C"], "reference_m": arm},
        }
    elif link == "beam":
        more = {
            "joints": {"A": [0.0, 0.0, 0.0], "B": [0.0, 0.0, LENGTH], "C": arm},
            "members": {
                "M": {"joints": ["A", "B"], "section": "tube"},
                "N": {"joints": ["B", "C"], "section": "tube"},
            },
            "interface": {"joints": ["C"], "reference_m": arm},
        }
    else:
        more = {}
    assembly = assemble(build_mesh(mast(2, **more)))
    load = np.zeros(assembly.mesh.n_dof)
    load[assembly.internal] = 1.0
    found = factorise(assembly.stiffness).solve(load)[assembly.internal]
    exact = (LENGTH**3 / 3.0 + LENGTH**2 * up + LENGTH * up**2) / EI + aside**2 * LENGTH / GJ
    return float(abs(found / exact - 1.0))


def tapered(elements: int) -> float:
    """Error of the stretch of a tapered tube of constant wall ratio, L/(E A) over its ends: A ~ d^2."""
    sections = {"tube": TUBE, "top": TUBE | {"diameter_m": 0.6, "thickness_m": 0.025}}
    structure = mast(elements, member={"section_last": "top"}, sections=sections)
    assembly = assemble(build_mesh(structure))
    load = np.zeros(assembly.mesh.n_dof)
    load[assembly.internal + 2] = 1.0
    found = factorise(assembly.stiffness).solve(load)[assembly.internal + 2]
    return float(abs(found * EA / (2.0 * LENGTH) - 1.0))


PROOFS = (
    Proof(
        key="consistent-mass-rate",
        claim="Frequencies of a cantilever with consistent mass converge with the fourth power",
        against="cos x cosh x = -1; 8 and 16 elements",
        error=rate_from(4.0),
        right="consistent",
        wrong={"lumped mass": "lumped"},
        allowed=0.15,
        reason="band of an observed rate",
    ),
    Proof(
        key="lumped-mass-rate",
        claim="Frequencies of a cantilever with lumped mass converge with the second power",
        against="cos x cosh x = -1; 8 and 16 elements",
        error=rate_from(2.0),
        right="lumped",
        wrong={"consistent mass": "consistent"},
        allowed=0.15,
        reason="band of an observed rate",
    ),
    Proof(
        key="cantilever-on-a-rotational-spring",
        claim="Frequencies of a cantilever on a rotational spring, given as list and as matrix",
        against="beam equation with k = 2 EI/L at the base",
        error=sprung,
        right=("diagonal", "matrix"),
        wrong={"clamped": ("clamped",), "spring doubled": ("double",)},
        allowed=2e-5,
        reason="error of 16 elements in the second mode",
    ),
    Proof(
        key="coupled-support-spring",
        claim="Flexibility of a mast on a spring that couples shear and rotation",
        against="closed form",
        error=coupled_spring,
        right=1.0,
        wrong={"coupling left out": 0.0, "coupling of the other sign": -1.0},
        allowed=1e-9,
        reason="round-off of the solution",
    ),
    Proof(
        key="pinned-beam-frequencies",
        claim="A beam clamped at one end and released at the other has the frequencies of a propped one",
        against="tan x = tanh x",
        error=held_beam,
        right=(None, "yz"),
        wrong={"no release": (None, None), "both ends released": ("yz", "yz")},
        allowed=4e-5,
        reason="error of 16 elements in the second mode, (beta h)^4/1440 = 2.6e-5",
    ),
    Proof(
        key="propped-cantilever",
        claim="End moments and prop force of a released member under uniform load",
        against="q L^2/8, 0 and 3 q L/8",
        error=propped,
        right="xyz",
        wrong={"no release": None, "released about another axis": "y"},
        allowed=1e-9,
        reason="round-off of the solution",
    ),
    Proof(
        key="sprung-hinge",
        claim="A hinge with a spring lets the mast lean about its own direction only",
        against="L^3/3EI, and L^2/k more across the hinge",
        error=hinge,
        right=[0.6, 0.8, 0.0],
        wrong={"hinge turned by 90 degrees": [0.8, -0.6, 0.0]},
        allowed=1e-9,
        reason="round-off of the solution",
    ),
    Proof(
        key="hexapod",
        claim="Six bars with released ends carry a platform as a truss",
        against="sum of EA/L times the bars' screws",
        error=hexapod,
        right=("yz", "xyz"),
        wrong={"no releases": (None, None), "released at one end": (None, "xyz")},
        allowed=1e-9,
        reason="round-off of the solution",
    ),
    Proof(
        key="rigid-link",
        claim="A rigid link carries force and moment of its arm to the mast",
        against="deflection and twist of a mast with a rigid arm",
        error=rigid_top,
        right="link",
        wrong={"flexible arm": "beam", "force on the mast's top": "none"},
        allowed=1e-9,
        reason="round-off of the solution",
    ),
    Proof(
        key="tapered-tube",
        claim="Stretch of a tube of half the width at its top",
        against="L/(E sqrt(A0 A1))",
        error=tapered,
        right=32,
        wrong={"one element": 1},
        allowed=1e-3,
        reason="steps of 32 elements, squared",
    ),
)
