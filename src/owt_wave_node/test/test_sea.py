"""Seas of a case: shapes and bands, random streams, directions and headings, focus, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.contracts import SeaState, sea_facts
from owt_model.errors import InputError
from owt_wave_node.core.realisation import amplitudes, directions
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state, sea_field, waves
from owt_wave_node.core.spectrum import (
    SHAPES,
    density,
    most_probable_systems,
    spectral_density,
    torsethaugen_systems,
)
from owt_wave_node.core.spreading import mean_direction

#: Rayleigh factors and angles in rad of components 1 to 3 of seed 1; the latter for s = 2.
LUCK = [0.8036257235825672, 0.9579993865563904, 0.5302374376410691]
ANGLE = [-0.6777160070831034, -1.4904477166513834, -0.18698914675223838]


#: Peak period in s of the sea of Hs 6 m, where it is not the default's.
PEAK = {"ochi-hubble": 11.83}


def sea(**given: Any) -> SeaState:
    return build_sea_state(parse_case({"sea_state": given}))


def height(state: SeaState) -> float:
    return 4.0 * math.sqrt(float(np.sum(state.amplitude_m**2)) / 2.0)


# Shapes, bands, scales


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_positive_and_finite_at_any_frequency(name: str) -> None:
    state = parse_case({"sea_state": {"spectrum": name, "tp_s": PEAK.get(name, 9.45)}}).sea_state
    assert state is not None
    f = np.geomspace(1e-7, 1e3, 300)
    s = density(state, f, gravity=9.81)
    assert np.isfinite(s).all()
    assert (s >= 0.0).all()
    assert 0.02 < f[s.argmax()] < 0.3


@pytest.mark.parametrize("name", SHAPES)
def test_formula_is_the_spectrum_as_printed(name: str) -> None:
    case = parse_case({"sea_state": {"spectrum": name, "scale": "formula", "tp_s": PEAK.get(name, 9.45)}})
    f, s = spectral_density(case)
    assert case.sea_state is not None
    assert s == pytest.approx(density(case.sea_state, f, gravity=9.81), rel=1e-14)
    made = build_sea_state(case)
    assert made.amplitude_m == pytest.approx(np.sqrt(2.0 * s / 600.0), rel=1e-14)
    assert height(made) == pytest.approx(6.0, rel=0.02)
    assert height(made) != pytest.approx(6.0, rel=1e-6)


def test_spectral_density_is_that_of_the_components() -> None:
    case = parse_case({"sea_state": {"cutin_over_peak": 0.5}})
    f, s = spectral_density(case)
    made = build_sea_state(case)
    assert f == pytest.approx(made.omega_rad_s / (2.0 * math.pi), rel=1e-15)
    assert s == pytest.approx(0.5 * made.amplitude_m**2 * 600.0, rel=1e-13)


def test_spectral_density_needs_a_spectrum(listed) -> None:
    with pytest.raises(InputError, match="not given by a spectrum"):
        spectral_density(listed(1.0, 1.0, 0.0))


def test_gamma_that_is_recorded() -> None:
    assert sea(gamma=2.0).gamma == 2.0
    assert sea(spectrum="pierson-moskowitz").gamma == 1.0
    assert sea(spectrum="torsethaugen").gamma == torsethaugen_systems(6.0, 9.45, gravity=9.81)[0].shape
    without = sea(spectrum="ochi-hubble", tp_s=11.83)
    assert without.gamma == 0.0
    assert sea_facts(without)["gamma"] is None
    assert sea_facts(sea())["gamma"] == pytest.approx(3.7186537, rel=1e-7)


def test_band_limits() -> None:
    """Cut-in and cut-off over the peak, or the cut-off by steepness; the limit itself belongs to the band."""
    both = sea(tp_s=10.0, cutin_over_peak=0.5, cutoff_over_peak=3.0)
    assert both.omega_rad_s[[0, -1]] == pytest.approx([2 * math.pi * 0.05, 2 * math.pi * 0.3], rel=1e-14)
    assert both.omega_rad_s.size == 151
    steep = sea(cutoff="steepness")
    assert steep.cutoff_rad_s == pytest.approx(math.sqrt(2 * 9.81 / 6.0), rel=1e-14)
    assert steep.omega_rad_s[-1] <= steep.cutoff_rad_s < steep.omega_rad_s[-1] + 2 * math.pi / 600.0
    assert height(both) == pytest.approx(6.0, rel=1e-13)
    assert height(steep) == pytest.approx(6.0, rel=1e-13)
    assert sea().cutoff_rad_s == pytest.approx(4.0 * 2 * math.pi / 9.45, rel=1e-14)


def test_random_numbers_belong_to_the_component() -> None:
    """Component m of a seed is the same in every band: its phase, its luck and its direction."""
    how = {"amplitudes": "rayleigh", "spreading": 4.0, "scale": "formula", "seed": 9}
    whole, part = sea(**how), sea(**how, cutin_over_peak=0.8, cutoff_over_peak=2.0)
    i = np.flatnonzero(np.isin(whole.omega_rad_s, part.omega_rad_s))
    assert i.size == part.omega_rad_s.size
    for name in ("amplitude_m", "phase_rad", "component_direction_deg"):
        assert np.array_equal(getattr(whole, name)[i], getattr(part, name))


def test_phases_do_not_depend_on_what_else_is_drawn() -> None:
    plain = sea(seed=3)
    for more in ({"amplitudes": "rayleigh"}, {"spreading": 2.0}, {"spectrum": "torsethaugen"}):
        assert np.array_equal(sea(seed=3, **more).phase_rad, plain.phase_rad)
    assert np.array_equal(sea(seed=3, spreading=2.0).amplitude_m, plain.amplitude_m)


def test_streams_are_independent() -> None:
    """Phases, amplitudes and directions of a seed are uncorrelated, to four standard errors."""
    n = 20000
    phase = np.random.Generator(np.random.PCG64(5)).random(n)
    luck = amplitudes(np.ones(n), kind="rayleigh", seed=5)
    angle = directions(n, 5, exponent=1.0)
    for one, other in ((phase, luck), (phase, angle), (luck, angle)):
        assert abs(np.corrcoef(one, other)[0, 1]) < 4.0 / math.sqrt(n)


def test_streams_are_the_same_everywhere() -> None:
    assert amplitudes(np.full(3, 0.5), kind="rayleigh", seed=1) == pytest.approx(LUCK, abs=1e-12)
    assert directions(3, 1, exponent=2.0) == pytest.approx(ANGLE, abs=1e-12)


def test_rayleigh_seas_differ_in_height() -> None:
    heights = [height(sea(amplitudes="rayleigh", seed=seed)) for seed in range(20)]
    assert np.std(heights) > 0.1
    assert np.mean(heights) == pytest.approx(6.0, rel=0.05)


def test_most_probable_systems_of_a_height() -> None:
    """Ochi and Hubble's swell and wind sea of Hs 6 m."""
    swell, wind = most_probable_systems(6.0)
    assert swell == pytest.approx((5.04, 11.829, 3.0), rel=1e-4)
    assert wind == pytest.approx((3.24, 6.904, 1.0616), rel=1e-4)
    given = {"spectrum": "ochi-hubble", "scale": "formula", "tp_s": 11.83}
    total = math.hypot(swell.hs, wind.hs)
    six = sea(**given, hs_m=total, systems=[list(swell), list(wind)])
    assert six.amplitude_m == pytest.approx(sea(**given).amplitude_m, rel=1e-13)


