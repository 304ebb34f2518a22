"""General damping: vectors of dashpots, ratios of modes, decays; the jacket's stiffness factor."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from scipy.linalg import eig

from owt_model.config import parse_case
from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.pod import load_basis
from owt_model.structure import case_structure, load_structure, parse_structure
from owt_model.structure_config import Damping
from owt_structure_node.core import damping as damping_module
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.damping import (
    ModalDamping,
    damped_modes,
    dashpot_vectors,
    modal_damping,
)
from owt_structure_node.core.eigen import eigen_report, log_decrement
from owt_structure_node.core.error_estimate import LOW_MODES, ErrorModel
from owt_structure_node.core.integrators import METHODS
from owt_structure_node.core.modes import lowest_modes
from owt_structure_node.core.motion import MotionState, Oscillators, integrate, static_state
from owt_structure_node.core.recovery import end_force_map
from owt_structure_node.core.reduction import guyan
from owt_structure_node.core.response import build_modal_model, model_damping

NONE = Damping(alpha=0.0, beta=0.0)
TOP = (3e4, 2e4, 1e4, 4e5, 5e5, 6e5)


def rigid(mesh, seed=0):
    """Motion of all nodes with a body that moves and turns [6 node]."""
    move, turn = np.random.default_rng(seed).standard_normal((2, 3))
    motion = np.tile(np.concatenate([move, turn]), (mesh.n_nodes, 1))
    motion[:, :3] += np.cross(turn, mesh.node_position)
    return motion.reshape(-1)


def held(models, dashpots, **more):
    return build_mesh(models.frame(dashpots=dashpots, **more))


# --- vectors of dashpots ------------------------------------------------------------------------------


@pytest.mark.parametrize("joints", [["b1", "c3"], ["a2", "b4"], ["b2", "tower_top"], ["tower_top", "b2"]])
def test_pair_does_not_resist_a_rigid_motion(models, monkeypatch, joints):
    mesh = held(models, {"D": {"joints": joints, "damping": list(TOP)}})

    def check():
        vectors = dashpot_vectors(mesh, NONE)
        assert len(vectors) == 6
        assert np.abs(vectors @ rigid(mesh)).max() < 1e-12 * np.abs(vectors).max() * 1e2

    check()
    # to the ground it resists, and so does a pair without the arm between its places
    alone = held(models, {"D": {"joints": joints[1:], "damping": list(TOP)}})
    assert np.abs(dashpot_vectors(alone, NONE) @ rigid(alone)).max() > 1.0
    monkeypatch.setattr(damping_module, "lever", lambda offset: np.eye(6))
    with pytest.raises(AssertionError):
        check()


def test_pair_resists_relative_motion_at_its_second_place(models):
    """Power c v^2 of a motion of the second place alone; of the first the same with the arm's rotation."""
    mesh = held(models, {"D": {"joints": ["b1", "c3"], "damping": [5.0, 0, 0, 0, 0, 0]}})
    vectors = dashpot_vectors(mesh, NONE)
    assert len(vectors) == 1
    first, second = (mesh.node_name.index(name) for name in ("b1", "c3"))
    arm = mesh.node_position[second] - mesh.node_position[first]
    expected = np.zeros((mesh.n_nodes, 6))
    expected[second, 0] = 1.0
    expected[first] = [-1.0, 0.0, 0.0, 0.0, -arm[2], arm[1]]  # -(theta x r)_x
    assert vectors.T @ vectors == pytest.approx(
        5.0 * np.outer(expected.reshape(-1), expected.reshape(-1)), abs=1e-12
    )


