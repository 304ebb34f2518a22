"""Second order against closed forms and the reference seas."""

from __future__ import annotations

import math

import numpy as np
import pytest

from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import build_sea_state, waves
from owt_wave_node.core.transfer import set_down, transfer

G = 9.81
QUANTITIES = [("velocity", 0), ("velocity", 2), ("acceleration", 0), ("acceleration", 2)]


def pair(periods: list[float], depth: float):
    omega = 2.0 * math.pi / np.array(periods)
    k = wavenumber(omega, water_depth=depth, gravity=G)
    return omega, k, transfer(omega, k, water_depth=depth, gravity=G)


def printed_b_plus(omega, k, t):
    """Eq. 4.19 as the thesis prints it, with plus R_m R_n in B+."""
    r = omega**2 / G
    product = k[:, None] * k[None, :] + r[:, None] * r[None, :]
    return 0.25 * ((t.d_plus - product) / np.sqrt(r[:, None] * r[None, :]) + r[:, None] + r[None, :])


def check_stokes(b_plus: float, period: float, depth: float) -> None:
    """eta2 / a^2 of one component = k cosh kd (2 + cosh 2kd) / (4 sinh^3 kd)."""
    k = float(wavenumber(np.array([2.0 * math.pi / period]), water_depth=depth, gravity=G)[0])
    kd = k * depth
    assert b_plus == pytest.approx(
        k * math.cosh(kd) * (2.0 + math.cosh(2.0 * kd)) / (4.0 * math.sinh(kd) ** 3), rel=1e-12
    )


STOKES = {
    (5.0, 50.0): 0.08048615,
    (10.0, 50.0): 0.02351352,
    (15.0, 50.0): 0.02510208,
    (10.0, 20.0): 0.06633190,
}


@pytest.mark.parametrize(("period", "depth"), [*STOKES, (12.0, 8.0), (3.0, 200.0), (9.45, 50.0)])
def test_stokes(period: float, depth: float) -> None:
    _, _, t = pair([period], depth)
    check_stokes(t.b_plus[0, 0], period, depth)
    if (period, depth) in STOKES:
        assert t.b_plus[0, 0] == pytest.approx(STOKES[period, depth], abs=5e-9)


def test_stokes_would_notice_the_printed_sign() -> None:
    omega, k, t = pair([10.0], 50.0)
    with pytest.raises(AssertionError):
        check_stokes(printed_b_plus(omega, k, t)[0, 0], 10.0, 50.0)


def test_stokes_velocity_and_elevation_in_time(listed) -> None:
    """One component: eta2 with its set-down, and u2 = 3/4 a^2 omega k cosh 2k(z+d) / sinh^4 kd."""
    a, omega, depth, z = 1.3, 2.0 * math.pi / 10.0, 20.0, -4.0
    k = float(wavenumber(np.array([omega]), water_depth=depth, gravity=G)[0])
    case = listed(omega, a, 0.4, water_depth_m=depth, time={"dt_s": 0.1, "n": 100}, points_m=[[3.0, 0.0, z]])
    got = wave_kinematics(case)
    psi = omega * got.t - k * 3.0 - 0.4
    kd = k * depth
    b = k * math.cosh(kd) * (2.0 + math.cosh(2.0 * kd)) / (4.0 * math.sinh(kd) ** 3)
    eta2 = a**2 * (b * np.cos(2.0 * psi) - k / (2.0 * math.sinh(2.0 * kd)))
    scale = 0.75 * a**2 * omega * k / math.sinh(kd) ** 4
    u2 = scale * math.cosh(2.0 * k * (z + depth)) * np.cos(2.0 * psi)
    w2 = -scale * math.sinh(2.0 * k * (z + depth)) * np.sin(2.0 * psi)
    assert got.eta2[:, 0] == pytest.approx(eta2, abs=1e-13)
    assert got.velocity2[:, 0, 0] == pytest.approx(u2, abs=1e-13)
    assert got.velocity2[:, 0, 2] == pytest.approx(w2, abs=1e-13)


def test_two_components() -> None:
    _, _, t = pair([10.0, 9.0], 50.0)
    assert t.b_plus[0, 1] == pytest.approx(0.02504470, abs=5e-9)
    assert t.b_minus[0, 1] == pytest.approx(-0.00719192, abs=5e-9)
    assert np.array_equal(t.b_plus, t.b_plus.T)


def check_deep(b_plus: float, b_minus: float, k: np.ndarray) -> None:
    """Deep water: B+ = (k1 + k2) / 4, B- = -|k1 - k2| / 4; D+ vanishes."""
    assert b_plus == pytest.approx((k[0] + k[1]) / 4.0, rel=1e-13)
    assert b_minus == pytest.approx(-abs(k[0] - k[1]) / 4.0, rel=1e-12)


