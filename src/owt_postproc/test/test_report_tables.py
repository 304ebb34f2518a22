"""Tables beside a report, and records added up before the largest damage is looked for."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet
import pytest

from owt_model.errors import InputError
from owt_postproc.figures_fatigue import rainflow_matrix
from owt_postproc.figures_jacket import jacket
from owt_postproc.plot_style import SCALE
from owt_postproc.report_measures import YEAR_S, design_life, measures
from owt_postproc.report_records import Records, records_table
from owt_postproc.report_tables import case_hash, usage_tables, write_tables
from owt_postproc.report_usage import add_up, usage_of


@pytest.fixture(scope="module")
def usage(report_data):
    return usage_of(report_data.fatigue, report_data.reduced.end_name)


def test_usage_is_the_result_by_spot(usage, report_data):
    fatigue = report_data.fatigue
    np.testing.assert_array_equal(usage.end_damage, fatigue.end_damage)
    np.testing.assert_array_equal(usage.worst_spot, fatigue.worst_spot)
    np.testing.assert_array_equal(usage.end_max_range, fatigue.end_max_range)
    assert usage.spot_name[usage.most_used] == report_data.spot_name
    joint = next(i for i, kind in enumerate(usage.end_kind) if kind)
    spot = int(usage.worst_spot[joint])
    assert f"{usage.spot_side[spot]} of the {usage.end_kind[joint]} joint at " in usage.describe(spot)
    assert "axial saddle" in usage.describe(spot)
    wall = usage.spot_side.index("wall")
    assert usage.describe(wall).endswith("stress concentration factor 2")
    assert usage.spot_factor[wall] == 2.0


def test_tables_hold_the_results(usage, report_data, tmp_path):
    design = design_life(report_data.case)
    tables = usage_tables(usage, design)
    paths = write_tables(tables, tmp_path, {"case_sha256": case_hash(report_data.case), "versions": "{}"})
    names = ("member_ends", "hot_spots", "stress_ranges")
    assert {p.name for p in paths} == {f"{name}.{end}" for name in names for end in ("csv", "parquet")}
    assert {p.name for p in tmp_path.iterdir()} == {p.name for p in paths}
    for name in names:
        arrow = pyarrow.parquet.read_table(tmp_path / f"{name}.parquet")
        assert arrow.schema.metadata[b"case_sha256"].decode() == case_hash(report_data.case)
        with (tmp_path / f"{name}.csv").open(newline="") as stream:
            head, *rows = csv.reader(stream)
        assert head == arrow.column_names
        assert len(rows) == arrow.num_rows
    spots = pyarrow.parquet.read_table(tmp_path / "hot_spots.parquet")
    np.testing.assert_array_equal(spots["damage"], report_data.fatigue.damage)
    np.testing.assert_array_equal(spots["max_range_pa"], report_data.fatigue.max_range)
    assert spots.schema.field("max_range_pa").metadata == {b"unit": b"Pa"}
    assert spots["scf_axial_crown"].null_count == usage.spot_side.count("wall")
    ends = pyarrow.parquet.read_table(tmp_path / "member_ends.parquet").to_pylist()
    worst = max(ends, key=lambda end: end["damage"])
    assert (worst["member_end"], worst["worst_spot"]) == (report_data.end_name, report_data.spot_name)
    rate = worst["damage"] / usage.duration_s * YEAR_S
    assert worst["damage_per_year"] == pytest.approx(rate, rel=1e-12)
    assert worst["utilisation"] == pytest.approx(25.0 * 3.0 * rate, rel=1e-12)


def test_range_counts_are_all_cycles(usage):
    """What is left out is empty bins only: the counts of a spot add up to its cycles."""
    counts = usage_tables(usage, None)[2].columns
    total: dict[str, float] = {}
    for name, cycles in zip(counts["hot_spot"], counts["cycles"], strict=True):
        total[name] = total.get(name, 0.0) + cycles
    assert [total[name] for name in usage.spot_name] == usage.cycles.tolist()
    assert (counts["range_low_pa"] < counts["range_high_pa"]).all()


def test_the_hash_of_a_case_does_not_hang_on_its_order():
    assert case_hash({"a": 1, "b": 2.5}) == case_hash({"b": 2.5, "a": 1})
    assert case_hash({"a": 1, "b": 2.5}) != case_hash({"a": 1, "b": 2.6})


def two_halves(usage):
    """Two records whose own most damaged spots are others than that of both together."""
    first, second = (np.full(len(usage.damage), 1e-9) for _ in range(2))
    first[10], second[20], first[30], second[30] = 5e-6, 5e-6, 4e-6, 4e-6
    return replace(usage, damage=first), replace(usage, damage=second)


def check_adds_before_the_largest(combine, usage):
    first, second = two_halves(usage)
    spot, damage = combine(first, second)
    assert {first.most_used, second.most_used} == {10, 20}
    assert spot == 30
    assert damage == pytest.approx(8e-6, rel=1e-12)


def largest_first(first, second):
    """Wrong: the largest of each record, added."""
    return first.most_used, float(first.damage.max() + second.damage.max())


def test_damage_is_added_up_before_the_largest_is_taken(usage):
    def right(first, second):
        both = add_up(first, second)
        return both.most_used, float(both.damage.max())

    check_adds_before_the_largest(right, usage)
    with pytest.raises(AssertionError):
        check_adds_before_the_largest(largest_first, usage)


def test_other_spots_do_not_add_up(usage):
    other = replace(usage, curve=replace(usage.curve, name="other"))
    with pytest.raises(InputError, match="does not add up"):
        add_up(usage, other)


def test_records_of_other_structures_are_groups_of_their_own(report_data, tmp_path):
    records = Records()
    for name in "ab":
        records.add(name, report_data, tmp_path / name / "report.html")
    reduced = replace(report_data.reduced, model_hash="other")
    records.add("c", replace(report_data, reduced=reduced), tmp_path / "c" / "report.html")
    assert [len(group.records) for group in records.groups] == [2, 1]
    group = records.groups[0]
    np.testing.assert_array_equal(group.usage.damage, 2.0 * report_data.fatigue.damage)
    assert group.usage.duration_s == 2.0 * report_data.fatigue.duration_s
    table = records_table(group).columns
    assert table["record"] == ["a", "b"]
    np.testing.assert_allclose(table["damage_at_most_used_spot"], report_data.fatigue.damage.max())
    json.dumps(records.summary(), allow_nan=False)
    assert "which do not add up" in records.render(group, tmp_path)


def test_measures_and_their_colours(usage, report_data):
    shown = measures(usage, design_life(report_data.case))
    assert [m.key for m in shown] == ["damage", "range", "total", "utilisation"]
    for measure in shown:
        plain = measure.plain()
        assert plain["share"][int(np.argmax(measure.value))] == 1.0
        assert min(plain["share"]) >= 0.0
        assert all(0.0 <= t <= 1.0 + 1e-9 for t in plain["tick"])
        json.dumps(plain, allow_nan=False)
    assert [m.key for m in measures(usage, None)] == ["damage", "range", "total"]
    nothing = replace(usage, damage=np.zeros_like(usage.damage))
    json.dumps([m.plain() for m in measures(nothing, None)], allow_nan=False)


def luminance(colour: str) -> float:
    """Relative luminance of an sRGB colour."""
    channel = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    linear = np.where(channel <= 0.04045, channel / 12.92, ((channel + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_the_scale_grows_darker_all_the_way():
    """So that its order does not hang on hue; a rainbow fails."""
    found = [luminance(colour) for _, colour in SCALE]
    assert (np.diff(found) < -0.03).all()
    rainbow = [luminance(colour) for colour in ("#0000ff", "#00ff00", "#ffff00", "#ff0000")]
    assert not (np.diff(rainbow) < -0.03).all()


def test_the_structure_is_closed_tubes(usage, report_data):
    """Every half of a member has its own vertices, at its own radius from the member's axis."""
    geometry = report_data.geometry
    figure = jacket(usage, geometry, None)
    tubes, end = figure.data[0], np.array(figure.extra["end_of_vertex"])
    assert set(end) == set(range(len(usage.end_name)))
    face = np.stack([tubes[name] for name in "ijk"], axis=1)
    assert (end[face] == end[face][:, :1]).all()
    assert len(figure.extra["end_text"]) == len(usage.end_name)


def test_a_rainflow_matrix_loses_no_cycle(report_data):
    figure = rainflow_matrix(report_data.stress_normal, "here")
    counted = np.sum(figure.data[0]["customdata"])
    assert counted == report_data.fatigue.cycles[report_data.stress_spot]
    assert rainflow_matrix(np.zeros(10), "here") is None
