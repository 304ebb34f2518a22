"""The structure stage: output times, streaming, energy, exactness of a complete basis, and refusals."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.errors import ComputationError, InputError
from owt_model.mesh import build_mesh
from owt_structure_node.core.response import build_modal_model
from owt_structure_node.core.stage import build_response_model, initial_state, step

SAMPLES = 40


def case_of(reduction, **structure):
    return parse_case({"structure": {"model": "oc4", "reduction": reduction} | structure})


UNDAMPED = {"damping": {"alpha": 0.0, "beta": 0.0}}


@pytest.fixture(scope="module")
def mesh(models):
    return build_mesh(models.frame())


@pytest.fixture(scope="module")
def record(mesh):
    """Smooth random loads on the wet nodes, with fixed-end forces."""
    rng = np.random.default_rng(11)
    node = np.flatnonzero((mesh.node_position[:, 2] < 0) & (np.arange(mesh.n_nodes) < mesh.transition_piece))
    element = np.unique(mesh.end_element)[::2]
    time = 0.1 * np.arange(SAMPLES)
    nodal, fixed = 0.0, 0.0
    for omega in (0.7, 1.9, 4.1, 9.0):
        wave = np.cos(omega * time + omega)[:, None, None]
        nodal = nodal + wave * rng.standard_normal((len(node), 6)) * [1e5, 1e5, 1e5, 1e4, 1e4, 1e4]
        fixed = fixed + wave * rng.standard_normal((len(element), 12)) * 1e4
    return {"node": node, "element": element, "nodal": nodal, "fixed_end": fixed}


def run(models, mesh, model, record, cuts):
    """Stream the record cut at `cuts`; return the concatenated outputs and the blocks."""
    state, out = initial_state(model), []
    for i, (a, b) in enumerate(pairwise(cuts)):
        block = models.block(
            mesh,
            record["nodal"][a:b],
            node=record["node"],
            element=record["element"],
            fixed_end=record["fixed_end"][a:b],
            sequence=i,
            start=a,
            last=b == SAMPLES,
        )
        state, response = step(model, state, block)
        out.append(response)
    fields = {
        "displacement": lambda r: r.modal.displacement,
        "velocity": lambda r: r.modal.velocity,
        "acceleration": lambda r: r.modal.acceleration,
        "axial": lambda r: r.stress.axial,
        "bending_y": lambda r: r.stress.bending_y,
        "bending_z": lambda r: r.stress.bending_z,
        "von_mises": lambda r: r.stress.von_mises,
        "potential": lambda r: r.energy.potential,
        "kinetic": lambda r: r.energy.kinetic,
        "potential_mode": lambda r: r.energy.potential_mode,
    }
    return {name: np.concatenate([get(r) for r in out]) for name, get in fields.items()}, out


def worst(found, expected):
    return max(np.abs(found[k] - expected[k]).max() / np.abs(expected[k]).max() for k in expected)


def test_output_times(models, mesh, record):
    """First block 5 (L - 1) + 1 rows from t = 0, later ones 5 L, without a gap."""
    model = build_response_model(case_of("CB05"), mesh, None)
    _, blocks = run(models, mesh, model, record, [0, 10, 17, 18, SAMPLES])
    assert [len(b.energy.potential) for b in blocks] == [46, 35, 5, 110]
    assert [b.modal.start for b in blocks] == [0, 46, 81, 86]
    assert [b.stress.last for b in blocks] == [False, False, False, True]
    assert {b.stress.dt for b in blocks} == {0.02}
    assert blocks[1].modal.time_ns == 920_000_000
    one, _ = run(models, mesh, model, record, [0, 1, SAMPLES])
    assert len(one["potential"]) == 5 * (SAMPLES - 1) + 1


def test_static_start(models, mesh, record):
    """The first row is the static answer to the first sample; a constant load keeps it for ever."""
    model = build_response_model(case_of("CB05"), mesh, None)
    still = dict(record)
    for key in ("nodal", "fixed_end"):
        still[key] = np.repeat(record[key][:1], SAMPLES, axis=0)
    out, _ = run(models, mesh, model, still, [0, 13, SAMPLES])
    for name in ("displacement", "axial", "von_mises", "potential"):
        scale = np.abs(out[name]).max()
        assert np.abs(out[name] - out[name][0]).max() < 1e-9 * scale
    assert out["kinetic"].max() < 1e-15 * out["potential"].max()
    moving, _ = run(models, mesh, model, record, [0, SAMPLES])
    assert moving["kinetic"].max() > 1e-6 * moving["potential"].max()


@pytest.mark.parametrize("reduction", ["CB05", "CB05+SIM"])
def test_streaming_is_the_batch(models, mesh, record, reduction):
    """Any cut gives the numbers of one block to round-off; the same cut gives the same bits."""
    model = build_response_model(case_of(reduction), mesh, None)
    whole, _ = run(models, mesh, model, record, [0, SAMPLES])
    for cuts in (list(range(SAMPLES + 1)), [0, 7, 8, 30, SAMPLES]):
        streamed, _ = run(models, mesh, model, record, cuts)
        assert worst(streamed, whole) < 1e-12
        again, _ = run(models, mesh, build_response_model(case_of(reduction), mesh, None), record, cuts)
        assert all(np.array_equal(again[name], streamed[name]) for name in streamed)
    shifted = dict(record, nodal=np.roll(record["nodal"], 1, axis=0))
    assert worst(run(models, mesh, model, shifted, [0, SAMPLES])[0], whole) > 1e-3


def test_static_improvement_in_recovery(models, mesh, record):
    """Stress and energy with SIM are nearer to the full model; what is left is dynamic and falls with it."""
    full, _ = run(models, mesh, build_response_model(case_of("full"), mesh, None), record, [0, 20, SAMPLES])
    error = {}
    for name in ("CB05", "CB05+SIM", "CB20+SIM"):
        found, _ = run(
            models, mesh, build_response_model(case_of(name), mesh, None), record, [0, 20, SAMPLES]
        )
        kept = {key: full[key] for key in ("axial", "bending_y", "bending_z", "potential")}
        error[name] = worst(found, kept)
    assert error["CB05+SIM"] < 0.2 * error["CB05"]
    assert error["CB20+SIM"] < 0.5 * error["CB05+SIM"]
    assert error["CB20+SIM"] < 0.05


def test_complete_basis_is_the_full_model(models, mesh, record):
    """Stresses, energies and motion of CB with all its modes are those of the unreduced model."""
    full, _ = run(models, mesh, build_response_model(case_of("full"), mesh, None), record, [0, 20, SAMPLES])
    internal = build_modal_model(mesh, "full").assembly.internal
    every = build_response_model(case_of(f"CB{internal}"), mesh, None)
    found, _ = run(models, mesh, every, record, [0, 20, SAMPLES])
    names = every.description.coordinate_name
    outer = [i for i, name in enumerate(names) if not name.startswith("CB")]
    names = (
        "displacement",
        "velocity",
        "axial",
        "bending_y",
        "bending_z",
        "von_mises",
        "potential",
        "kinetic",
    )
    for name in names:
        mine = found[name][:, outer] if name in ("displacement", "velocity") else found[name]
        assert np.abs(mine - full[name]).max() < 1e-6 * np.abs(full[name]).max()
    few, _ = run(models, mesh, build_response_model(case_of("CB05"), mesh, None), record, [0, 20, SAMPLES])
    assert np.abs(few["von_mises"] - full["von_mises"]).max() > 1e-3 * np.abs(full["von_mises"]).max()


def test_augmented_basis_beats_modes_on_the_loads_it_was_made_for(models, mesh, record):
    """Static first row: exact with the load's own shapes in the basis, wrong with modes alone."""
    shape = record["nodal"][0]
    basis = models.load_basis(mesh, shape[None] / np.linalg.norm(shape), node=record["node"])
    full, _ = run(models, mesh, build_response_model(case_of("full"), mesh, None), record, [0, SAMPLES])
    for reduction, exact in (("M01", True), ("CB05M01", True), ("CB05", False)):
        out, _ = run(
            models, mesh, build_response_model(case_of(reduction), mesh, basis), record, [0, SAMPLES]
        )
        error = abs(out["potential"][0] / full["potential"][0] - 1)
        assert (error < 1e-8) == exact


