"""Beam element against closed forms: cantilevers, rigid-body motion, masses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse import csc_array, diags_array

from owt_model.axes import rotation
from owt_model.mesh import build_mesh
from owt_model.section import area, bending_inertia, polar_inertia
from owt_structure_node.core.assembly import assemble, element_stiffness, element_transformation
from owt_structure_node.core.elements import (
    partial_mass,
    shear_coefficient,
    shear_parameter,
    stiffness,
    tube_mass,
)
from owt_structure_node.core.modes import factorise, lowest_modes

DIRECTIONS = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.3, -0.7, 0.5), (0.2, 0.1, -1.0)]


def tip_motion(assembly, force):
    """Displacement and rotation of the tip under six forces there."""
    load = np.zeros(assembly.mesh.n_dof)
    load[assembly.internal :] = force
    return factorise(assembly.stiffness).solve(load)[assembly.internal :]


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_cantilever_under_end_forces(models, direction, beam):
    """A cantilever's tip: stretch, twist, deflection and slope, exact for any number of elements."""
    assembly = assemble(build_mesh(models.cantilever(direction=direction, beam=beam, elements=3)))
    ends = assembly.mesh.node_position[assembly.mesh.member_node[0]]
    axes = rotation(ends[0], ends[1])
    d, t, length, force = np.array([models.diameter]), np.array([models.thickness]), 20.0, 1e5
    a, i, j = (float(f(d, t)[0]) for f in (area, bending_inertia, polar_inertia))
    nu = models.E / (2 * models.G) - 1
    kappa = float(shear_coefficient(d, t, np.array([nu]))[0])
    shear = force * length / (kappa * models.G * a) if beam == "timoshenko" else 0.0
    expected = np.zeros((6, 6))
    expected[0, 0] = force * length / (models.E * a)
    expected[3, 3] = force * length / (models.G * j)
    expected[1, 1] = expected[2, 2] = force * length**3 / (3 * models.E * i) + shear
    expected[4, 4] = expected[5, 5] = force * length / (models.E * i)
    slope = force * length**2 / (2 * models.E * i)
    expected[1, 5] = expected[5, 1] = slope
    expected[2, 4] = expected[4, 2] = -slope
    turn = np.kron(np.eye(2), axes)
    found = np.array([turn @ tip_motion(assembly, turn.T @ (force * unit)) for unit in np.eye(6)]).T
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    wrong = expected.copy()
    wrong[2, 4] = slope  # a left-handed rotation about y
    assert np.abs(found - wrong).max() > 1e-3 * np.abs(expected).max()


def test_cantilever_under_uniform_load(models):
    """Consistent nodal loads give q L^4 / 8 E I at the tip, with one element as with many."""
    length, q = 20.0, 1e4
    inertia = float(bending_inertia(np.array([models.diameter]), np.array([models.thickness]))[0])
    exact = q * length**4 / (8 * models.E * inertia)

    def deflection(elements, *, moments=True):
        assembly = assemble(build_mesh(models.cantilever(direction=(1.0, 0.0, 0.0), elements=elements)))
        h = length / elements
        nodal = np.zeros((assembly.mesh.n_nodes, 6))
        for first, second in assembly.mesh.element_node:
            nodal[first, 1] += q * h / 2
            nodal[second, 1] += q * h / 2
            nodal[first, 5] += moments * q * h**2 / 12
            nodal[second, 5] -= moments * q * h**2 / 12
        # the transition-piece node sits on joint B
        u = factorise(assembly.stiffness).solve(assembly.expansion.T @ nodal.reshape(-1))
        return u[assembly.internal + 1]

    for elements in (1, 2, 5):
        assert deflection(elements) == pytest.approx(exact, rel=1e-9)
        assert deflection(elements, moments=False) != pytest.approx(exact, rel=1e-3)


def test_cantilever_frequencies_converge_with_rate_four(models):
    """Frequencies of a clamped-free beam converge to cos(x) cosh(x) = -1 as h^4, from above."""
    length = 60.0
    d, t = np.array([models.diameter]), np.array([models.thickness])
    roots = [
        brentq(lambda x: np.cos(x) * np.cosh(x) + 1, a, b, xtol=1e-14) for a, b in ((1, 3), (4, 6), (7, 9))
    ]
    factor = np.sqrt(models.E * bending_inertia(d, t) / (models.rho * area(d, t)))[0] / length**2
    exact = np.array(roots) ** 2 * factor

    def error(elements, *, lumped=False):
        assembly = assemble(build_mesh(models.cantilever(length=length, elements=elements)))
        mass = assembly.mass
        if lumped:
            h = length / elements
            half = models.rho * area(d, t)[0] * h / 2
            node = np.array([half] * 3 + [half * h**2 / 100] * 3)
            mass = csc_array(diags_array(np.concatenate([np.tile(2 * node, elements - 1), node])))
        omega = np.sqrt(lowest_modes(assembly.stiffness, mass, 8)[0])
        return (omega[[0, 2, 4]] - exact) / exact  # bending modes come in pairs

    def check(coarse, fine):
        assert np.abs(np.log2(np.abs(coarse / fine)) - 4.0).max() < 0.15

    assert (error(8) > 0).all()
    check(error(8), error(16))
    with pytest.raises(AssertionError):
        check(error(8, lumped=True), error(16, lumped=True))