#: Hs, Tp and shape of a swell below a wind sea.
SWELL, WIND = [3.0, 14.0, 3.0], [4.0, 7.0, 1.0]


def test_two_systems_lie_in_the_band() -> None:
    """Cut-in over the lower and cut-off over the higher peak frequency, in either order of the systems."""
    for systems in ([SWELL, WIND], [WIND, SWELL]):
        both = sea(spectrum="ochi-hubble", systems=systems, hs_m=5.0, tp_s=7.0, cutin_over_peak=0.5)
        assert both.cutoff_rad_s == pytest.approx(4.0 * 2 * math.pi / 7.0, rel=1e-14)
        assert both.omega_rad_s[0] == pytest.approx(2 * math.pi * 0.5 / 14.0, abs=2 * math.pi / 600.0)
        assert both.omega_rad_s[0] >= 2 * math.pi * 0.5 / 14.0
    swell_first = sea(
        spectrum="ochi-hubble", systems=[[4.0, 14.0, 3.0], [3.0, 7.0, 1.0]], hs_m=5.0, tp_s=14.0
    )
    assert swell_first.cutoff_rad_s == both.cutoff_rad_s
    probable = sea(spectrum="ochi-hubble", tp_s=11.83)
    assert probable.cutoff_rad_s == pytest.approx(4.0 * 2 * math.pi / most_probable_systems(6.0)[1].tp)


