"""The load at the tower top: samples of a topic, a rotor's thrust, and what the stage makes of it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from owt_model.config import parse_case
from owt_model.errors import ComputationError, InputError
from owt_model.live_samples import LiveRules
from owt_model.mesh import build_mesh
from owt_model.timing import sample_time_ns
from owt_model.wind_config import RotorConfig, ThrustConfig
from owt_structure_node.core import tower_top as module
from owt_structure_node.core.motion import integrate, static_state
from owt_structure_node.core.response import build_modal_model
from owt_structure_node.core.rotor_thrust import Rotor
from owt_structure_node.core.rotor_wind import Wind
from owt_structure_node.core.stage import build_response_model, initial_state, step
from owt_structure_node.core.tower_top import TowerTopLoad, WrenchSamples, beside, thrust_load, turned

SAMPLES, DT, SECOND = 30, 0.1, 1_000_000_000
REDUCTIONS = pytest.mark.parametrize("reduction", ["full", "CB05", "CB05+SIM"])
LINEAR = ("displacement", "velocity", "acceleration", "axial", "bending_y", "bending_z")
GRID = np.array([sample_time_ns(i, DT) for i in range(SAMPLES)])


@pytest.fixture(scope="module")
def mesh(models):
    return build_mesh(models.frame())


@pytest.fixture(scope="module")
def bare(models):
    return build_mesh(models.frame(tower=None, rotor_nacelle=None))


def load_blocks(models, mesh, cuts, nodal=None):
    """Blocks of nodal loads [sample, node, 6], those of two nodes also fixed-end forces, cut at `cuts`."""
    nodal = np.zeros((cuts[-1], mesh.n_nodes, 6)) if nodal is None else nodal
    given, blocks = {"dt": DT, "element": mesh.end_element[:1]}, []
    for i, (a, b) in enumerate(pairwise(cuts)):
        given |= {"sequence": i, "start": a, "last": b == cuts[-1]}
        blocks.append(models.block(mesh, nodal[a:b], fixed_end=nodal[a:b, :2].reshape(-1, 1, 12), **given))
    return blocks


def messages(*, on_grid):
    """Times from 0 to the last sample, on the samples or anywhere, and wrenches."""
    rng = np.random.default_rng(5)
    times = GRID[::2] if on_grid else np.cumsum(rng.integers(1, 4 * 10**8, 200)) - 10**7
    times = [0, *map(int, times[(times > 0) & (times < GRID[-1])]), int(GRID[-1])]
    return times, rng.standard_normal((len(times), 6)) * 1e5


def read_out(models, mesh, cuts, times, values, *, hold):
    """All samples, each message added when its block cannot do without it."""
    samples, found, given = WrenchSamples(LiveRules(step=hold)), [], iter(zip(times, values, strict=True))
    for block in load_blocks(models, mesh, cuts):
        while not samples.reach(block):
            samples.add(*next(given))
        found.append(samples.block(block))
    return np.concatenate([b.wrench for b in found])


@pytest.mark.parametrize("on_grid", [True, False])
@pytest.mark.parametrize("hold", [True, False])
def test_samples_of_messages(models, mesh, hold, on_grid):
    """Against np.interp, and a search sample by sample; the other rule gives other numbers."""
    times, values = messages(on_grid=on_grid)
    held = np.array([values[max(i for i, t in enumerate(times) if t <= now)] for now in GRID])
    linear = np.stack([np.interp(GRID, times, column) for column in values.T], axis=1)
    expected, other = (held, linear) if hold else (linear, held)
    found = read_out(models, mesh, [0, SAMPLES], times, values, hold=hold)
    np.testing.assert_allclose(found, expected, atol=1e-9)  # of 1e5: round-off of one product
    assert np.abs(found - other).max() > 1e3
    np.testing.assert_array_equal(found[np.isin(GRID, times)], values[np.isin(times, GRID)])


@pytest.mark.parametrize("hold", [True, False])
def test_blocks_of_any_length_give_the_same_samples(models, mesh, hold):
    """Bit for bit, with all messages there at once or just in time; what is past is forgotten on the way."""
    times, values = messages(on_grid=False)
    whole = read_out(models, mesh, [0, SAMPLES], times, values, hold=hold)
    for cuts in (range(SAMPLES + 1), [0, 1, 2, 17, SAMPLES], [0, 29, SAMPLES]):
        np.testing.assert_array_equal(read_out(models, mesh, cuts, times, values, hold=hold), whole)
        early = WrenchSamples(LiveRules(step=hold))
        for time, value in zip([*times, times[-1] + SECOND], [*values, np.ones(6)], strict=True):
            early.add(time, value)
        blocks = [early.block(block) for block in load_blocks(models, mesh, cuts)]
        np.testing.assert_array_equal(np.concatenate([b.wrench for b in blocks]), whole)
        assert len(early.buffer._time) == len(early.buffer._value) == 2


def test_messages_before_zero_and_just_short_of_the_end(models, mesh):
    samples, (block,) = WrenchSamples(LiveRules()), load_blocks(models, mesh, [0, 11])
    for time, value in ((-SECOND, -1.0), (SECOND - 1, 1.0), (SECOND, 1.0)):
        assert not samples.reach(block), "also where 1 ns is missing"
        samples.add(time, np.full(6, value))
    np.testing.assert_allclose(samples.block(block).wrench[:, 0], np.linspace(0.0, 1.0, 11), atol=1e-8)


def test_messages_that_are_refused(models, mesh):
    samples, (block,) = WrenchSamples(LiveRules(step=True)), load_blocks(models, mesh, [0, 5])
    with pytest.raises(ComputationError, match=r"asked for 0 s to 0\.4 s, known is nothing"):
        samples.block(block)
    samples.add(SECOND // 10, np.ones(6))
    # A stamp below the one before is sorted in as long as its time is not counted, so no error any more; two
    # values of one time still are.
    with pytest.raises(ComputationError, match=r"wrench at 0\.1 s comes twice, with different values"):
        samples.add(SECOND // 10, np.zeros(6))
    for bad in (np.nan, np.inf):
        with pytest.raises(ComputationError, match="wrench at 7 s holds NaN or inf"):
            samples.add(7 * SECOND, np.array([0.0, 0.0, 0.0, bad, 0.0, 0.0]))
    assert not samples.reach(block), "what was refused does not count"
    samples.add(SECOND, np.ones(6))
    with pytest.raises(ComputationError, match=r"known is 0\.1 s to 1 s; its first message must be stamped"):
        samples.block(block)


def test_block_of_a_record(models, mesh):
    wrench, blocks = np.arange(60.0).reshape(10, 6), load_blocks(models, mesh, [0, 3, 4, 10])
    found = [TowerTopLoad(wrench).block(block) for block in blocks]
    np.testing.assert_array_equal(np.concatenate([b.wrench for b in found]), wrench)
    for name in ("sequence", "start", "dt", "last"):
        assert [getattr(b, name) for b in found] == [getattr(b, name) for b in blocks]
    for short, held in ((wrench[:9], 9), (None, 0)):
        with pytest.raises(ComputationError, match=f"samples 4 to 10 asked for, the record has {held}"):
            TowerTopLoad(short).block(blocks[2])


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, -120.0, 360.0])
def test_turned(angle):
    """Force and moment alike, from x towards y; z and what is turned back stay."""
    wrench = np.random.default_rng(1).standard_normal((4, 6))
    found = turned(wrench, angle)
    for x in (0, 3):
        arrow = (wrench[:, x] + 1j * wrench[:, x + 1]) * np.exp(1j * np.deg2rad(angle))
        expected = np.stack([arrow.real, arrow.imag, wrench[:, x + 2]], axis=1)
        np.testing.assert_allclose(found[:, x : x + 3], expected, atol=1e-14)
    np.testing.assert_allclose(turned(found, -angle), wrench, atol=1e-14)


@pytest.fixture
def core_of(monkeypatch):
    """The rotor and the wind that the core gets for the options of a case."""
    given, rotor_thrust = [], module.rotor_thrust
    monkeypatch.setattr(module, "rotor_thrust", lambda *a, **k: given.append(a) or rotor_thrust(*a, **k))
    return lambda **options: (
        thrust_load(ThrustConfig(**options), tower_top_z=89.0, dt=DT, n=100),
        given[-1],
    )[1]


def test_fields_of_the_case_are_those_of_the_core(core_of):
    """Every one arrives, and has its default, but for the direction: wind goes with the default waves."""
    rotor, wind = core_of()
    assert rotor == Rotor()
    assert replace(wind, direction_deg=0.0) == Wind()
    assert wind.direction_deg == parse_case({}).sea_state.direction_deg
    assert [name for name in Rotor.__dataclass_fields__ if name != "hub_height"] == list(module.ROTOR)
    assert list(RotorConfig.model_fields) == list(module.ROTOR.values())
    changed = {name: 1.01 * field.default for name, field in RotorConfig.model_fields.items()}
    rotor, _ = core_of(rotor=RotorConfig(**changed))
    assert rotor.hub_height == 89.0 + changed["hub_above_top_m"]
    for name, given in module.ROTOR.items():
        assert given.startswith(name)
        assert getattr(rotor, name) == changed[given] != getattr(Rotor(), name)
    options = {"speed_m_s": 9.0, "turbulence": "A", "direction_deg": -30.0, "shear_exponent": 0.2, "seed": 7}
    assert core_of(**options)[1] == Wind(*options.values())
    assert core_of(turbulence_intensity=0.11)[1].turbulence == 0.11
    assert len(ThrustConfig.model_fields) == len(options) + 3, "the two, and aerodynamic_damping"


@pytest.mark.parametrize("direction", [0.0, 90.0, 210.0])
def test_thrust_pushes_and_damps_along_the_wind(direction):
    b, h, c = np.deg2rad(direction), 3.0, 5e4
    options = {"direction_deg": direction, "rotor": RotorConfig(hub_above_top_m=h, damping_n_s_m=c)}
    load = thrust_load(ThrustConfig(**options), tower_top_z=89.0, dt=DT, n=200)
    axis = np.array([np.cos(b), np.sin(b), 0.0])
    unit = np.concatenate([axis, np.cross([0.0, 0.0, h], axis)])
    thrust = load.wrench @ unit / (unit @ unit)
    np.testing.assert_allclose(load.wrench, np.outer(thrust, unit), atol=1e-6)  # of 5e5 N
    assert thrust.min() > 1e5
    np.testing.assert_allclose(load.dashpots, np.sqrt(c) * unit[None], atol=1e-9)
    # Its power is c times the square of the hub's velocity along the wind.
    speed, turn = np.array([0.3, -0.2, 0.1]), np.array([0.02, 0.03, -0.01])
    hub = speed + np.cross(turn, [0.0, 0.0, h])
    assert np.sum((load.dashpots @ [*speed, *turn]) ** 2) == pytest.approx(c * (hub @ axis) ** 2)
    undamped = thrust_load(ThrustConfig(**options, aerodynamic_damping=False), tower_top_z=89.0, dt=DT, n=200)
    np.testing.assert_array_equal(undamped.wrench, load.wrench)
    none = thrust_load(ThrustConfig(rotor=RotorConfig(damping_n_s_m=0.0)), tower_top_z=89.0, dt=DT, n=200)
    assert undamped.dashpots.shape == none.dashpots.shape == (0, 6)


@pytest.mark.parametrize(
    ("thrust", "message"),
    [
        ({"speed_m_s": 2.0}, r"wind\.thrust\.speed_m_s = 2\.0: lies outside cut-in"),
        ({"rotor": {"diameter_m": 200.0}}, r"wind\.thrust\.rotor\.diameter_m = 200\.0: must be below twice"),
        ({"rotor": {"tower_distance_m": 2.0}}, r"wind\.thrust\.rotor\.tower_distance_m = 2\.0"),
        ({"rotor": {"controller_time_s": 0.15}}, r"time\.dt_s = 0\.1: must be > 0 and at most half"),
    ],
)
def test_a_rotor_is_refused_in_the_words_of_the_case(thrust, message):
    with pytest.raises(InputError, match=f"^{message}"):
        thrust_load(ThrustConfig.model_validate(thrust), tower_top_z=89.0, dt=DT, n=100)


def run(models, mesh, cuts, *, nodal=None, wrench=None, reduction="CB05", **structure):
    """Stream loads through the stage; everything that it gives, by name."""
    model = build_response_model(parse_case({"structure": {"reduction": reduction} | structure}), mesh, None)
    state, found = initial_state(model), []
    for block in load_blocks(models, mesh, cuts, nodal):
        top = None if wrench is None else beside(block, wrench[block.start : block.start + len(block.nodal)])
        state, out = step(model, state, block, top)
        found.append({k: v for part in (out.modal, out.stress, out.energy) for k, v in vars(part).items()})
    arrays = [name for name, value in found[0].items() if isinstance(value, np.ndarray)]
    return {name: np.concatenate([block[name] for block in found]) for name in arrays}


def close(one, two, names=LINEAR, limit=1e-11):
    """Tell whether series agree, relative to the largest value of each; modes leave 1e-13 of round-off."""
    return all(np.abs(one[n] - two[n]).max() <= limit * np.abs(two[n]).max() for n in names)


@pytest.fixture(scope="module")
def loads(mesh):
    """Nodal loads [sample, node, 6] and a wrench [sample, 6], neither zero at the start."""
    rng, t = np.random.default_rng(3), DT * np.arange(SAMPLES)[:, None, None]
    nodal = np.cos(2.0 * t + 0.4) * rng.standard_normal((mesh.n_nodes, 6)) * 1e5
    return nodal, (1.0 + np.sin(3.1 * t[:, 0] + 1.0)) * rng.standard_normal(6) * 1e5


def static_motion(assembly, force):
    """Motion of the free degrees of freedom under forces [node, 6], by the whole stiffness matrix."""
    return spsolve(assembly.stiffness, assembly.expansion.T @ force.reshape(-1))


@REDUCTIONS
def test_a_constant_wrench_is_a_static_load(models, mesh, reduction):
    """K^-1 f from the first row on, nothing moves; a wrench that sets in later does move it."""
    force = np.zeros((mesh.n_nodes, 6))
    force[mesh.tower_top] = [3e5, -2e5, -4e5, 5e6, 4e6, 1e6]
    above = mesh.node_dof[[mesh.transition_piece, *mesh.tower_node]]
    expected = static_motion(build_modal_model(mesh, reduction).assembly, force)[above]
    steady = np.tile(force[mesh.tower_top], (SAMPLES, 1))
    found = run(models, mesh, [0, 7, SAMPLES], wrench=steady, reduction=reduction)
    shown = np.hstack([found["displacement"][:, :6], found["displacement"][:, -18:]])
    # Round-off of static condensation and of modes: 1e-9 of the largest.
    assert np.abs(shown - expected.reshape(-1)).max() < 1e-8 * np.abs(expected).max()
    assert found["kinetic"].max() < 1e-15 * found["potential"].max()
    steady[0] = 0.0
    late = run(models, mesh, [0, 7, SAMPLES], wrench=steady, reduction=reduction)
    assert late["kinetic"].max() > 0.01 * late["potential"].max()


def test_waves_and_wrench_superpose(models, mesh, loads):
    nodal, wrench = loads
    loaded = ({"nodal": nodal}, {"wrench": wrench}, {"nodal": nodal, "wrench": wrench})
    waves, wind, both = (run(models, mesh, [0, 11, SAMPLES], **given) for given in loaded)
    assert close({name: waves[name] + wind[name] for name in LINEAR}, both)
    assert not close(waves, both, limit=1e-3)
    at_node = nodal.copy()
    at_node[:, mesh.tower_top] += wrench
    assert close(run(models, mesh, [0, 11, SAMPLES], nodal=at_node), both)


@pytest.mark.parametrize("reduction", ["CB05", "CB05+SIM"])
def test_ramp(models, mesh, loads, reduction):
    """From zero; the loads times half a cosine, unscaled after it, whatever the blocks."""
    (nodal, wrench), names = loads, (*LINEAR, "potential", "kinetic")
    t, length = DT * np.arange(SAMPLES), 1.25
    factor = np.where(t < length, 0.5 - 0.5 * np.cos(np.pi * t / length), 1.0)
    given = {"nodal": nodal, "wrench": wrench, "reduction": reduction}
    found = run(models, mesh, [0, SAMPLES], **given, ramp_s=length)
    assert not any(found[name][0].any() for name in names)
    by_hand = given | {"nodal": nodal * factor[:, None, None], "wrench": wrench * factor[:, None]}
    assert close(found, run(models, mesh, [0, SAMPLES], **by_hand), names)
    assert not close(found, run(models, mesh, [0, SAMPLES], **given, ramp_s=1.3), names, 1e-3)
    for cuts in (range(SAMPLES + 1), [0, 12, 13, SAMPLES]):
        assert close(run(models, mesh, cuts, **given, ramp_s=length), found, names)
    sudden = run(models, mesh, [0, SAMPLES], **given)
    assert sudden["potential"][0] > 0.0 == np.abs(sudden["velocity"][0]).max()  # a step starts at rest


@REDUCTIONS
def test_energies_of_jacket_and_tower(models, mesh, loads, reduction):
    """Quadratic forms of each part's own matrices over all degrees of freedom, from the modes' motion."""
    nodal, wrench = loads
    found = run(models, mesh, [0, 11, SAMPLES], nodal=nodal, wrench=wrench, reduction=reduction)
    model, parts = build_modal_model(mesh, reduction), build_modal_model(mesh, reduction).assembly
    system = build_response_model(parse_case({"structure": {"reduction": reduction}}), mesh, None).oscillators
    force = nodal.copy()
    force[:, mesh.tower_top] += wrench
    modal = force.reshape(SAMPLES, -1) @ parts.expansion @ model.shapes
    _, motion = integrate(system, static_state(system, modal[0]), modal[1:])
    for kind, rows, (below, above) in (
        ("potential", motion.displacement, (parts.jacket_stiffness, parts.upper_stiffness)),
        ("kinetic", motion.velocity, (parts.jacket_mass, parts.upper_mass)),
    ):
        u, found_here = rows @ model.shapes.T, found[f"{kind}_substructure"][1:]
        jacket, tower = (0.5 * ((u @ matrix) * u).sum(axis=1) for matrix in (below, above))
        np.testing.assert_allclose(found[f"{kind}_substructure"].sum(axis=1), found[kind], rtol=1e-12)
        np.testing.assert_allclose(found_here[:, 1], tower, atol=1e-9 * tower.max())
        if kind == "kinetic" or "SIM" not in reduction:
            np.testing.assert_allclose(found_here[:, 0], jacket, atol=1e-9 * jacket.max())
        assert np.abs(jacket - tower).max() > 0.1 * tower.max(), "the two differ: a swap would be noticed"
    # At rest under the first sample, with static improvement or unreduced, the jacket's share is exact.
    u = static_motion(parts, force[0])
    error = abs(found["potential_substructure"][0, 0] / (0.5 * u @ parts.jacket_stiffness @ u) - 1.0)
    assert (error < 1e-8) == (reduction != "CB05"), error
