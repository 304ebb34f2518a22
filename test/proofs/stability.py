"""Axial forces of weights: beam-columns, buckling, and what they do to frequencies."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from owt_model.mesh import build_mesh
from owt_structure_node.core.assembly import Assembly, assemble
from owt_structure_node.core.modes import factorise, lowest_modes
from owt_structure_node.core.reduction import guyan
from proofs.frame import EI, LENGTH, LINE, TUBE, mast
from proofs.registry import Proof

DRY = {"sections": {"tube": TUBE | {"density_kg_m3": 1e-6}}}
EULER = np.pi**2 * EI / (4.0 * LENGTH**2)


@cache
def pressed(share: float, p_delta: bool = True, offset: float = 0.0) -> Assembly:
    """Mast of negligible mass below a weight that is a share of its buckling load."""
    weight = {"mass_kg": share * EULER / 9.81, "offset_m": [0.0, 0.0, offset]}
    state = {"gravity_m_s2": 9.81, "p_delta": p_delta}
    return assemble(build_mesh(mast(16, transition_piece=weight, static_state=state, **DRY)))


def slowest(assembly: Assembly) -> float:
    """Lowest squared circular frequency, from the inverse: the mast's mass is all but nothing."""
    return 1.0 / float(eigh(assembly.mass.toarray(), assembly.stiffness.toarray(), eigvals_only=True)[-1])


def softened(p_delta: bool) -> float:
    """Error of the tip's stiffness under compression, P alpha/(tan(alpha L) - alpha L), at three loads."""
    worst = 0.0
    for share in (0.1, 0.5, 0.9):
        assembly = pressed(share, p_delta)
        alpha = np.sqrt(share * EULER / EI)
        exact = share * EULER * alpha / (np.tan(alpha * LENGTH) - alpha * LENGTH)
        load = np.zeros(assembly.mesh.n_dof)
        load[assembly.internal] = 1.0
        tip = factorise(assembly.stiffness).solve(load)[assembly.internal]
        omega2 = slowest(assembly)
        mass = share * EULER / 9.81
        worst = max(worst, abs(exact * tip - 1.0), abs(omega2 * mass / exact - 1.0))
    return float(worst)


def buckling(load: float) -> float:
    """Error of a buckling load: the squared frequency times the weight falls to zero there."""
    # omega^2 times the share is all but linear in it near buckling: two loads give where it vanishes.
    shares = np.array([0.98, 0.99])
    values = np.array([slowest(pressed(float(s))) * s for s in shares])
    zero = shares[1] - values[1] * (shares[1] - shares[0]) / (values[1] - values[0])
    return float(abs(zero * EULER / load - 1.0))


def leaning(offset: float) -> float:
    """Error of the buckling weight of a body whose centre of gravity lies 6 m above a mast's top.

    A rigid stub upon the mast: alpha L tan(alpha L) = L/h.
    """
    height = 6.0
    root = brentq(lambda x: x * np.tan(x) - LENGTH / height, 0.1, 1.57)
    critical = root**2 * EI / LENGTH**2 / EULER
    shares = critical * np.array([0.98, 0.99])
    values = []
    for share in shares:
        assembly = pressed(float(share), True, offset)
        values.append(np.linalg.eigvalsh(guyan_of(assembly))[0])
    zero = shares[1] - values[1] * (shares[1] - shares[0]) / (values[1] - values[0])
    return float(abs(zero / critical - 1.0))


def guyan_of(assembly: Assembly) -> np.ndarray:
    """Stiffness at the top, what stands on it included."""
    n = assembly.internal
    upper = assembly.upper_stiffness[n : n + 6, n : n + 6].toarray()
    return np.asarray(guyan(assembly).stiffness + upper)


def own_weight(coefficient: float) -> float:
    """Error of the gravity at which a uniform mast buckles under its own weight: q L^3 = 7.837 EI."""
    critical = coefficient * EI / LENGTH**3 / LINE
    omega2 = []
    shares = np.array([0.9, 0.95])
    for share in shares:
        state = {"gravity_m_s2": float(share * 7.837347 * EI / LENGTH**3 / LINE)}
        assembly = assemble(build_mesh(mast(24, static_state=state)))
        omega2.append(lowest_modes(assembly.stiffness, assembly.mass, 1)[0][0])
    zero = shares[1] - omega2[1] * (shares[1] - shares[0]) / (omega2[1] - omega2[0])
    return float(abs(zero * 7.837347 * EI / LENGTH**3 / LINE / critical - 1.0))


PROOFS = (
    Proof(
        key="beam-column",
        claim="Stiffness and frequency of a mast under 10, 50 and 90 % of its buckling load",
        against="k = P a/(tan aL - aL), a^2 = P/EI",
        error=softened,
        right=True,
        wrong={"no geometric stiffness": False},
        allowed=2e-5,
        reason="error of 16 elements close to buckling",
    ),
    Proof(
        key="euler-buckling",
        claim="The weight that brings the frequency of a mast to zero",
        against="pi^2 EI/(4 L^2)",
        error=buckling,
        right=EULER,
        wrong={"pinned column": 4.0 * EULER, "weight on a cantilever's middle": 0.7 * EULER},
        allowed=1e-4,
        reason="extrapolation from 98 and 99 %",
    ),
    Proof(
        key="weight-above-the-top",
        claim="A centre of gravity above its node lowers the buckling weight",
        against="aL tan aL = L/h for a rigid stub of h = L/10",
        error=leaning,
        right=6.0,
        wrong={"at the node": 0.0, "below the node": -6.0},
        allowed=1e-3,
        reason="extrapolation from 98 and 99 %",
    ),
    Proof(
        key="self-buckling",
        claim="A uniform mast buckles under its own weight",
        against="q L^3 = 7.837 EI",
        error=own_weight,
        right=7.837347,
        wrong={"weight at the top": np.pi**2 / 4.0, "half of it at the top": np.pi**2 / 2.0},
        allowed=5e-3,
        reason="extrapolation from 90 and 95 %",
    ),
)
