"""Flags of the demo, alone and on top of a case file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest

from owt_bringup.case_flags import add_case_flags, case_from_flags
from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError


def case_of(*flags: str) -> CaseConfig:
    parser = argparse.ArgumentParser()
    add_case_flags(parser)
    return case_from_flags(parser.parse_args(flags))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "case.json"
    data = {
        "sea_state": {"hs_m": 3.0, "tp_s": 8.0, "seed": 7},
        "time": {"dt_s": 0.05, "n": 400},
        "structure": {"reduction": "CB20", "dt_s": 0.01},
        "wind": {"thrust": {"speed_m_s": 9.0}},
    }
    path.write_text(json.dumps(data))
    return path


def test_no_flags_are_the_defaults() -> None:
    assert case_of() == CaseConfig()


def test_flags_change_their_fields_only() -> None:
    case = case_of("--hs", "4", "--duration", "60", "--tolerance", "0.01", "--reduction", "auto")
    expected = {"sea_state": {"hs_m": 4.0}, "time": {"n": 600}}
    assert case == parse_case(expected | {"structure": {"reduction": "auto", "tolerance": 0.01}})


def test_a_case_file_stays_where_no_flag_is_given(file: Path) -> None:
    assert case_of("--case", str(file)) == parse_case(json.loads(file.read_text()))
    case = case_of("--case", str(file), "--seed", "8", "--duration", "10")
    assert case.sea_state is not None
    assert (case.sea_state.hs_m, case.sea_state.seed, case.time.n, case.time.dt_s) == (3.0, 8, 200, 0.05)
    assert case.structure.reduction == "CB20"
    assert case.wind is not None


def test_a_flag_of_the_sea_state_goes_with_no_other_sea(file: Path) -> None:
    data = json.loads(file.read_text()) | {"sea_state": None}
    wave = {"omega_rad_s": [0.6], "amplitude_m": [1.0], "phase_rad": [0.0]}
    file.write_text(json.dumps(data | {"components": wave}))
    assert case_of("--case", str(file)).sea_state is None
    with pytest.raises(InputError, match="components"):
        case_of("--case", str(file), "--hs", "4")


@pytest.mark.parametrize("duration", ["0.02", "10.01", "nan", "1e9"])
def test_a_duration_is_whole_steps(duration: str) -> None:
    with pytest.raises(InputError, match="duration"):
        case_of("--duration", duration)
