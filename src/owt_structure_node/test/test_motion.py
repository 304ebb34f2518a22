"""Time integration: order, energy, the static start, and blocks that do not change a bit."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_structure_node.core.motion import MotionState, Oscillators, integrate, static_state


def one(value):
    return np.array([float(value)])


def forced(step, *, n_periods=3, zeta=0.02, omega=2.0, drive=3.1):
    """Displacement and velocity error of an SDOF under cos(drive t) from rest, at a fixed time."""
    end = n_periods * 2 * np.pi / drive
    n = round(end / step)
    step = end / n
    time = step * np.arange(n + 1)
    load = np.cos(drive * time)[:, None]
    system = Oscillators(one(omega**2), one(2 * zeta * omega), step, 1)
    start = MotionState(one(0), one(0), one(1.0), load[0])
    _, motion = integrate(system, start, load[1:])
    # exact: particular solution plus damped free vibration
    den = (omega**2 - drive**2) ** 2 + (2 * zeta * omega * drive) ** 2
    a, b = (omega**2 - drive**2) / den, 2 * zeta * omega * drive / den
    damped = omega * np.sqrt(1 - zeta**2)
    c1, c2 = -a, (-b * drive - zeta * omega * a) / damped
    decay = np.exp(-zeta * omega * time)
    free = decay * (c1 * np.cos(damped * time) + c2 * np.sin(damped * time))
    exact = a * np.cos(drive * time) + b * np.sin(drive * time) + free
    return np.abs(motion.displacement[:, 0] - exact[1:]).max()


def check_order(errors, order):
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.abs(rates - order).max() < 0.15


def test_second_order_against_the_exact_oscillator():
    """Halving the step divides the error by four."""
    errors = [forced(step) for step in (0.04, 0.02, 0.01)]
    check_order(errors, 2)
    with pytest.raises(AssertionError):
        check_order(errors, 1)


def test_free_vibration_keeps_its_energy():
    """Without damping and load, potential and kinetic energy sum to a constant, over 10,000 steps."""
    omega2 = np.array([0.5, 40.0, 1e5])  # the last far beyond what the step resolves
    start = MotionState(np.ones(3), np.array([0.3, -2.0, 5.0]), -omega2, np.zeros(3))

    def energy(damping):
        system = Oscillators(omega2, np.full(3, damping), 0.02, 5)
        _, motion = integrate(system, start, np.zeros((2000, 3)))
        return 0.5 * omega2 * motion.displacement**2 + 0.5 * motion.velocity**2

    conserved = energy(0.0)
    initial = 0.5 * omega2 * start.displacement**2 + 0.5 * start.velocity**2
    assert np.abs(conserved / initial - 1).max() < 1e-9
    assert np.abs(energy(1e-4) / initial - 1).max() > 1e-3


def test_work_of_the_load_is_the_gain_of_energy():
    """Undamped: the trapezoidal work of the load equals the energy gained, step by step."""
    rng = np.random.default_rng(3)
    omega2 = np.array([1.0, 30.0, 4e3])
    system = Oscillators(omega2, np.zeros(3), 0.02, 5)
    load = rng.standard_normal((40, 3))
    state = static_state(system, load[0])
    _, motion = integrate(system, state, load[1:])
    x = np.concatenate([state.displacement[None], motion.displacement])
    v = np.concatenate([state.velocity[None], motion.velocity])
    fine = np.empty((len(x), 3))
    for j in range(3):
        fine[:, j] = np.interp(np.arange(len(x)) / 5, np.arange(40), load[:, j])
    energy = 0.5 * omega2 * x**2 + 0.5 * v**2
    work = np.cumsum(np.diff(x, axis=0) * 0.5 * (fine[1:] + fine[:-1]), axis=0)
    assert np.allclose(energy[1:] - energy[0], work, rtol=1e-9, atol=1e-12)
    held = np.cumsum(np.diff(x, axis=0) * fine[:-1], axis=0)  # load taken at the start of each step
    assert not np.allclose(energy[1:] - energy[0], held, rtol=1e-3, atol=1e-6)


def test_static_start_stays_at_rest():
    """Under a constant load nothing moves; from zero it would swing to twice the static displacement."""
    system = Oscillators(np.array([4.0, 900.0]), np.array([0.1, 0.1]), 0.02, 5)
    load = np.tile([3.0, -7.0], (50, 1))
    _, motion = integrate(system, static_state(system, load[0]), load[1:])
    assert np.abs(motion.displacement - load[0] / system.stiffness).max() < 1e-12
    assert np.abs(motion.velocity).max() < 1e-12
    zero = MotionState(np.zeros(2), np.zeros(2), load[0], load[0])
    _, motion = integrate(system, zero, load[1:])
    assert motion.displacement[:, 0].max() > 1.5 * 3.0 / 4.0


def test_blocks_do_not_change_a_bit():
    """Streaming with a carried state gives the bits of the whole record, for any cut."""
    rng = np.random.default_rng(5)
    modes = 37
    system = Oscillators(rng.uniform(1, 1e4, modes), rng.uniform(0, 1, modes), 0.02, 5)
    load = rng.standard_normal((101, modes))
    start = static_state(system, load[0])
    end, whole = integrate(system, start, load[1:])

    def stream(cuts, *, forget=False):
        state, rows = start, []
        for a, b in pairwise(cuts):
            state, motion = integrate(system, state, load[a:b])
            rows.append(motion.acceleration)
            if forget:
                state = MotionState(state.displacement, state.velocity, state.acceleration, load[b - 1] * 0)
        return state, np.concatenate(rows)

    for cuts in ([1, 101], [1, 2, 3, 50, 51, 101], list(range(1, 102))):
        state, acceleration = stream(cuts)
        assert np.array_equal(acceleration, whole.acceleration)
        assert np.array_equal(state.displacement, end.displacement)
    assert not np.array_equal(stream([1, 50, 101], forget=True)[1], whole.acceleration)


def test_load_is_linear_between_samples():
    """A very stiff oscillator follows the interpolated load quasi-statically."""
    system = Oscillators(one(1e10), one(1e5), 0.02, 5)
    load = np.array([[0.0], [1e10], [3e10]])
    _, motion = integrate(system, static_state(system, load[0]), load[1:])
    expected = np.array([0.2, 0.4, 0.6, 0.8, 1.0, 1.4, 1.8, 2.2, 2.6, 3.0])
    assert np.abs(motion.displacement[:, 0] - expected).max() < 0.05


def test_bad_step_is_refused():
    with pytest.raises(InputError, match=r"structure\.dt_s"):
        Oscillators(one(1), one(0), 0.0, 1)
