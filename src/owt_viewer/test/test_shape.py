"""The deformation shown is that of the structure stage's own basis functions."""

from functools import cache

import numpy as np
import pytest

from owt_campaign.pipeline import CaseRun, prepare_case, stream_case
from owt_model.config import parse_case
from owt_model.errors import ComputationError
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_viewer.core.shape import displacement_basis, node_displacement


@cache
def prepared(reduction: str) -> CaseRun:
    return prepare_case(
        parse_case(
            {
                "sea_state": {"hs_m": 3.0, "tp_s": 8.0, "seed": 2},
                "wave": {"order": 1},
                "time": {"n": 190},
                "structure": {"reduction": reduction, "tolerance": 0.05},
            }
        )
    )


@pytest.mark.parametrize("reduction", ["CB10M10", "CB00", "M08", "CB05M03j1Y", "auto"])
def test_nodes_move_as_in_the_structure_stage(reduction: str) -> None:
    """Bit by bit the same functions, so round-off only: also the pairs of modes of a square jacket."""
    run = prepared(reduction)
    model, block = run.response, next(iter(stream_case(run))).modal
    basis = displacement_basis(run.mesh, model.description, run.load_basis)
    expected = model.node_basis[:, :3] @ block.displacement[40]
    assert np.abs(expected).max() > 1e-4
    np.testing.assert_allclose(node_displacement(basis, block.displacement[40]), expected, rtol=0, atol=1e-12)


def test_the_wrong_sign_of_one_mode_would_be_seen() -> None:
    run = prepared("CB10M10")
    block = next(iter(stream_case(run))).modal.displacement[40].copy()
    basis = displacement_basis(run.mesh, run.response.description, run.load_basis)
    expected = node_displacement(basis, block)
    block[np.abs(block[6:16]).argmax() + 6] *= -1.0
    assert np.abs(node_displacement(basis, block) - expected).max() > 1e-9


def test_the_unreduced_jacket_follows_the_transition_piece() -> None:
    run = prepared("full")
    coordinate = next(iter(stream_case(run))).modal.displacement[40]
    moved = node_displacement(
        displacement_basis(run.mesh, run.response.description, run.load_basis), coordinate
    )
    np.testing.assert_allclose(moved[run.mesh.transition_piece], coordinate[:3], atol=1e-15)
    np.testing.assert_allclose(moved[run.mesh.tower_top], coordinate[-6:-3], atol=1e-15)
    assert np.abs(moved[run.mesh.node_position[:, 2] < -49.9]).max() < 0.2 * np.abs(moved).max()


def test_a_basis_of_other_coordinates_is_refused() -> None:
    run, other = prepared("CB10M10"), prepared("CB00").response.description
    described = type(other)(**{**vars(other), "reduction": "CB10M10"})
    with pytest.raises(ComputationError, match="that are not the same"):
        displacement_basis(run.mesh, described, run.load_basis)
    tower = build_mesh(load_structure("oc4-thesis"))
    assert tower.structure.content_hash != run.mesh.structure.content_hash