def test_peak_period_is_that_of_the_systems() -> None:
    """Tp shapes an Ochi-Hubble sea by its systems only: another Tp is refused, not ignored."""
    given = {"spectrum": "ochi-hubble", "systems": [SWELL, WIND], "hs_m": 5.0}
    for tp in (6.94, 7.0, 7.06):
        sea(**given, tp_s=tp)
    for tp in (3.0, 6.92, 7.08, 14.0):
        with pytest.raises(InputError, match=r"sea_state\.tp_s .*1 % of the peak period 7 s.*Set it to 7\."):
            sea(**given, tp_s=tp)
    for tp in (7.0, 14.0):  # of equal systems either
        sea(spectrum="ochi-hubble", systems=[[3.0, 14.0, 3.0], [3.0, 7.0, 1.0]], hs_m=4.243, tp_s=tp)
    for tp in (10.7, 11.83, 13.0):
        sea(spectrum="ochi-hubble", tp_s=tp)
    for tp in (9.45, 10.6, 13.1):
        with pytest.raises(
            InputError, match=r"sea_state\.tp_s .*11\.83 s .*Set it to 11\.83, or give systems"
        ):
            sea(spectrum="ochi-hubble", tp_s=tp)


# Directions


def test_spread_directions_surround_the_heading() -> None:
    spread = sea(spreading=10.0, direction_deg=-40.0)
    assert spread.direction_deg == -40.0
    w = waves(spread)
    assert np.ptp(w.angle) > 1.0
    assert np.abs(np.mean(w.angle)) < 0.1
    by_frequency = spread.component_direction_deg - spread.direction_deg
    kept = np.isin(spread.omega_rad_s, w.omega)
    assert w.angle == pytest.approx(np.deg2rad(by_frequency[kept]), abs=1e-12)


def test_narrow_spreading_tends_to_long_crests() -> None:
    assert np.abs(waves(sea(spreading=1000.0)).angle).max() < 0.2
    assert np.all(waves(sea()).angle == 0.0)


def test_components_of_several_directions(listed) -> None:
    """Each keeps its direction; the heading is the mean weighted by energy; x along it."""
    case = listed([0.5, 0.6], [1.0, 1.0], [0.0, 0.0], direction=[10.0, 20.0])
    state = build_sea_state(case)
    assert state.component_direction_deg.tolist() == [10.0, 20.0]
    assert state.direction_deg == pytest.approx(15.0, abs=1e-12)
    assert waves(state).angle == pytest.approx(np.deg2rad([-5.0, 5.0]), abs=1e-14)
    unequal = build_sea_state(listed([0.5, 0.6], [2.0, 1.0], [0.0, 0.0], direction=[0.0, 90.0]))
    assert unequal.direction_deg == pytest.approx(math.degrees(math.atan2(1.0, 4.0)), rel=1e-13)


def test_one_direction_given_in_two_ways_is_one(listed) -> None:
    same = build_sea_state(listed([0.5, 0.6], [1.0, 1.0], [0.0, 0.0], direction=[-90.0, 270.0]))
    assert same.direction_deg == -90.0
    assert np.all(waves(same).angle == 0.0)


