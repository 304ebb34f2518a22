"""Damping by the drag on the structure's own motion."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.structure_config import Damping
from owt_structure_node.core.response import build_modal_model, model_damping
from owt_structure_node.core.stage import build_response_model

NONE = Damping(alpha=0.0, beta=0.0)


@pytest.fixture(scope="module")
def mesh(models):
    return build_mesh(models.frame())


def damped(models, mesh, damping):
    basis = models.load_basis(mesh, np.zeros((0, mesh.n_nodes, 6)))
    return dataclasses.replace(basis, damping=damping)


def test_dashpots_at_all_nodes_damp_by_the_shape_of_each_mode(models, mesh) -> None:
    """The whole matrix Phi' C Phi, C = c I at the nodes' translations; full and reduced alike."""
    basis = damped(models, mesh, np.tile(7.0 * np.eye(3), (mesh.n_nodes, 1, 1)))
    full, reduced = (build_modal_model(mesh, name) for name in ("full", "CB10"))
    motion = full.node_basis[:, :3]
    found = model_damping(full, NONE, basis)
    expected = 7.0 * np.einsum("nam,nak->mk", motion, motion)
    assert found.coupling @ found.coupling.T == pytest.approx(expected, rel=1e-9, abs=1e-12 * expected.max())
    assert found.coupling.shape[1] <= len(full.omega_squared)
    assert found.diagonal == pytest.approx(np.diag(expected), rel=1e-12)
    assert model_damping(reduced, NONE, basis).diagonal[:3] == pytest.approx(found.diagonal[:3], rel=1e-2)
    assert not model_damping(full, NONE).diagonal.any()
    assert not model_damping(full, NONE, damped(models, mesh, np.zeros((0, 3, 3)))).diagonal.any()


def test_it_adds_to_the_damping_of_the_model(models, mesh) -> None:
    """Small damping adds the diagonal of Phi' C Phi to first order; the integration has all of it."""
    case = parse_case({"structure": {"reduction": "CB10"}})
    dashpots = np.tile(1e3 * np.eye(3), (mesh.n_nodes, 1, 1))
    plain, more = (
        build_response_model(case, mesh, damped(models, mesh, d)) for d in (dashpots[:0], dashpots)
    )
    omega = 2.0 * np.pi * plain.description.frequency_hz
    added = more.description.damping_ratio - plain.description.damping_ratio
    model = build_modal_model(mesh, "CB10")
    expected = model_damping(model, NONE, damped(models, mesh, dashpots))
    swinging = plain.description.damping_ratio < 0.5
    first_order = expected.diagonal / (2.0 * omega)
    assert added[swinging] == pytest.approx(first_order[swinging], rel=2e-2)
    assert (added[swinging] > 0.0).all()
    assert plain.oscillators.coupling is None
    assert more.oscillators.coupling == pytest.approx(expected.coupling, rel=1e-12)


def test_damping_of_other_nodes_is_refused(models, mesh) -> None:
    with pytest.raises(InputError, match=r"load_basis\.damping"):
        model_damping(build_modal_model(mesh, "CB10"), NONE, damped(models, mesh, np.zeros((3, 3, 3))))
