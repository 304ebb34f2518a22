"""What several topics build on: the reference seas, cases of them, the jacket, a column."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from owt_model.config import CaseConfig, parse_case
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure, parse_structure

__all__ = ["DATA", "column", "listed", "oc4", "openfast", "recorded", "reference", "relative"]

DATA = Path(__file__).parents[1] / "data"


def relative(got: Any, expected: Any) -> float:
    """Largest difference over the largest expected magnitude."""
    return float(np.abs(np.asarray(got) - expected).max() / np.abs(expected).max())


@cache
def reference(name: str) -> dict[str, Any]:
    """Arrays of the reference sea A or C, see test/data/waves/README.md; not to be written to."""
    with np.load(DATA / "waves" / f"case_{name}.npz") as file:
        return dict(file)


@cache
def openfast() -> dict[str, Any]:
    """Arrays that OpenFAST gives for the same seas, single precision, see test/data/waves/README.md."""
    with np.load(DATA / "waves" / "openfast.npz") as file:
        return dict(file)


def listed(omega: Any, amplitude: Any, phase: Any, *, direction: Any = 0.0, **fields: Any) -> CaseConfig:
    """Case of listed components (rad/s, m, rad, degrees), 600 s at 0.1 s; keywords replace or extend."""
    data: dict[str, Any] = {
        "components": {
            "omega_rad_s": np.atleast_1d(omega).tolist(),
            "amplitude_m": np.atleast_1d(amplitude).tolist(),
            "phase_rad": np.atleast_1d(phase).tolist(),
            "direction_deg": direction,
        },
        "time": {"dt_s": 0.1, "n": 6000},
    }
    return parse_case(data | fields)


def recorded(name: str, **fields: Any) -> CaseConfig:
    """Case of the components of a reference sea."""
    d = reference(name)
    return listed(d["omega"], d["a"], d["phi"], **fields)


@cache
def oc4() -> Mesh:
    """Mesh of the OC4 jacket."""
    return build_mesh(load_structure("oc4"))


def column(
    *,
    depth: float = 20.0,
    top: tuple[float, float, float] = (0.0, 0.0, 10.0),
    elements: int = 3,
    **more: Any,
) -> Mesh:
    """One tube of 1.5 m from the sea bed to above the water, clamped below, its top the interface."""
    data: dict[str, Any] = {
        "name": "column",
        "elements_per_member": elements,
        "mudline_z_m": -depth,
        "sections": {
            "tube": {
                "diameter_m": 1.5,
                "thickness_m": 0.05,
                "youngs_modulus_pa": 2.1e11,
                "shear_modulus_pa": 8.1e10,
                "density_kg_m3": 7850.0,
            }
        },
        "joints": {"foot": [0.0, 0.0, -depth], "head": list(top)},
        "members": {"tube": {"joints": ["foot", "head"], "section": "tube"}},
        "supports": {"foot": [True] * 6},
        "interface": {"joints": ["head"], "reference_m": list(top)},
    }
    return build_mesh(parse_structure(data | more, source="test"))
