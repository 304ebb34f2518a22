"""Integrators as recurrences: order, exactness, stability, damping of what the step does not resolve."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from owt_model.errors import InputError
from owt_structure_node.core.integrators import METHODS, exact, generalised_alpha, newmark, recurrence
from owt_structure_node.core.motion import MotionState, Oscillators, integrate


def one(value):
    return np.array([float(value)])


def reference(omega2, damping, load, step):
    """State after piecewise linear loads, by the exponential of the augmented matrix."""
    matrix = np.array([[0, 1, 0, 0], [-omega2, -damping, 1, 0], [0, 0, 0, 1.0], [0, 0, 0, 0]])
    e, state, rows = expm(matrix * step), np.zeros(2), []
    for f_0, f_1 in pairwise(load):
        state = (e @ [*state, f_0, (f_1 - f_0) / step])[:2]
        rows.append(state)
    return np.array(rows)


def run(method, omega2, damping, load, step):
    system = Oscillators(one(omega2), one(damping), step, 1, method)
    start = MotionState(one(0), one(0), one(load[0]), one(load[0]))
    return integrate(system, start, load[1:, None])[1]


def smooth_error(method, step):
    """Largest displacement error under a smooth load from rest, against the exact motion on a fine grid."""
    end, fine = 6.0, 512
    n = round(end / step)
    time = np.linspace(0, end, n * fine // 64 + 1)
    truth = reference(4.0, 0.08, np.sin(3.1 * time) ** 2, time[1])[fine // 64 - 1 :: fine // 64, 0]
    got = run(method, 4.0, 0.08, np.sin(3.1 * np.linspace(0, end, n + 1)) ** 2, step)
    return np.abs(got.displacement[:, 0] - truth).max()


def check_order(errors, order):
    assert np.abs(np.log2(np.array(errors[:-1]) / np.array(errors[1:])) - order).max() < 0.15


@pytest.mark.parametrize("method", METHODS)
def test_second_order(method):
    """Error of the load's interpolation included, every method is of second order."""
    errors = [smooth_error(method, step) for step in (0.04, 0.02, 0.01)]
    check_order(errors, 2)
    with pytest.raises(AssertionError):
        check_order(errors, 1)


@pytest.mark.parametrize(("omega2", "damping"), [(9.0, 0.1), (9.0, 6.0), (9.0, 40.0), (2e4, 3.0), (0.04, 0)])
def test_exact_for_loads_linear_in_a_step(omega2, damping):
    """Any step, under-, critically and overdamped: round-off; average acceleration is not exact."""
    load = np.random.default_rng(1).standard_normal(60)
    truth = reference(omega2, damping, load, 0.3)
    scale = np.abs(truth).max(axis=0)

    def check(motion):
        found = np.column_stack([motion.displacement, motion.velocity])
        assert (np.abs(found - truth).max(axis=0) < 1e-9 * scale).all()

    check(run("exact", omega2, damping, load, 0.3))
    with pytest.raises(AssertionError):
        check(run("newmark", omega2, damping, load, 0.3))


@pytest.mark.parametrize("method", METHODS)
def test_acceleration_balances_the_forces(method):
    """x'' + c x' + k x = f at every step; generalised-alpha balances between the ends of the step instead."""
    load = np.random.default_rng(2).standard_normal(50)
    motion = run(method, 9.0, 0.5, load, 0.02)
    parts = [motion.acceleration, 0.5 * motion.velocity, 9.0 * motion.displacement]
    residual = np.abs(sum(parts)[:, 0] - load[1:]).max()
    if method == "generalised-alpha":
        assert residual > 1e-6
    else:
        assert residual < 1e-12 * 50


def test_stability_limit_of_the_explicit_method():
    """Spectral radius 1 up to 2 / omega, above 1 beyond; a case beyond it is refused."""
    omega = 50.0
    limit = 2.0 / omega
    within = newmark(one(omega**2), one(0), 0.999 * limit, gamma=0.5, beta=0.0)
    assert within.spectral_radius()[0] == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(InputError, match=r"structure\.dt_s.*stability limit"):
        recurrence("newmark-explicit", one(omega**2), one(0), 1.001 * limit)
    # the limit is the right one: a system past it, which a lower mode hides from the check, blows up
    beyond = newmark(one((0.99 * omega) ** 2), one(0), limit, gamma=0.5, beta=0.0).transition
    faster = newmark(one((0.5 * omega) ** 2), one(0), 1.002 * limit, gamma=0.5, beta=0.0)
    assert np.isfinite(beyond).all()
    assert faster.spectral_radius()[0] <= 1.0 + 1e-9


@pytest.mark.parametrize("gamma", [0.6, 0.9])
def test_limit_for_gamma_above_one_half(gamma):
    """F.2: sqrt(2 / gamma) / omega; just below stable, just above unstable."""
    limit = np.sqrt(2.0 / gamma) / 7.0
    assert newmark(one(49), one(0), 0.999 * limit, gamma=gamma, beta=0.0).spectral_radius()[0] <= 1.0
    with pytest.raises(InputError):
        newmark(one(49), one(0), 1.001 * limit, gamma=gamma, beta=0.0)


def test_generalised_alpha_damps_only_what_is_not_resolved():
    stiff, slow = one(1e12), one(1.0)
    for rho in (0.0, 0.5, 0.8, 1.0):
        # at rho = 0 the three eigenvalues meet at zero: round-off to the power 1/3
        assert generalised_alpha(stiff, one(0), 0.02, rho_infinity=rho).spectral_radius()[0] == pytest.approx(
            rho, abs=2e-3
        )
        assert generalised_alpha(slow, one(0), 0.02, rho_infinity=rho).spectral_radius()[0] > 1.0 - 1e-6
    average = newmark(stiff, one(0), 0.02, gamma=0.5, beta=0.25)
    assert average.spectral_radius()[0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_rest_under_a_constant_load(method):
    system = Oscillators(np.array([4.0, 900.0]), np.array([0.1, 0.1]), 0.02, 5, method)
    load = np.tile([3.0, -7.0], (50, 1))
    rest = MotionState(load[0] / system.stiffness, np.zeros(2), np.zeros(2), load[0])
    _, motion = integrate(system, rest, load[1:])
    assert np.abs(motion.displacement - load[0] / system.stiffness).max() < 1e-12


def test_bad_names_and_factors_are_refused():
    with pytest.raises(InputError, match=r"structure\.integrator"):
        recurrence("leapfrog", one(1), one(0), 0.1)
    with pytest.raises(InputError, match="rho_infinity"):
        generalised_alpha(one(1), one(0), 0.1, rho_infinity=1.5)


def test_exact_keeps_the_energy_of_a_free_oscillator():
    rule = exact(np.array([1e8]), np.array([0.0]), 0.02)
    energy = []
    x, v = 1.0, 0.0
    for _ in range(1000):
        x, v = (rule.transition[:2, :2, 0] @ [x, v]).tolist()
        energy.append(0.5 * 1e8 * x**2 + 0.5 * v**2)
    assert max(abs(np.array(energy) / 0.5e8 - 1.0)) < 1e-9
