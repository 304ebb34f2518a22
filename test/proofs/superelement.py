"""Superelements: the file, the reduced jacket from it under the tower, and what ExtPtfm makes of it."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from functools import cache

import numpy as np

from owt_model.config import parse_case
from owt_model.contracts import LoadBlock
from owt_model.superelement import INTERFACE, Superelement, write_superelement
from owt_model.superelement_file import parse_superelement
from owt_structure_node.core.reduction import Reduction, reduce, solve_interior
from owt_structure_node.core.stage import build_response_model, initial_state, step
from owt_structure_node.core.superelement import (
    attach,
    frequencies,
    jacket_superelement,
    project_loads,
    rayleigh_coefficients,
)
from owt_structure_node.core.superelement_response import respond
from proofs.reduction import DT, basis, history, jacket, nodes
from proofs.registry import Proof

NAME, STEP = "CB10M08", 0.02
ALPHA, BETA = 0.027, 0.002
SAMPLES = 400


@cache
def reduced() -> Reduction:
    """The basis of the chain: which of two equal modes is which depends on how many are asked for."""
    return reduce(jacket(), NAME, basis(), interior=solve_interior(jacket(), 11))


@cache
def exported() -> Superelement:
    """The OC4 jacket of the thesis and 40 s of loads."""
    loads = project_loads(jacket(), reduced(), nodes(), history()[:SAMPLES])
    return jacket_superelement(jacket(), reduced(), loads, dt=DT, alpha=ALPHA, beta=BETA)


def text(element: Superelement) -> str:
    stream = io.StringIO()
    write_superelement(stream, element)
    return stream.getvalue()


def through_file(digits: int = 17) -> Superelement:
    """The superelement as the file gives it back, which may be written with fewer digits."""
    content = text(exported())
    if digits < 17:
        number = re.compile(r"-?\d\.\d{16}e[+-]\d\d")
        content = number.sub(lambda found: f"{float(found[0]):.{digits - 1}e}", content)
    return parse_superelement(content, source="jacket.dat")


def relative(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def permuted(element: Superelement, order: list[int]) -> Superelement:
    """Degrees of freedom in another order, in all of the file."""
    at = np.ix_(order, order)
    matrices = (element.mass[at], element.stiffness[at], element.damping[at])
    return replace(
        element,
        **dict(zip(("mass", "stiffness", "damping"), matrices, strict=True)),
        loads=element.loads[:, order],
    )


def round_trip_error(digits: int) -> float:
    found, given = through_file(digits), exported()
    names = ("mass", "stiffness", "damping", "loads")
    return max(relative(getattr(found, name), getattr(given, name)) for name in names)


# --- under the tower ----------------------------------------------------------------------------------


def frequency_error(variant: str) -> float:
    """All frequencies of the assembled system."""
    element = through_file()
    if variant == "modes first":
        n = element.n_dof
        element = permuted(element, [*range(INTERFACE, n), *range(INTERFACE)])
    attached = attach(element, jacket(), alpha=ALPHA, beta=BETA)
    stiffness, mass = attached.stiffness, attached.mass
    if variant == "no transition piece":
        mass = mass.copy()
        mass[:INTERFACE, :INTERFACE] = element.mass[:INTERFACE, :INTERFACE]
    return relative(frequencies(stiffness, mass), frequencies(reduced().stiffness, reduced().mass))


@cache
def chain() -> tuple[np.ndarray, ...]:
    """The in-house response: interface and tower top, displacement and acceleration, force from below.

    The force comes from the equation of the jacket with the generalised coordinates of the chain: what loads,
    inertia, damping and stiffness leave at the interface.
    """
    structure = {"reduction": NAME, "damping": {"alpha": ALPHA, "beta": BETA}, "dt_s": STEP}
    case = parse_case({"structure": structure, "time": {"dt_s": DT, "n": SAMPLES}})
    model = build_response_model(case, jacket().mesh, basis())
    none = np.zeros(0, dtype=np.int64)
    block = LoadBlock(
        sequence=0,
        start=0,
        dt=DT,
        last=True,
        model_hash=jacket().mesh.structure.content_hash,
        node=nodes(),
        element=none,
        nodal=np.ascontiguousarray(history()[:SAMPLES]),
        fixed_end=np.zeros((SAMPLES, 0, 12)),
    )
    modal = step(model, initial_state(model), block)[1].modal
    names = model.description.coordinate_name
    name = jacket().mesh.node_name[jacket().mesh.tower_top]
    top = [names.index(f"{name}.{direction}") for direction in ("ux", "uy", "uz", "rx", "ry", "rz")]
    own, every = exported(), round(DT / STEP)
    q, v, a = (
        getattr(modal, part)[::every, : own.n_dof] for part in ("displacement", "velocity", "acceleration")
    )
    below = own.loads - q @ own.stiffness - v @ own.damping - a @ own.mass
    return (
        modal.displacement[:, :INTERFACE],
        modal.acceleration[:, :INTERFACE],
        modal.displacement[:, top],
        modal.acceleration[:, top],
        below[:, :INTERFACE],
    )


def response_error(variant: str) -> float:
    """Largest error of translations, rotations, forces and moments, each kind over its peak."""
    element = through_file(6 if variant == "six digits" else 17)
    if variant == "order":
        element = permuted(element, [1, 0, *range(2, element.n_dof)])
    elif variant == "sign":
        element = replace(element, loads=-element.loads)
    elif variant == "late":
        element = replace(element, loads=np.concatenate([element.loads[:1], element.loads[:-1]]))
    elif variant == "interface":
        element = replace(element, loads=element.loads * (np.arange(element.n_dof) < INTERFACE))
    elif variant == "undamped":
        element = replace(element, damping=np.zeros_like(element.damping))
    elif variant == "six digits":  # its damping would be refused: the same of the rounded matrices
        element = replace(element, damping=ALPHA * element.mass + BETA * element.stiffness)
    alpha, beta = rayleigh_coefficients(element)
    found = respond(element, attach(element, jacket(), alpha=alpha, beta=beta), step=STEP)
    series = (
        found.interface.displacement,
        found.interface.acceleration,
        found.top.displacement,
        found.top.acceleration,
        found.force[:: round(DT / STEP)],
    )
    kinds = (slice(0, 3), slice(3, 6))
    return max(
        relative(one[:, kind], other[:, kind])
        for one, other in zip(series, chain(), strict=True)
        for kind in kinds
    )


# --- ExtPtfm ------------------------------------------------------------------------------------------


def extptfm_error(variant: str) -> float:
    """Force at the interface by ExtPtfm's state-space form of the file, at frequencies from 0.05 to 8 Hz.

    Its equations have no inner mass and no stiffness between interface and inside (OpenFAST manual, theory of
    ExtPtfm): x = (x_2, x_2'), u = (x_1, x_1', x_1''), y = f_C. The unreduced matrices of the file give the
    same force if the inner mass is the identity.
    """
    element, n1 = through_file(), INTERFACE
    scale = np.ones(element.n_dof)
    if variant == "modes of another norm":
        scale[n1:] = 2.0
    shift = np.eye(element.n_dof) * scale
    if variant == "attachment modes":  # stiffness couples them to the interface
        shift[0, n1] = 0.01
    m, k, c = (shift.T @ a @ shift for a in (element.mass, element.stiffness, element.damping))
    f, worst, rng = shift.T @ element.loads[10], 0.0, np.random.default_rng(7)
    for frequency in np.geomspace(0.05, 8.0, 40):
        s = 2j * np.pi * frequency
        x1 = rng.standard_normal(n1) * [1e-2, 1e-2, 1e-3, 1e-4, 1e-4, 1e-4]
        z = s * s * m + s * c + k
        x2 = np.linalg.solve(z[n1:, n1:], f[n1:] - z[n1:, :n1] @ x1)
        exact = f[:n1] - z[:n1, :n1] @ x1 - z[:n1, n1:] @ x2
        worst = max(worst, float((np.abs(_extptfm(m, k, c, f, x1, s) - exact) / np.abs(exact).max()).max()))
    return worst


def _extptfm(
    m: np.ndarray, k: np.ndarray, c: np.ndarray, f: np.ndarray, x1: np.ndarray, s: complex
) -> np.ndarray:
    """f_C = C x + D u + f_y with s x = A x + B u + f_x."""
    n1, n2 = INTERFACE, len(m) - INTERFACE
    one, two = slice(0, n1), slice(n1, None)
    zero, eye = np.zeros((n2, n2)), np.eye(n2)
    a = np.block([[zero, eye], [-k[two, two], -c[two, two]]])
    b = np.block([[np.zeros((n2, 3 * n1))], [np.zeros((n2, n1)), -c[two, one], -m[two, one]]])
    m12 = m[one, two]
    out = np.hstack([m12 @ k[two, two], m12 @ c[two, two] - c[one, two]])
    through = np.hstack([-k[one, one], -c[one, one] + m12 @ c[two, one], -m[one, one] + m12 @ m[two, one]])
    u = np.concatenate([x1, s * x1, s * s * x1])
    x = np.linalg.solve(s * np.eye(2 * n2) - a, b @ u + np.concatenate([np.zeros(n2), f[two]]))
    return np.asarray(out @ x + through @ u + f[one] - m12 @ f[two])


PROOFS = (
    Proof(
        key="superelement-round-trip",
        claim="A superelement file gives back every number of matrices and loads as it was",
        against="what was written, the OC4 jacket in CB10M08 and 40 s of loads",
        error=round_trip_error,
        right=17,
        wrong={"nine digits, as files often have": 9, "16 digits": 16},
        allowed=0.0,
        reason="seventeen digits name a float64",
    ),
    Proof(
        key="superelement-frequencies",
        claim="The superelement from the file under the tower has the frequencies of the reduced model",
        against="all frequencies of the in-house model in CB10M08",
        error=frequency_error,
        right="right",
        wrong={
            "modes before the interface": "modes first",
            "transition piece left out": "no transition piece",
        },
        allowed=1e-9,
        reason="round-off of the eigenvalue problem",
    ),
    Proof(
        key="superelement-response",
        claim="Interface and tower-top motion and interface force from the file are those of the chain",
        against="structure stage on the nodal loads; force from the equation of the jacket",
        error=response_error,
        right="right",
        wrong={
            "surge and sway exchanged in the file": "order",
            "loads of the other sign": "sign",
            "loads one sample late": "late",
            "loads of the interface only": "interface",
            "damping left out": "undamped",
            "six digits": "six digits",
        },
        allowed=1e-6,
        reason="round-off of the modes of a system whose frequencies span 0.3 Hz to 4 kHz",
    ),
    Proof(
        key="superelement-extptfm",
        claim="ExtPtfm's state-space form of the file gives the interface force of its matrices",
        against="dynamic stiffness of the file, interface moved and loads inside, 0.05 to 8 Hz",
        error=extptfm_error,
        right="right",
        wrong={
            "modes of another norm": "modes of another norm",
            "a basis with stiffness between interface and inside": "attachment modes",
        },
        allowed=1e-8,
        reason="round-off of two solves",
    ),
)
