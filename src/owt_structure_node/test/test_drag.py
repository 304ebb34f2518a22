"""Damping by the drag on the structure's own motion."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_structure_node.core.response import build_modal_model, drag_rate
from owt_structure_node.core.stage import build_response_model


@pytest.fixture(scope="module")
def mesh(models):
    return build_mesh(models.frame())


def damped(models, mesh, damping):
    basis = models.load_basis(mesh, np.zeros((0, mesh.n_nodes, 6)))
    return dataclasses.replace(basis, damping=damping)


def test_dashpots_at_all_nodes_damp_by_the_shape_of_each_mode(models, mesh) -> None:
    """c times the sum of the squared translations of the mode, full and reduced alike."""
    basis = damped(models, mesh, np.tile(7.0 * np.eye(3), (mesh.n_nodes, 1, 1)))
    full, reduced = (build_modal_model(mesh, name) for name in ("full", "CB10"))
    motion = full.node_basis[:, :3]
    assert drag_rate(full, basis) == pytest.approx(7.0 * (motion**2).sum(axis=(0, 1)), rel=1e-12)
    assert drag_rate(reduced, basis)[:3] == pytest.approx(drag_rate(full, basis)[:3], rel=1e-2)
    assert not drag_rate(full, None).any()
    assert not drag_rate(full, damped(models, mesh, np.zeros((0, 3, 3)))).any()


def test_it_adds_to_the_damping_of_the_model(models, mesh) -> None:
    case = parse_case({"structure": {"reduction": "CB10"}})
    dashpots = np.tile(1e3 * np.eye(3), (mesh.n_nodes, 1, 1))
    plain, more = (
        build_response_model(case, mesh, damped(models, mesh, d)) for d in (dashpots[:0], dashpots)
    )
    omega = 2.0 * np.pi * plain.description.frequency_hz
    added = more.description.damping_ratio - plain.description.damping_ratio
    model = build_modal_model(mesh, "CB10")
    expected = drag_rate(model, damped(models, mesh, dashpots))
    assert added == pytest.approx((expected / (2.0 * omega)), rel=1e-9)
    assert (added > 0.0).all()
    assert more.oscillators.damping == pytest.approx(plain.oscillators.damping + expected, rel=1e-12)


def test_damping_of_other_nodes_is_refused(models, mesh) -> None:
    with pytest.raises(InputError, match=r"load_basis\.damping"):
        drag_rate(build_modal_model(mesh, "CB10"), damped(models, mesh, np.zeros((3, 3, 3))))
