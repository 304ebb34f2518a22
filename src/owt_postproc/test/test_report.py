"""The report needs nothing but a browser, shows what it promises, and its numbers are those of the run."""

from __future__ import annotations

import json
import re
from dataclasses import fields, replace

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.contracts import StressBlock
from owt_model.errors import ComputationError, InputError
from owt_model.frame import frame_of_mesh
from owt_postproc.bag_report import bag_report
from owt_postproc.core.hot_spots import build_hot_spots
from owt_postproc.core.rainflow import rainflow
from owt_postproc.core.stage import build_fatigue_model, final, initial_state, step
from owt_postproc.core.summary import fatigue_summary
from owt_postproc.figures import all_figures
from owt_postproc.plot_style import envelope
from owt_postproc.report import render, summary, write_report
from owt_postproc.report_case import case_facts
from owt_postproc.report_data import ReportCollector

FIGURES = [
    "jacket",
    "damage",
    "exceedance",
    "matrix",
    "stress",
    "elevation",
    "shear",
    "tower_top",
    "energy",
    "spectrum",
]


@pytest.fixture
def data(report_data):
    return report_data


@pytest.fixture(scope="module")
def page(report_data):
    return render(report_data)


def without_plotly(page: str) -> str:
    """The page without the plotting library's own script."""
    start = page.index("<script>")
    return page[:start] + page[page.index("</script>", start) :]


def check_self_contained(page: str) -> None:
    own = without_plotly(page)
    assert not re.findall(r"<(?:link|img|iframe|object|embed)\b", own)
    assert not re.findall(r"\b(?:src|href|action)\s*=", own)
    assert not re.findall(r"@import|url\(", own)
    assert "http:" not in own
    assert "https:" not in own
    assert "plotly.js v" in page  # the library itself is inside


def test_self_contained(page):
    check_self_contained(page)


@pytest.mark.parametrize(
    "wrong",
    ['<script src="https://cdn.plot.ly/plotly.min.js"></script>', '<link rel="stylesheet" href="x.css">',
     "<style>@import 'x.css';</style>"],
)  # fmt: skip
def test_self_contained_would_notice(page, wrong):
    with pytest.raises(AssertionError):
        check_self_contained(page.replace("</body>", wrong + "</body>"))


def test_every_figure_is_there(page, data):
    assert [figure.key for figure in all_figures(data)] == FIGURES
    payload = re.search(r'<script id="figures" type="application/json">(.*?)</script>', page, re.S)
    assert payload is not None
    shown = json.loads(payload[1].replace("<\\/", "</"))
    assert [figure["key"] for figure in shown] == FIGURES
    for key in FIGURES:
        assert page.count(f'id="plot-{key}"') == 1


def test_size(page):
    assert len(page.encode()) < 8e6


def test_what_it_says(page, data):
    for text in ("CB10M10", "T_cathodic_protection", "DNV-RP-C203", data.end_name, "Hs 6 m", np.__version__):
        assert text in page
    assert page.count("<table") == 9


def test_text_is_escaped(data):
    page = render(replace(data, title="<script>alert(1)</script>", versions={"<b>": "&"}))
    assert "<script>alert" not in page
    assert "&lt;b&gt;" in page


def test_same_from_bag_and_from_blocks(bag, data):
    recorded = bag_report(bag)
    for field in fields(data):
        if field.name in ("reduced", "fatigue", "geometry"):
            continue
        a, b = getattr(data, field.name), getattr(recorded, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b)
        else:
            assert a == b, field.name
    np.testing.assert_array_equal(data.fatigue.damage, recorded.fatigue.damage)
    np.testing.assert_array_equal(data.geometry.node, recorded.geometry.node)
    np.testing.assert_array_equal(data.geometry.tower_node, recorded.geometry.tower_node)
    assert summary(data) == summary(recorded)


def test_stress_shown_is_the_one_counted(data):
    ranges, _, counts = rainflow(data.stress_normal)
    spot = data.stress_spot
    assert data.fatigue.max_range[spot] == pytest.approx(ranges.max(), rel=1e-9)
    assert data.fatigue.cycles[spot] == counts.sum()
    assert data.fatigue.damage[spot] == data.fatigue.damage.max()
    assert data.fatigue.hot_spots.end[spot] == data.stress_end


