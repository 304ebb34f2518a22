"""Frequencies that OpenFAST's SubDyn prints for decks of its own test suite, retyped as structures."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_structure_node.core.eigen import eigen_report
from proofs.frame import CLAMPED, mast
from proofs.registry import Proof


def monopile(variant: dict[str, Any]) -> float:
    """Error of the frequencies that SubDyn prints for the OC3 monopile below its transition piece."""
    tube = {
        "diameter_m": 6.0,
        "thickness_m": 0.06,
        "youngs_modulus_pa": 2.1e11,
        "shear_modulus_pa": 8.08e10,
        "density_kg_m3": 8500.0,
    }
    levels = {"1": -20.0001, "2": -10.0, "3": 0.0, "4": 10.0}
    structure = mast(
        3,
        sections={"tube": tube},
        joints={name: [0.0, 0.0, z] for name, z in levels.items()},
        members={f"M{i}": {"joints": [str(i), str(i + 1)], "section": "tube"} for i in (1, 2, 3)},
        supports={"1": CLAMPED},
        interface={"joints": ["4"], "reference_m": [0.0, 0.0, 10.0]},
        **({"beam": "timoshenko", "rotary_inertia": True} | variant),
    )
    printed = [6.072686, 6.072686, 25.72555, 28.32034, 28.32034, 41.47330, 58.59113, 58.59113, 77.96200]
    found = eigen_report(structure, n_modes=9)["frequencies_hz"]
    return float(np.abs(np.array(found) / printed - 1.0).max())


def pendulum(stiffness: float) -> float:
    """Error of the frequencies that SubDyn prints for a tube hung on a sprung hinge from a held one."""
    tube = {
        "diameter_m": 0.2,
        "thickness_m": 0.02,
        "youngs_modulus_pa": 2.1e11,
        "shear_modulus_pa": 8.0769e10,
        "density_kg_m3": 7850.0,
    }
    hinge = {"hinge": [0.0, 1.0, 0.0], "stiffness_nm_rad": stiffness}
    structure = mast(
        1,
        sections={"tube": tube},
        joints={"1": [0.0, 0.0, 0.0], "2": [0.0, 0.0, -1.0], "3": [0.0, 0.0, -6.0]},
        members={
            "M1": {"joints": ["1", "2"], "section": "tube"},
            "M2": {"joints": ["2", "3"], "section": "tube", "release_first": hinge},
        },
        supports={},
        free=True,
        interface={"joints": ["1"], "reference_m": [0.0, 0.0, 0.0]},
        beam="timoshenko",
        rotary_inertia=True,
    )
    printed = [0.02616088, 5.154898, 34.48768, 36.39185, 98.26435]
    found = eigen_report(structure, fixed_interface=True, n_modes=5)["frequencies_hz"]
    return float(np.abs(np.array(found) / printed - 1.0).max())


PROOFS = (
    Proof(
        key="subdyn-monopile",
        claim="Frequencies of the OC3 monopile",
        against="SubDyn, OpenFAST r-test 5MW_OC3Mnpl_Linear (seven digits)",
        error=monopile,
        right={},
        wrong={
            "Euler-Bernoulli": {"beam": "euler-bernoulli"},
            "no rotary inertia": {"rotary_inertia": False},
        },
        allowed=1e-6,
        reason="digits printed",
    ),
    Proof(
        key="subdyn-pendulum",
        claim="Frequencies of a tube on a sprung hinge below a held interface",
        against="SubDyn, OpenFAST r-test SD_PendulumDamp (seven digits)",
        error=pendulum,
        right=100.0,
        wrong={"hinge without spring": 1e-3, "spring doubled": 200.0},
        allowed=1e-6,
        reason="digits printed",
    ),
)