def test_round_off_in_a_direction_is_no_second_direction(listed) -> None:
    """-89.7 and 270.3 degrees differ in their last digit only."""
    same = build_sea_state(listed([0.5, 0.6], [1.0, 2.0], [0.0, 0.0], direction=[-89.7, 270.3]))
    assert same.direction_deg == 270.3
    assert np.all(waves(same).angle == 0.0)


def test_components_without_energy_have_no_say_in_the_heading(listed) -> None:
    state = build_sea_state(listed([0.5, 0.6], [1.0, 0.0], [0.0, 0.0], direction=[33.3, 20.0]))
    assert state.direction_deg == 33.3
    assert waves(state).angle.tolist() == [0.0]


def test_opposite_waves_head_with_the_largest() -> None:
    assert mean_direction(np.array([10.0, 190.0]), np.array([1.0, 1.0])) == 10.0
    assert mean_direction(np.array([10.0, 190.0]), np.array([1.0, 3.0])) == pytest.approx(-170.0)


def test_equal_frequencies_merge_within_a_direction_only(listed) -> None:
    case = listed(
        [0.7, 0.7, 0.7, 0.6], [1.0, 0.5, 2.0, 0.3], [0.0, 0.0, 0.0, 1.0], direction=[-89.7, 10.0, 270.3, 10.0]
    )
    w = waves(build_sea_state(case))
    assert w.omega.tolist() == [0.6, 0.7, 0.7]
    assert np.abs(w.amplitude) == pytest.approx([0.3, 3.0, 0.5], rel=1e-14)


# Focus


@pytest.mark.parametrize("spreading", [None, 10.0])
@pytest.mark.parametrize("background", [True, False])
@pytest.mark.parametrize("order", [1, 2])
def test_crest_through_the_field(order: int, background: bool, spreading: float | None) -> None:
    """The first order has the crest at a sample and is lower a step before and after; order 2 adds to it."""
    focus = {"crest_m": 6.0, "time_s": 120.0, "place_m": [15.0, 5.0], "background": background}
    sea_state = {"focus": focus, "direction_deg": 70.0, "spreading": spreading}
    case = parse_case({"sea_state": sea_state, "wave": {"order": order}})
    state = build_sea_state(case)
    place = Frame(state.direction_deg).place(np.array([[15.0, 5.0]]))
    first, second = make_field(case, state).elevation(place)
    assert first[0, 1200] == pytest.approx(6.0, rel=1e-12)
    assert first[0, 1199] < 6.0
    assert first[0, 1201] < 6.0
    assert (second[0, 1200] > 0.3) == (order == 2)


def test_focus_leaves_the_frequencies_and_the_far_sea() -> None:
    plain, focused = sea(), sea(focus={"crest_m": 8.0, "time_s": 300.0})
    assert np.array_equal(plain.omega_rad_s, focused.omega_rad_s)
    t = np.arange(0.0, 600.0, 0.5)
    one, other = (np.cos(np.outer(t, s.omega_rad_s) - s.phase_rad) @ s.amplitude_m for s in (plain, focused))
    far = np.abs(t - 300.0) > 100.0
    assert np.abs(one - other)[far].max() < 0.05 * np.abs(one - other).max()


REFUSED = [
    ({"focus": {"crest_m": 5.0, "time_s": 600.0}}, "sea_state.focus.time_s", "after the last sample"),
    ({"focus": {"crest_m": 31.0, "time_s": 6.0}}, "sea_state.focus.crest_m", "of the water depth"),
    (
        {"cutoff_over_peak": 1.005, "cutin_over_peak": 0.999, "tp_s": 9.45},
        "time.n",
        "no component",
    ),
    ({"spectrum": "torsethaugen", "gamma": 2.0}, "sea_state.gamma", "jonswap"),
    ({"systems": [[5, 12, 3], [3, 7, 1]]}, "sea_state.systems", "ochi-hubble"),
    (
        {"spectrum": "ochi-hubble", "systems": [[5, 12, 3], [5, 7, 1]]},
        "sea_state.hs_m",
        "7.071 m",
    ),
]


