"""The frame of the studies: what a study writes, its index, and that every committed one is whole."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from owt_bringup.cli import main
from owt_bringup.commands.study import INDEX_TITLE, index_page
from owt_campaign.studies.registry import STUDIES
from owt_campaign.studies.result import Row, StudyResult, Verdict, rows_table

STUDY = Path(__file__).parents[1] / "docs" / "study"
#: A few tens of kB each, and a picture that shows something.
LARGEST, SMALLEST = 150_000, 3_000


def result(**changes) -> StudyResult:
    """A study of nothing."""
    row = Row("ratio", "table 9.9", 1.06, 1.0512345678, spread=(1.04, 1.06), verdict="reproduced")

    def draw():
        from owt_campaign.studies.plotting import canvas

        figure, panels = canvas(1, 2)
        panels[0, 0].plot([0, 1], [0, 1])
        return figure

    settings = {"full": True, "figures": {"lines": draw}, "data": {"more": 1}, **changes}
    verdict = Verdict("partly", "Some of it.")
    return StudyResult("eigen", "Nothing", ["Text.", rows_table([row])], [row], verdict, **settings)


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "owt_campaign.studies.registry.run_study", lambda name, *, full, progress: result(full=full)
    )


def test_a_study_writes_page_figures_json_and_index(study, tmp_path: Path, capsys) -> None:
    assert main(["study", "eigen", "--full", "-o", str(tmp_path)]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "README.md", "eigen-lines.png", "eigen.json", "eigen.md",
    ]  # fmt: skip
    found = json.loads((tmp_path / "eigen.json").read_text())
    assert found["verdict"] == {"outcome": "partly", "why": "Some of it."}
    assert found["rows"][0]["ours"] == 1.05123
    assert found["more"] == 1
    assert found["revision"]
    page = (tmp_path / "eigen.md").read_text()
    assert page == capsys.readouterr().out
    assert page == result().signed_page(found["revision"])
    assert page.startswith(result().page)
    assert "| ratio | table 9.9 | 1.06 | 1.05 | 1.04 to 1.06 | reproduced |" in page
    assert page.endswith(
        "**Partly reproduced.** Some of it.\n\n"
        f"*Structure: model `oc4-thesis`; revision {found['revision']}.*\n"
    )
    assert "[eigen](eigen.md)" in (tmp_path / "README.md").read_text()


def test_a_reduced_version_says_so(study, tmp_path: Path, capsys) -> None:
    assert main(["study", "eigen", "-o", str(tmp_path)]) == 0
    assert "Reduced version" in capsys.readouterr().out
    assert "(reduced version)" in (tmp_path / "README.md").read_text()


def test_a_readme_of_somebody_else_is_left_alone(study, tmp_path: Path) -> None:
    (tmp_path / "README.md").write_text("mine")
    assert main(["study", "eigen", "-o", str(tmp_path)]) == 0
    assert (tmp_path / "README.md").read_text() == "mine"


def test_list_and_a_missing_name(capsys, tmp_path: Path) -> None:
    assert main(["study", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(STUDIES)
    assert main(["study", "--list", "-o", str(tmp_path)]) == 0
    assert (tmp_path / "README.md").read_text().startswith(INDEX_TITLE)
    capsys.readouterr()
    assert main(["study"]) == 1
    assert capsys.readouterr().err.startswith("error: study = None")


def test_nothing_is_drawn_unless_it_is_written(study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "owt_campaign.studies.plotting", None)  # an import would fail
    assert main(["study", "eigen"]) == 0


@pytest.mark.parametrize("name", STUDIES)
def test_committed_study_is_whole(name: str) -> None:
    """Page, JSON and figures of the full version, each figure named on the page."""
    page, found = (STUDY / f"{name}.md").read_text(), json.loads((STUDY / f"{name}.json").read_text())
    assert found["full"]
    assert found["revision"]
    assert found["rows"]
    assert found["verdict"]["why"] in page
    assert page.endswith(f"*Structure: {found['structure']}; revision {found['revision']}.*\n")
    shown = set(re.findall(r"\]\(([\w.-]+\.png)\)", page))
    there = {path.name for path in STUDY.glob(f"{name}-*.png") if not _of_another(name, path.name)}
    assert shown == there
    for picture in shown:
        assert SMALLEST < (STUDY / picture).stat().st_size < LARGEST


def _of_another(name: str, file: str) -> bool:
    return any(file.startswith(f"{other}-") and other.startswith(name) and other != name for other in STUDIES)


def test_index_is_that_of_the_committed_studies() -> None:
    text = (STUDY / "README.md").read_text()
    assert text.startswith(INDEX_TITLE)
    assert text == index_page(STUDY)
    assert all(f"[{name}]({name}.md)" in text for name in STUDIES)
