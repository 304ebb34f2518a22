"""Rotor wind and thrust: units, directions, seeds, slices, notes, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_structure_node.core.rotor_thrust import (
    Rotor,
    passing_harmonics,
    passing_wind,
    rotor_thrust,
    thrust_curve,
    tower_deficit,
    tower_top_wrench,
)
from owt_structure_node.core.rotor_wind import (
    Turbulence,
    Wind,
    kaimal,
    normal_turbulence,
    realise_rotor_wind,
    rotor_spectrum,
    rotor_variance,
    turbulence_at,
)

ROTOR = Rotor()
WIND = Wind(speed=14.0, direction_deg=210.0, seed=3)
#: Turbulence so weak that only what is steady or periodic is left, and a tower and shear that are none.
CALM = replace(WIND, turbulence=1e-12)
BARE = replace(ROTOR, tower_diameter=0.0)


def test_turbulence_of_the_standard():
    """Category B at 12 m/s: 0.14 (9 + 5.6) = 2.044 m/s; Lambda_1 42 m above 60 m, 0.7 z below."""
    assert normal_turbulence(12.0, "B") == pytest.approx(2.044)
    assert Wind(speed=12.0, turbulence="C").sigma == pytest.approx(0.12 * 14.6)
    assert Wind(speed=12.0, turbulence=0.1).sigma == pytest.approx(1.2)
    assert turbulence_at(WIND, 91.0).length == pytest.approx(340.2)
    assert turbulence_at(WIND, 50.0).scale == pytest.approx(35.0)


def test_kaimal_at_zero_frequency():
    """S(0) = 4 sigma^2 L/V."""
    air = Turbulence(speed=10.0, sigma=2.0, scale=42.0)
    assert kaimal(np.zeros(1), air)[0] == pytest.approx(4.0 * 4.0 * 34.02)


def check_peaks(step: float) -> None:
    """The spectrum has local peaks at 3P and 6P, the first the higher, and none at P, 2P, 4P, 5P."""
    air = turbulence_at(WIND, 91.0)
    P = ROTOR.frequency(WIND.speed)

    def S(number):
        f = np.array([number * step])
        return float(rotor_spectrum(f, air, radius=65.0, rotor_frequency=P)[0])

    for number in (3, 6):
        assert S(number) > 1.5 * max(S(number - 0.2), S(number + 0.2))
    assert S(3) > S(6)
    assert S(0.8) > S(1) > S(1.2)  # no peak: it falls through
    assert S(3) > 5.0 * S(2)


def test_peaks_at_three_and_six_per_revolution():
    check_peaks(ROTOR.frequency(WIND.speed))
    with pytest.raises(AssertionError):
        check_peaks(ROTOR.frequency(WIND.speed) / 3.0)  # would-be peaks at 1P and 2P


def test_disc_takes_variance_out_and_turning_does_not():
    air = turbulence_at(WIND, 91.0)
    f = np.geomspace(1e-6, 50.0, 400_001)
    turning, standing = (
        float(np.trapezoid(rotor_spectrum(f, air, radius=65.0, rotor_frequency=P), f)) for P in (0.2, 0.0)
    )
    assert turning == pytest.approx(rotor_variance(air, 65.0), rel=2e-3)
    assert standing == pytest.approx(turning, rel=2e-3)
    assert rotor_variance(air, 65.0) < 0.8 * air.sigma**2
    assert rotor_variance(air, 0.05) == pytest.approx(air.sigma**2, rel=0.01)


def test_series_is_periodic_gaussian_sum_of_the_spectrum():
    """Zero mean; the variance is sum S df to round-off; the transform has the amplitude sqrt(2 S df)."""
    air, n, dt = turbulence_at(WIND, 91.0), 6001, 0.1
    u = realise_rotor_wind(air, radius=65.0, rotor_frequency=0.2, dt=dt, n=n, seed=3)
    f = np.arange(1, 3001) / (n * dt)
    S = rotor_spectrum(f, air, radius=65.0, rotor_frequency=0.2)
    assert abs(u.mean()) < 1e-12
    assert u.var() == pytest.approx(S.sum() / (n * dt), rel=1e-12)
    amplitude = 2.0 / n * np.abs(np.fft.rfft(u))[1:]
    np.testing.assert_allclose(amplitude, np.sqrt(2.0 * S / (n * dt)), rtol=1e-9)


@pytest.mark.parametrize("n", [3, 4, 100, 101])
def test_any_number_of_samples(n):
    air = turbulence_at(WIND, 91.0)
    u = realise_rotor_wind(air, radius=65.0, rotor_frequency=0.2, dt=0.1, n=n, seed=3)
    assert u.shape == (n,)
    assert abs(u.mean()) < 1e-12
    assert u.std() > 0.0


def test_seed_gives_the_same_record_and_another_seed_another():
    one, again = (rotor_thrust(ROTOR, WIND, dt=0.1, n=600) for _ in range(2))
    np.testing.assert_array_equal(one.wrench, again.wrench)
    other = rotor_thrust(ROTOR, replace(WIND, seed=4), dt=0.1, n=600)
    assert abs(np.corrcoef(one.slow_wind, other.slow_wind)[0, 1]) < 0.99
    assert other.wind.std() == pytest.approx(one.wind.std(), rel=0.05)


def test_phases_are_not_those_of_waves_of_the_same_seed():
    """Waves take PCG64(seed): the same phases would tie wind to waves, component by component."""
    u = realise_rotor_wind(turbulence_at(WIND, 91.0), radius=65.0, rotor_frequency=0.2, dt=0.1, n=600, seed=1)
    phase = -np.angle(np.fft.rfft(u))[1:300] % (2.0 * math.pi)
    waves = 2.0 * math.pi * np.random.Generator(np.random.PCG64(1)).random(299)
    assert abs(np.mean(np.exp(1j * (phase - waves)))) < 0.2


def test_thrust_curve():
    """1/2 rho A C_T V^2 below the rated speed, continuous there, falling above, zero without wind."""
    V = np.array([-3.0, 0.0, 8.0, 10.5, 10.5 + 1e-6, 15.0, 25.0])
    T = thrust_curve(V, ROTOR)
    area = math.pi * 65.0**2
    assert T[0] == T[1] == 0.0
    assert T[2] == pytest.approx(0.5 * 1.225 * area * 0.8 * 64.0)
    assert T[3] == pytest.approx(T[4], rel=1e-3)
    assert np.all(np.diff(T[3:]) < 0.0)
    assert 650e3 < T[3] < 750e3


def test_slow_wind_moves_the_operating_point_and_the_rest_the_gain():
    found = rotor_thrust(ROTOR, WIND, dt=0.1, n=2000)
    fast = found.thrust - thrust_curve(found.slow_wind, ROTOR)
    np.testing.assert_allclose(fast, 6.1e4 * (found.wind - found.slow_wind), rtol=1e-9, atol=1e-6)
    assert found.damping == 6.1e4
    assert found.slow_wind.std() < found.wind.std()
    assert np.abs(np.diff(found.slow_wind)).max() < 0.3 * np.abs(np.diff(found.wind)).max()


def test_rotor_frequency_follows_the_mean_wind_up_to_the_rated_speed():
    assert ROTOR.frequency(20.0) == pytest.approx(14.0 / 60.0)
    assert ROTOR.frequency(5.25) == pytest.approx(7.0 / 60.0)
    assert rotor_thrust(ROTOR, WIND, dt=0.1, n=100).rotor_frequency == pytest.approx(14.0 / 60.0)


@pytest.mark.parametrize(
    ("direction", "force", "moment"),
    [
        (0.0, (1.0, 0.0, 0.0), (0.0, 2.0, 0.0)),
        (90.0, (0.0, 1.0, 0.0), (-2.0, 0.0, 0.0)),
        (180.0, (-1.0, 0.0, 0.0), (0.0, -2.0, 0.0)),
        (-90.0, (0.0, -1.0, 0.0), (2.0, 0.0, 0.0)),
    ],
)
def test_wrench_points_where_the_wind_blows_to(direction, force, moment):
    wrench = tower_top_wrench(np.array([3e5, 1e5]), direction_deg=direction, hub_above_top=2.0)
    np.testing.assert_allclose(wrench, np.outer([3e5, 1e5], [*force, *moment]), atol=1e-9)
    np.testing.assert_allclose(wrench[0, 3:], np.cross([0.0, 0.0, 2.0], wrench[0, :3]), atol=1e-9)


def test_record_is_sliced_without_a_change():
    found = rotor_thrust(ROTOR, WIND, dt=0.1, n=600)
    assert found.wrench.shape == (600, 6)
    assert found.wrench.flags.c_contiguous
    blocks = [found.wrench[i : i + 50] for i in range(0, 600, 50)]
    np.testing.assert_array_equal(np.concatenate(blocks), found.wrench)
    b = math.radians(210.0)
    np.testing.assert_allclose(found.wrench[:, 0], math.cos(b) * found.thrust, rtol=1e-12)


def test_steady_wind_gives_the_thrust_curve():
    found = rotor_thrust(BARE, replace(CALM, shear_exponent=0.0), dt=0.1, n=200)
    np.testing.assert_allclose(found.thrust, thrust_curve(np.array([14.0]), BARE)[0], rtol=1e-9)


def test_tower_slows_the_blade_that_points_down_most():
    azimuth = np.array([0.0, 0.05, -0.05, 0.3, math.pi])
    change = tower_deficit(azimuth, ROTOR)
    assert change[0] == pytest.approx(-((2.25 / 9.0) ** 2))
    assert change[0] < change[1] == pytest.approx(change[2])
    assert change[1] < change[3]
    assert change[4] == 0.0
    assert not passing_wind(BARE, replace(WIND, shear_exponent=0.0), dt=0.1, n=50).any()


def test_passing_repeats_three_times_a_turn_and_scales_with_the_wind():
    P = ROTOR.frequency(WIND.speed)
    per_turn = 300
    series = passing_wind(ROTOR, WIND, dt=1.0 / (P * per_turn), n=2 * per_turn)
    np.testing.assert_allclose(series, np.roll(series, per_turn // 3), atol=1e-10)
    assert abs(series.mean()) < 1e-12
    assert series.argmin() % (per_turn // 3) == 0  # a blade before the tower at t = 0
    faster = passing_harmonics(ROTOR, replace(WIND, speed=21.0), 12)[1]
    np.testing.assert_allclose(faster, 1.5 * passing_harmonics(ROTOR, WIND, 12)[1])


def test_coarse_samples_leave_harmonics_out_and_say_so():
    """At 1 s, Nyquist's 0.5 Hz lies below 3P = 0.7 Hz: nothing periodic is left, nothing folded back."""
    found = rotor_thrust(ROTOR, CALM, dt=1.0, n=600)
    assert np.ptp(found.thrust) < 1e-3
    assert "3P (0.7 Hz) and 6P (1.4 Hz) left out" in found.notes[0]
    assert rotor_thrust(ROTOR, WIND, dt=0.1, n=6000).notes == ()
    half = rotor_thrust(ROTOR, WIND, dt=0.5, n=1200)
    assert any("6P" in note and "3P" not in note for note in half.notes)


