"""Where a case lies among theories and loads, and what it is told."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.structure import load_structure
from owt_wave_node.core.regime import SeaRegime, orbital_speed, regime_warnings, sea_regime
from owt_wave_node.core.sea import build_sea_state
from owt_wave_node.core.wave_theory import breaking_height, harmonics, linear_wavenumber, regular_regime


def regime(**case: Any) -> SeaRegime:
    config = parse_case(case)
    return sea_regime(config, build_sea_state(config), load_structure("oc4"))


@pytest.mark.parametrize(
    ("height", "period", "depth", "theory"),
    [
        (0.5, 10.0, 50.0, "airy"),
        (6.0, 10.0, 50.0, "stokes 2"),
        (12.0, 10.0, 50.0, "stokes 3"),
        (16.0, 10.0, 50.0, "stokes 5"),
        (20.0, 10.0, 50.0, "stream function"),
        (21.0, 10.0, 50.0, "breaking"),
        (2.0, 15.0, 5.0, "stream function"),
        (3.95, 15.0, 5.0, "breaking"),
    ],
)
def test_theory_of_a_regular_wave(height: float, period: float, depth: float, theory: str) -> None:
    assert regular_regime(height=height, period=period, depth=depth, gravity=9.81).theory == theory


def test_theories_come_in_order_as_the_wave_grows() -> None:
    """Whatever the depth, a higher wave never asks for less."""
    from owt_wave_node.core.wave_theory import THEORIES

    for depth in (2.0, 10.0, 30.0, 100.0, 1000.0):
        ranks = [
            THEORIES.index(regular_regime(height=h, period=9.0, depth=depth, gravity=9.81).theory)
            for h in np.geomspace(1e-6, 40.0, 200)
        ]
        assert ranks == sorted(ranks)
        assert ranks[0] == 0
        assert ranks[-1] == len(THEORIES) - 1


def test_harmonics_are_those_of_raschii() -> None:
    """Fenton's coefficients as an independent library has them."""
    raschii = pytest.importorskip("raschii.wave_stokes")
    for kd in (0.5, 1.0, 3.0, 20.0):
        data = raschii.stokes_coefficients(kd, 5)
        expected = [data["B22"], -data["B31"], data["B44"], data["B55"]]
        np.testing.assert_allclose(harmonics(kd, 2.0 / kd, 1.0), expected, rtol=1e-9)


def test_extremes_stay_finite() -> None:
    for period, depth in ((0.1, 5000.0), (6e4, 1e-3), (3.0, 5000.0)):
        k = linear_wavenumber(period, depth=depth, gravity=9.81)
        assert np.isfinite(harmonics(k, 1e-150, depth)).all()
        found = regular_regime(height=1e-150, period=period, depth=depth, gravity=9.81)
        assert found.theory == "airy"
        assert math.isfinite(orbital_speed(found, -depth))
        assert breaking_height(k, depth) > 0.0


def test_the_default_case_is_told_of_its_cutoff_only() -> None:
    found = regime()
    assert len(found.warnings) == 1
    assert "2.66 rad/s is above sqrt(2 g/Hs) = 1.81 rad/s" in found.warnings[0]
    assert "sea_state.cutoff to steepness" in found.warnings[0]
    assert regime(sea_state={"cutoff": "steepness"}).warnings == ()


def test_the_cutoff_matters_to_first_order_where_short_components_grow_in_the_crest() -> None:
    """Taylor and no stretching carry them up; constant and Wheeler do not; without them nothing is said."""
    for stretching, lines in (("taylor", 1), ("none", 1), ("constant", 0), ("wheeler", 0)):
        found = regime(wave={"order": 1, "stretching": stretching}).warnings
        assert sum("1.81 rad/s" in line and "first order" in line for line in found) == len(found) == lines
        low = {"sea_state": {"cutoff": "steepness"}, "wave": {"order": 1, "stretching": stretching}}
        assert regime(**low).warnings == ()


