"""The superelement command: files for both generations of OpenFAST, what they show, and refusals."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

import numpy as np
import pytest

from owt_bringup.cli import main
from owt_bringup.commands import superelement
from owt_model.errors import InputError

SHORT = {"time": {"n": 300}, "sea_state": {"hs_m": 3.0, "tp_s": 8.0, "cutoff_over_peak": 3.0}}


def call(*arguments: object) -> int:
    parser = argparse.ArgumentParser()
    superelement.add_arguments(parser)
    return superelement.run(parser.parse_args([str(argument) for argument in arguments]))


def case(folder: Path, **changes: object) -> Path:
    path = folder / "case.json"
    path.write_text(json.dumps({**SHORT, **changes}))
    return path


def shown(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict:
    capsys.readouterr()
    assert call("show", "--json", *arguments) == 0
    return json.loads(capsys.readouterr().out)


def test_export_show_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "jacket.dat", tmp_path / "out.npz"
    assert call("export", case(tmp_path), "-o", file, "--elevation") == 0
    report = shown(capsys, file, "--tower", "oc4")
    assert report["dimension"] == 26
    assert (report["samples"], report["dt_s"], report["has_elevation"]) == (300, 0.1, True)
    np.testing.assert_allclose(report["rayleigh"], [0.027, 0.002], rtol=1e-9)
    assert len(report["fixed_interface_frequencies_hz"]) == 20
    assert 0.3 < report["tower_frequencies_hz"][0] < 0.4
    assert call("show", file) == 0
    assert "26 degrees of freedom, 20 of them inside" in capsys.readouterr().out
    assert call("run", file, "--tower", "oc4", "-o", out, "--dt", "0.05") == 0
    with np.load(out) as data:
        assert data["t"].shape == (599,)
        assert data["interface_force"].shape == data["tower_top_displacement"].shape == (599, 6)
        assert np.abs(data["tower_top_displacement"]).max() > 1e-4


def test_two_files_for_openfast_5_hold_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, two, forces = (tmp_path / name for name in ("one.dat", "two.dat", "forces.dat"))
    given = case(tmp_path, structure={"reduction": "CB02"})
    assert call("export", given, "-o", one) == 0
    assert call("export", given, "-o", two, "--openfast5", forces) == 0
    capsys.readouterr()
    assert shown(capsys, one) == shown(capsys, two, "--forces", forces)
    assert shown(capsys, two)["samples"] == 1


@pytest.mark.parametrize(
    ("structure", "message"),
    [
        ({"reduction": "full"}, "has no basis"),
        ({"reduction": "CB10+SIM"}, "static improvement"),
        ({"damping": {"modes": [[1, 3.0]]}}, "modes of jacket and tower together"),
    ],
)
def test_what_no_file_carries_is_refused(tmp_path: Path, structure: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call("export", case(tmp_path, structure=structure), "-o", tmp_path / "jacket.dat")
    assert not (tmp_path / "jacket.dat").exists()


def test_notes_say_what_the_file_leaves_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = case(
        tmp_path,
        morison={"buoyancy": True},
        wind={"thrust": {}},
        structure={"reduction": "CB00", "ramp_s": 5.0, "damping": {"tower_top": [1e4, 0, 0, 0, 0, 0]}},
    )
    assert call("export", given, "-o", tmp_path / "jacket.dat") == 0
    notes = capsys.readouterr().err
    for option in ("morison.buoyancy", "structure.ramp_s", "dashpots at the tower top", "wind"):
        assert re.search(rf"note: {option} (is|are) not in the file", notes)


def test_drag_damping_is_in_the_file_and_not_proportional(tmp_path: Path) -> None:
    file = tmp_path / "jacket.dat"
    given = case(tmp_path, morison={"hydrodynamic_damping": True}, structure={"reduction": "CB00"})
    assert call("export", given, "-o", file) == 0
    assert "and dashpots" in file.read_text()
    with pytest.raises(InputError, match="Give alpha and beta of the tower"):
        call("run", file, "--tower", "oc4", "-o", tmp_path / "out.npz")
    with pytest.raises(InputError, match="belong together"):
        call("run", file, "--tower", "oc4", "-o", tmp_path / "out.npz", "--alpha", "0.02")


def test_weights_of_the_tower_belong_to_the_tower(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The jacket's file has the geometric stiffness of all weights; `--static` gives the tower its own."""
    given = case(tmp_path, structure={"reduction": "CB05", "static_state": {}})
    file = tmp_path / "jacket.dat"
    assert call("export", given, "-o", file) == 0
    assert "must count its own" in capsys.readouterr().err
    assert "geometric stiffness of all weights" in file.read_text()
    bare, weighed = (shown(capsys, file, "--tower", "oc4", *more) for more in ((), ("--static",)))
    assert main(["eigen", "--reduction", "CB05", "--static", "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)["frequencies_hz"]
    assert weighed["tower_frequencies_hz"][:4] == pytest.approx(whole[:4], rel=1e-6)
    assert bare["tower_frequencies_hz"][0] != pytest.approx(whole[0], rel=5e-3)


def test_a_file_without_loads_has_no_response(tmp_path: Path) -> None:
    given = case(tmp_path, structure={"reduction": "CB00"})
    file, forces = tmp_path / "jacket.dat", tmp_path / "forces.dat"
    assert call("export", given, "-o", file, "--openfast5", forces) == 0
    with pytest.raises(InputError, match="no loads to respond to"):
        call("run", file, "--tower", "oc4", "-o", tmp_path / "out.npz")
    assert call("run", file, "--forces", forces, "--tower", "oc4", "-o", tmp_path / "out.npz") == 0
