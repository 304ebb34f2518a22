"""The configuration refuses what cannot be, in one line that names field, value, limit and remedy."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from owt_model.config import CaseConfig, load_case, parse_case
from owt_model.errors import InputError

REFUSED = [
    ({"sea_state": {"hs_m": -1.0}}, "sea_state.hs_m", "greater than 0"),
    ({"sea_state": {"tp_s": 0}}, "sea_state.tp_s", "greater than 0"),
    ({"sea_state": {"hs_m": "six"}}, "sea_state.hs_m", "must be a number"),
    ({"sea_state": {"seed": -1.5}}, "sea_state.seed", "whole number"),
    (
        {"sea_state": {"hs_m": 29.9, "tp_s": 30.0}, "water_depth_m": 40.0},
        "sea_state.hs_m",
        "of the water depth",
    ),
    ({"sea_state": {"hs_m": 9.0, "tp_s": 5.0}}, "sea_state.tp_s", "1/7"),
    ({"sea_state": {"typo": 1}}, "sea_state.typo", "not a known key"),
    ({"sea_state": None}, "sea_state", "must be given once"),
    ({"typo": 1}, "typo", "not a known key"),
    ({"water_depth_m": -5}, "water_depth_m", "greater than or equal to 0.1"),
    ({"time": {"n": 0}}, "time.n", "greater than"),
    ({"time": {"dt_s": float("nan")}}, "time.dt_s", "finite"),
    ({"time": {"dt_s": 1e9}}, "time.dt_s", "less than"),
    ({"sea_state": {"cutoff_over_peak": 1.5}, "time": {"n": 3}}, "time.n", "no component"),
    ({"wave": {"order": 3}}, "wave.order", "1 or 2"),
    ({"wave": {"stretching": "magic"}}, "wave.stretching", "taylor"),
    ({"wave": {"order": 2, "stretching": "wheeler"}}, "wave.stretching", "first order only"),
    ({"points_m": [[0, 0]]}, "points_m[0][2]", "is missing"),
    ({"points_m": [[0, 0, -80]]}, "points_m[0]", "below the sea bed"),
    ({"structure": {"reduction": "CB1"}}, "structure.reduction", "CBnn"),
    ({"components": {"omega_rad_s": [1.0], "amplitude_m": [1.0]}}, "components.phase_rad", "is missing"),
    (
        {"components": {"omega_rad_s": [1], "amplitude_m": [1, 2], "phase_rad": [0]}},
        "components.amplitude_m",
        "1",
    ),
    (
        {"components": {"omega_rad_s": [1], "amplitude_m": [1], "phase_rad": [0]}, "sea_state": {}},
        "components",
        "both",
    ),
    (
        {"components": {"omega_rad_s": [1], "amplitude_m": [1], "phase_rad": [0], "direction_deg": [423]}},
        "components.direction_deg[0]",
        "less than or equal to 360",
    ),
    ({"morison": {"cd": [[0, 1], [-5, 99]]}}, "morison.cd[1][1]", "less than or equal to 10"),
    ({"morison": {"cd": -1}}, "morison.cd", "greater than or equal to 0"),
    ({"sea_state": {"hs_m": "a", "tp_s": -1}}, "sea_state.hs_m", "must be a number"),
    ({"wind": 3}, "wind", "must be an object"),
    ({"wind": {}}, "wind", "by one of series, topic, thrust"),
    ({"wind": {"thrust": {}, "topic": {}}}, "wind.thrust", "by one of series, topic, thrust"),
    ({"wind": {"thrust": {"rotor": {"diameter_m": 0}}}}, "wind.thrust.rotor.diameter_m", "greater than 0"),
    ({"structure": {"damping": {"fit": [[1, 5], [1, 9]]}}}, "structure.damping.fit", "two different"),
    (
        {"structure": {"damping": {"fit": [[1, 5], [2, 1]]}}},
        "structure.damping.fit",
        "neither may be negative",
    ),
    (
        {"structure": {"damping": {"fit": [[1, 5], [2, 6]], "beta": 0.1}}},
        "structure.damping.beta",
        "beside `fit`",
    ),
    ({"structure": {"damping": {"modes": [[1, 5], [1, 6]]}}}, "structure.damping.modes", "each once"),
    ({"structure": {"damping": {"modes": [[1.5, 5]]}}}, "structure.damping.modes", "number of a mode"),
    ({"structure": {"damping": {"tower_top": [1, 2]}}}, "structure.damping.tower_top[2]", "missing"),
    ({"structure": {"ramp_s": -1}}, "structure.ramp_s", "greater than or equal to 0"),
    ({"structure": {"jacket_stiffness_factor": 0}}, "structure.jacket_stiffness_factor", "greater than 0"),
    ([], "case", "JSON object"),
    ("x", "case", "JSON object"),
]


@pytest.mark.parametrize(("data", "field", "limit"), REFUSED, ids=lambda value: str(value)[:40])
def test_refuses_with_field_and_limit(data: object, field: str, limit: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_case(data)
    assert caught.value.field == field
    assert limit in caught.value.limit
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["{", "", "\x00\x01", "[", '{"a": }'])
def test_refuses_what_is_not_json(tmp_path: Path, text: str) -> None:
    path = tmp_path / "case.json"
    path.write_text(text)
    with pytest.raises(InputError, match="is not JSON"):
        load_case(path)


def test_refuses_an_unreadable_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        load_case(tmp_path / "absent.json")
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        load_case(tmp_path / "binary.json")


def test_defaults_are_thesis_table_4_3() -> None:
    case = parse_case({})
    assert (case.water_depth_m, case.density_kg_m3) == (50.0, 1025.0)
    assert (case.morison.cd, case.morison.cm, case.morison.discretisation_m) == (1.0, 2.0, 1.0)
    assert (case.time.dt_s, case.time.duration_s) == (0.1, 600.0)
    assert case.sea_state is not None
    assert case.sea_state.cutoff_over_peak == 4.0
    assert case.substeps == 5


def test_components_replace_the_sea_state() -> None:
    case = parse_case({"components": {"omega_rad_s": [1], "amplitude_m": [1], "phase_rad": [0]}})
    assert case.sea_state is None


def test_round_trip_and_frozen() -> None:
    case = parse_case({"sea_state": {"hs_m": 3.0}, "points_m": [[0, 0, -5]]})
    assert parse_case(json.loads(case.model_dump_json())) == case
    with pytest.raises(ValueError, match="frozen"):
        case.water_depth_m = 3.0  # type: ignore[misc]


def test_committed_schema_is_that_of_the_code() -> None:
    committed = Path(__file__).parents[3] / "docs" / "case.schema.json"
    assert json.loads(committed.read_text()) == CaseConfig.model_json_schema()


def test_integration_step_divides_the_load_step_where_it_is_used() -> None:
    case = parse_case({"time": {"dt_s": 0.05}})
    with pytest.raises(InputError, match="must divide") as caught:
        _ = case.substeps
    assert "0.0166667 s" in caught.value.remedy
    assert parse_case({"time": {"dt_s": 0.05}, "structure": {"dt_s": 0.01}}).substeps == 5


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"seed": ' + "9" * 5001 + "}", '{"wave": {"order": 1, "order": 2}}'], ids=len
)
def test_hostile_text_is_one_clear_error(tmp_path: Path, text: str) -> None:
    """Nesting without end, a number without end, a key given twice."""
    (tmp_path / "case.json").write_text(text)
    with pytest.raises(InputError):
        load_case(tmp_path / "case.json")