@pytest.mark.parametrize("depth", [3500.0, 5000.0])
def test_deep_water(depth: float) -> None:
    _, k, t = pair([10.0, 9.0], depth)
    check_deep(t.b_plus[0, 1], t.b_minus[0, 1], k)
    assert abs(t.d_plus[0, 1]) < 1e-10


def test_deep_water_would_notice_finite_depth() -> None:
    _, k, t = pair([10.0, 9.0], 20.0)
    with pytest.raises(AssertionError):
        check_deep(t.b_plus[0, 1], t.b_minus[0, 1], k)


def check_bracket(above: float, k: float, depth: float) -> None:
    """k^2 - R^2 = k^2 / cosh^2 kd at any depth: D+ of one component times its denominator / 4 R."""
    assert above == pytest.approx(k**2 / math.cosh(k * depth) ** 2, rel=1e-12, abs=0.0)


def test_deep_water_keeps_its_digits() -> None:
    """D+ of one component is 12 R (k^2 - R^2) / (4 R - 2 k tanh 2kd): not lost at k d = 12."""
    omega, k, t = pair([2.0 * math.pi / math.sqrt(G * 12.0 / 50.0)], 50.0)
    s2 = omega[0] ** 2 / G
    bracket = t.d_plus[0, 0] * (4.0 * s2 - 2.0 * k[0] * math.tanh(2.0 * k[0] * 50.0)) / (12.0 * s2)
    check_bracket(bracket, k[0], 50.0)
    with pytest.raises(AssertionError):
        check_bracket(k[0] ** 2 - s2**2, k[0], 50.0)  # the wrong variant: straight subtraction


def test_set_down(reference, recorded) -> None:
    for name in "AC":
        w = waves(build_sea_state(recorded(name)))
        assert set_down(w) == pytest.approx(float(reference[name]["mean_setdown"]), rel=1e-12)
        _, eta2 = component_field(w).elevation(np.zeros((1, 3)))
        assert eta2.mean() == pytest.approx(float(reference[name]["mean_setdown"]), rel=1e-9)


def rows(d, key: str) -> np.ndarray:
    return np.rint(d[key] / 0.1).astype(int)


def check_kinematics(got, d, part, error) -> None:
    """[quantity] of [time, point, 3] against the reference, to 1e-10 of the peak of the term."""
    for q, (name, axis) in enumerate(QUANTITIES):
        series = got[name][:, :, axis].T
        for p in range(len(d["points"])):
            assert error(series[p], part(d["kin"][p, q])) < 1e-10, (name, axis, d["points"][p])


@pytest.mark.parametrize("name", ["A", "C"])
def test_reference_kinematics(name: str, reference, recorded, error) -> None:
    d = reference[name]
    points = [[x, 0.0, z] for x, z in d["points"]]
    at = rows(d, "t")
    for order, part in ((1, lambda kin: kin[0]), (2, lambda kin: kin[1] + kin[2])):
        k = wave_kinematics(recorded(name, wave={"order": order, "stretching": "taylor"}, points_m=points))
        suffix = "" if order == 1 else "2"
        got = {q: getattr(k, q + suffix)[at] for q in ("velocity", "acceleration")}
        check_kinematics(got, d, part, error)
        wrong = {q: series[:, :, [2, 1, 0]] for q, series in got.items()}
        with pytest.raises(AssertionError):  # the wrong variant: horizontal and vertical swapped
            check_kinematics(wrong, d, part, error)
    with pytest.raises(AssertionError):  # the wrong variant: without the difference terms
        check_kinematics(got, d, lambda kin: kin[1], error)
    eta = d["eta_x0"]
    assert error(k.eta1[rows(d, "t_eta"), 0], eta[0]) < 1e-10
    assert error(k.eta2[rows(d, "t_eta"), 0], eta[1] + eta[2]) < 1e-10
    assert error(k.eta2[rows(d, "t_eta"), 0] - k.eta2.mean(), eta[1] + eta[2]) > 1e-10  # set-down counts


def check_above(k, d, error) -> None:
    at = rows(d, "t")
    for q, (name, axis) in enumerate(QUANTITIES):
        assert error(getattr(k, name)[at][:, :, axis].T, d["kin_above_total"][:, q]) < 1e-10


@pytest.mark.parametrize("name", ["A", "C"])
def test_reference_above_still_water(name: str, reference, recorded, error) -> None:
    points = [[x, 0.0, z] for x, z in reference[name]["points_above"]]
    check_above(wave_kinematics(recorded(name, points_m=points)), reference[name], error)


@pytest.mark.parametrize("stretching", ["constant", "none"])
def test_reference_above_would_notice(stretching: str, reference, recorded, error) -> None:
    points = [[x, 0.0, z] for x, z in reference["A"]["points_above"]]
    case = recorded("A", points_m=points, wave={"order": 2, "stretching": stretching})
    with pytest.raises(AssertionError):
        check_above(wave_kinematics(case), reference["A"], error)
