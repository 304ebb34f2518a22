"""S-N curves and Palmgren-Miner against the printed check values and closed forms."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_postproc.core.rainflow import rainflow
from owt_postproc.core.sn import SNCurve, cycles_to_failure, miner_damage, sn_curve, sn_curves

VALUES = json.loads((Path(__file__).parent / "data" / "fatigue_values.json").read_text())
SN = VALUES["sn_dnv_rp_c203"]


def single(m: float) -> SNCurve:
    return SNCurve("single", (m, m), (12.0, 12.0), 1e7)


def first_slope_only(name: str) -> SNCurve:
    """Wrong: the second slope is ignored."""
    curve = sn_curve(name)
    return SNCurve("wrong", (curve.m[0],) * 2, (curve.log10_a[0],) * 2, curve.knee_cycles)


def check_air(curve):
    table = {float(k.split("_")[0]): v for k, v in SN["check_cycles_D_air"].items()}
    found = cycles_to_failure(curve, 1e6 * np.array(list(table)))
    np.testing.assert_allclose(found, list(table.values()), rtol=1e-4)


def test_check_values_in_air():
    check_air(sn_curve("D_air"))
    check_air(sn_curve("T_air"))


def test_check_values_would_notice_a_lost_second_slope():
    with pytest.raises(AssertionError):
        check_air(first_slope_only("D_air"))


def test_check_value_with_cathodic_protection():
    expected = SN["check_cycles_D_cp"]["100_MPa"]
    found = cycles_to_failure(sn_curve("D_cathodic_protection"), np.array([100e6]))
    np.testing.assert_allclose(found, [expected], rtol=1e-4)


@pytest.mark.parametrize("name", ["D_air", "T_air", "D_cathodic_protection", "T_cathodic_protection"])
def test_table_holds_the_quoted_constants(name):
    curve = sn_curve(name)
    quoted = SN["D_and_T_air" if name.endswith("air") else "D_and_T_seawater_cathodic_protection"]
    assert list(curve.m) == quoted["m"]
    assert list(curve.log10_a) == quoted["log10_a"]
    assert curve.knee_cycles == quoted["knee_cycles"]
    assert curve.thickness_exponent == SN["thickness_exponent"][name[0]]
    assert "DNV-RP-C203" in curve.edition


@pytest.mark.parametrize("name", sorted(sn_curves()))
def test_slopes_meet_at_the_knee(name):
    curve = sn_curve(name)
    knee = curve.knee_stress_pa
    above, below = cycles_to_failure(curve, np.array([knee, knee * (1 - 1e-9)]))
    assert above == pytest.approx(curve.knee_cycles, rel=1e-9)
    assert below == pytest.approx(above, rel=2e-3)  # the printed constants have three decimals


def test_unknown_curve_lists_the_known_ones():
    with pytest.raises(InputError, match=r"fatigue\.sn_curve = 'X'.*D_air, D_cathodic_protection, .*T_air"):
        sn_curve("X")


def test_zero_range_never_fails_and_negative_is_refused():
    assert cycles_to_failure(sn_curve("D_air"), np.zeros(1))[0] == np.inf
    with pytest.raises(InputError, match="stress_range"):
        cycles_to_failure(sn_curve("D_air"), np.array([-1.0]))


@pytest.mark.parametrize("field", ["m", "log10_a"])
def test_impossible_curve_is_refused(field):
    values = {"m": (3.0, 5.0), "log10_a": (12.0, 15.0), field: (3.0, np.nan)}
    with pytest.raises(InputError, match=rf"bad\.{field}"):
        SNCurve("bad", knee_cycles=1e7, **values)


@pytest.mark.parametrize("m", [3.0, 4.0, 5.0])
@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_damage_scales_with_the_power_of_the_slope(m, scale):
    series = np.cumsum(np.random.default_rng(2).normal(size=2000)) * 1e6

    def damage(factor):
        ranges, _, counts = rainflow(factor * series)
        return miner_damage(single(m), ranges, counts)

    assert damage(scale) == pytest.approx(scale**m * damage(1.0), rel=1e-10)
    with pytest.raises(AssertionError):  # the check can fail: another slope has another power
        assert damage(scale) == pytest.approx(scale ** (m + 1) * damage(1.0), rel=1e-10)


@pytest.mark.parametrize("amplitude", [10e6, 40e6])
def test_sine_in_closed_form(amplitude):
    cycles, curve = 37, sn_curve("D_air")
    t = np.arange(cycles * 64 + 1) / 64
    ranges, _, counts = rainflow(amplitude * np.cos(2 * np.pi * t))
    s = 2 * amplitude / 1e6
    n = 10**12.164 / s**3 if s > 52.6 else 10**15.606 / s**5
    assert counts.sum() == cycles
    assert miner_damage(curve, ranges, counts) == pytest.approx(cycles / n, rel=1e-10)


def test_unsigned_stress_loses_range():
    bending = 60e6 * np.cos(2 * np.pi * np.arange(100 * 64 + 1) / 64)
    table = VALUES["signed_versus_unsigned"]["alternating_bending_zero_mean"]
    for m in (3, 5):
        damage = []
        for series in (np.abs(bending), bending):
            ranges, _, counts = rainflow(series)
            damage.append(miner_damage(single(float(m)), ranges, counts))
        expected = table["damage_ratio_unsigned_over_signed"][f"m{m}"]
        assert damage[0] / damage[1] == pytest.approx(expected, abs=0.01)
