"""Dashpots inside the jacket: few modes alone do not feel them, their static response does."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.mesh import build_mesh
from owt_model.structure_config import Damping
from owt_structure_node.core import eigen, reduction
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.damping import ModalDamping, damped_modes, lowest_damped
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.reduction import reduce
from owt_structure_node.core.response import build_modal_model, describe, model_damping

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
    assert reduced.notes == (f"{name} has {directions} more vectors, for dashpots inside the jacket",)
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