def test_tower_top_is_the_last_node_or_the_transition_piece(models):
    mesh = held(models, {"D": {"joints": ["tower_top"], "damping": list(TOP)}})
    named = dashpot_vectors(mesh, NONE)
    given = dashpot_vectors(build_mesh(models.frame()), Damping(tower_top=TOP))
    assert named.T @ named == pytest.approx(given.T @ given)
    assert set(np.flatnonzero(named.any(axis=0)) // 6) == {mesh.tower_node[-1]}
    bare = held(
        models,
        {"D": {"joints": ["tower_top"], "damping": list(TOP)}},
        tower=None,
        rotor_nacelle=None,
    )
    assert set(np.flatnonzero(dashpot_vectors(bare, NONE).any(axis=0)) // 6) == {bare.transition_piece}


def test_matrix_is_the_sum_of_its_vectors(models):
    """A full matrix, one of rank two, and no coefficient at all."""
    root = np.random.default_rng(1).standard_normal((6, 6)) * [[1e3]] * 6
    for matrix, rank in ((root @ root.T, 6), (root[:, :2] @ root[:, :2].T, 2), (np.zeros((6, 6)), 0)):
        matrix = 0.5 * (matrix + matrix.T)
        mesh = held(models, {"D": {"joints": ["b1"], "damping": matrix.tolist()}})
        vectors = dashpot_vectors(mesh, NONE)
        assert vectors.shape == (rank, 6 * mesh.n_nodes)
        at = 6 * mesh.node_name.index("b1")
        assert (vectors.T @ vectors)[at : at + 6, at : at + 6] == pytest.approx(matrix, abs=1e-9 * 1e6)
    assert dashpot_vectors(mesh, NONE, np.ones((2, 6))).shape == (2, 6 * mesh.n_nodes)


def test_dashpot_at_a_clamped_joint_does_nothing(models):
    mesh = held(models, {"D": {"joints": ["a1"], "damping": list(TOP)}})
    model = build_modal_model(mesh, "CB05")
    assert not model_damping(model, NONE).coupling.any()
    free = build_modal_model(held(models, {"D": {"joints": ["b1"], "damping": list(TOP)}}), "CB05")
    assert model_damping(free, NONE).coupling.any()


# --- damping of the modes -----------------------------------------------------------------------------


def test_ratio_of_a_mode_that_there_is_not():
    omega2 = np.array([1.0, 4.0])
    with pytest.raises(InputError, match=r"structure\.damping\.modes = 3: is not one of 2 modes"):
        modal_damping(omega2, Damping(modes=((3.0, 5.0),)))
    modal_damping(omega2, Damping(modes=((2.0, 5.0),)))


def test_ratio_replaces_rayleigh_and_dashpots_add():
    omega2, damping = np.array([1.0, 4.0, 9.0]), Damping(alpha=0.1, beta=0.2, modes=((2.0, 10.0),))
    plain = modal_damping(omega2, damping)
    assert plain.coupling.shape == (3, 0)
    zeta = 0.1 / np.hypot(2.0 * np.pi, 0.1)
    assert plain.rate == pytest.approx([0.3, 2.0 * zeta * 2.0, 1.9], rel=1e-14)
    more = modal_damping(omega2, damping, np.array([[1.0, 2.0, 3.0]]))
    assert more.diagonal == pytest.approx(plain.rate + np.array([1.0, 4.0, 9.0]))


def test_many_directions_are_compressed_to_the_same_matrix():
    rng = np.random.default_rng(2)
    directions = rng.standard_normal((300, 12)) * np.geomspace(1e-2, 1e6, 300)[:, None]
    found = modal_damping(np.arange(1.0, 13.0), NONE, directions).coupling
    exact = directions.T @ directions
    assert found.shape == (12, 12)
    assert np.abs(found @ found.T - exact).max() < 1e-12 * np.abs(exact).max()
    rank_two = rng.standard_normal((50, 2)) @ rng.standard_normal((2, 12))
    assert modal_damping(np.arange(1.0, 13.0), NONE, rank_two).coupling.shape == (12, 2)
    assert modal_damping(np.ones(3), NONE, np.zeros((9, 3))).coupling.shape == (3, 0)


def test_damped_modes_are_named_after_the_undamped():
    """The second of two modes, so damped that it swings slower than the first, stays the second."""
    omega2, zeta = np.array([1.0, 1.1, 25.0]), np.array([0.01, 0.5, 0.02])
    column = np.array([[0.0], [np.sqrt(2.0 * 0.49 * np.sqrt(1.1))], [1e-4]])  # couples it to the third
    rate = 2.0 * np.array([0.01, 0.01, 0.02]) * np.sqrt(omega2)
    found = damped_modes(omega2, ModalDamping(rate, column))
    assert found.ratio == pytest.approx(zeta, rel=1e-4)
    assert found.frequency_hz == pytest.approx(np.sqrt(omega2 * (1.0 - zeta**2)) / (2.0 * np.pi), rel=1e-4)
    assert found.frequency_hz[1] < found.frequency_hz[0]


@pytest.mark.parametrize("zeta", [0.0, 0.5, 0.999, 1.001, 20.0, 1e9])
def test_one_oscillator_with_a_dashpot(zeta):
    """Overdamped it does not swing; its ratio is that of the diagonal."""
    found = damped_modes(np.array([9.0]), ModalDamping(np.zeros(1), np.array([[np.sqrt(6.0 * zeta)]])))
    assert found.ratio[0] == pytest.approx(zeta, rel=1e-9, abs=1e-12)
    swing = 3.0 * np.sqrt(max(1.0 - zeta**2, 0.0)) / (2.0 * np.pi)
    assert found.frequency_hz[0] == pytest.approx(swing, rel=1e-9)


def test_a_very_strong_dashpot_holds_its_place(models):
    """What swings has the frequencies of the frame whose tower top is held, and hardly any damping."""
    assembly = assemble(build_mesh(models.frame()))
    exact = lowest_modes(assembly.stiffness[:-6, :-6], assembly.mass[:-6, :-6], 6)[0]

    def check(strength):
        model = build_modal_model(assembly.mesh, "full")
        strong = model_damping(model, Damping(alpha=0.0, beta=0.0, tower_top=(strength,) * 6))
        found = damped_modes(model.omega_squared, strong)
        swings = found.frequency_hz > 0.0
        assert (~swings).sum() == 6
        order = np.argsort(found.frequency_hz[swings])[:6]
        assert (2.0 * np.pi * found.frequency_hz[swings][order]) ** 2 == pytest.approx(exact, rel=1e-5)
        assert found.ratio[swings][order].max() < 1e-3

    check(1e13)
    check(1e15)
    with pytest.raises(AssertionError):
        check(1e6)


def test_decrement_of_the_report_is_that_of_a_decay(models):
    """Decays in time, each started in its shape; samples obey x_2 = 2 e^-sh cos(wh) x_1 - e^-2sh x_0."""
    dashpots = {"D": {"joints": ["b1", "tower_top"], "damping": [4e4, 3e4, 0, 0, 0, 0]}}
    damping = Damping(alpha=0.02, beta=5e-4, tower_top=(1e5, 6e4, 0, 0, 0, 0))
    # Every mode: of the lowest 60 the pair's arm at b1 is too stiff, and mode 4 is off by 20 %.
    report = eigen_report(models.frame(dashpots=dashpots), damping=damping, n_modes=144)
    model = build_modal_model(held(models, dashpots), "full")
    c = model_damping(model, damping)
    n, h = len(c.rate), 0.001
    system = Oscillators(model.omega_squared, c.rate, h, 1, "exact", c.coupling)
    square = np.zeros((2 * n, 2 * n))
    square[:n, n:], square[n:, :n] = np.eye(n), -np.diag(model.omega_squared)
    square[n:, n:] = -np.diag(c.rate) - c.coupling @ c.coupling.T
    value, vector = eig(square)
    checked = 0
    for i in range(4):
        pair = int(np.abs(value.imag / (2.0 * np.pi) - report["damped_frequencies_hz"][i]).argmin())
        start = [(value[pair] ** k * vector[:n, pair]).real for k in range(3)]
        x = integrate(system, MotionState(*start, np.zeros(n)), np.zeros((2000, n)))[1].displacement
        x = x[::50, np.abs(start[0]).argmax()]
        twice, product = np.linalg.lstsq(np.column_stack([x[1:-1], x[:-2]]), x[2:], rcond=None)[0]
        modulus = np.sqrt(-product)
        decrement = -2.0 * np.pi * np.log(modulus) / np.arccos(0.5 * twice / modulus)
        assert 0.01 * report["logdec_percent"][i] == pytest.approx(decrement, rel=1e-4)  # step squared
        alone = log_decrement(c.diagonal / (2.0 * np.sqrt(model.omega_squared)))[i]
        checked += decrement != pytest.approx(alone, rel=1e-4)
    assert checked  # of the diagonal alone some mode has another decrement


# --- integration --------------------------------------------------------------------------------------


def strung(method, coupling, step=0.02):
    omega2 = np.array([4.0, 900.0, 7e3])
    return Oscillators(omega2, np.array([0.1, 0.3, 1.0]), step, 5, method, coupling)


@pytest.mark.parametrize("method", METHODS)
def test_dashpots_of_no_strength_change_no_bit(method):
    load = np.random.default_rng(3).standard_normal((50, 3))
    none, zero, some = (strung(method, c) for c in (None, np.zeros((3, 2)), 0.1 * np.ones((3, 2))))
    motion = [integrate(s, static_state(s, load[0]), load[1:])[1].acceleration for s in (none, zero, some)]
    assert np.array_equal(motion[0], motion[1])
    assert not np.array_equal(motion[0], motion[2])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("strength", [1.0, 1e4, 1e10])
def test_more_directions_than_modes_and_parallel_dashpots(method, strength):
    """Seven dashpots side by side are one of their sum; as strong as may be, they stay bounded."""
    g = np.sqrt(strength) * np.array([[0.7], [0.5], [-0.4]])
    load = np.random.default_rng(4).standard_normal((200, 3))
    one, seven = (strung(method, c) for c in (g, np.tile(g / np.sqrt(7.0), 7)))
    a, b = (integrate(s, static_state(s, load[0]), load[1:])[1] for s in (one, seven))
    for name in ("displacement", "velocity", "acceleration"):
        found, expected = getattr(b, name), getattr(a, name)
        # The seven make a system of condition 1 + g'qg <= 1e10.
        assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()
    free = integrate(strung(method, None), static_state(one, load[0]), load[1:])[1]
    assert np.abs(a.velocity @ g).max() < 0.9 * np.abs(free.velocity @ g).max()


# --- estimated errors ---------------------------------------------------------------------------------


def test_error_estimate_counts_dashpots(models):
    """Low modes resonate as with the same ratios given to them one by one."""
    assembly = assemble(build_mesh(models.frame()))
    mesh, rng = assembly.mesh, np.random.default_rng(5)
    node = np.arange(4, mesh.transition_piece)
    nodal = rng.standard_normal((400, len(node), 6)) * 1e4
    basis = load_basis(nodal, node, 5, model_hash=mesh.structure.content_hash)
    strong = Damping(tower_top=(6e4, 3e4, 0.0, 0.0, 0.0, 1e5))
    omega2, shapes = lowest_modes(assembly.stiffness, assembly.mass, LOW_MODES)
    top = shapes[-6:]  # the last motions are those of the tower top
    rate = strong.alpha + strong.beta * omega2 + np.array(strong.tower_top) @ top**2
    percent = 100.0 * log_decrement(rate / (2.0 * np.sqrt(omega2)))
    alike = Damping(modes=tuple((float(i + 1), float(p)) for i, p in enumerate(percent)))

    def gain(damping):
        return ErrorModel(assembly, basis, damping=damping, dt=0.1).low_gain

    assert gain(strong) == pytest.approx(gain(alike), rel=1e-9)
    assert gain(strong)[0] < 0.9 * gain(Damping())[0]


# --- input --------------------------------------------------------------------------------------------


def test_damping_of_a_case():
    damping = parse_case({"structure": {"damping": {"fit": [[0.4, 5.0], [6.0, 25.0]], "modes": [[1, 30]]}}})
    alpha, beta = damping.structure.damping.rayleigh
    omega = 2.0 * np.pi * np.array([0.4, 6.0])
    assert 100 * log_decrement((alpha / omega + beta * omega) / 2.0) == pytest.approx([5.0, 25.0], rel=1e-12)
    assert damping.structure.damping.mode_ratio == {0: pytest.approx(0.3 / np.hypot(2.0 * np.pi, 0.3))}
    assert Damping().rayleigh == (0.027, 0.002)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"fit": [[1, 5], [1, 5]]}, r"fit.*two different frequencies"),
        ({"fit": [[1, 5], [2, 50]]}, r"fit.*neither may be negative.*0\.5 to 2 times the first"),
        ({"fit": [[1, 5], [2, 2]]}, r"fit.*neither may be negative"),
        ({"fit": [[1, 5], [2, 5]], "alpha": 0.1}, r"damping\.alpha.*beside `fit`"),
        ({"modes": [[1.5, 5]]}, r"modes = 1\.5.*number of a mode"),
        ({"modes": [[0, 5]]}, r"modes = 0.*number of a mode"),
        ({"modes": [[1, 5], [1, 6]]}, r"modes = 1.*each once"),
        ({"modes": [[1, -5]]}, r"modes.*greater than or equal to 0"),
        ({"tower_top": [-1, 0, 0, 0, 0, 0]}, r"tower_top\[0\].*greater than or equal to 0"),
        ({"tower_top": [1, 2, 3]}, r"tower_top"),
    ],
)
def test_damping_that_cannot_be(given, message):
    with pytest.raises(InputError, match=message):
        parse_case({"structure": {"damping": given}})


