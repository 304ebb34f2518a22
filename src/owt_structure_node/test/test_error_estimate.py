"""Estimated errors of a basis, and the choice of ``auto``."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.pod import load_basis
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.auto import Target, auto_reduction, candidates, chosen_reduction, spectral_note
from owt_structure_node.core.error_estimate import ErrorModel
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.reduction import reduce

DT = 0.1
RAYLEIGH = Damping(alpha=0.02, beta=0.002)
TARGET = Target(tolerance=1e-3, damping=RAYLEIGH, dt=DT)
DAMPING = {"damping": RAYLEIGH, "dt": DT}


@pytest.fixture(scope="module")
def frame(models):
    return assemble(build_mesh(models.frame()))


@pytest.fixture(scope="module")
def history(frame):
    """Slow loads of 18 shapes inside the jacket, each half the size of the one before, and a mean."""
    rng = np.random.default_rng(5)
    mesh = frame.mesh
    node = np.arange(4, mesh.transition_piece)
    shapes = rng.standard_normal((18, len(node), 6)) * [1e5, 1e5, 1e5, 1e4, 1e4, 1e4]
    time = DT * np.arange(1000)
    omega, phase = 0.02 * np.pi * np.arange(5, 23), rng.uniform(0.0, 6.0, 18)  # whole periods: no leakage
    amplitude = np.cos(time[:, None] * omega + phase) * 0.5 ** np.arange(18)
    nodal = np.tensordot(amplitude, shapes, axes=1) + 2.0 * shapes[1]
    return node, np.ascontiguousarray(nodal)


@pytest.fixture(scope="module")
def basis(frame, history):
    node, nodal = history
    return load_basis(nodal, node, 30, model_hash=frame.mesh.structure.content_hash)


def static_energy(frame, history, shapes=None):
    """Mean of f' K^-1 f over the history, in the space of the shapes."""
    node, nodal = history
    full = np.zeros((len(nodal), frame.mesh.n_nodes, 6))
    full[:, node] = nodal
    load = frame.expansion.T @ full.reshape(len(nodal), -1).T
    if shapes is None:
        return np.mean(np.einsum("dt,dt->t", load, factorise(frame.stiffness).solve(load)))
    small = shapes.T @ load
    return np.mean(
        np.einsum("dt,dt->t", small, np.linalg.solve(shapes.T @ (frame.stiffness @ shapes), small))
    )


@pytest.mark.parametrize("name", ["CB00", "CB10", "CB05M05", "M10", "CB10M05j1", "CB05M05Y"])
def test_static_part_is_the_static_residual_of_the_history(frame, history, basis, name):
    """Moments of the loads give what the whole history gives, 1 - E[f' K_r^-1 f] / E[f' K^-1 f]."""
    still = dataclasses.replace(basis, spectrum=np.zeros((0, 0)))
    model = ErrorModel(frame, still, **DAMPING)
    reduced = reduce(frame, name, basis)
    found = model.estimate(reduced)
    expected = 1.0 - static_energy(frame, history, reduced.shapes) / static_energy(frame, history)
    assert found.static == pytest.approx(expected, rel=1e-5, abs=1e-12)
    assert found.energy == model.energy_error(reduced)
    # Negative control: without the mean load it is another number.
    other = ErrorModel(frame, dataclasses.replace(still, mean=np.zeros_like(basis.mean)), **DAMPING)
    assert other.estimate(reduced).static != pytest.approx(expected, rel=1e-4)


def test_better_bases_have_smaller_estimates(frame, basis):
    model = ErrorModel(frame, basis, **DAMPING)
    found = [model.estimate(reduce(frame, name, basis)) for name in ("CB00", "CB10", "CB10M05", "CB10M10Y")]
    assert all(after.energy < before.energy for before, after in pairwise(found))
    # Modes alone may do harm to a single member end.
    assert found[3].member_force < found[2].member_force < found[1].member_force
    improved = model.estimate(reduce(frame, "CB10+SIM", basis))
    assert improved.static == 0.0
    assert improved.dynamic == pytest.approx(found[1].dynamic, rel=1e-9)
    assert improved.member_force < found[1].member_force
    assert found[0].member_end in frame.mesh.end_name


def test_estimate_of_a_basis_that_has_everything(frame, basis):
    """Nothing is left to err about but the loads outside the basis, of which there are none."""
    model = ErrorModel(frame, basis, **DAMPING)
    found = model.estimate(reduce(frame, f"CB{frame.internal}"))
    assert found.energy < 1e-6
    assert found.member_force < 1e-3


def test_auto_takes_the_smallest_that_meets_the_tolerance(frame, basis):
    model = ErrorModel(frame, basis, **DAMPING)
    ladder = candidates(frame.internal, len(basis.vectors))
    for tolerance in (1e-1, 1e-3):
        choice = auto_reduction(frame, basis, dataclasses.replace(TARGET, tolerance=tolerance))
        assert choice.estimate.energy <= tolerance
        assert f"auto: {choice.reduced.name} meets tolerance {tolerance:g}" in choice.note
        smaller = ladder[: ladder.index(choice.reduced.name)]
        assert all(model.energy_error(reduce(frame, name, basis)) > tolerance for name in smaller)
    none = auto_reduction(frame, basis, dataclasses.replace(TARGET, tolerance=1e-12))
    assert "does not meet tolerance 1e-12" in none.note
    assert none.estimate.energy <= choice.estimate.energy


def test_ladder_is_ordered_by_size(frame):
    ladder = candidates(40, 30)
    assert ladder[:6] == ["CB00", "CB05", "CB00M05", "CB10", "CB05M05", "CB00M10"]
    assert ladder[-1] == "CB40M30"
    assert candidates(7, 3) == ["CB00", "CB05"]


def test_modes_should_reach_beyond_the_loads(frame, basis):
    """Thesis 3.6.1: a basis that stops below 1.5 times the highest frequency of the loads is noted."""
    assert 0.05 < basis.highest_frequency / DT < 0.22 + 0.02
    assert chosen_reduction(frame, "CB05", basis, TARGET)[1] == ()
    fast = dataclasses.replace(basis, highest_frequency=4.9 * DT)
    notes = chosen_reduction(frame, "CB00", fast, TARGET)[1]
    first = np.sqrt(reduce(frame, "CB01").fixed_interface[0]) / (2.0 * np.pi)
    assert (first < 1.5 * 4.9) == bool(notes)
    assert "leaves out a mode of the jacket" in spectral_note(frame, "CB05", 1e3)
    assert spectral_note(frame, "CB05", 0.0) is None
    assert spectral_note(frame, f"CB{frame.internal}", 1e3) is None


def test_refusals(frame, basis):
    with pytest.raises(InputError, match="chooses a basis for given loads"):
        chosen_reduction(frame, "auto", None, TARGET)
    with pytest.raises(InputError, match="must lie between 0 and 1"):
        auto_reduction(frame, basis, dataclasses.replace(TARGET, tolerance=0.0))


def test_loads_that_do_nothing(frame, basis):
    """A flat sea: no shapes, no error, and the smallest basis."""
    node = np.arange(4, frame.mesh.transition_piece)
    flat = load_basis(np.zeros((50, len(node), 6)), node, 30, model_hash=frame.mesh.structure.content_hash)
    choice = auto_reduction(frame, flat, TARGET)
    assert choice.reduced.name == "CB00"
    assert choice.estimate.energy == 0.0
