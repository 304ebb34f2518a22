"""The table of S-N curves, tables of a user, and the thickness effect."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_postproc.core.rainflow import rainflow
from owt_postproc.core.sn import SNCurve, cycles_to_failure, miner_damage, sn_curve, sn_curves
from owt_postproc.kernels import fatigue

CLASSES = ["B1", "B2", "C", "C1", "C2", "D", "E", "F", "F1", "F3", "G", "W1", "W2", "W3", "T"]
ENVIRONMENTS = ["air", "cathodic_protection", "free_corrosion"]
#: Stress range in MPa at 1e7 cycles in air, as the standard's tables print it beside the constants.
LIMIT_AT_1E7 = {
    "B1": 106.97, "B2": 93.59, "C": 73.10, "C1": 65.50, "C2": 58.48, "D": 52.63, "E": 46.78, "F": 41.52,
    "F1": 36.84, "F3": 32.75, "G": 29.24, "W1": 26.32, "W2": 23.39, "W3": 21.05,
}  # fmt: skip


def test_every_class_in_every_environment():
    assert set(sn_curves()) == {f"{name}_{where}" for name in CLASSES for where in ENVIRONMENTS}


@pytest.mark.parametrize("name", sorted(sn_curves()))
def test_every_curve_names_its_edition_and_source(name):
    curve = sn_curve(name)
    assert "DNV-RP-C203" in curve.edition
    assert "check against your licensed copy" in curve.source
    assert curve.description
    assert curve.reference_thickness_m == 0.025
    assert ("not" in curve.note) == name.startswith("T_")  # what is not confirmed is said


@pytest.mark.parametrize("name", list(LIMIT_AT_1E7))
def test_limit_at_ten_million_cycles(name):
    """A column of the table that is no input here: a misprint of slope or intercept shows."""
    limit = 1e6 * LIMIT_AT_1E7[name]
    for where in ("air", "cathodic_protection"):
        # three decimals of log10 a are 0.12 % of N; with protection the second slope holds there
        assert cycles_to_failure(sn_curve(f"{name}_{where}"), np.array([limit]))[0] == pytest.approx(
            1e7, rel=3e-3
        )


def test_limit_would_notice_two_digits_exchanged():
    wrong = SNCurve("wrong", (3.0, 3.0), (12.614, 12.614), 1e7)
    assert cycles_to_failure(wrong, np.array([52.63e6]))[0] != pytest.approx(1e7, rel=3e-3)


def test_protection_costs_a_factor_of_2_5_and_no_protection_3():
    """Design lives over those in air of one class, above both knees: 10^0.4 and 10^0.477."""
    stress = np.array([200e6])
    for name in CLASSES[2:]:
        air, protected, free = (
            cycles_to_failure(sn_curve(f"{name}_{where}"), stress)[0] for where in ENVIRONMENTS
        )
        assert air / protected == pytest.approx(2.5, rel=6e-3)
        assert air / free == pytest.approx(3.0, rel=6e-3)


def test_free_corrosion_has_one_slope_and_no_limit():
    for name in CLASSES:
        curve = sn_curve(f"{name}_free_corrosion")
        assert curve.has_one_slope
        assert curve.m == (3.0, 3.0)
        low, high = cycles_to_failure(curve, np.array([1e6, 10e6]))
        assert low / high == pytest.approx(1e3)


# Thickness


def test_no_thickness_effect_below_the_reference():
    curve = sn_curve("D_air")
    for thickness in (0.001, 0.0249, 0.025):
        assert curve.thickness_factor(thickness) == 1.0
        np.testing.assert_array_equal(curve.coefficients_for(thickness), curve.coefficients)


@pytest.mark.parametrize("name", ["D_air", "F_cathodic_protection", "T_free_corrosion", "B1_air"])
def test_thickness_is_a_factor_on_stress(name):
    curve, thickness = sn_curve(name), 0.05
    factor = 2.0**curve.thickness_exponent
    stress = np.geomspace(1e6, 500e6, 40)
    found = cycles_to_failure(curve, stress, thickness_m=thickness)
    np.testing.assert_allclose(found, cycles_to_failure(curve, factor * stress), rtol=1e-12)
    if curve.thickness_exponent:
        assert (found < cycles_to_failure(curve, stress)).all()


def test_thickness_would_notice_an_effect_on_thin_walls():
    def unlimited(curve, thickness):
        return (thickness / curve.reference_thickness_m) ** curve.thickness_exponent

    assert unlimited(sn_curve("D_air"), 0.0125) != sn_curve("D_air").thickness_factor(0.0125)


def test_worked_value_in_a_thick_wall():
    """D in air, 100 MPa, 50 mm: N = 10^12.164 / (100 x 2^0.2)^3 = 1.4588e6 / 2^0.6."""
    found = cycles_to_failure(sn_curve("D_air"), np.array([100e6]), thickness_m=0.05)
    assert found[0] == pytest.approx(1458800.0 / 2.0**0.6, rel=1e-4)


def test_kernel_and_core_have_the_same_damage_in_a_thick_wall():
    curve = sn_curve("T_cathodic_protection")
    ranges, _, counts = rainflow(np.random.default_rng(3).standard_normal(500) * 60e6)
    coefficients = curve.coefficients_for(0.06)
    found = sum(fatigue._damage(r, 2.0 * c, coefficients) for r, c in zip(ranges, counts, strict=True))
    assert found == pytest.approx(miner_damage(curve, ranges, counts, thickness_m=0.06), rel=1e-12)


@pytest.mark.parametrize("thickness", [0.0, -0.02, np.nan, np.inf])
def test_impossible_thickness_is_refused(thickness):
    with pytest.raises(InputError, match="thickness_m"):
        sn_curve("D_air").coefficients_for(thickness)


# Tables of a user

OWN = """
tables:
  - edition: our tests of 2025
    environment: grouted
    knee_cycles: 1.0e+6
    reference_thickness_m: 0.016
    curves:
      X: {m: [3.0, 5.0], log10_a: [12.0, 16.0], thickness_exponent: 0.3}
      Y: {m: 4.0, log10_a: 13.5, environment: ""}