def test_summary_is_finite_json(data):
    text = json.dumps(summary(data), allow_nan=False)
    result = json.loads(text)
    assert result["fatigue"]["max_damage_end"] == data.end_name
    assert len(result["fatigue"]["ends"]) == len(data.reduced.end_name)
    assert result["statistics"]["elevation_total"]["max_m"] == data.elevation_total.max()
    assert result["sea_state"]["hs_m"] == 6.0


def test_fatigue_so_far_is_that_of_the_summary(run, data):
    """What a service answers at the end is what the summary says; earlier, less has been counted."""
    assert {**fatigue_summary(data.fatigue, run.reduced, complete=True)} == summary(data)["fatigue"]
    model = build_fatigue_model(run.case, build_hot_spots(frame_of_mesh(run.mesh), run.case.fatigue))
    state, _ = step(model, initial_state(model), run.of(StressBlock)[0])
    early = fatigue_summary(final(model, state), run.reduced, complete=False)
    json.dumps(early, allow_nan=False)
    assert early["samples"] == len(run.of(StressBlock)[0].axial)
    assert early["max_damage"] < data.fatigue.damage.max()
    # Nothing counted yet is no error.
    nothing = fatigue_summary(final(model, initial_state(model)), run.reduced, complete=False)
    assert nothing["max_damage"] == 0.0


def test_no_tower_and_no_geometry(data):
    bare = replace(data, tower_top=None, geometry=None, sea_state={}, versions={}, case={})
    assert [figure.key for figure in all_figures(bare)] == [
        k for k in FIGURES if k not in ("tower_top", "jacket")
    ]
    check_self_contained(render(bare))
    json.dumps(summary(bare), allow_nan=False)


def test_no_damage_at_all(data):
    fatigue = replace(data.fatigue, damage=np.zeros_like(data.fatigue.damage))
    check_self_contained(render(replace(data, fatigue=fatigue)))


def test_written_whole(tmp_path, data, page):
    path = write_report(data, tmp_path / "report.html")
    assert path.read_text(encoding="utf-8") == page
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
    with pytest.raises(InputError, match="report"):
        write_report(data, tmp_path / "nowhere" / "report.html")


def test_gap_is_an_error(run):
    collector = ReportCollector(6)
    first, _, third = run.of(StressBlock)[:3]
    collector.add(first)
    with pytest.raises(ComputationError, match="stress sequence 2: expected 1"):
        collector.add(third)


def test_nothing_recorded_is_an_error(run, data):
    with pytest.raises(ComputationError, match="no block has arrived"):
        ReportCollector(6).finish(case={}, reduced=run.reduced, fatigue=data.fatigue)


def strided(x, y, most):
    """Wrong: every so many samples, peaks lost."""
    every = int(np.ceil(len(x) / most))
    return x[::every], y[::every], every


def check_keeps_peaks(thin):
    y = np.random.default_rng(0).normal(size=30_001)
    y[1234], y[-1] = 40.0, -30.0
    x = np.arange(len(y)) * 0.02
    x_thin, y_thin, interval = thin(x, y, 3000)
    assert len(x_thin) <= 3000
    assert (np.diff(x_thin) > 0).all()
    assert (y_thin.max(), y_thin.min()) == (40.0, -30.0)
    assert interval > 1


def test_envelope_keeps_peaks():
    check_keeps_peaks(envelope)


def test_envelope_check_would_notice_striding():
    with pytest.raises(AssertionError):
        check_keeps_peaks(strided)


def test_short_lines_are_complete():
    x = np.arange(10.0)
    assert envelope(x, x)[2] == 1
    assert envelope(x, x)[0] is x


def test_a_case_is_shown_as_far_as_it_is_not_the_default():
    case = parse_case(
        {
            "regular": {"height_m": 12.0, "period_s": 11.0},
            "morison": {"hydrodynamic_damping": True, "cd": [[0.0, 1.1], [-50.0, 0.7]]},
            "current": {"speed_m_s": 0.8},
        }
    ).model_dump(mode="json")
    facts = dict(case_facts(case))
    assert facts["regular.height_m"] == 12.0
    assert facts["regular.theory"] == "stream"  # a default, yet part of what the sea is
    assert facts["morison.hydrodynamic_damping"] == "on"
    assert facts["morison.cd"] == "[[0.0, 1.1], [-50.0, 0.7]]"
    assert facts["current.speed_m_s"] == 0.8
    assert not {"morison.cm", "wave.order", "structure.model"} & set(facts)
    assert case_facts(parse_case({}).model_dump(mode="json")) == []