def test_short_records_and_excursions_are_noted():
    short = rotor_thrust(ROTOR, WIND, dt=0.1, n=300)
    assert any("of the variance" in note for note in short.notes)
    fast = rotor_thrust(ROTOR, replace(WIND, speed=24.9), dt=0.1, n=6000)
    assert any("leaves cut-in ... cut-out" in note for note in fast.notes)


@pytest.mark.parametrize(
    ("make", "field", "says"),
    [
        (lambda: Wind(speed=0.0), "wind.speed", "> 0"),
        (lambda: Wind(speed=float("nan")), "wind.speed", "> 0"),
        (lambda: Wind(turbulence=0.0), "wind.turbulence", "fraction"),
        (lambda: Wind(turbulence=12.0), "wind.turbulence", "0.12"),
        (lambda: Wind(turbulence="D"), "wind.turbulence", "A, B and C"),
        (lambda: Wind(direction_deg=400.0), "wind.direction_deg", "360"),
        (lambda: Wind(shear_exponent=-0.1), "wind.shear_exponent", "0 ... 1"),
        (lambda: Wind(seed=-1), "wind.seed", "integer"),
        (lambda: Rotor(diameter=0.0), "rotor.diameter", "> 0"),
        (lambda: Rotor(damping=-1.0), "rotor.damping", ">= 0"),
        (lambda: Rotor(air_density=float("inf")), "rotor.air_density", ">= 0"),
        (lambda: Rotor(hub_height=60.0), "rotor.diameter", "twice the height"),
        (lambda: Rotor(rated_speed=26.0), "rotor.rated_speed", "cut-out"),
        (lambda: Rotor(thrust_coefficient=1.0), "rotor.thrust_coefficient", "8/9"),
        (lambda: Rotor(tower_distance=2.0), "rotor.tower_distance", "tower diameter"),
        (lambda: rotor_thrust(ROTOR, Wind(speed=3.0), dt=0.1, n=100), "wind.speed", "idling"),
        (lambda: rotor_thrust(ROTOR, Wind(speed=26.0), dt=0.1, n=100), "wind.speed", "cut-out"),
        (lambda: rotor_thrust(ROTOR, WIND, dt=3.0, n=100), "time.dt_s", "time constant"),
        (lambda: rotor_thrust(ROTOR, WIND, dt=0.0, n=100), "time.dt_s", "> 0"),
        (lambda: rotor_thrust(ROTOR, WIND, dt=0.1, n=2), "time.n", ">= 3"),
    ],
)
def test_bad_input_is_refused(make, field, says):
    with pytest.raises(InputError, match=says) as refused:
        make()
    assert refused.value.field == field
