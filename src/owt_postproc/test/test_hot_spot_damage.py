"""Damage at hot spots: closed forms, scaling, thickness, signed stress, splits and threads."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.contracts import StressBlock
from owt_model.fatigue_config import Fatigue
from owt_model.frame import Frame
from owt_postproc.core import efthymiou as eq
from owt_postproc.core.hot_spots import build_hot_spots
from owt_postproc.core.sn import sn_curve
from owt_postproc.core.stage import build_fatigue_model, final, initial_state, step
from tubular import BRACE, CHORDS, WALL_T, O, brace, end_of, frame_of, k_frame, shape


def sine_damage(case: dict, frame: Frame, amplitude: dict[str, float], cycles: int = 20) -> tuple:
    """Result of a sine in some channels of every end of the brace."""
    parsed = parse_case(case)
    made = build_hot_spots(frame, parsed.fatigue)
    model = build_fatigue_model(parsed, made)
    wave = np.sin(2 * np.pi * np.arange(cycles * 40 + 1) / 40)
    given = {
        name: np.zeros((len(wave), made.n_ends)) for name in ("axial", "bending_y", "bending_z", "von_mises")
    }
    end = end_of(frame, "B")
    for name, value in amplitude.items():
        given[name][:, end] = value * wave
    given["von_mises"] = np.abs(given["axial"]) + np.hypot(given["bending_y"], given["bending_z"])
    state, _ = step(model, initial_state(model), StressBlock(0, 0, model.dt, True, **given))
    return final(model, state), made, end


def test_damage_of_a_sine_in_closed_form_and_scaling():
    """19.5 cycles of 2 x SCF x amplitude, and half a cycle of half the range at either end: 19.5 + 2^-m.

    c times the stress is c^m times the damage on one slope.
    """
    frame = frame_of(CHORDS | {"B": brace(90.0)})
    case = {"fatigue": {"sn_curve": "D_air", "chord_effect": "length", "chord_fixity": 0.5}}
    one, made, end = sine_damage(case, frame, {"axial": 20e6})
    saddle = made.name.index("B:J chord 90")
    scf = eq.t5(shape(90.0), 0.5)
    curve = sn_curve("D_air")
    stress_range = 2.0 * 20.0 * scf
    factor = (WALL_T / curve.reference_thickness_m) ** curve.thickness_exponent
    cycles = 10.0 ** curve.log10_a[0] * (stress_range * factor) ** -curve.m[0]
    assert one.damage[saddle] == pytest.approx((19.5 + 2.0 ** -curve.m[0]) / cycles, rel=1e-9)
    assert int(one.worst_spot[end]) == int(np.argmax(one.damage))
    two, _, _ = sine_damage(case, frame, {"axial": 40e6})
    assert two.damage[saddle] == pytest.approx(one.damage[saddle] * 2.0 ** curve.m[0], rel=1e-9)


def test_thin_walls_have_no_thickness_effect():
    """Below the reference thickness a wall counts as the reference; thicker ones are weaker."""
    curve = sn_curve("D_air")
    thin, thick = curve.reference_thickness_m * 0.5, curve.reference_thickness_m * 2.0
    found = {}
    for wall in (thin, curve.reference_thickness_m, thick):
        frame = frame_of({"B": (O, (0.0, 0.0, 10.0))}, {"B": (BRACE, wall)})
        for effect in (True, False):
            case = {"fatigue": {"sn_curve": "D_air", "hot_spots": "nominal", "thickness_effect": effect}}
            result, _, _ = sine_damage(case, frame, {"axial": 100e6})
            found[wall, effect] = result.damage.max()
    assert found[thin, True] == found[thin, False] == found[curve.reference_thickness_m, True]
    ratio = found[thick, True] / found[thick, False]
    assert ratio == pytest.approx(2.0 ** (curve.thickness_exponent * curve.m[0]), rel=1e-9)


@pytest.mark.parametrize(("amplitude", "slope", "ratio"), [(100e6, 3.0, 0.25), (5e6, 5.0, 0.07)])
def test_unsigned_stress_loses_damage(amplitude, slope, ratio):
    """Alternating bending: the unsigned stress has half the range at twice the rate, 2 (1/2)^m of the damage.

    The acceptance value for m = 5, 0.07, is 2/32 = 0.0625 rounded up: the tolerance covers it.
    """
    frame = frame_of(CHORDS | {"B": brace(90.0)})
    case = {"fatigue": {"sn_curve": "D_air", "hot_spots": "nominal", "thickness_effect": False}}
    signed, made, end = sine_damage(case, frame, {"bending_z": amplitude}, cycles=200)
    wave = amplitude * np.sin(2 * np.pi * np.arange(200 * 40 + 1) / 40)
    model = build_fatigue_model(parse_case(case), made)
    zero = np.zeros((len(wave), made.n_ends))
    folded = zero.copy()
    folded[:, end] = np.abs(wave)
    block = StressBlock(0, 0, model.dt, True, folded, zero, zero, folded)
    unsigned = final(model, step(model, initial_state(model), block)[0])
    found = unsigned.damage.max() / signed.damage.max()
    assert found == pytest.approx(2.0 * 0.5**slope, rel=0.02)
    assert found == pytest.approx(ratio, abs=0.01)


def random_blocks(n_ends: int, cuts: list[int]) -> list[StressBlock]:
    rng = np.random.default_rng(3)
    series = [np.cumsum(rng.normal(size=(900, n_ends)), axis=0) * 1e6 for _ in range(3)]
    series.append(np.abs(series[0]))
    edges = [0, *cuts, 900]
    return [
        StressBlock(i, a, 0.02, b == 900, *(np.ascontiguousarray(x[a:b]) for x in series))
        for i, (a, b) in enumerate(pairwise(edges))
    ]


@pytest.mark.parametrize("threads", ["1", "2", "5"])
@pytest.mark.parametrize("cuts", [[1, 400], list(range(7, 900, 7))])
def test_splits_and_threads_change_no_bit(monkeypatch, threads, cuts):
    frame = k_frame()
    model = build_fatigue_model(parse_case({}), build_hot_spots(frame, Fatigue()))
    whole, _ = step(model, initial_state(model), random_blocks(frame.n_ends, [])[0])
    monkeypatch.setenv("OWT_THREADS", threads)
    monkeypatch.setattr("owt_postproc.core.stage.WORTH_A_THREAD", 1)
    state = initial_state(model)
    for block in random_blocks(frame.n_ends, cuts):
        state, running = step(model, state, block)
    one, two = final(model, whole), final(model, state)
    for name in ("damage", "cycles", "max_range", "histogram", "total_stress"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    np.testing.assert_array_equal(running.damage, two.end_damage)
    worst = two.worst_spot
    assert [("wall", "chord", "brace")[i] for i in running.side] == [two.hot_spots.side[i] for i in worst]


def test_stress_of_a_spot_is_what_is_counted():
    frame = k_frame()
    model = build_fatigue_model(parse_case({}), build_hot_spots(frame, Fatigue()))
    (block,) = random_blocks(frame.n_ends, [])
    result = final(model, step(model, initial_state(model), block)[0])
    for spot in (0, 20, result.hot_spots.n_spots - 1, int(np.argmax(result.damage))):
        series = result.hot_spots.stress(spot, block.axial, block.bending_y, block.bending_z)
        assert result.max_range[spot] == pytest.approx(np.ptp(series), rel=1e-12)
