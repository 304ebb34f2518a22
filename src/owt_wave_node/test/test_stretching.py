"""Kinematics above still water: Wheeler, constant, none."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.loads import jacket_loads
from owt_wave_node.core.profile import first_order_profile

G, D = 9.81, 20.0
OMEGA = 2.0 * np.pi / 8.0


def check_wheeler(k, x: float, z: float, a: float, *, printed: bool = True) -> None:
    """u = a g k / omega cosh k(z'+d) / cosh kd cos psi at z' = (z - eta) / (1 + eta / d)."""
    kk = float(wavenumber(np.array([OMEGA]), water_depth=D, gravity=G)[0])
    psi = OMEGA * k.t - kk * x
    eta = a * np.cos(psi)
    level = (z - eta) / (1.0 + eta / D) if printed else np.full_like(eta, min(z, 0.0))
    wet = z <= eta
    scale = a * G * kk / OMEGA / np.cosh(kk * D)
    u = scale * np.cosh(kk * (level + D)) * np.cos(psi)
    dw = -OMEGA * scale * np.sinh(kk * (level + D)) * np.cos(psi)
    assert np.abs(k.velocity[wet, 0, 0] - u[wet]).max() < 1e-9 * np.abs(u).max()
    assert np.abs(k.acceleration[wet, 0, 2] - dw[wet]).max() < 1e-9 * np.abs(dw).max()


@pytest.mark.parametrize("stretching", ["wheeler", "taylor", "constant"])
def test_a_surface_below_the_bed_is_refused(stretching: str, listed) -> None:
    """A trough that dries the bed leaves 1 + eta / d <= 0; just above it all stays finite."""
    more = {"water_depth_m": 5.0, "time": {"dt_s": 0.1, "n": 80}, "points_m": [[0.0, 0.0, -1.0]]}
    wave = {"order": 1, "stretching": stretching}
    with pytest.raises(InputError, match="below the sea bed") as refused:
        wave_kinematics(listed(OMEGA, 5.2, 0.0, wave=wave, **more))
    assert refused.value.field == "components.amplitude_m"
    assert np.isfinite(wave_kinematics(listed(OMEGA, 4.8, 0.0, wave=wave, **more)).velocity).all()


def test_loads_refuse_a_surface_below_the_bed(listed, column) -> None:
    wave = {"order": 1, "stretching": "constant"}
    case = listed(0.5, 20.5, 0.0, water_depth_m=20.0, time={"dt_s": 0.1, "n": 200}, wave=wave)
    with pytest.raises(InputError, match=r"components\.amplitude_m.*below the sea bed"):
        jacket_loads(case, column(top=(0.0, 0.0, 5.0)))


@pytest.mark.parametrize("z", [-5.0, 0.6])
def test_wheeler(z: float, listed) -> None:
    a, x = 1.5, 2.0
    fields = {"water_depth_m": D, "time": {"dt_s": 0.1, "n": 80}, "points_m": [[x, 0.0, z]]}
    k = wave_kinematics(listed(OMEGA, a, 0.0, wave={"order": 1, "stretching": "wheeler"}, **fields))
    check_wheeler(k, x, z, a)
    with pytest.raises(AssertionError):  # the wrong variant: not stretched
        check_wheeler(k, x, z, a, printed=False)
    assert np.isfinite(k.velocity).all()


def test_wheeler_of_an_irregular_sea_against_a_direct_sum(recorded, reference) -> None:
    d = reference["A"]
    x, z, at = 3.0, -1.2, np.arange(0, 6000, 37)
    case = recorded("A", wave={"order": 1, "stretching": "wheeler"}, points_m=[[x, 0.0, z]])
    got = wave_kinematics(case)
    psi = got.t[at, None] * d["omega"] - d["k"] * x - d["phi"]
    eta = (d["a"] * np.cos(psi)).sum(axis=1)
    level = ((z - eta) / (1.0 + eta / 50.0))[:, None]
    wet = z <= eta
    scale = d["a"] * G * d["k"] / d["omega"] / np.cosh(d["k"] * 50.0)
    c, s = np.cosh(d["k"] * (level + 50.0)), np.sinh(d["k"] * (level + 50.0))
    expected = {
        ("velocity", 0): (scale * c * np.cos(psi)).sum(axis=1),
        ("velocity", 2): -(scale * s * np.sin(psi)).sum(axis=1),
        ("acceleration", 0): -(scale * d["omega"] * c * np.sin(psi)).sum(axis=1),
        ("acceleration", 2): -(scale * d["omega"] * s * np.cos(psi)).sum(axis=1),
    }
    for (name, axis), series in expected.items():
        error = getattr(got, name)[at, 0, axis] - series
        assert np.abs(error[wet]).max() < 1e-10 * np.abs(series).max()
    plain = (scale * np.cosh(d["k"] * (z + 50.0)) * np.cos(psi)).sum(axis=1)  # wrong variant: not stretched
    assert np.abs(plain - expected["velocity", 0]).max() > 1e-2 * np.abs(plain).max()


def test_profiles_above_still_water() -> None:
    k, z = np.array([0.05, 0.3]), np.array([2.0])
    at = {s: first_order_profile(k, z, water_depth=D, stretching=s) for s in ("taylor", "constant", "none")}
    zero = first_order_profile(k, np.zeros(1), water_depth=D, stretching="taylor")
    for i, (value, slope) in enumerate(((np.ones(2), np.tanh(k * D)), (np.tanh(k * D), np.ones(2)))):
        assert zero[i][0] == pytest.approx(value, rel=1e-14)
        assert at["constant"][i][0] == pytest.approx(value, rel=1e-14)
        assert at["taylor"][i][0] == pytest.approx(value + k * z * slope, rel=1e-14)
    assert at["none"][0][0] == pytest.approx(np.cosh(k * (z + D)) / np.cosh(k * D), rel=1e-13)
    assert at["none"][1][0] == pytest.approx(np.sinh(k * (z + D)) / np.cosh(k * D), rel=1e-13)


def test_below_still_water_the_choice_does_not_matter() -> None:
    k, z = np.array([0.05, 0.3]), np.array([-3.0, 0.0])
    one = first_order_profile(k, z, water_depth=D, stretching="taylor")
    for stretching in ("constant", "none"):
        other = first_order_profile(k, z, water_depth=D, stretching=stretching)
        assert np.array_equal(one[0], other[0])
        assert np.array_equal(one[1], other[1])
