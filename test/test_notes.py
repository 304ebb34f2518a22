"""What the commands note on standard error: options without effect, and compression."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from owt_bringup.cli import main
from owt_bringup.sea_notes import ignored_options
from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure


@pytest.fixture
def case(tmp_path: Path) -> Callable[..., Path]:
    """Write a short case in a calm sea, changed as asked; return its path."""

    def write(**changes: Any) -> Path:
        path = tmp_path / "case.json"
        calm = {"hs_m": 3.0, "tp_s": 8.0, "cutoff": "steepness"}
        path.write_text(json.dumps({"time": {"n": 300}, "sea_state": calm, **changes}))
        return path

    return write


@pytest.mark.parametrize(
    ("given", "command", "word"),
    [
        (
            {"regular": {"height_m": 4.0, "period_s": 9.0}, "wave": {"order": 1}},
            "waves",
            "wave.order",
        ),
        ({"sea_state": {"cutoff": "steepness", "cutoff_over_peak": 3.0}}, "waves", "cutoff_over_peak"),
        ({"morison": {"hydrodynamic_damping": True}}, "loads", "hydrodynamic_damping"),
        ({"morison": {"buoyancy": True}}, "simulate", "buoyancy"),
        ({"morison": {"end_cd": 1.0}}, "loads", "oc4 has no free end"),
    ],
)
def test_options_without_effect_are_named(given: dict[str, Any], command: str, word: str) -> None:
    mesh = build_mesh(load_structure("oc4"))
    found = ignored_options(parse_case(given), command, mesh)
    assert len(found) == 1
    assert word in found[0]


def test_options_with_effect_are_not_named(
    case: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = build_mesh(load_structure("oc4"))
    for given, command in (
        ({}, "loads"),
        ({"morison": {"hydrodynamic_damping": True}}, "simulate"),
        ({"morison": {"buoyancy": True}}, "loads"),
        ({"regular": {"height_m": 4.0, "period_s": 9.0, "theory": "airy"}, "wave": {"order": 1}}, "waves"),
        ({"sea_state": {"cutoff_over_peak": 3.0}}, "waves"),
    ):
        assert ignored_options(parse_case(given), command, mesh) == ()
    path = case(morison={"hydrodynamic_damping": True})
    assert main(["loads", str(path), "-o", str(path.with_suffix(".npz"))]) == 0
    notes = [line for line in capsys.readouterr().err.splitlines() if line.startswith("note: ")]
    assert len(notes) == 1


def test_waves_tell_of_compression(
    case: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `loads` does: a note and the estimated error; an exact sum has neither."""
    out = tmp_path / "out.npz"
    for route in ("compressed", "exact"):
        path = case(wave={"route": route}, points_m=[[0, 0, -5]])
        assert main(["waves", str(path), "-o", str(out)]) == 0
        err = capsys.readouterr().err
        with np.load(out) as data:
            error = float(data["error_estimate"])
        if route == "compressed":
            assert 0.0 < error < 1e-6
            assert err == f"note: waves compressed, estimated error {error:.1g}\n"
        else:
            assert error == 0.0
            assert err == ""
