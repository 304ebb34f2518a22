"""Dashpots inside the jacket, whose static response few modes need; weak, strong and idle ones."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.errors import ComputationError
from owt_model.mesh import build_mesh
from owt_model.structure_config import Damping
from owt_structure_node.core import damping as damping_module
from owt_structure_node.core import eigen, reduction
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.damping import ModalDamping, damped_modes, lowest_damped, modal_damping
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.reduction import reduce
from owt_structure_node.core.response import build_modal_model, describe, model_damping
from owt_structure_node.core.response_model import build_response_model

#: Between two brace joints of one level, and turning one joint: motions that low modes hardly have.
PAIR = {"D": {"joints": ["b1", "b3"], "damping": [2e6, 2e6, 0, 0, 0, 0]}}
TURN = {"D": {"joints": ["b2"], "damping": [0, 0, 0, 1e9, 1e9, 1e9]}}
LIGHT = Damping(alpha=0.01, beta=1e-4)
MODES = 6


def exact(structure):
    """Log decrements of the lowest modes from all of them."""
    return np.array(
        eigen_report(structure, damping=LIGHT, n_modes=200)["logdec_percent"][:MODES], dtype=float
    )


def off(found, expected):
    return float(np.abs(np.array(found[:MODES], dtype=float) / expected - 1.0).max())


@pytest.mark.parametrize("dashpots", [PAIR, TURN], ids=["pair", "turn"])
def test_few_modes_and_static_responses_give_the_decrements_of_all(models, monkeypatch, dashpots):
    structure = models.frame(dashpots=dashpots)
    expected = exact(structure)
    assert off(eigen_report(structure, damping=LIGHT, n_modes=MODES)["logdec_percent"], expected) < 2e-4
    # Negative control: the lowest modes alone.
    monkeypatch.setattr(eigen, "with_static_responses", lambda _, k, m, modes, vectors: modes)
    assert off(eigen_report(structure, damping=LIGHT, n_modes=MODES)["logdec_percent"], expected) > 2e-3


def test_tower_top_dashpots_need_none_of_it(models):
    structure = models.frame()
    damping = LIGHT.model_copy(update={"tower_top": (5e4, 5e4, 0.0, 0.0, 0.0, 0.0)})
    few = eigen_report(structure, damping=damping, n_modes=MODES)["logdec_percent"]
    many = eigen_report(structure, damping=damping, n_modes=200)["logdec_percent"]
    assert off(few, np.array(many[:MODES], dtype=float)) < 1e-6


@pytest.mark.parametrize("name", ["CB10", "CB00"])
@pytest.mark.parametrize("dashpots", [PAIR, TURN], ids=["pair", "turn"])
def test_reduced_models_have_vectors_of_their_own_for_them(models, monkeypatch, name, dashpots):
    structure = models.frame(dashpots=dashpots)
    expected, reduced = exact(structure), reduce(assemble(build_mesh(structure)), name)
    directions = int(np.count_nonzero(dashpots["D"]["damping"]))
    assert len(reduced.pseudo) == directions
    assert reduced.notes == (f"{name} has up to {directions} more vectors, for dashpots inside the jacket",)
    found = eigen_report(structure, name, damping=LIGHT, n_modes=MODES)["logdec_percent"]
    limit = {"CB10": 0.01, "CB00": 0.05}[name]  # the basis itself moves the modes
    assert off(found[:4], expected[:4]) < limit
    monkeypatch.setattr(reduction, "_inner_dashpots", lambda assembly: np.zeros((assembly.internal, 0)))
    without = eigen_report(structure, name, damping=LIGHT, n_modes=MODES)["logdec_percent"]
    assert off(without[:4], expected[:4]) > 3.0 * off(found[:4], expected[:4])


def test_description_of_very_many_modes_counts_the_others(models, monkeypatch):
    """Of 144 modes 20 are reported, with the decrements of all."""
    structure = models.frame(dashpots=PAIR)
    model = build_modal_model(build_mesh(structure), "full")
    damping = model_damping(model, LIGHT)
    every = damped_modes(model.omega_squared, damping).ratio[:MODES]
    assert off(lowest_damped(model.omega_squared, damping, 20).ratio, every) < 1e-3
    cut = ModalDamping(damping.rate[:20], damping.coupling[:20])
    assert off(damped_modes(model.omega_squared[:20], cut).ratio, every) > 1e-2
    assert off(describe(model, damping).damping_ratio, every) < 1e-12  # fewer than it reports


def test_dashpots_at_the_interface_add_no_vectors(models):
    structure = models.frame(dashpots={"D": {"joints": ["c1"], "damping": [1e6] * 6}})
    reduced = reduce(assemble(build_mesh(structure)), "CB10")
    assert not len(reduced.pseudo)
    assert reduced.notes == ()


def test_weak_dashpots_stay_beside_strong_ones():
    """Singular values of G keep 1e-14 of the largest: coefficients keep 1e-28."""
    omega2 = np.array([1.0, 4.0, 9.0, 16.0, 25.0])
    strong = 1e7 * np.eye(5)[[4, 4, 4, 4, 4, 4, 3]]
    weak = np.array([[1.0, 1.0, 0.0, 0.0, 0.0]])
    found = modal_damping(omega2, Damping(alpha=0.0, beta=0.0), np.vstack([strong, weak]))
    assert found.coupling.shape[1] == 3
    assert found.diagonal[:2] == pytest.approx([1.0, 1.0], rel=1e-9)
    assert found.diagonal[4] == pytest.approx(6e14, rel=1e-12)


def test_a_negative_damping_ratio_is_an_error(monkeypatch):
    plain, omega2 = damping_module.eig, np.array([1.0, 4.0])
    damping = ModalDamping(np.zeros(2), np.array([[0.1], [0.05]]))
    damped_modes(omega2, damping)

    def lost(matrix):
        value, vector = plain(matrix)
        return value + 0.1, vector

    monkeypatch.setattr(damping_module, "eig", lost)
    with pytest.raises(ComputationError, match="lost its digits"):
        damped_modes(omega2, damping)


def test_dashpots_on_fixed_joints_are_noted(models):
    idle = {
        "D": {"joints": ["a1"], "damping": [1e6] * 6},
        "E": {"joints": ["a1", "b1"], "damping": [1.0] * 6},
    }
    case = parse_case({"structure": {"reduction": "CB05"}})
    assert "dashpots D do nothing: they sit on fixed joints" in notes_of(models, case, idle)
    assert not any("nothing" in note for note in notes_of(models, case, {"E": idle["E"]}))


def notes_of(models, case, dashpots):
    return build_response_model(case, build_mesh(models.frame(dashpots=dashpots)), None).description.notes
