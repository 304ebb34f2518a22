"""Regular waves: against the library itself, headings, windows, above the crest, refusals, loads.

Published values, limits and boundary conditions are proved in test/proofs/regular.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.loads import jacket_loads
from owt_wave_node.core.regular import RegularField
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import build_sea_state, sea_field
from owt_wave_node.core.steady import highest_wave, steady_wave

G, D = 9.81, 50.0


def regular(theory: str = "stream", **more: Any) -> CaseConfig:
    wave = {key: more.pop(key) for key in ("height_m", "period_s", "length_m", "order") if key in more}
    wave = wave or {"height_m": 8.0, "period_s": 10.0}
    wave |= {key: more.pop(key) for key in ("direction_deg", "phase_rad") if key in more}
    data = {"sea_state": None, "regular": {"theory": theory} | wave, "time": {"dt_s": 0.1, "n": 173}}
    return parse_case(data | more)


def solved(theory: str, height: float, **more: Any) -> Any:
    given = {"period": None, "length": None, "order": None, "depth": D, "gravity": G} | more
    return steady_wave(theory, height=height, **given)


@pytest.mark.parametrize(
    ("theory", "model", "order"), [("stokes", "StokesWave", 5), ("stream", "FentonWave", 12)]
)
def test_kinematics_are_those_of_the_library(theory: str, model: str, order: int) -> None:
    import raschii

    wave = getattr(raschii, model)(14.0, D, 200.0, N=order, g=G)
    points = [[3.0, 1.0, z] for z in (-50.0, -20.0, -5.0, 0.0, 6.0)]
    case = regular(theory, height_m=14.0, length_m=200.0, order=order, points_m=points, phase_rad=0.7)
    got = wave_kinematics(case)
    x = np.full(5, 3.0) + 0.7 / wave.k  # the crest passes x = 0 at t = phase / omega
    z = np.array(points)[:, 2] + D
    velocity = wave.velocity(x, z, got.t, all_points_wet=True)
    # The library stops at a residual of 1e-8 of its equations, here they are solved to round-off.
    for name, axis in (("u", 0), ("w", 1)):
        expected = velocity[:, :, axis]
        error = np.abs(got.velocity[:, :, 2 * axis] - expected).max() / np.abs(velocity).max()
        assert error < 1e-6, name
    assert np.abs(got.eta1 - wave.surface_elevation(x, got.t, include_depth=False)).max() < 1e-6 * 14.0
    if theory == "stream":
        expected = wave.acceleration(x, z, got.t, all_points_wet=True)
        assert np.abs(got.acceleration[:, :, ::2] - expected).max() < 1e-6 * np.abs(expected).max()
    assert not got.eta2.any()
    assert not got.velocity2.any()


def check_heading(turned: Any, along: Any, angle: float) -> None:
    b = np.deg2rad(angle)
    c, s = np.cos(b), np.sin(b)
    rotation = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    for name in ("velocity", "acceleration"):
        expected = getattr(along, name) @ rotation
        assert np.abs(getattr(turned, name) - expected).max() < 1e-13 * np.abs(expected).max()
    assert np.abs(turned.eta1 - along.eta1).max() < 1e-12


@pytest.mark.parametrize("theory", ["airy", "stokes", "stream"])
def test_heading(theory: str) -> None:
    c, s = np.cos(np.deg2rad(40.0)), np.sin(np.deg2rad(40.0))
    wave = {"wave": {"order": 1}}
    along = wave_kinematics(regular(theory, points_m=[[12.0, 3.0, -4.0]], **wave))
    place = [[12.0 * c - 3.0 * s, 12.0 * s + 3.0 * c, -4.0]]
    turned = wave_kinematics(regular(theory, points_m=place, direction_deg=40.0, **wave))
    check_heading(turned, along, 40.0)
    with pytest.raises(AssertionError):  # the wrong variant: turned the other way
        check_heading(turned, along, -40.0)


def test_airy_is_one_component_of_first_order() -> None:
    case = regular("airy", height_m=4.0, period_s=8.0, phase_rad=0.3, points_m=[[5.0, 0.0, 1.0]])
    listed = parse_case(
        {
            "components": {"omega_rad_s": [np.pi / 4.0], "amplitude_m": [2.0], "phase_rad": [0.3]},
            "time": {"dt_s": 0.1, "n": 173},
            "points_m": [[5.0, 0.0, 1.0]],
            "wave": {"order": 1},
        }
    )
    one, other = wave_kinematics(case), wave_kinematics(listed)
    assert np.abs(one.velocity - other.velocity).max() < 1e-13 * np.abs(other.velocity).max()
    assert not one.eta2.any()  # wave.order is 2, and of no effect


@pytest.mark.parametrize("stretching", ["none", "constant", "taylor", "wheeler"])
def test_stretching_is_for_airy_waves_only(stretching: str) -> None:
    def at_crest(theory: str, chosen: str) -> float:
        wave = {"order": 1, "stretching": chosen}
        case = regular(theory, height_m=4.0, period_s=8.0, points_m=[[0.0, 0.0, 1.5]], wave=wave)
        return float(wave_kinematics(case).velocity[0, 0, 0])

    assert at_crest("stream", stretching) == at_crest("stream", "none")
    if stretching != "none":
        assert at_crest("airy", stretching) < 0.998 * at_crest("airy", "none")


def test_sea_state_is_one_component_with_the_length_of_the_theory() -> None:
    case = regular(height_m=17.0, period_s=14.0, direction_deg=30.0)
    sea = build_sea_state(case)
    assert (sea.source, sea.direction_deg, sea.order, sea.stretching) == ("regular", 30.0, 20, "none")
    assert sea.amplitude_m.tolist() == [8.5]
    assert 2.0 * np.pi / sea.wavenumber_rad_m[0] == pytest.approx(269.465, abs=1e-3)
    assert 2.0 * np.pi / sea.omega_rad_s[0] == pytest.approx(14.0, rel=1e-12)
    assert sea_field(case) == "regular.height_m"


def test_a_length_gives_the_period_that_gives_the_length() -> None:
    for theory in ("airy", "stokes", "stream"):
        one = solved(theory, 9.0, length=140.0)
        assert solved(theory, 9.0, period=one.period).length == pytest.approx(140.0, rel=1e-10)


def test_water_deeper_than_three_lengths_changes_nothing() -> None:
    for theory in ("airy", "stokes", "stream"):
        one, other = (solved(theory, 1.0, period=4.0, depth=d) for d in (100.0, 4000.0))
        assert one.length == pytest.approx(other.length, rel=1e-12)
        assert one.speed == pytest.approx(other.speed, rel=1e-10, abs=1e-12)


def test_a_window_is_a_part_of_the_record() -> None:
    case = regular(time={"dt_s": 0.1, "n": 10_000})
    field = make_field(case, build_sea_state(case))
    assert isinstance(field, RegularField)
    place = np.array([[3.0, 0.0, -4.0], [9.0, 0.0, 2.0]])
    part = field.window(4000, 300).window(50, 100)
    assert part.n == 100
    for name in ("elevation", "first", "second"):
        whole, cut = getattr(field, name)(place), getattr(part, name)(place)
        assert np.abs(np.array(whole)[..., 4050:4150] - np.array(cut)).max() < 1e-11
    assert np.array_equal(field.prepare(place).kinematics(np.array([1])), field.first(place[1:]))


def test_a_record_that_repeats_itself_is_summed_once() -> None:
    case = regular(time={"dt_s": 0.1, "n": 6000}, phase_rad=0.3)
    sea = build_sea_state(case)
    field, other = make_field(case, sea), make_field(case, sea)
    place = np.array([[3.0, 0.0, -4.0]])
    assert field._repeat == 100
    other._repeat = 6000
    assert np.abs(field.first(place) - other.first(place)).max() < 1e-9
    other._repeat = 101  # the wrong variant
    assert np.abs(field.first(place) - other.first(place)).max() > 0.1
    never = regular(time={"dt_s": 0.1, "n": 6000}, height_m=8.0, length_m=150.0)
    assert make_field(never, build_sea_state(never))._repeat == 6000


def test_above_the_crest_the_profile_goes_on_along_its_tangent() -> None:
    case = regular(height_m=17.0, period_s=14.0)
    field = make_field(case, build_sea_state(case))
    crest = solved("stream", 17.0, period=14.0).crest
    z = crest + np.array([-1e-3, 0.0, 1e-3, 5.0, 30.0])
    u = field.first(np.column_stack([0.0 * z, 0.0 * z, z]))[:, :, 0]
    slope = (u[1, 0] - u[0, 0]) / 1e-3
    assert u[2:, 0] == pytest.approx(u[1, 0] + slope * (z[2:] - crest), rel=1e-3)
    assert np.isfinite(u).all()


@pytest.mark.parametrize(
    ("theory", "wave", "depth", "field"),
    [
        ("stream", {"height_m": 23.5, "period_s": 10.0}, D, "regular.height_m"),
        ("stokes", {"height_m": 40.0, "period_s": 10.0}, D, "regular.height_m"),
        ("stream", {"height_m": 8.0, "period_s": 1.0}, D, "regular.height_m"),
        ("stream", {"height_m": 45.0, "period_s": 20.0}, D, "regular.height_m"),
        ("airy", {"height_m": 30.0, "length_m": 150.0}, D, "regular.height_m"),
        ("stream", {"height_m": 20.2, "length_m": 150.0}, D, "regular.height_m"),
        ("stokes", {"height_m": 5.0, "period_s": 10.0}, 10.0, "regular.theory"),
        ("stokes", {"height_m": 5.0, "period_s": 10.0, "order": 6}, D, "regular.order"),
        ("airy", {"height_m": 5.0, "period_s": 10.0, "order": 2}, D, "regular.order"),
    ],
)
def test_refusals(theory: str, wave: dict[str, Any], depth: float, field: str) -> None:
    with pytest.raises(InputError) as error:
        build_sea_state(regular(theory, water_depth_m=depth, **wave))
    assert error.value.field == field
    assert error.value.limit


def test_highest_wave_in_deep_and_shallow_water() -> None:
    assert highest_wave(100.0, 1e5) == pytest.approx(14.1, rel=1e-3)
    assert highest_wave(1e6, 10.0) == pytest.approx(8.33, rel=1e-3)


def test_steep_and_long_waves_are_solved() -> None:
    steep = solved("stream", 19.8, length=150.0)
    assert 0.97 * highest_wave(150.0, D) < 19.8
    assert np.abs(steep.speed[-1]) < 1e-6 * steep.speed[0]
    # Full steps from the linear wave end in a solution of several crests here.
    long = solved("stream", 4.0, length=400.0, depth=10.0, order=40)
    assert long.crest == pytest.approx(3.62, abs=0.05)
    eta = np.cos(np.outer(np.linspace(0.0, np.pi, 200), np.arange(1, 41))) @ long.elevation
    assert np.diff(eta).max() < 1e-4  # several crests rise by metres


def test_loads_grow_from_airy_to_stream_function(column) -> None:
    mesh = column(depth=20.0, top=(0.0, 0.0, 10.0))
    more = {"water_depth_m": 20.0, "height_m": 6.0, "period_s": 9.0, "wave": {"order": 1}}
    airy, stream = (
        float(np.abs(jacket_loads(regular(theory, **more), mesh).force[:, 0]).max())
        for theory in ("airy", "stream")
    )
    assert 1.05 * airy < stream < 2.0 * airy
