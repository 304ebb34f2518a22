"""The load at the tower top of a case: read from a file, or where it comes from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.stage import build_response_model
from owt_structure_node.wind_source import COLUMNS, read_wrench, tower_top_load

SAMPLES, DT, HEAD = 30, 0.1, "time_s,fx_n\n"


@pytest.fixture(scope="module")
def mesh(models):
    return build_mesh(models.frame())


@pytest.fixture(scope="module")
def bare(models):
    return build_mesh(models.frame(tower=None, rotor_nacelle=None))


def test_a_rotor_hangs_over_the_water_of_its_structure(mesh):
    with pytest.raises(InputError, match=r"diameter_m = 130\.0: must be below twice the height .* 50 m"):
        tower_top_load(parse_case({"wind": {"thrust": {}}}), mesh)


def test_read_wrench(tmp_path):
    """Columns in any order, those left out zero, comments, blank lines, spaces, quotes, a byte order mark."""
    file = tmp_path / "w.csv"
    text = '# a code\n\n my_nm ,"time_s",fx_n\n1e3,-0.5,2\n   \n# gap\n"4",0.25, 5 \r\n6,7e0,8\n'
    file.write_text(text, encoding="utf-8-sig")
    time, wrench = read_wrench(file)
    assert time.tolist() == [-0.5, 0.25, 7.0]
    assert wrench.tolist() == [[2, 0, 0, 0, 1000, 0], [5, 0, 0, 0, 4, 0], [8, 0, 0, 0, 6, 0]]
    file.write_text(",".join(["time_s", *COLUMNS]) + "\n0,1,2,3,4,5,6\n")
    assert read_wrench(file)[1].tolist() == [[1, 2, 3, 4, 5, 6]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is headed by nothing: it must be time_s and one or more of fx_n, fy_n"),
        ("0,1\n1,2\n", "is headed by 0,1: it must"),
        ("time_s\n0\n", "is headed by time_s: it must"),
        ("time_s,fx_n,fx_n\n0,1,2\n", "each once"),
        ("time_s,Fx_n\n0,1\n", "is headed by time_s,Fx_n: it must"),
        (HEAD + "0,1\n\n1\n", r"has a row 4, '1', that is not 2 finite numbers\. Fill gaps"),
        (HEAD + "0,1\n1,nan\n", "has a row 3, '1,nan'"),
        (HEAD + '0,1\n1,"1\n0"\n2,2\n', "has a row 3, '1,\"1'"),
        (HEAD + "0," + "1" * 140_000 + "\n", "has a row 2, '0,1{58}'"),
        (HEAD + "0,1\n0,2\n", r"has the time 0 s in row 3, not later than the row before\. Sort"),
        (HEAD + "# c\n1,1\n0.5,2\n", r"has the time 0\.5 s in row 4"),
        (HEAD, r"covers nothing, the record is 0 to 9\.9 s\. Give a series from 0 s"),
        (HEAD + "0,1\n9.8,2\n", "covers 0 to 9.8 s"),
        (HEAD + "100,1\n300,2\n", "covers 100 to 300 s"),
    ],
)
def test_a_bad_file_is_one_error(mesh, tmp_path, text, message):
    file = tmp_path / "w.csv"
    file.write_text(text)
    case = parse_case({"time": {"n": 100}, "wind": {"series": {"path": str(file)}}})
    with pytest.raises(InputError, match=rf"^wind\.series\.path .*{message}"):
        tower_top_load(case, mesh)


@pytest.mark.parametrize(
    ("name", "message"),
    [("none", "No such file"), ("", "Is a directory"), ("latin", "is not UTF-8"), ("a\0b", "embedded null")],
)
def test_what_cannot_be_read_is_named(tmp_path, name, message):
    (tmp_path / "latin").write_bytes(b"time_s,fx_n\n0,\xe9\n")
    with pytest.raises(InputError, match=rf"cannot be read \({message}"):
        read_wrench(Path(f"{tmp_path}/{name}"))


def series_case(file, times, **options):
    rows = "".join(f"{t!r},{1e3 * t!r},{2e3 * t!r}\n" for t in map(float, times))
    file.write_text("time_s,fx_n,mz_nm\n" + rows)
    wind = {"series": {"path": str(file), **options}}
    return parse_case({"time": {"n": 100}, "structure": {"reduction": "CB05"}, "wind": wind})


def test_a_file_on_the_samples(mesh, bare, tmp_path):
    """Linear in time, turned to its direction, no damping; also on a structure without tower."""
    case = series_case(tmp_path / "w.csv", [-1.0, 0.33, 4.0, 9.9], direction_deg=90.0)
    for structure in (mesh, bare):
        load = tower_top_load(case, structure)
        expected = np.outer(DT * np.arange(100), [0.0, 1e3, 0.0, 0.0, 0.0, 2e3])
        np.testing.assert_allclose(load.wrench, expected, atol=1e-8)
        assert (load.dashpots.shape, load.notes) == ((0, 6), ())


@pytest.mark.parametrize(("dt", "noted"), [(0.0125, True), (0.06, True), (0.0999, False), (0.1, False)])
def test_a_series_finer_than_the_samples_is_noted(mesh, tmp_path, dt, noted):
    case = series_case(tmp_path / "w.csv", dt * np.arange(round(10.0 / dt) + 1))
    notes = tower_top_load(case, mesh).notes
    assert ["faster than 5 Hz appears slower" in note for note in notes] == [True] * noted
    assert build_response_model(case, mesh, None, tower_top_load(case, mesh)).description.notes == notes


def test_where_a_load_comes_from(mesh, bare):
    assert tower_top_load(parse_case({}), mesh) is None
    topic = parse_case({"wind": {"topic": {}}})
    assert tower_top_load(topic, mesh, live=True).wrench is None
    with pytest.raises(InputError, match=r"wind\.topic = 'given': is read by the running graph only"):
        tower_top_load(topic, mesh)
    with pytest.raises(InputError, match=r"wind\.thrust = 'given': needs a tower, frame has none"):
        tower_top_load(parse_case({"wind": {"thrust": {}}}), bare)
    for given in ({}, {"topic": {}, "thrust": {}}):
        with pytest.raises(InputError, match="given once, by one of series, topic, thrust"):
            parse_case({"wind": given})


def notes_of(case, mesh):
    return build_response_model(case, mesh, None, tower_top_load(case, mesh)).description.notes


def test_blades_that_pass_at_the_tower_s_frequency_are_noted():
    """The default rotor meets the thesis' turbine at 5.7 m/s."""
    mesh = build_mesh(load_structure("oc4-thesis"))
    for speed, noted in ((5.7, True), (12.0, False)):
        data = {"wind": {"thrust": {"speed_m_s": speed}}, "structure": {"reduction": "CB05"}}
        notes = notes_of(parse_case(data), mesh)
        assert any("within 10% of its mode at 0.381 Hz" in note for note in notes) is noted


def test_damping_of_the_rotor_beside_a_tower_top_dashpot_is_noted():
    mesh = build_mesh(load_structure("oc4-thesis"))
    top = {"reduction": "CB05", "damping": {"tower_top": [6.1e4, 6.1e4, 0, 0, 0, 0]}}
    for aerodynamic, noted in ((True, True), (False, False)):
        wind = {"thrust": {"aerodynamic_damping": aerodynamic}}
        notes = notes_of(parse_case({"wind": wind, "structure": top}), mesh)
        assert any("both act at the tower top" in note for note in notes) is noted


def test_a_ramp_longer_than_the_record_is_noted(mesh):
    case = parse_case({"time": {"n": 100}, "structure": {"reduction": "CB05", "ramp_s": 11.0}})
    assert "the record of 10 s ends before the loads have risen" in notes_of(case, mesh)
