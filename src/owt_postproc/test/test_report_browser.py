"""The report in a real browser: it loads without errors or network, and what one does with it works."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from browser import Opened, browser, chromium, open_page
from owt_postproc.report import write_report
from owt_postproc.report_html import write_page
from owt_postproc.report_records import Records

pytestmark = [pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def started():
    with browser() as one:
        yield one


@pytest.fixture(scope="module")
def written(report_data, tmp_path_factory) -> Path:
    return write_report(report_data, tmp_path_factory.mktemp("page") / "report.html")


@pytest.fixture(scope="module")
def opened(started, written) -> Iterator[Opened]:
    one = open_page(started, written)
    yield one
    one.close()


def test_without_a_browser_nothing_is_green(monkeypatch):
    """It fails and says what to do, or skips where that is asked for."""
    monkeypatch.delenv("OWT_NO_BROWSER", raising=False)
    monkeypatch.delenv("OWT_CHROMIUM", raising=False)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(pytest.fail.Exception, match="apt-get install chromium"):
        chromium()
    monkeypatch.setenv("OWT_NO_BROWSER", "1")
    with pytest.raises(pytest.skip.Exception, match="no page was looked at"):
        chromium()


def check_quiet(opened: Opened) -> None:
    assert opened.page.evaluate("document.body.dataset.ready") == "yes"
    assert opened.errors == []
    assert opened.requests == []


def check_fits(opened: Opened) -> None:
    width, window = opened.page.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
    assert width <= window


def test_loads_without_errors_or_network(opened):
    check_quiet(opened)
    check_fits(opened)
    assert opened.page.locator("#plot-jacket canvas").count() >= 1
    for plot in opened.page.locator(".plot").all():
        assert plot.locator(".main-svg").count() >= 1, plot.get_attribute("id")


@pytest.mark.parametrize(
    ("wrong", "check"),
    [
        ("<img src='http://127.0.0.1:9/x.png'>", check_quiet),
        ("<script>throw new Error('broken');</script>", check_quiet),
        ("<div style='width:1600px;height:1px'></div>", check_fits),
    ],
)
def test_the_checks_would_notice(started, tmp_path, wrong, check):
    path = tmp_path / "wrong.html"
    path.write_text(f"<!DOCTYPE html><body data-ready='yes'>{wrong}</body>")
    one = open_page(started, path)
    with pytest.raises(AssertionError):
        check(one)
    one.close()


def test_hovering_a_bar_names_the_member_end(opened, report_data):
    page = opened.page
    bars = page.locator("#plot-damage .bars .point")
    bars.last.scroll_into_view_if_needed()
    bars.last.hover(force=True)
    label = page.locator("#plot-damage .hoverlayer")
    label.locator(".hovertext").first.wait_for()
    assert report_data.end_name in label.text_content()


#: Place on the screen of every corner of a surface in space, those nearest to the eye first.
PLACES = """
trace => {
  const plot = document.getElementById("plot-jacket"), scene = plot._fullLayout.scene._scene;
  const { model, view, projection } = scene.glplot.cameraParams, { x, y, z } = plot.data[trace];
  const box = plot.getBoundingClientRect(), scale = scene.dataScale;
  const times = (m, v) => [0, 1, 2, 3].map(i => m[i]*v[0] + m[4+i]*v[1] + m[8+i]*v[2] + m[12+i]*v[3]);
  return Array.from(x, (_, i) => {
    const p = [model, view, projection].reduce(
      (v, m) => times(m, v), [x[i] * scale[0], y[i] * scale[1], z[i] * scale[2], 1]);
    return { i, x: box.x + box.width * (0.5 + 0.5 * p[0] / p[3]),
             y: box.y + box.height * (0.5 - 0.5 * p[1] / p[3]), depth: p[3] };
  }).filter(p => p.y > box.y + 30 && p.y < box.y + box.height - 30 && p.y < innerHeight - 5)
    .sort((a, b) => a.depth - b.depth);
}
"""


@pytest.mark.parametrize(
    ("trace", "name", "parts"),
    [
        (0, r"member M\d+, end at joint J\d+damage ", ("largest range", "total stress", "worst spot", "°")),
        (1, r"joint J\d+at \(", ("members M", "largest damage")),
    ],
    ids=["member", "joint"],
)
def test_hovering_the_structure_names_it(opened, trace, name, parts):
    """The pointer goes to corners of the surface that are near the eye, until one of them speaks."""
    page, label = opened.page, opened.page.locator("#plot-jacket .hovertext")
    page.locator("#plot-jacket").scroll_into_view_if_needed()
    said: list[str] = []
    for place in page.evaluate(PLACES, trace)[:200:5]:
        page.mouse.move(place["x"], place["y"])
        page.wait_for_timeout(300)
        said += label.all_text_contents()
        if said and re.match(name, said[-1]):
            break
    assert said
    assert re.match(name, said[-1]), said
    for part in parts:
        assert part in said[-1]


def test_a_heading_sorts(opened):
    page = opened.page
    table = page.locator(".table[data-name=member_ends]")
    head = table.locator("thead th", has_text="largest range")
    column = head.evaluate("cell => cell.cellIndex")

    def shown() -> list[float]:
        cells = f"t => Array.from(t.tBodies[0].rows, r => Number(r.cells[{column}].dataset.value))"
        return table.locator("table").evaluate(cells)

    head.locator("button").click()
    down = shown()
    assert down == sorted(down, reverse=True)
    assert head.get_attribute("aria-sort") == "descending"
    head.locator("button").click()
    assert shown() == sorted(down)
    assert head.get_attribute("aria-sort") == "ascending"
    assert shown() != down
    # Names sort as text, and the keyboard does what the pointer does.
    first = table.locator("thead th").first.locator("button")
    first.focus()
    page.keyboard.press("Enter")
    names = table.locator("tbody tr td:first-child").all_text_contents()
    assert names == sorted(names, reverse=True)


def test_a_table_is_saved_as_csv(opened, report_data, tmp_path):
    button = opened.page.locator(".table[data-name=member_ends] .download")
    with opened.page.expect_download() as waiting:
        button.click()
    assert waiting.value.suggested_filename == "member_ends.csv"
    waiting.value.save_as(tmp_path / "ends.csv")
    with (tmp_path / "ends.csv").open(newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head[0] == "member end"
    assert "largest range, MPa" in head
    damage = {row[0]: float(row[head.index("damage")]) for row in rows}
    assert set(damage) == set(report_data.reduced.end_name)
    assert damage[report_data.end_name] == report_data.fatigue.damage.max()


def test_the_selector_recolours(opened):
    page = opened.page
    colours = "Array.from(document.getElementById('plot-jacket').data[0].intensity)"
    strokes = "Array.from(document.querySelectorAll('.views line'), l => l.getAttribute('stroke'))"
    options = page.locator("#measure option").evaluate_all("all => all.map(one => one.value)")
    assert options[:3] == ["damage", "range", "total"]
    seen = {}
    for option in options:
        page.locator("#measure").select_option(option)
        title = page.evaluate("document.getElementById('plot-jacket').data[0].colorbar.title.text")
        note = page.locator("#measure-note").text_content()
        seen[option] = (title, note, json.dumps(page.evaluate(colours)), json.dumps(page.evaluate(strokes)))
        assert 0.0 <= min(json.loads(seen[option][2])) <= max(json.loads(seen[option][2])) <= 1.0
    for part in range(4):  # on its logarithmic scale utilisation has the colours of the damage
        assert len({seen[option][part] for option in options[:3]}) == 3
    damage, used = (json.loads(seen[option][2]) for option in ("damage", "utilisation"))
    np.testing.assert_allclose(used, damage, atol=2e-4)
    assert seen["utilisation"][0] != seen["damage"][0]
    page.locator("#measure").select_option("damage")
    assert json.dumps(page.evaluate(colours)) == seen["damage"][2]


@pytest.fixture(scope="module")
def long(report_data):
    """Ten times as long: too many samples to draw them all at once."""
    names = ("stress_normal", "stress_von_mises", "potential", "kinetic", "potential_substructure",
             "kinetic_substructure", "tower_top")  # fmt: skip
    series = {name: np.concatenate([getattr(report_data, name)] * 10) for name in names}
    dt = report_data.time[1] - report_data.time[0]
    return replace(report_data, time=np.arange(len(series["potential"])) * dt, **series)


def test_zooming_in_shows_all_samples(started, long, tmp_path):
    one = open_page(started, write_report(long, tmp_path / "report.html"))
    check_quiet(one)
    line = "document.getElementById('plot-stress').data[2]"  # normal stress, whole record
    assert one.page.evaluate(f"{line}.name") == "normal stress"
    overview = one.page.evaluate(f"{line}.x.length")
    assert overview <= 3000 < len(long.time)
    zoom = "range => Plotly.relayout('plot-stress', range)"
    one.page.evaluate(zoom, {"xaxis.range[0]": 100.0, "xaxis.range[1]": 150.0})
    x, y = (np.array(one.page.evaluate(f"Array.from({line}.{name})")) for name in "xy")
    inside = (x >= 100.0) & (x <= 150.0)
    wanted = (long.time >= 100.0) & (long.time <= 150.0)
    np.testing.assert_allclose(x[inside], long.time[wanted], rtol=1e-12)
    # single precision in the page: 24 bits of a value
    np.testing.assert_allclose(y[inside], 1e-6 * long.stress_normal[wanted], rtol=1e-6, atol=1e-9)
    one.page.evaluate(zoom, {"xaxis.range[0]": 0.0, "xaxis.range[1]": 400.0})
    assert one.page.evaluate(f"{line}.x.length") == overview
    one.close()


def test_printing(started, written, report_data):
    """On A4: no picture wider than the page, views for the picture in space, 40 rows of long tables."""
    one = open_page(started, written)
    paper = one.page.pdf(format="A4", print_background=True)
    assert paper.startswith(b"%PDF")
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", paper)) <= 15
    one.page.emulate_media(media="print")
    one.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    one.page.set_viewport_size({"width": 695, "height": 1000})  # A4 without its margins
    check_fits(one)
    for plot in one.page.locator(".js-plotly-plot .main-svg").all():
        if plot.is_visible():
            assert plot.bounding_box()["width"] <= 695
    assert not one.page.locator("#plot-jacket").is_visible()
    assert one.page.locator(".views svg").first.is_visible()
    assert one.page.locator(".views line").count() == 2 * len(report_data.reduced.end_name)
    rows = one.page.locator(".table[data-name=member_ends] tbody tr")
    assert sum(row.is_visible() for row in rows.all()) == 40 < rows.count()
    assert not one.page.locator(".download").first.is_visible()
    check_quiet(one)
    one.close()


def test_without_drawing_in_space(started, written):
    """A browser without WebGL shows the views, in the chosen colours, and no error."""
    with browser("--disable-3d-apis", beside=started) as flat:
        one = open_page(flat, written)
        check_quiet(one)
        assert one.page.locator(".views svg").first.is_visible()
        stroke = "document.querySelector('.views line[data-end=\"3\"]').getAttribute('stroke')"
        before = one.page.evaluate(stroke)
        one.page.locator("#measure").select_option("range")
        assert one.page.evaluate(stroke) != before
        one.close()


def test_the_page_of_several_records(started, report_data, tmp_path):
    records = Records()
    for name in ("first", "<second>"):
        records.add(name, report_data, tmp_path / name.strip("<>") / "report.html")
    records.add("third", replace(report_data, complete=False), tmp_path / "third" / "report.html")
    records.fail("fourth", "error & more")
    (group,) = records.groups
    one = open_page(started, write_page(records.render(group, tmp_path), tmp_path / "all.html"))
    check_quiet(one)
    check_fits(one)
    assert one.page.locator("h1").text_content() == "Fatigue over 3 records"
    warning = one.page.locator(".warning").text_content()
    assert "fourth failed and is not counted: error & more" in warning
    assert "third is not complete" in warning
    links = one.page.locator(".table[data-name=records] a")
    assert links.all_text_contents() == ["first", "<second>", "third"]
    assert links.nth(1).get_attribute("href") == "second/report.html"
    one.close()