def test_energy_balance_of_the_jacket(models):
    """Undamped OC4 jacket: potential plus kinetic energy gained is the work of the nodal loads."""
    mesh = models.shipped("oc4-thesis").mesh
    rng = np.random.default_rng(6)
    node = np.flatnonzero((mesh.node_position[:, 2] < 0) & (np.arange(mesh.n_nodes) < mesh.transition_piece))
    time = 0.1 * np.arange(SAMPLES)
    nodal = 0.0
    for omega in (0.7, 2.3, 6.0):
        nodal = nodal + np.sin(omega * time)[:, None, None] * rng.standard_normal((len(node), 6)) * 1e4

    def imbalance(**structure):
        model = build_response_model(case_of("CB10", **structure), mesh, None)
        state, out = initial_state(model), []
        for i, (a, b) in enumerate(((0, 17), (17, SAMPLES))):
            block = models.block(mesh, nodal[a:b], node=node, sequence=i, start=a, last=b == SAMPLES)
            state, response = step(model, state, block)
            out.append(response)
        q = np.concatenate([r.modal.displacement for r in out])
        energy = np.concatenate([r.energy.potential + r.energy.kinetic for r in out])
        fine = 0.02 * np.arange(len(q))
        load = nodal.reshape(SAMPLES, -1)
        load = np.array([np.interp(fine, time, column) for column in load.T]).T
        motion = q @ model.node_basis[node].reshape(-1, q.shape[1]).T
        work = np.cumsum((0.5 * (load[1:] + load[:-1]) * np.diff(motion, axis=0)).sum(axis=1))
        return np.abs(energy[1:] - energy[0] - work).max() / energy.max()

    assert imbalance(**UNDAMPED) < 1e-9
    assert imbalance() > 1e-3  # damping takes its share


