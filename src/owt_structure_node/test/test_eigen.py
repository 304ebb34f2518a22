"""The eigenvalue report: its keys, its options, and its refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.linalg import eigh

from owt_model.config import Damping
from owt_model.errors import ComputationError, InputError
from owt_model.mesh import build_mesh
from owt_structure_node import kernels
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.eigen import eigen_report, log_decrement
from owt_structure_node.core.modes import dense_modes


def test_report_is_plain_data(models):
    report = eigen_report(models.frame())
    again = json.loads(json.dumps(report, allow_nan=False))
    assert again == report
    for key in ("mass_kg", "frequencies_hz", "fixed_interface_frequencies_hz", "guyan_stiffness"):
        assert report[key]
    assert len(report["frequencies_hz"]) == 20
    assert report["frequencies_hz"] == sorted(report["frequencies_hz"])
    assert np.array(report["guyan_stiffness"]).shape == (6, 6)


def test_full_report_is_the_dense_solution(models):
    assembly = assemble(build_mesh(models.frame()))
    dense = np.sqrt(dense_modes(assembly.stiffness.toarray(), assembly.mass.toarray())[0]) / (2 * np.pi)
    report = eigen_report(models.frame(), n_modes=30)
    assert np.abs(np.array(report["frequencies_hz"]) / dense[:30] - 1).max() < 1e-7
    held = eigen_report(models.frame(), fixed_interface=True)
    assert held["frequencies_hz"] == held["fixed_interface_frequencies_hz"]
    assert held["frequencies_hz"][0] > 1.5 * report["frequencies_hz"][0]


def chain():
    """Three masses on springs of 1, two of them with a stub of next to no mass behind a stiff spring."""
    stiff = 1e8
    k = np.diag([2.0, 2.0 + stiff, 1.0 + stiff, stiff, stiff])
    for i, j, spring in ((0, 1, 1.0), (1, 2, 1.0), (2, 3, stiff), (1, 4, stiff)):
        k[i, j] = k[j, i] = -spring
    return k, np.diag([1.0, 1.0, 1.0, 1e-10, 1e-10])


def test_low_modes_survive_stiff_stubs_of_no_mass():
    """omega^2 of the chain is 4 sin^2((2 n - 1) pi/14), of the stubs 1e18, whose round-off is 100."""
    k, m = chain()
    exact = 4.0 * np.sin((2.0 * np.arange(1, 4) - 1.0) * np.pi / 14.0) ** 2
    values, shapes = dense_modes(k, m)
    assert np.abs(values[:3] / exact - 1.0).max() < 1e-6  # digits of 1 in 1e8
    assert values[3:] == pytest.approx(1e18, rel=1e-6)
    assert np.abs(shapes.T @ m @ shapes - np.eye(5)).max() < 1e-8
    # Negative control: one eigenvalue problem for all.
    assert np.abs(eigh(k, m)[0][:3] / exact - 1.0).max() > 1.0
    with pytest.raises(ComputationError, match="singular"):
        dense_modes(k - np.diag([1.0, 1.0, 1.0, 0.0, 0.0]), m)


def test_reductions_in_the_report(models):
    """Augmented reductions need a load basis; fewer modes than asked for are simply fewer."""
    structure = models.frame()
    mesh = build_mesh(structure)
    vectors = np.random.default_rng(0).standard_normal((4, mesh.n_nodes, 6))
    basis = models.load_basis(mesh, vectors)
    full = np.array(eigen_report(structure)["frequencies_hz"])
    for name, size in (("CB00", 24), ("CB10", 34), ("M04", 28), ("CB10M04", 38)):
        report = eigen_report(structure, name, basis=basis, n_modes=30)
        assert report["degrees_of_freedom"] == size
        assert len(report["frequencies_hz"]) == min(30, size)
        assert report["frequencies_hz"][0] == pytest.approx(full[0], rel=1e-2)
    with pytest.raises(InputError, match="needs 4 load vectors"):
        eigen_report(structure, "CB10M04")


def test_log_decrement():
    """delta = 2 pi zeta / sqrt(1 - zeta^2): the decay per period of a free oscillator."""
    zeta = np.array([0.01, 0.2, 0.7])
    omega = 3.0
    damped = omega * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * omega * 2 * np.pi / damped)
    assert np.allclose(log_decrement(zeta), -np.log(decay), rtol=1e-14)
    assert not np.allclose(log_decrement(zeta), 2 * np.pi * zeta, rtol=1e-3)
    assert np.isinf(log_decrement(np.array([1.0, 1.5]))).all()


def test_overdamped_modes_have_no_decrement(models):
    report = eigen_report(models.frame(), damping=Damping(alpha=0.0, beta=1.0))
    assert report["logdec_percent"][-1] is None


def test_refusals(models):
    with pytest.raises(InputError, match="n_modes"):
        eigen_report(models.frame(), n_modes=0)
    with pytest.raises(InputError, match=r"structure\.reduction"):
        eigen_report(models.frame(), "CB5")


def test_kernels_warm_up():
    kernels.warm_up()
