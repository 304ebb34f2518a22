"""A jacket as a superelement: the same model under the same tower, and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csr_array

from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.structure_config import Damping
from owt_structure_node.core import superelement_response
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.damping import damped_modes
from owt_structure_node.core.eigen import eigen_report, log_decrement
from owt_structure_node.core.reduction import guyan, reduce
from owt_structure_node.core.stage import build_response_model, initial_state, step
from owt_structure_node.core.superelement import (
    attach,
    check_reduction,
    frequencies,
    jacket_superelement,
    project_loads,
    rayleigh_coefficients,
)
from owt_structure_node.core.superelement_response import decouple, respond

ALPHA, BETA, DT = 0.03, 0.002, 0.1


@pytest.fixture(scope="module")
def frame(models):
    return assemble(build_mesh(models.frame()))


def jacket_nodes(assembly):
    return np.arange(assembly.mesh.transition_piece, dtype=np.int64)


def nodal_loads(assembly, samples, seed=0):
    shape = (samples, assembly.mesh.transition_piece, 6)
    return np.random.default_rng(seed).standard_normal(shape) * 1e4


def element_of(assembly, name="CB06", samples=40, **more):
    reduced = reduce(assembly, name)
    loads = project_loads(assembly, reduced, jacket_nodes(assembly), nodal_loads(assembly, samples))
    return jacket_superelement(assembly, reduced, loads, dt=DT, alpha=ALPHA, beta=BETA, **more)


def close(found, exact, rtol=1e-9):
    assert np.abs(np.asarray(found) - exact).max() <= rtol * np.abs(exact).max()


@pytest.mark.parametrize("name", ["CB00", "CB06", "CB05M04", "M04", "CB03Yj1"])
def test_under_its_own_tower_it_is_the_reduced_model(models, frame, name) -> None:
    vectors = np.random.default_rng(5).standard_normal((4, frame.mesh.n_nodes, 6))
    vectors[:, frame.mesh.transition_piece :] = 0.0
    reduced = reduce(frame, name, models.load_basis(frame.mesh, vectors))
    size = 6 + len(reduced.fixed_interface) + len(reduced.pseudo)
    element = jacket_superelement(frame, reduced, np.zeros((1, size)), dt=DT, alpha=ALPHA, beta=BETA)
    assert element.n_dof == size
    attached = attach(element, frame, alpha=ALPHA, beta=BETA)
    close(attached.stiffness, reduced.stiffness, 1e-11)
    close(attached.mass, reduced.mass, 1e-11)
    close(attached.damping, ALPHA * reduced.mass + BETA * reduced.stiffness, 1e-11)
    assert attached.coordinate_name[:6] == reduced.coordinate_name[:6]
    assert attached.coordinate_name[size:] == reduced.coordinate_name[size:]
    square = np.sort(np.concatenate([reduced.fixed_interface, reduced.pseudo]))
    held = frequencies(element.stiffness[6:, 6:], element.mass[6:, 6:])
    assert len(held) == len(square)
    if len(square):
        close(held, np.sqrt(square) / (2.0 * np.pi))


def test_guyan_part_is_that_of_the_jacket_alone(frame) -> None:
    element, static = element_of(frame), guyan(frame)
    close(element.stiffness[:6, :6], static.stiffness, 1e-11)
    close(element.mass[:6, :6], static.mass, 1e-11)
    assert np.abs(element.mass[6:, 6:] - np.eye(6)).max() < 1e-10


def test_loads_do_the_work_of_the_nodal_loads(frame) -> None:
    """Virtual work: generalised loads times coordinates is nodal loads times the motion of the nodes."""
    reduced, nodal = reduce(frame, "CB06"), nodal_loads(frame, 5)
    loads = project_loads(frame, reduced, jacket_nodes(frame), nodal)
    q = np.random.default_rng(3).standard_normal(12)
    motion = (frame.expansion @ (reduced.shapes[:, :12] @ q)).reshape(-1, 6)
    work = np.einsum("snd,nd->s", nodal, motion[: frame.mesh.transition_piece])
    close(loads @ q, work, 1e-12)


def case(models, name="CB06", n=40):
    return models.parse_case(
        {
            "time": {"n": n, "dt_s": DT},
            "structure": {"reduction": name, "damping": {"alpha": ALPHA, "beta": BETA}, "dt_s": 0.02},
        }
    )


def test_response_is_that_of_the_stage(models, frame) -> None:
    model = build_response_model(case(models), frame.mesh, None)
    block = models.block(frame.mesh, nodal_loads(frame, 40), node=jacket_nodes(frame))
    modal = step(model, initial_state(model), block)[1].modal
    element = element_of(frame)
    found = respond(element, attach(element, frame, alpha=ALPHA, beta=BETA), step=0.02)
    names = model.description.coordinate_name
    top = [names.index(f"{frame.mesh.node_name[frame.mesh.tower_top]}.{d}") for d in ("ux", "uy", "uz", "rx")]
    for name in ("displacement", "velocity", "acceleration"):
        series = getattr(modal, name)
        close(getattr(found.interface, name), series[:, :6])
        close(getattr(found.top, name)[:, :4], series[:, top])
    # equilibrium of the jacket: what its own equation leaves at the interface
    q, v, a = (getattr(modal, name)[::5, :12] for name in ("displacement", "velocity", "acceleration"))
    left = element.loads - q @ element.stiffness - v @ element.damping - a @ element.mass
    close(found.force[::5], left[:, :6])
    assert np.abs(left[:, 6:]).max() < 1e-6 * np.abs(element.loads[:, 6:]).max()


def test_blocks_of_a_long_record_join(frame, monkeypatch) -> None:
    element = element_of(frame, samples=130)
    attached = attach(element, frame, alpha=ALPHA, beta=BETA)
    whole = respond(element, attached, step=0.05)
    monkeypatch.setattr(superelement_response, "_BLOCK", 7)
    pieces = respond(element, attached, step=0.05)
    assert len(whole.force) == 2 * 129 + 1
    close(pieces.force, whole.force, 1e-12)
    close(pieces.top.displacement, whole.top.displacement, 1e-12)


def test_constant_load_is_static(frame) -> None:
    element = element_of(frame, samples=1)
    attached = attach(element, frame, alpha=ALPHA, beta=BETA)
    found = respond(element, attached)
    load = np.zeros(len(attached.mass))
    load[:12] = element.loads[0]
    exact = np.linalg.solve(attached.stiffness, load)
    close(found.interface.displacement[0], exact[:6])
    close(found.top.displacement[0], exact[attached.top])
    assert np.abs(found.force).max() < 1e-6 * np.abs(load).max()  # nothing loads what stands above


def test_structure_without_tower(models) -> None:
    assembly = assemble(build_mesh(models.cantilever()))
    element = element_of(assembly, "CB02")
    attached = attach(element, assembly, alpha=ALPHA, beta=BETA)
    np.testing.assert_array_equal(attached.top, np.arange(6))
    found = respond(element, attached)
    np.testing.assert_array_equal(found.top.displacement, found.interface.displacement)


def test_rayleigh_coefficients_are_found(frame) -> None:
    element = element_of(frame)
    for alpha, beta in ((ALPHA, BETA), (0.0, 0.01), (0.2, 0.0)):
        damped = replace(element, damping=alpha * element.mass + beta * element.stiffness)
        found = rayleigh_coefficients(damped)
        assert abs(found[0] - alpha) < 1e-9
        assert abs(found[1] - beta) < 1e-12
    assert rayleigh_coefficients(replace(element, damping=np.zeros((12, 12)))) == (0.0, 0.0)


def test_other_damping_is_no_rayleigh_damping(frame) -> None:
    element = element_of(frame)
    damping = element.damping.copy()
    damping[0, 0] *= 1.01
    with pytest.raises(InputError, match=r"is no sum alpha M \+ beta K"):
        rayleigh_coefficients(replace(element, damping=damping))
    attached = attach(replace(element, damping=damping), frame, alpha=ALPHA, beta=BETA)
    assert np.isfinite(respond(element, attached).top.displacement).all()


def test_other_coefficients_above_couple_the_modes(frame) -> None:
    """The response equals that of the coupled matrices, integrated step by step with one factorisation."""
    element = element_of(frame)
    attached = attach(element, frame, alpha=ALPHA, beta=0.1 * BETA)
    modes = decouple(attached.stiffness, attached.mass, attached.damping)
    assert modes.damping.coupling.size
    assert not decouple_proportional(element, frame).damping.coupling.size
    found = respond(element, attached)
    h, loads = element.dt, np.zeros((len(element.loads), len(attached.mass)))
    loads[:, : element.n_dof] = element.loads
    k, m, c = attached.stiffness, attached.mass, attached.damping
    factor = lu_factor(m + 0.5 * h * c + 0.25 * h * h * k)
    x, v = np.linalg.solve(k, loads[0]), np.zeros(len(k))
    a, motion = np.zeros(len(k)), [x]
    for load in loads[1:]:
        x_free, v_free = x + h * v + 0.25 * h * h * a, v + 0.5 * h * a
        a = lu_solve(factor, load - c @ v_free - k @ x_free)
        x, v = x_free + 0.25 * h * h * a, v_free + 0.5 * h * a
        motion.append(x)
    expected = np.array(motion)[:, attached.top]
    assert (
        np.abs(found.top.displacement - expected).max() < 1e-7 * np.abs(expected).max()
    )  # round-off of K^-1
    other = respond(element, attach(element, frame, alpha=ALPHA, beta=BETA)).top.displacement
    assert np.abs(other - expected).max() > 1e-3 * np.abs(expected).max()


def decouple_proportional(element, frame):
    attached = attach(element, frame, alpha=ALPHA, beta=BETA)
    return decouple(attached.stiffness, attached.mass, attached.damping)


def test_damping_that_drives_is_refused(frame) -> None:
    attached = attach(element_of(frame), frame, alpha=ALPHA, beta=BETA)
    with pytest.raises(InputError, match=r"damping matrix = .*none may be negative"):
        decouple(attached.stiffness, attached.mass, -attached.damping)


def test_undamped_is_proportional(frame) -> None:
    element = replace(element_of(frame), damping=np.zeros((12, 12)))
    attached = attach(element, frame, alpha=0.0, beta=0.0)
    assert not decouple(attached.stiffness, attached.mass, attached.damping).damping.diagonal.any()


def test_dashpots_on_the_jacket_are_part_of_it(frame) -> None:
    motion = np.zeros((2, frame.mesh.n_nodes, 6))
    node = frame.mesh.node_name.index("b1")
    motion[0, node, 0] = 300.0
    motion[1, frame.mesh.tower_top, 0] = 300.0
    element = element_of(frame, dashpots=csr_array(motion.reshape(2, -1)))
    added = element.damping - element_of(frame).damping
    reduced = reduce(frame, "CB06")
    g = 300.0 * (frame.expansion @ reduced.shapes[:, :12])[6 * node]
    close(added, np.outer(g, g), 1e-6)
    assert np.linalg.matrix_rank(added, tol=1e-6 * np.abs(added).max()) == 1  # the tower's is not in it
    joined = motion[:1].copy()
    joined[0, frame.mesh.tower_top, 0] = -300.0
    with pytest.raises(InputError, match="join jacket and tower"):
        element_of(frame, dashpots=csr_array(joined.reshape(1, -1)))


def test_dashpots_on_the_tower_go_with_it(models, frame) -> None:
    """The decrements of file and tower are those of the reduced model with the tower's dashpots."""
    top = {"D": {"joints": ["tower_top"], "damping": [2e4, 1e4, 0, 0, 0, 0]}}
    damped = assemble(build_mesh(models.frame(dashpots=top)))
    attached = attach(element_of(frame), damped, alpha=ALPHA, beta=BETA)
    modes = decouple(attached.stiffness, attached.mass, attached.damping)
    found = log_decrement(damped_modes(modes.omega_squared, modes.damping).ratio)[:4]
    report = eigen_report(damped.mesh.structure, "CB06", damping=Damping(alpha=ALPHA, beta=BETA), n_modes=4)
    assert 100.0 * found == pytest.approx(report["logdec_percent"], rel=1e-6)
    bare = eigen_report(frame.mesh.structure, "CB06", damping=Damping(alpha=ALPHA, beta=BETA), n_modes=4)
    assert 100.0 * found[0] != pytest.approx(bare["logdec_percent"][0], rel=0.1)


