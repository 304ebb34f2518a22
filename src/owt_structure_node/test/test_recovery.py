"""Forces and stresses at member ends: fixed-end forces, signs, and the formulas of thesis 4.3.2."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.mesh import build_mesh
from owt_model.section import area, bending_inertia, polar_inertia
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.recovery import (
    end_force_map,
    end_samples,
    end_sections,
    fixed_end_columns,
    stresses,
)

LENGTH = 24.0  # of the whole beam, clamped at both ends


@pytest.fixture(scope="module")
def beam(models):
    """A level beam along x, clamped at both ends, its middle the transition piece; two members."""
    data = models.cantilever().model_dump(mode="json")
    joints = {"A": [0.0, 0.0, -50.0], "B": [LENGTH / 2, 0.0, -50.0], "C": [LENGTH, 0.0, -50.0]}
    structure = models.cantilever(
        joints=joints,
        members={
            "left": {"joints": ["A", "B"], "section": "tube"},
            "right": {"joints": ["B", "C"], "section": "tube"},
        },
        supports={"A": [True] * 6, "C": [True] * 6},
        interface={"joints": ["B"], "reference_m": joints["B"]},
    )
    assert data["name"] == structure.name
    return assemble(build_mesh(structure))


def uniform(assembly, q):
    """End forces of a beam under a uniform load q (3 components, N/m), with and without fixed-end forces."""
    mesh = assembly.mesh
    h = LENGTH / mesh.n_elements
    equivalent = np.zeros(12)  # of one element, in element axes, which are the global ones here
    for i in (0, 6):
        equivalent[i : i + 3] = np.array(q) * h / 2
    equivalent[4], equivalent[10] = -q[2] * h**2 / 12, q[2] * h**2 / 12
    equivalent[5], equivalent[11] = q[1] * h**2 / 12, -q[1] * h**2 / 12
    nodal = np.zeros((mesh.n_nodes, 6))
    for first, second in mesh.element_node:
        nodal[first] += equivalent[:6]
        nodal[second] += equivalent[6:]
    u = factorise(assembly.stiffness).solve(assembly.expansion.T @ nodal.reshape(-1))
    elastic = end_force_map(assembly, u[:, None]).copy()
    ends = end_sections(mesh)
    loaded = np.unique(mesh.end_element)
    fixed = np.tile(-equivalent, (1, len(loaded), 1))
    force = elastic + end_samples(fixed, fixed_end_columns(ends, loaded)).transpose(0, 2, 1)
    return force, elastic, ends


def stress_of(force, ends):
    """Stress of end forces [row, end, 6]."""
    return stresses(np.ascontiguousarray(force.transpose(0, 2, 1)), ends)


def exact_section_forces(q):
    """N, V_y, V_z, M_y, M_z at A, B (left), B (right), C of a clamped beam under a uniform load."""
    x = np.array([0.0, LENGTH / 2, LENGTH / 2, LENGTH])
    moment = LENGTH**2 / 12 - LENGTH * x / 2 + x**2 / 2  # M'' = q, clamped ends: E I v'' for q = 1
    shear = -(x - LENGTH / 2)
    normal = q[0] * (LENGTH / 2 - x)
    # M_z = E I v'' = q_y moment; M_y = -E I w'' = -q_z moment; V = q (L/2 - x)
    return normal, q[1] * shear, q[2] * shear, -q[2] * moment, q[1] * moment


def check_exact(force, ends, q):
    section = force[0] * ends.sign[:, None]
    expected = np.array(exact_section_forces(q)).T
    scale = np.abs(expected).max()
    assert np.abs(section[:, [0, 1, 2, 4, 5]] - expected).max() < 1e-7 * scale


@pytest.mark.parametrize("q", [(0.0, 0.0, -1e4), (0.0, 1e4, 0.0), (3e3, -2e3, 5e3)])
def test_clamped_beam_under_distributed_load(beam, q):
    """End shear q L/2, end moment q L^2/12, middle moment q L^2/24: exact with fixed-end forces only."""
    force, elastic, ends = uniform(beam, q)
    check_exact(force, ends, q)
    with pytest.raises(AssertionError):
        check_exact(elastic, ends, q)  # eq. 4.69 as printed
    with pytest.raises(AssertionError):
        check_exact(2 * elastic - force, ends, q)  # fixed-end forces with the wrong sign


def test_stress_of_a_sagging_beam(beam):
    """Load downwards: top fibre (+z) in tension at the ends, in compression in the middle."""
    force, _, ends = uniform(beam, (0.0, 0.0, -1e4))
    stress = stress_of(force, ends)
    d, t = np.array([1.2]), np.array([0.05])
    modulus = (bending_inertia(d, t) / (d / 2))[0]
    end, middle = 1e4 * LENGTH**2 / 12 / modulus, 1e4 * LENGTH**2 / 24 / modulus
    assert np.allclose(stress.bending_y[0], [end, -middle, -middle, end], rtol=1e-9)
    assert np.abs(stress.bending_z).max() < 1e-6 * end
    assert np.abs(stress.axial).max() < 1e-6 * end


def test_stress_of_a_beam_pushed_sideways(beam):
    """Load towards +y: the +y fibre is in tension in the middle... and in compression at the ends."""
    force, _, ends = uniform(beam, (0.0, 1e4, 0.0))
    stress = stress_of(force, ends)
    assert (np.sign(stress.bending_z[0]) == [-1, 1, 1, -1]).all()
    assert np.abs(stress.bending_y).max() < 1e-6 * np.abs(stress.bending_z).max()


def test_axial_stress_is_positive_in_tension_at_both_ends(models):
    """A hanging pull on a vertical cantilever stretches it, at either end, whichever way it is drawn."""
    for joints in (["A", "B"], ["B", "A"]):
        structure = models.cantilever(members={"M": {"joints": joints, "section": "tube"}})
        assembly = assemble(build_mesh(structure))
        load = np.zeros(assembly.mesh.n_dof)
        load[assembly.internal + 2] = 1e6
        u = factorise(assembly.stiffness).solve(load)
        stress = stress_of(end_force_map(assembly, u[:, None]), end_sections(assembly.mesh))
        a = area(np.array([models.diameter]), np.array([models.thickness]))[0]
        assert np.allclose(stress.axial, 1e6 / a, rtol=1e-9)


def test_bending_of_a_cantilever_in_any_direction(models):
    """At the clamp of a tilted cantilever the extreme normal stress is F L r / I, on the side of the push."""
    direction = np.array([0.3, -0.7, 0.5]) / np.linalg.norm([0.3, -0.7, 0.5])
    assembly = assemble(build_mesh(models.cantilever(direction=direction)))
    push = np.cross(direction, [0.2, 0.9, -0.4])
    push /= np.linalg.norm(push)
    load = np.zeros(assembly.mesh.n_dof)
    load[assembly.internal : assembly.internal + 3] = 1e5 * push
    u = factorise(assembly.stiffness).solve(load)
    stress = stress_of(end_force_map(assembly, u[:, None]), end_sections(assembly.mesh))
    d, t = np.array([models.diameter]), np.array([models.thickness])
    peak = 1e5 * 20.0 * (d / 2 / bending_inertia(d, t))[0]
    theta = np.linspace(0, 2 * np.pi, 721)
    normal = stress.bending_y[0, 0] * np.sin(theta) + stress.bending_z[0, 0] * np.cos(theta)
    assert normal.max() == pytest.approx(peak, rel=1e-4)
    from owt_model.axes import rotation

    axes = rotation(np.zeros(3), direction)
    at_peak = theta[normal.argmax()]
    fibre = axes[1] * np.cos(at_peak) + axes[2] * np.sin(at_peak)
    assert fibre @ push == pytest.approx(-1.0, abs=1e-4)  # pushed that way, the near side is stretched


def test_von_mises_is_the_printed_formula(beam):
    """Eq. 4.70 to 4.79, one by one, on random forces."""
    ends = end_sections(beam.mesh)
    force = np.random.default_rng(7).standard_normal((50, 4, 6)) * [1e6, 1e5, 1e5, 1e5, 1e6, 1e6]
    found = stress_of(force, ends)
    d, t = 1.2, 0.05
    r_o, r_i = d / 2, d / 2 - t
    a, i, j = (float(f(np.array([d]), np.array([t]))[0]) for f in (area, bending_inertia, polar_inertia))
    section = force * ends.sign[:, None]
    resultant_moment = np.hypot(section[..., 4], section[..., 5])
    resultant_shear = np.hypot(section[..., 1], section[..., 2])
    sigma = resultant_moment * r_o / i + section[..., 0] / a
    shape = (r_o**2 + r_o * r_i + r_i**2) / (r_o**2 + r_i**2)
    tau = np.abs(section[..., 3]) * r_o / j + 4 * resultant_shear / (3 * a) * shape
    printed = np.sqrt(2 * sigma**2 + 6 * tau**2) / np.sqrt(2)
    assert np.allclose(found.von_mises, printed, rtol=1e-13)
    assert not np.allclose(found.von_mises, np.sqrt(sigma**2 + tau**2), rtol=1e-3)
    assert np.allclose(np.hypot(found.bending_y, found.bending_z), resultant_moment * r_o / i, rtol=1e-13)


def test_fixed_end_forces_are_linear_between_load_samples(beam):
    """Rows between two load samples hold the interpolated value; other elements hold none."""
    mesh = beam.mesh
    ends = end_sections(mesh)
    loaded = mesh.end_element[[2]]  # the first element of the second member
    fixed = np.zeros((3, 1, 12))
    fixed[:, 0, 0] = [0.0, 10.0, 40.0]
    samples = end_samples(fixed, fixed_end_columns(ends, loaded))
    axial = stresses(np.zeros((11, 6, 4)), ends, samples, 5).axial
    found = axial[:, 2] / (ends.sign[2] * ends.factor[0, 2])
    assert np.allclose(found, [0, 2, 4, 6, 8, 10, 16, 22, 28, 34, 40])
    assert not axial[:, [0, 1, 3]].any()
    # Negative control: as many rows without interpolation.
    held = stresses(np.zeros((11, 6, 4)), ends, np.repeat(samples, [5, 5, 1], axis=0), 1).axial[:, 2]
    assert not np.allclose(held, axial[:, 2])


def test_one_element_members_have_both_ends_on_it(models):
    mesh = build_mesh(models.cantilever(elements=1))
    columns = fixed_end_columns(end_sections(mesh), np.array([0]))
    assert columns.tolist() == [[0, 0], [0, 6]]
