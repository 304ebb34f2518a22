"""`owt study eigen`: the thesis' tables B.1 to B.3, beside the print, held to what the page says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from owt_bringup.cli import main
from owt_campaign.studies.eigen import EigenStudy, eigen_study, quarter_turn_classes, thesis_tables
from owt_campaign.studies.eigen_page import eigen_page, eigen_result
from owt_model.errors import InputError
from owt_model.sensitivity import sensitivity_model

PAGE = Path(__file__).parents[1] / "docs" / "study" / "eigen.md"
PRINTED_CLASSES = "EEBABEEABA"  # modes 4 and 5 have changed places


@pytest.fixture(scope="module")
def study() -> EigenStudy:
    return eigen_study()


def off(found: list[float], printed: list[float], last: int = 20) -> float:
    """Largest difference in percent."""
    return float(100.0 * np.abs(np.array(found[:last]) / printed[:last] - 1.0).max())


def test_table_b1(study: EigenStudy) -> None:
    printed = thesis_tables()["table_B1"]
    assert set(study.table_b1) == set(printed)
    for name in ("full", "CB20"):
        assert off(study.table_b1[name], printed[name], 10) < 1.0
        assert off(study.table_b1[name], printed[name]) < 3.1
    assert off(study.table_b1["CB10M10"], printed["CB10M10"], 10) < 1.0
    assert off(study.table_b1["CB10M10"], printed["CB10M10"]) < 3.6
    assert off(study.table_b1["CB00"], printed["CB00"], 10) < 3.0
    assert off(study.table_b1["M20"], printed["M20"], 8) < 1.0
    # Negative control: the reductions are not each other.
    assert off(study.table_b1["CB00"], printed["full"], 10) > 30.0


def test_reductions_are_compared_by_shape(study: EigenStudy) -> None:
    """CB20 keeps twenty modes of the turbine; Guyan's reduction stops at the first of the jacket."""
    for mode, (match, likeness) in enumerate(study.match["CB20"]):
        assert match == mode
        assert likeness > 0.99
    assert min(likeness for _, likeness in study.match["CB00"][:8]) > 0.9
    assert study.match["CB00"][8][1] < 0.7


def test_table_b2(study: EigenStudy) -> None:
    printed = thesis_tables()["table_B2"]
    for kind in "ABE":
        found = [f for f, c in zip(study.table_b2, study.class_b2, strict=True) if c == kind]
        expected = [f for f, c in zip(printed, PRINTED_CLASSES, strict=True) if c == kind]
        assert off(found, expected) < 1.3
    assert sorted(study.class_b2) == sorted(PRINTED_CLASSES)


def test_table_b3(study: EigenStudy) -> None:
    printed = thesis_tables()["table_B3"]
    for name, table in printed.items():
        found = study.table_b3[name]
        assert off(found["frequency_hz"], table["frequency_hz"], 10) < 1.0
        assert off(found["frequency_hz"], table["frequency_hz"]) < 3.1
        assert off(found["logdec_percent"], table["logdec_percent"], 10) < 1.5
        assert off(found["logdec_percent"], table["logdec_percent"]) < 3.0
    # Negative control: damping the first two modes alone is not what the thesis printed.
    modal = study.table_b3["damping-modal"]["logdec_percent"]
    assert off(modal[:2], printed["damping"]["logdec_percent"][:2]) < 0.5
    assert off(modal, printed["damping"]["logdec_percent"], 10) > 10.0


def test_committed_page_is_that_of_the_code(study: EigenStudy) -> None:
    """Words exactly, numbers to their printed digits but the last; signed with the revision of the JSON."""
    revision = json.loads(PAGE.with_suffix(".json").read_text())["revision"]
    signed = eigen_result(study, thesis_tables()).signed_page(revision)
    found, committed = (text.split() for text in (signed, PAGE.read_text()))
    assert len(found) == len(committed), "run ./owt study eigen -o docs/study"
    for one, other in zip(found, committed, strict=True):
        if one == other:
            continue
        assert float(one.strip("()")) == pytest.approx(float(other.strip("()")), abs=0.011), (one, other)


def test_command_prints_the_layout_of_the_print(
    study: EigenStudy,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setattr("owt_campaign.studies.eigen.eigen_study", lambda: study)
    assert main(["study", "eigen", "--json", "-o", str(tmp_path)]) == 0
    shown, printed = json.loads(capsys.readouterr().out), thesis_tables()
    for table in ("table_B1", "table_B3"):
        assert set(printed[table]) <= set(shown[table])
    for name, column in printed["table_B1"].items():
        assert len(shown["table_B1"][name]) == len(column)
    for name, columns in printed["table_B3"].items():
        assert {key: len(shown["table_B3"][name][key]) for key in columns} == dict.fromkeys(columns, 20)
    assert len(shown["table_B2"]) == len(printed["table_B2"])
    signed = eigen_result(study, printed).signed_page(shown["revision"])
    assert (tmp_path / "eigen.md").read_text() == signed
    assert signed.startswith(eigen_page(study, printed))
    with pytest.raises(SystemExit):
        main(["study", "no-such-study"])


def test_sensitivity_models_on_the_command_line(
    study: EigenStudy, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("damping", "frequency"):
        assert main(["eigen", "--model", "oc4-thesis", "--sensitivity", name, "--modes", "20", "--json"]) == 0
        shown = json.loads(capsys.readouterr().out)
        assert shown["logdec_percent"] == pytest.approx(study.table_b3[name]["logdec_percent"], rel=1e-9)
        assert shown["logdec_percent"] != pytest.approx(
            study.table_b3["reference"]["logdec_percent"], rel=1e-3
        )
    with pytest.raises(InputError, match=r"sensitivity = 'none'"):
        sensitivity_model("none")


@pytest.mark.parametrize("reduction", ["M10", "CB10M10", "CB20"])
def test_weights_go_with_every_reduction(reduction: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eigen", "--model", "oc4-thesis", "--static", "--reduction", reduction, "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    change = np.array(shown["static_state"]["change_percent"][:2])
    assert (np.abs(change + 1.1) < 0.1).all()


def test_a_damping_model_of_the_turbine_is_not_that_of_a_held_jacket() -> None:
    assert main(["eigen", "--sensitivity", "damping", "--fixed-interface"]) == 1


def test_quarter_turn_would_notice_another_turn(models_mesh) -> None:
    mesh, motion = models_mesh
    assert quarter_turn_classes(mesh, motion) == "A"
    motion[:4] *= -1.0
    assert quarter_turn_classes(mesh, motion) != "A"


@pytest.fixture
def models_mesh():
    """The thesis' jacket in uniform heave, which a quarter turn leaves alike."""
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure

    mesh = build_mesh(load_structure("oc4-thesis"))
    motion = np.zeros((mesh.n_nodes, 6, 1))
    motion[:, 2] = 1.0
    return mesh, motion
