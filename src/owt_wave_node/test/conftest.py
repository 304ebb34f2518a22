"""Cases, reference seas and small structures that the wave tests share with the proofs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from owt_model.config import CaseConfig
from owt_model.mesh import Mesh
from proofs import cases


@pytest.fixture(scope="session")
def error() -> Callable[[np.ndarray, np.ndarray], float]:
    return cases.relative


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    return {name: cases.reference(name) for name in "AC"}


@pytest.fixture(scope="session")
def listed() -> Callable[..., CaseConfig]:
    return cases.listed


@pytest.fixture(scope="session")
def recorded() -> Callable[..., CaseConfig]:
    return cases.recorded


@pytest.fixture(scope="session")
def oc4() -> Mesh:
    return cases.oc4()


@pytest.fixture(scope="session")
def column() -> Callable[..., Mesh]:
    return cases.column