@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_rigid_motion_strains_nothing_and_carries_the_mass(models, beam):
    """Six zero eigenvalues of a free element, and its mass and inertia under rigid motion."""
    mesh = build_mesh(models.cantilever(direction=(0.3, -0.7, 0.5), elements=1, beam=beam, length=4.0))
    turn = element_transformation(mesh)[0]
    k = turn.T @ element_stiffness(mesh)[0] @ turn
    d, t = mesh.element_diameter, mesh.element_thickness
    length = np.array([4.0])
    local = tube_mass(length, d, t, mesh.element_density, rotary_inertia=True)[0]
    m = turn.T @ local @ turn
    values = np.linalg.eigvalsh(k)
    assert np.abs(values[:6]).max() < 1e-9 * values[-1]
    assert values[6] > 1e-6 * values[-1]
    rigid = np.zeros((12, 6))
    centre = mesh.node_position[mesh.element_node[0]].mean(axis=0)
    for n, node in enumerate(mesh.element_node[0]):
        x, y, z = mesh.node_position[node] - centre
        rigid[6 * n : 6 * n + 6] = np.eye(6)
        rigid[6 * n : 6 * n + 3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    assert np.abs(k @ rigid).max() < 1e-9 * np.abs(k).max() * 4.0
    total = float((mesh.element_density * area(d, t) * length)[0])
    whole = rigid.T @ m @ rigid
    axes = turn[:3, :3]
    lengthwise = float((mesh.element_density * polar_inertia(d, t) * length)[0])
    across = total * 4.0**2 / 12 + lengthwise / 2  # a thick rod about its centre
    inertia = axes.T @ np.diag([lengthwise, across, across]) @ axes
    assert np.allclose(whole[:3, :3], total * np.eye(3), rtol=1e-12, atol=1e-9 * total)
    assert np.allclose(whole[3:, 3:], inertia, rtol=1e-12, atol=1e-9 * across)
    without = tube_mass(length, d, t, mesh.element_density, rotary_inertia=False)[0]
    assert not np.allclose((rigid.T @ turn.T @ without @ turn @ rigid)[3:, 3:], inertia, rtol=1e-4)


def test_timoshenko_becomes_euler_bernoulli_in_a_slender_beam():
    """The shear parameter falls with the square of the slenderness."""
    d, t, e, g = (np.array([value]) for value in (1.2, 0.05, 2.1e11, 8.0769e10))
    assert shear_parameter(np.array([1e4]), d, t, e, g)[0] < 1e-6
    assert shear_parameter(np.array([1.0]), d, t, e, g)[0] > 1.0


def test_shear_coefficient_limits():
    """Cowper-type limits: thin tube about 0.53, solid section about 0.93 (nu = 0.3)."""
    nu, one = np.array([0.3]), np.array([1.0])
    assert shear_coefficient(one, 1e-6 * one, nu)[0] == pytest.approx(
        6 * 1.3**2 * 4 / (4 * (7 + 14 * 0.3 + 8 * 0.09) + 4 * (5 + 3 + 0.36)), rel=1e-5
    )
    solid = 6 * 1.3**2 / (7 + 14 * 0.3 + 8 * 0.09)
    assert shear_coefficient(one, 0.5 * one, nu)[0] == pytest.approx(solid, rel=1e-12)


def test_partial_mass_is_exact():
    """A line mass over a part of the element: exact integrals, parts that add to the whole."""
    length, one = np.array([7.0]), np.ones(1)
    whole = partial_mass(length, 0 * one, one, 3 * one, 2 * one)
    parts = partial_mass(length, 0 * one, 0.37 * one, 3 * one, 2 * one)
    parts = parts + partial_mass(length, 0.37 * one, one, 3 * one, 2 * one)
    assert np.allclose(whole, parts, rtol=0, atol=1e-13 * np.abs(whole).max())
    assert whole[0, 1, 1] == pytest.approx(3 * 7 * 156 / 420, rel=1e-14)
    assert whole[0, 1, 5] == pytest.approx(3 * 7 * 22 * 7 / 420, rel=1e-14)
    assert whole[0, 2, 4] == pytest.approx(-3 * 7 * 22 * 7 / 420, rel=1e-14)
    assert whole[0, 0, 6] == pytest.approx(2 * 7 / 6, rel=1e-14)
    assert not np.allclose(parts, partial_mass(length, 0 * one, 0.8 * one, 3 * one, 2 * one), rtol=1e-3)


def test_stiffness_is_symmetric_and_scales():
    """Doubling E and G doubles the stiffness."""
    data = [np.array([value]) for value in (5.0, 0.8, 0.02, 2.1e11, 8.1e10)]
    k = stiffness(*data, np.zeros(1))
    assert np.array_equal(k, k.transpose(0, 2, 1))
    data[3], data[4] = 2 * data[3], 2 * data[4]
    assert np.allclose(stiffness(*data, np.zeros(1)), 2 * k, rtol=1e-15)