@pytest.mark.parametrize(
    ("name", "message"),
    [("full", "has no basis"), ("CB10+SIM", "static improvement"), ("CBx", "must be full")],
)
def test_reductions_that_no_file_carries(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        check_reduction(name)
    check_reduction("auto")
    check_reduction("CB10M10j1Y")


def test_improved_reduction_is_refused(frame) -> None:
    with pytest.raises(InputError, match="static improvement"):
        element_of(frame, "CB06+SIM")


def test_loads_on_the_tower_are_refused(frame) -> None:
    reduced = reduce(frame, "CB00")
    node = np.array([0, frame.mesh.tower_top])
    nodal = np.zeros((3, 2, 6))
    project_loads(frame, reduced, node, nodal)
    nodal[1, 1, 0] = 1.0
    name = frame.mesh.node_name[frame.mesh.tower_top]
    with pytest.raises(InputError, match=rf"\['{name}'\]: act on the tower"):
        project_loads(frame, reduced, node, nodal)


@pytest.mark.parametrize("dt", [0.03, 0.0, -0.1, 0.2, float("nan")])
def test_steps_must_divide_that_of_the_loads(frame, dt: float) -> None:
    element = element_of(frame)
    with pytest.raises(InputError, match=r"dt = .*divide the step of the loads"):
        respond(element, attach(element, frame, alpha=ALPHA, beta=BETA), step=dt)
