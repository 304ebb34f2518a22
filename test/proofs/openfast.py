"""Loads on the jacket beside OpenFAST's HydroDyn, for the same components."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_wave_node.core.loads import jacket_loads
from proofs import cases
from proofs.registry import Proof


def hydrodyn(changes: dict[str, Any]) -> float:
    """Fx, Fz and My of sea A, second order, each over its peak, elements of 1 m."""
    fields: dict[str, Any] = {
        "wave": {"order": 2, "stretching": "taylor"},
        "morison": {"cd": 1.0, "cm": 2.0, "discretisation_m": 1.0},
    }
    for key, values in changes.items():
        fields[key] = fields[key] | values
    got = jacket_loads(cases.recorded("A", **fields), cases.oc4())
    at = np.rint(cases.reference("A")["t_load"] / 0.1).astype(int)
    series = (got.force[at, 0], got.force[at, 2], got.moment[at, 1])
    expected = cases.openfast()["load_second_A"].astype(float)
    return max(cases.relative(a, b) for a, b in zip(series, expected, strict=True))


PROOFS = (
    Proof(
        key="openfast-loads",
        claim="shear, lift and moment of the OC4 jacket as OpenFAST's HydroDyn gives them",
        against="OpenFAST, sea A, second order, elements of at most 1 m, over the peak of each",
        error=hydrodyn,
        right={},
        wrong={
            "the first order": {"wave": {"order": 1}},
            "constant above still water": {"wave": {"stretching": "constant"}},
            "segments on or off by their middle": {"morison": {"surface": "midpoint"}},
            "C_A for C_M": {"morison": {"cm": 1.0}},
        },
        allowed=3e-3,
        reason="HydroDyn with elements of 1 m is 2e-3 from the reference with 0.25 m",
    ),
)
