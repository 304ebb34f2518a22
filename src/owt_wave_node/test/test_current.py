"""The steady current and its sum with the waves."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_wave_node.core.current import current_velocity
from owt_wave_node.core.kinematics import wave_kinematics

Z = np.array([-20.0, -15.0, -5.0, 0.0, 3.0])


def speeds(depth: float = 20.0, direction: float = 0.0, **current) -> np.ndarray:
    case = parse_case({"water_depth_m": depth, "current": {"direction_deg": direction} | current})
    return current_velocity(case, Z)


def test_without_a_current() -> None:
    assert not current_velocity(parse_case({}), Z).any()


def test_uniform_and_its_direction() -> None:
    got = speeds(direction=120.0, speed_m_s=1.5)
    assert got == pytest.approx(np.tile([1.5 * np.cos(np.pi * 2 / 3), 1.5 * np.sin(np.pi * 2 / 3)], (5, 1)))
    assert got[0, 0] < 0.0 < got[0, 1]  # flows to -x, +y: a direction that it came from would swap the signs


def test_power_law() -> None:
    got = speeds(profile="power", speed_m_s=1.2)[:, 0]
    assert got == pytest.approx([0.0, 1.2 * 0.25 ** (1 / 7), 1.2 * 0.75 ** (1 / 7), 1.2, 1.2], rel=1e-15)


@pytest.mark.parametrize("descending", [False, True])
def test_table_is_linear_and_constant_beyond(descending: bool) -> None:
    table = [[-15.0, 0.2], [-10.0, 0.4], [-2.0, 2.0]]
    got = speeds(profile="table", table=table[::-1] if descending else table)[:, 0]
    assert got == pytest.approx([0.2, 0.2, 1.4, 2.0, 2.0], rel=1e-15)


def test_still_water_is_where_it_stops_changing() -> None:
    got = speeds(profile="table", table=[[-10.0, 0.0], [10.0, 2.0]])[:, 0]
    assert got == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0], rel=1e-15)


def check_added(got, bare, expected) -> None:
    assert np.abs(got.velocity - bare.velocity - expected).max() < 1e-15 * 4.0
    for name in ("eta1", "eta2", "acceleration", "velocity2", "acceleration2"):
        assert np.array_equal(getattr(got, name), getattr(bare, name))


def test_waves_add_it_to_the_velocity_only(listed) -> None:
    fields = {
        "time": {"dt_s": 0.5, "n": 40},
        "points_m": [[0.0, 0.0, -5.0], [3.0, 1.0, 2.0]],
        "water_depth_m": 20.0,
        "direction": 30.0,
    }
    bare = wave_kinematics(listed([0.8, 0.9], [1.0, 0.5], [0.1, 0.2], **fields))
    fields["current"] = {"profile": "power", "speed_m_s": 1.0, "direction_deg": 90.0}
    got = wave_kinematics(listed([0.8, 0.9], [1.0, 0.5], [0.1, 0.2], **fields))
    expected = np.array([[0.0, 0.75 ** (1 / 7), 0.0], [0.0, 1.0, 0.0]])
    check_added(got, bare, expected)
    with pytest.raises(AssertionError):  # the wrong variant: along the waves
        check_added(got, bare, expected[:, [1, 0, 2]])