@pytest.mark.parametrize(("given", "field", "limit"), REFUSED)
def test_refused_sea_states(given: dict[str, Any], field: str, limit: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_case({"sea_state": given})
    assert caught.value.field == field
    assert limit in caught.value.limit


def test_a_cutin_above_the_cutoff_is_refused() -> None:
    """Only steepness can bring the cut-off that low: less gravity, the same steepness limit."""
    state = parse_case({"sea_state": {"cutoff": "steepness", "cutin_over_peak": 0.9}}).sea_state
    assert state is not None
    with pytest.raises(InputError, match=r"sea_state\.cutin_over_peak .*above the cut-off"):
        state.component_numbers(duration=600.0, gravity=0.1)


def test_a_band_without_energy_is_refused() -> None:
    """The components of a record shorter than the waves may all lie in the tail of a narrow peak."""
    narrow = {"spectrum": "ochi-hubble", "systems": [[6, 10, 20], [1, 10, 20]], "hs_m": 6.08, "tp_s": 10.0}
    short = parse_case({"sea_state": narrow | {"cutoff_over_peak": 20.0}, "time": {"dt_s": 0.1, "n": 10}})
    with pytest.raises(InputError, match=r"cutoff_over_peak .*of the energy"):
        build_sea_state(short)


#: Seas of which the band holds less than 0.75, and what it holds.
TAILLESS = [
    ({"spectrum": "pierson-moskowitz", "cutoff_over_peak": 1.4}, "0.72"),
    ({"spectrum": "torsethaugen", "hs_m": 1.0, "tp_s": 25.0}, "0.51"),
]


@pytest.mark.parametrize(("given", "share"), TAILLESS)
def test_a_band_that_leaves_much_of_the_sea_out_is_refused(given: dict[str, Any], share: str) -> None:
    """Scaled to Hs, what is left would be another sea; a longer record does not change it."""
    for n in (600, 6000):
        case = parse_case({"sea_state": given, "time": {"n": n}})
        with pytest.raises(InputError, match=rf"sea_state\.cutoff_over_peak .*leaves {share} of the energy"):
            build_sea_state(case)
    sea(**given, scale="formula")
    sea(**given, cutin_over_peak=0.1)  # a part is asked for


def test_usual_bands_are_allowed() -> None:
    """1.5 fp and the steepness cut-off, of the steepest seas too."""
    for name in ("jonswap", "pierson-moskowitz"):
        sea(spectrum=name, gamma=1.0 if name == "jonswap" else None, cutoff_over_peak=1.5)
        sea(spectrum=name, hs_m=6.0, tp_s=5.2, cutoff="steepness")


# Sources


def test_source_and_field_of_every_sea(listed) -> None:
    assert sea().source == "sea_state"
    assert build_sea_state(listed(1.0, 1.0, 0.0)).source == "components"
    regular = parse_case({"regular": {"theory": "airy", "height_m": 3.0, "period_s": 9.0}})
    state = build_sea_state(regular)
    assert state.source == "regular"
    assert state.hs_m == state.tp_s == 0.0
    assert sea_field(regular) == "regular.height_m"
    assert sea_field(parse_case({})) == "sea_state.hs_m"
    assert sea_field(listed(1.0, 1.0, 0.0)) == "components.amplitude_m"


@pytest.mark.parametrize(
    "given",
    [{"spectrum_file": {"path": "a.nc"}}, {"measured": {"path": "a.csv", "cutoff_rad_s": 2.0}}],
    ids=lambda given: next(iter(given)),
)
def test_a_sea_in_a_file_is_refused_before_it_is_read(given: dict[str, Any]) -> None:
    case = parse_case(given)
    field = f"{next(iter(given))}.path"
    assert sea_field(case) == field
    with pytest.raises(InputError, match="not read here") as caught:
        build_sea_state(case)
    assert caught.value.field == field
