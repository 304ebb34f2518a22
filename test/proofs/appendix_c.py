"""Thesis appendix C: force of a regular wave on the OC4 jacket, against Morison's equation written out."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from owt_model.config import parse_case
from owt_model.structure import load_structure
from owt_wave_node.core.loads import jacket_loads
from proofs import cases
from proofs.registry import Proof

HEIGHT, PERIOD, DEPTH, RHO, G = 2.5, 5.0, 50.0, 1025.0, 9.81
#: Equal time steps in one period.
STEPS = 50


def deep_wavenumber() -> float:
    """k of omega^2 = g k tanh kd by plain iteration, which converges at once in water this deep."""
    k = omega_squared = (2.0 * math.pi / PERIOD) ** 2 / G
    for _ in range(20):
        k = omega_squared / math.tanh(k * DEPTH)
    return k


@cache
def written_out(longest: float = 0.05) -> np.ndarray:
    """Total force along x in N of pieces of the members, as far as each is wet, Cd 1 and Cm 2, numpy."""
    t = np.arange(STEPS) * PERIOD / STEPS
    omega, k, a = 2.0 * math.pi / PERIOD, deep_wavenumber(), 0.5 * HEIGHT
    structure, total = load_structure("oc4"), np.zeros(STEPS)
    for member in structure.members.values():
        start, end = (np.array(structure.joints[name]) for name in member.joints)
        diameter = structure.sections[member.section].diameter_m
        length = float(np.linalg.norm(end - start))
        axis, count = (end - start) / length, math.ceil(length / longest)
        middle = start + (np.arange(count)[:, None] + 0.5) / count * (end - start)
        middle = middle[(middle[:, 2] >= -DEPTH) & (middle[:, 2] <= a + longest)]
        x, z = middle[:, :1], middle[:, 2:]
        psi, level = omega * t - k * x, np.minimum(z, 0.0)
        speed = a * G * k / omega / math.cosh(k * DEPTH)
        c, s = speed * np.cosh(k * (level + DEPTH)), speed * np.sinh(k * (level + DEPTH))
        v = np.stack([c * np.cos(psi), 0.0 * psi, -s * np.sin(psi)], axis=-1)
        dv = omega * np.stack([-c * np.sin(psi), 0.0 * psi, -s * np.cos(psi)], axis=-1)
        v, dv = (q - (q @ axis)[..., None] * axis for q in (v, dv))
        force = 0.5 * RHO * diameter * np.linalg.norm(v, axis=-1) * v[..., 0]
        force += 0.5 * RHO * math.pi * diameter**2 * dv[..., 0]
        rise = max(abs(end[2] - start[2]) / count, 1e-9)
        wet = np.clip((a * np.cos(psi) - z) / rise + 0.5, 0.0, 1.0)
        total += (wet * force).sum(axis=0) * (length / count)
    return total


def force(changes: dict[str, Any]) -> float:
    """Largest difference over the largest force, hydrodynamic elements of 0.25 m."""
    data: dict[str, Any] = {
        "regular": {"theory": "airy", "height_m": HEIGHT, "period_s": PERIOD},
        "wave": {"order": 1, "stretching": "constant"},
        "time": {"dt_s": PERIOD / STEPS, "n": STEPS},
        "morison": {"cd": 1.0, "cm": 2.0, "discretisation_m": 0.25},
    }
    for key, fields in changes.items():
        data[key] = data[key] | fields
    return cases.relative(jacket_loads(parse_case(data), cases.oc4()).force[:, 0], written_out())


PROOFS = (
    Proof(
        key="appendix-c",
        claim="force of a regular wave on the OC4 jacket, H 2.5 m, T 5 s (thesis appendix C)",
        against="Morison's equation written out over pieces of 0.05 m; the print holds a picture only",
        error=force,
        right={},
        wrong={
            "elements on and off at midpoints": {"morison": {"surface": "midpoint"}},
            "Taylor expansion above still water": {"wave": {"stretching": "taylor"}},
            "C_A for C_M": {"morison": {"cm": 1.0}},
            "no drag": {"morison": {"cd": 0.0}},
        },
        allowed=3e-4,
        reason="elements of 0.25 m err by 1e-4 (second order), the pieces by 5e-5",
    ),
)
