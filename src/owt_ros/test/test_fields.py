"""Parameters derived from the configuration, without ROS."""

from typing import Any

import pytest
import yaml

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError
from owt_ros.fields import case_from_values, case_values, leaves
from owt_ros.parameters import parameter_yaml

CASES: list[dict[str, Any]] = [
    {},
    {"sea_state": {"gamma": 3.3, "seed": 2**62}, "wave": {"order": 1, "stretching": "wheeler"}},
    {"components": {"omega_rad_s": [0.5, 0.7], "amplitude_m": [1, 2], "phase_rad": [0, 1e-5]}},
    {
        "components": {
            "omega_rad_s": [0.5, 0.7], "amplitude_m": [1, 2], "phase_rad": [0, 1], "direction_deg": [10, 20]
        },
        "points_m": [[0, 0, -1], [1, 2, -3]],
        "gauges_m": [[0, 0], [5, 5]],
    },
    {"fatigue": {"sn_curve": "own", "sn_file": "curves of my own.yaml"}},
]  # fmt: skip


@pytest.mark.parametrize("data", CASES)
def test_case_there_and_back(data: dict[str, Any]) -> None:
    case = parse_case(data)
    assert case_from_values(case_values(case)) == case


@pytest.mark.parametrize("data", CASES)
def test_case_through_a_parameter_file(data: dict[str, Any]) -> None:
    case = parse_case(data)
    tree = yaml.safe_load(parameter_yaml(case))["/**"]["ros__parameters"]
    values: dict[str, Any] = {}

    def flatten(prefix: str, part: dict[str, Any]) -> None:
        for key, value in part.items():
            if isinstance(value, dict):
                flatten(f"{prefix}{key}.", value)
            else:
                values[f"{prefix}{key}"] = value

    flatten("", tree)
    assert case_from_values(values) == case


def test_every_field_is_a_parameter_with_a_description() -> None:
    table = {leaf.name: leaf for leaf in leaves(CaseConfig)}
    assert set(case_values(CaseConfig())) <= set(table)
    unset = {name for name, leaf in table.items() if leaf.default is None}
    parts = (
        "components",
        "spectrum_file",
        "measured",
        "regular",
        "live",
        "current",
        "sea_state.focus",
        "wind",
        "structure.static_state",
    )
    optional = tuple(f"{part}." for part in parts)
    assert {name for name in unset if not name.startswith(optional)} == {
        "sea_state.gamma",
        "sea_state.spreading",
        "sea_state.systems",
        "wave.window",
        "points_m",
        "fatigue.sn_file",
        "fatigue.wall_sn_curve",
        "structure.jacket_stiffness_factor",
        "structure.damping.fit",
        "structure.damping.modes",
        "structure.damping.tower_top",
    }
    for leaf in table.values():
        assert leaf.description, leaf.name
    assert (table["sea_state.hs_m"].minimum, table["sea_state.hs_m"].above) == (0.0, True)
    assert table["wave.order"].choices == (1, 2)
    assert table["points_m"].width == 3
    assert (table["morison.cd"].kind, table["morison.cd"].width) == ("any", 2)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("sea_state.hs_m", -1.0, r"sea_state\.hs_m = -1\.0: must be greater than 0.*significant wave height"),
        ("sea_state.hs_m", "6", r"sea_state\.hs_m = '6': must be a number"),
        (
            "sea_state.hs",
            6.0,
            r"sea_state\.hs = 6\.0: is not a known parameter\. Did you mean: sea",
        ),
        ("time.n", 1.5, r"time\.n = 1\.5: must be a whole number"),
        ("points_m", [0.0, 1.0], r"points_m = .*must hold 3 numbers per point"),
        ("sea_state.tp_s", 2.0, r"sea_state\.tp_s = 2\.0: makes the steepness"),
        ("components.omega_rad_s", [0.5], r"components\.amplitude_m = 'nothing': is missing"),
    ],
)
def test_what_is_refused_says_name_value_limit_and_remedy(name: str, value: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        case_from_values({**case_values(CaseConfig()), name: value})