def test_energies_per_mode_sum_to_the_total(models, mesh, record):
    out, blocks = run(models, mesh, build_response_model(case_of("CB05"), mesh, None), record, [0, SAMPLES])
    assert np.allclose(out["potential_mode"].sum(axis=1), out["potential"], rtol=1e-12)
    assert out["potential"].min() > 0.0
    assert blocks[0].energy.kinetic_mode.shape == out["potential_mode"].shape


def test_description(mesh):
    model = build_response_model(case_of("CB05"), mesh, None)
    d = model.description
    assert d.model_hash == mesh.structure.content_hash
    assert d.coordinate_name[d.tower_top_coordinate] == "tower.3.ux"
    assert len(d.end_name) == 2 * mesh.n_members
    assert d.end_name[0] == "lega1:a1"
    assert len(d.frequency_hz) == len(d.damping_ratio) == len(d.coordinate_name)
    omega = 2 * np.pi * d.frequency_hz
    assert np.allclose(d.damping_ratio, 0.027 / (2 * omega) + 0.002 * omega / 2, rtol=1e-12)


def test_structure_without_a_tower(models):
    """The top is the transition piece, and the stage runs."""
    mesh = build_mesh(models.frame(tower=None, rotor_nacelle=None))
    model = build_response_model(case_of("CB05"), mesh, None)
    assert model.description.coordinate_name[model.description.tower_top_coordinate] == "TP.ux"
    _, response = step(model, initial_state(model), models.block(mesh, np.ones((3, mesh.n_nodes, 6))))
    assert response.modal.displacement.shape == (11, 11)


@pytest.mark.filterwarnings("ignore:overflow")
def test_bad_blocks_are_refused(models, mesh, record):
    """Wrong structure, gap, repetition, after the last, other nodes, NaN: errors that name the block."""
    model = build_response_model(case_of("CB05"), mesh, None)

    def make(**change):
        data = {k: record[k][:4] if k in ("nodal", "fixed_end") else record[k] for k in record}
        block = models.block(mesh, data.pop("nodal"), last=False, **data)
        return dataclasses.replace(block, **change)

    state, _ = step(model, initial_state(model), make())
    following = {"sequence": 1, "start": 4}
    nan = record["nodal"][:4].copy()
    nan[2, 0, 0] = np.nan
    infinite = record["fixed_end"][:4].copy()
    infinite[3, 0, 0] = np.inf
    none = {key: record[key][:0] for key in ("nodal", "fixed_end")}
    for change, message in (
        ({"model_hash": "0" * 64}, "made for structure 000000000000"),
        ({}, "block 0 from sample 0: expected block 1 from sample 4"),
        ({"sequence": 2, "start": 8}, "expected block 1"),
        ({"sequence": 1, "start": 5}, "from sample 5: expected block 1 from sample 4"),
        (following | {"dt": 0.2}, "time step 0.2 s, the case has 0.1 s"),
        (following | {"node": record["node"][::-1].copy()}, "loads other nodes"),
        (following | {"nodal": nan}, "nodal load of sample 6 is NaN or inf"),
        (following | {"fixed_end": infinite}, "fixed-end force of sample 7 is NaN or inf"),
        (following | none, "0 samples of nodal loads"),
    ):
        with pytest.raises(ComputationError, match=message):
            step(model, state, make(**change))
    state, _ = step(model, state, make(**following, last=True))
    with pytest.raises(ComputationError, match="comes after the block marked last"):
        step(model, state, make(sequence=2, start=8))
    with pytest.raises(ComputationError, match="the mesh has 0 to"):
        step(model, initial_state(model), make(node=record["node"] + 1000))
    with pytest.raises(ComputationError, match="twice"):
        step(model, initial_state(model), make(node=np.zeros_like(record["node"])))
    huge = make(nodal=np.full_like(record["nodal"][:4], 1e300))
    with pytest.raises(ComputationError, match="not finite"):
        step(model, initial_state(model), huge)


def test_reduction_without_a_load_basis_is_refused(mesh):
    with pytest.raises(InputError, match="needs 10 load vectors, no load basis"):
        build_response_model(case_of("CB10M10"), mesh, None)