def test_a_focused_crest_is_the_largest_wave() -> None:
    """Twenty metres in a sea of two break, which is said; a low crest changes nothing."""
    sea = {"hs_m": 2.0, "tp_s": 10.0, "cutoff": "steepness"}
    for background in (True, False):
        found = regime(
            sea_state={**sea, "focus": {"crest_m": 20.0, "time_s": 300.0, "background": background}}
        )
        assert 25.0 < found.largest.height_m < 40.0
        assert [line for line in found.warnings if "focused crest" in line and "breaking height" in line]
        steep = regime(
            sea_state={**sea, "focus": {"crest_m": 11.0, "time_s": 300.0, "background": background}}
        )
        assert [line for line in steep.warnings if "focused crest" in line and "underrates" in line]
    small = regime(sea_state={**sea, "focus": {"crest_m": 0.5, "time_s": 300.0, "background": False}})
    assert small.largest.height_m < 3.0
    assert small.warnings == ()


def test_the_focused_wave_is_that_of_the_field() -> None:
    """Crest to trough beside it as the first order has them at the place of the focus."""
    from owt_wave_node.core.field import Field
    from owt_wave_node.core.route import make_field
    from owt_wave_node.core.sea import Frame

    focus = {"crest_m": 9.0, "time_s": 300.0, "place_m": [12.0, -30.0]}
    case = parse_case({"sea_state": {"hs_m": 3.0, "tp_s": 10.0, "focus": focus}})
    sea = build_sea_state(case)
    field: Field = make_field(case, sea)
    eta = field.elevation(Frame(sea.direction_deg).place(np.array([[12.0, -30.0, 0.0]])))[0][0]
    assert eta[3000] == pytest.approx(9.0, rel=1e-9)
    height = eta[3000] - eta[2900:3101].min()
    # 128 instants over two periods lie up to 0.08 s off the trough: 0.2 % of it
    assert sea_regime(case, sea).largest.height_m == pytest.approx(height, rel=2e-3)


def test_long_components_are_named() -> None:
    """A wave of 0.3 m and twenty minutes has second order of 10 m; a hundredth of it has a harmless one."""

    def of(amplitude: float, order: int = 2) -> tuple[str, ...]:
        listed = {"omega_rad_s": [0.005, 0.6], "amplitude_m": [amplitude, 1.0], "phase_rad": [0.0, 0.0]}
        return regime(components=listed, wave={"order": order}).warnings

    assert len(of(0.3)) == 1
    assert "component at 0.005 rad/s" in of(0.3)[0]
    assert "cut-in" in of(0.3)[0]
    assert of(0.001) == of(0.3, order=1) == ()


def test_long_components_count_together() -> None:
    """A hundred that each stay below the limit fail as the one of their energy does."""
    omega = np.linspace(0.01, 0.02, 100)
    for amplitude, lines in ((0.02, 1), (2e-4, 0)):
        listed = {
            "omega_rad_s": [*omega.tolist(), 0.6],
            "amplitude_m": [*[amplitude] * 100, 1.0],
            "phase_rad": [0.0] * 101,
        }
        assert len(regime(components=listed).warnings) == lines


@pytest.mark.parametrize(
    ("case", "word"),
    [
        ({"sea_state": {"hs_m": 0.5, "tp_s": 1.9}, "wave": {"order": 1}}, "maccamy-fuchs"),
        ({"sea_state": {"hs_m": 3.0, "tp_s": 4.5}}, "limit of sea states"),
        ({"sea_state": {"hs_m": 6.0, "tp_s": 16.0}, "water_depth_m": 15.0}, "Ursell"),
        ({"sea_state": {"hs_m": 3.0, "tp_s": 4.5}}, "breaking height"),
        ({"regular": {"height_m": 12.0, "period_s": 10.0, "theory": "airy"}}, "stokes 3 theory"),
        ({"regular": {"height_m": 20.0, "period_s": 10.0, "theory": "stokes"}}, "stream function theory"),
        (
            {"components": {"omega_rad_s": [0.7, 3.0], "amplitude_m": [2.0, 0.1], "phase_rad": [0, 0]}},
            "Leave out",
        ),
    ],
)
def test_each_warning(case: dict[str, Any], word: str) -> None:
    found = [line for line in regime(**case).warnings if word in line]
    assert len(found) == 1
    assert "\n" not in found[0]
    assert any(character.isdigit() for character in found[0])


