"""Cases, reference seas and small structures that the wave tests share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure, parse_structure

DATA = Path(__file__).parents[3] / "test" / "data" / "waves"


def relative(got: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference over the largest expected magnitude."""
    return float(np.abs(got - expected).max() / np.abs(expected).max())


@pytest.fixture(scope="session")
def error() -> Callable[[np.ndarray, np.ndarray], float]:
    return relative


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    return {name: np.load(DATA / f"case_{name}.npz") for name in "AC"}


@pytest.fixture(scope="session")
def listed() -> Callable[..., CaseConfig]:
    """Case of listed components (omega, amplitude, phase); keywords replace or extend."""

    def build(omega: Any, amplitude: Any, phase: Any, *, direction: Any = 0.0, **fields: Any) -> CaseConfig:
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

    return build


@pytest.fixture(scope="session")
def recorded(reference: dict[str, Any], listed: Callable[..., CaseConfig]) -> Callable[..., CaseConfig]:
    """Case of the components of a reference sea."""

    def build(name: str, **fields: Any) -> CaseConfig:
        d = reference[name]
        return listed(d["omega"], d["a"], d["phi"], **fields)

    return build


@pytest.fixture(scope="session")
def oc4() -> Mesh:
    return build_mesh(load_structure("oc4"))


@pytest.fixture(scope="session")
def column() -> Callable[..., Mesh]:
    """One straight tube from the sea bed to above the water, clamped below, its top the interface."""

    def build(
        *,
        depth: float = 20.0,
        top: tuple[float, float, float] = (0.0, 0.0, 10.0),
        elements: int = 3,
        **more: Any,
    ) -> Mesh:
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

    return build