ASYMMETRIC = [[0.0, 1.0, 0, 0, 0, 0], *[[0.0] * 6] * 5]


@pytest.mark.parametrize(
    ("dashpot", "message"),
    [
        ({"joints": ["q9"], "damping": [1.0] * 6}, r"dashpots\.D\.joints = 'q9': is not a joint"),
        ({"joints": ["b1", "q9"], "damping": [1.0] * 6}, r"dashpots\.D\.joints = 'q9': is not a joint"),
        ({"joints": ["b1", "b1"], "damping": [1.0] * 6}, r"must be two places"),
        ({"joints": [], "damping": [1.0] * 6}, r"dashpots\.D\.joints"),
        ({"joints": ["b1"], "damping": [-1.0, *[0.0] * 5]}, r"must not be negative in any direction"),
        ({"joints": ["b1"], "damping": ASYMMETRIC}, r"must be symmetric"),
        ({"joints": ["b1"], "damping": [1.0] * 5}, r"dashpots\.D\.damping"),
        ({"joints": ["b1"]}, r"dashpots\.D\.damping.*is missing"),
        ({"joints": ["b1"], "damping": [1.0] * 6, "stiffness": 1.0}, r"stiffness.*is not a known key"),
    ],
)
def test_dashpots_of_a_file(models, tmp_path, dashpot, message):
    data = models.frame().model_dump(mode="json", exclude_none=True)
    path = tmp_path / "frame.yaml"
    good = {"joints": ["b1", "tower_top"], "damping": [1.0] * 6}
    path.write_text(yaml.safe_dump(data | {"dashpots": {"D": good}}), encoding="utf-8")
    read = load_structure(str(path))
    assert read.dashpots["D"].joints == ("b1", "tower_top")
    assert read.content_hash == models.frame(dashpots={"D": good}).content_hash != models.frame().content_hash
    path.write_text(yaml.safe_dump(data | {"dashpots": {"D": dashpot}}), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        load_structure(str(path))


# --- stiffness factor of the jacket -------------------------------------------------------------------


def test_factor_of_the_case_or_of_the_structure():
    plain, soft = (
        case_structure(parse_case({"structure": {"model": "oc4-thesis"} | more}).structure)
        for more in ({}, {"jacket_stiffness_factor": 0.37})
    )
    assert plain.content_hash == load_structure("oc4-thesis").content_hash != soft.content_hash
    data = plain.model_dump(mode="json", exclude_none=True) | {"jacket_stiffness_factor": 0.37}
    assert parse_structure(data, source="soft").content_hash == soft.content_hash
    kept = case_structure(parse_case({"structure": {"model": "oc4-thesis"}}).structure)
    assert kept.jacket_stiffness_factor == 1.0
    with pytest.raises(InputError, match="jacket_stiffness_factor"):
        parse_structure(data | {"jacket_stiffness_factor": 0.0}, source="soft")


def test_factor_is_on_the_members_alone(models):
    """Stiffness of jacket and end forces scale, tower, springs and masses do not."""
    spring = {"b1": {"stiffness": [1e6, 1e6, 1e6, 0.0, 0.0, 0.0]}}
    one, soft, sprung = (
        assemble(build_mesh(models.frame(jacket_stiffness_factor=f, support_springs=s)))
        for f, s in ((1.0, {}), (0.37, {}), (0.37, spring))
    )
    assert guyan(soft).stiffness == pytest.approx(0.37 * guyan(one).stiffness, rel=1e-9, abs=1.0)
    assert guyan(soft).mass == pytest.approx(guyan(one).mass, rel=1e-9, abs=1e-3)
    assert (soft.upper_stiffness != one.upper_stiffness).nnz == 0
    assert (soft.mass != one.mass).nnz == 0
    difference = (sprung.jacket_stiffness - soft.jacket_stiffness).toarray()
    assert difference.diagonal().max() == pytest.approx(1e6, rel=1e-6)
    shape = np.random.default_rng(6).standard_normal((one.mesh.n_dof, 1))
    ends = [end_force_map(assembly, shape) for assembly in (one, soft)]
    assert ends[1] == pytest.approx(0.37 * ends[0], rel=1e-9)
    assert np.abs(ends[0]).max() > 0.0


def test_factor_with_the_weight_of_the_structure(models):
    """Forces at rest are those of statics, so that what they do to the stiffness stays as it was."""
    relief = {}
    for factor in (1.0, 0.37):
        loaded, elastic = (
            assemble(build_mesh(models.frame(jacket_stiffness_factor=factor, **more)))
            for more in ({"static_state": {}}, {})
        )
        relief[factor] = (elastic.stiffness - loaded.stiffness).toarray()
        assert (
            lowest_modes(loaded.stiffness, loaded.mass, 1)[0]
            < lowest_modes(elastic.stiffness, elastic.mass, 1)[0]
        )
    assert np.abs(relief[0.37] - relief[1.0]).max() < 1e-6 * np.abs(relief[1.0]).max()
    assert np.abs(relief[0.37] - 0.37 * relief[1.0]).max() > 0.1 * np.abs(relief[1.0]).max()