"""


def own(tmp_path, text=OWN):
    path = tmp_path / "own.yaml"
    path.write_text(text)
    return str(path)


def test_curves_of_a_user_beside_those_of_the_package(tmp_path):
    path = own(tmp_path)
    curve = sn_curve("X_grouted", path)
    assert curve == SNCurve(
        "X_grouted", (3.0, 5.0), (12.0, 16.0), 1e6, edition="our tests of 2025", thickness_exponent=0.3,
        reference_thickness_m=0.016,
    )  # fmt: skip
    assert sn_curve("Y", path).has_one_slope
    assert sn_curve("D_air", path) == sn_curve("D_air")
    assert "X_grouted" not in sn_curves()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("m: [3.0, 5.0]", "m: [3.0, 5.0, 7.0]", r"tables\[0\]\.curves\.X\.m"),
        ("log10_a: 13.5", "log10a: 13.5", r"curves\.Y\.log10_a = 'nothing': is missing"),
        ("log10_a: 13.5", "log10_a: 13.5, a: 1", r"curves\.Y\.a = 1: is not a known key. Known.*: m,"),
        ("log10_a: 13.5", "log10_a: lots", r"curves\.Y\.log10_a = 'lots': must be a number"),
        ("knee_cycles: 1.0e+6", "knee_cycles: 1.0e+8", r"X_grouted\.log10_a = .*leaves a gap at the knee"),
        ("m: 4.0", "m: -4.0", r"Y\.m = .* must be finite and > 0"),
        ("thickness_exponent: 0.3", "thickness_exponent: 30", r"X\.thickness_exponent = 30"),
        ("X:", "D:\n        environment: air\n        m: 3.0\n        log10_a: 12\n      X:", "D_air"),
        ("      Y:", "      X_grouted:", "X_grouted"),
        ("tables:", "table:", "must hold one key 'tables'"),
        ("curves:", "curve:", r"tables\[0\]\.curves = None: must hold curves by name"),
        ("{m: 4.0", "[m: 4.0", "cannot be read as YAML"),
        ("{m: 4.0, log10_a: 13.5, environment: \"\"}", "7", r"curves\.Y = 7: must be a mapping"),
    ],
)  # fmt: skip
def test_fault_in_a_table_is_named(tmp_path, old, new, message):
    assert old in OWN
    with pytest.raises(InputError, match=message):
        sn_curves(own(tmp_path, OWN.replace(old, new, 1)))


def test_missing_file_is_named():
    with pytest.raises(InputError, match=r"fatigue\.sn_file = 'no\.yaml'.*cannot be read"):
        sn_curve("D_air", "no.yaml")