def test_warnings_go_when_their_cause_goes() -> None:
    short = {"sea_state": {"hs_m": 0.5, "tp_s": 1.9}, "wave": {"order": 1}}
    assert not [
        line
        for line in regime(**short, morison={"diffraction": "maccamy-fuchs"}).warnings
        if "maccamy-fuchs" in line
    ]
    assert regime(regular={"height_m": 12.0, "period_s": 10.0, "theory": "stream"}).warnings == ()
    assert regime(regular={"height_m": 12.0, "period_s": 10.0, "theory": "stokes"}).warnings == ()


def test_a_flat_sea_is_not_warned_of() -> None:
    flat = parse_case({"components": {"omega_rad_s": [1.0], "amplitude_m": [0.0], "phase_rad": [0.0]}})
    assert regime_warnings(flat, build_sea_state(flat)) == ()


def test_members_of_the_jacket() -> None:
    """Eight piles (two diameters deep at the mudline), 24 leg tubes and 48 braces reach the water."""
    members = regime().members
    assert [round(m.diameter_m, 3) for m in members] == [2.082, 1.2, 0.8]
    assert all(m.level_m[0] <= 0.0 and m.level_m[1] >= -50.0 for m in members)
    legs = members[1]
    assert legs.level_m[0] == 0.0
    assert legs.load == "inertia and drag"
    assert legs.diffraction == pytest.approx(math.pi / legs.length_over_diameter)
    # KC and Re share their velocity: Re / KC = D^2 / (nu T)
    assert legs.reynolds[0] / legs.keulegan_carpenter[0] == pytest.approx(
        1.2**2 / (1.19e-6 * 9.45), rel=1e-12
    )
    grown = regime(morison={"marine_growth": True}).members
    growth = load_structure("oc4").marine_growth
    assert growth is not None
    assert max(m.diameter_m for m in grown) > 1.2 + 2.0 * growth.thickness_m - 1e-9


def test_a_current_adds_to_the_orbital_velocity() -> None:
    still, moving = regime(), regime(current={"profile": "uniform", "speed_m_s": 1.0})
    for a, b in zip(still.members, moving.members, strict=True):
        assert b.keulegan_carpenter[0] - a.keulegan_carpenter[0] == pytest.approx(
            9.45 / a.diameter_m, rel=1e-9
        )


def test_load_regimes() -> None:
    """Inertia in small waves, drag in high ones, diffraction in short ones (figure 2.9)."""
    of = {case: regime(sea_state={"hs_m": case[0], "tp_s": case[1]}, wave={"order": 1}).members[-1].load
          for case in ((0.2, 6.0), (6.0, 9.45), (14.0, 16.0), (0.2, 1.5))}  # fmt: skip
    assert of == {
        (0.2, 6.0): "inertia",
        (6.0, 9.45): "inertia and drag",
        (14.0, 16.0): "drag",
        (0.2, 1.5): "diffraction",
    }


def test_coefficients_by_level() -> None:
    """Drag over inertia with the coefficients at still water; none without inertia."""
    plain, table = regime(), regime(morison={"cd": [[-20.0, 0.7], [0.0, 2.0]]})
    assert plain.members[1].drag_over_inertia is not None
    assert table.members[1].drag_over_inertia == pytest.approx(2.0 * plain.members[1].drag_over_inertia)
    assert regime(morison={"cm": 0.0}).members[1].drag_over_inertia is None


def test_listed_components_and_regular_waves_are_classified_too() -> None:
    listed = regime(components={"omega_rad_s": [0.6], "amplitude_m": [2.0], "phase_rad": [0.0]})
    assert listed.wave.height_m == pytest.approx(4.0 * 2.0 / math.sqrt(2.0))
    assert listed.wave.period_s == pytest.approx(2.0 * math.pi / 0.6)
    regular = regime(regular={"height_m": 4.0, "period_s": 9.0, "theory": "airy"})
    assert (regular.wave.height_m, regular.largest.height_m) == (4.0, 4.0)
    assert regular.wave.period_s == pytest.approx(9.0)
