"""Assembly: rigid interface, lumped bodies, zones, equilibrium, and structures that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import ComputationError, InputError
from owt_model.mesh import build_mesh
from owt_model.structure import PointMass, load_structure
from owt_structure_node.core.assembly import assemble, element_transformation
from owt_structure_node.core.elements import partial_mass
from owt_structure_node.core.masses import body_matrix, distributed_mass, joint_mass
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.recovery import end_force_map


def rigid_motion(mesh):
    """Six rigid motions of all nodes about the origin [6 node, 6]."""
    motion = np.zeros((mesh.n_nodes, 6, 6))
    motion[:] = np.eye(6)
    x, y, z = mesh.node_position.T
    motion[:, 0, 4], motion[:, 0, 5] = z, -y
    motion[:, 1, 3], motion[:, 1, 5] = -z, x
    motion[:, 2, 3], motion[:, 2, 4] = y, -x
    return motion.reshape(-1, 6)


def test_interface_joints_follow_the_transition_piece(models):
    mesh = build_mesh(models.frame())
    assembly = assemble(mesh)
    rigid = rigid_motion(mesh)
    u = np.zeros((mesh.n_dof, 6))
    free = mesh.node_dof.reshape(-1) >= 0
    u[mesh.node_dof.reshape(-1)[free]] = rigid[free]
    moved = assembly.expansion @ u
    tied = np.isin(np.arange(mesh.n_nodes), mesh.interface_node).repeat(6)
    assert np.allclose(moved[tied], rigid[tied], atol=1e-12)
    assert not np.allclose(moved[tied], np.tile(u[assembly.internal : assembly.internal + 6], (4, 1)))


def test_upper_part_is_free_of_strain_under_rigid_motion(models):
    """Tower, transition piece and rotor-nacelle carry no stress and their exact mass in rigid motion."""
    mesh = build_mesh(models.frame())
    assembly = assemble(mesh)
    rigid = rigid_motion(mesh)
    upper = np.zeros((mesh.n_dof, 6))
    for node in (mesh.transition_piece, *mesh.tower_node):
        upper[mesh.node_dof[node]] = rigid[6 * node : 6 * node + 6]
    strain = np.abs(assembly.upper_stiffness @ upper).max()
    assert strain < 1e-9 * np.abs(assembly.upper_stiffness).max() * 50
    mass = upper.T @ (assembly.upper_mass @ upper)
    parts = assembly.mass_kg
    total = parts["transition_piece"] + parts["tower"] + parts["rotor_nacelle"]
    assert mass[0, 0] == pytest.approx(total, rel=1e-12)
    assert assembly.structural_mass_kg == pytest.approx(total + parts["members"], rel=1e-12)


def test_body_matrix_is_steiner():
    """A body off its node: parallel axes, products as entries of the inertia matrix."""
    body = PointMass(mass_kg=2.0, inertia_kg_m2=(10.0, 20.0, 30.0, 1.0, 2.0, 3.0), offset_m=(1.0, 2.0, 3.0))
    m = body_matrix(body)
    assert np.array_equal(m, m.T)
    assert m[3, 3] == 10.0 + 2.0 * (4.0 + 9.0)
    assert m[3, 4] == 1.0 - 2.0 * 1.0 * 2.0
    assert m[0, 4] == 2.0 * 3.0  # a forward push of the centre of gravity for a pitch of the node
    assert m[0, 5] == -2.0 * 2.0
    velocity = np.array([0.3, -0.2, 0.5, 0.1, 0.7, -0.4])
    centre = velocity[:3] + np.cross(velocity[3:], body.offset_m)
    inertia = np.array([[10.0, 1.0, 2.0], [1.0, 20.0, 3.0], [2.0, 3.0, 30.0]])
    energy = centre @ centre + 0.5 * velocity[3:] @ inertia @ velocity[3:]
    assert 0.5 * velocity @ m @ velocity == pytest.approx(energy, rel=1e-14)


def test_zones_are_cut_exactly(models):
    """Distributed masses of an inclined member: total and centre of the wetted, grown and flooded parts."""
    more = {
        "marine_growth": {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -41.3, "z_top_m": -30.9},
        "flooding": {"density_kg_m3": 1025.0, "free_surface_z_m": -33.3},
        "added_mass": {"coefficient": 0.9, "density_kg_m3": 1025.0, "free_surface_z_m": -36.1},
    }
    members = {"M": {"joints": ["A", "B"], "section": "tube", "flooded": True}}
    structure = models.cantilever(length=30.0, direction=(0.4, 0.3, 0.9), members=members, **more)
    mesh = build_mesh(structure)
    extra = distributed_mass(mesh)
    slope = 0.9 / np.linalg.norm([0.4, 0.3, 0.9])
    d, t = models.diameter, models.thickness
    quarter = np.pi / 4
    ring = quarter * ((d + 0.2) ** 2 - d**2)
    expected = {
        "marine_growth": 1100.0 * ring * (41.3 - 30.9) / slope,
        "flood_water": 1025.0 * quarter * (d - 2 * t) ** 2 * min((50 - 33.3) / slope, 30.0),
        "added_mass": 0.9 * 1025.0 * (quarter * d**2 * (50 - 36.1) + ring * (41.3 - 36.1)) / slope,
    }
    for kind, mass in expected.items():
        assert extra.total_kg[kind] == pytest.approx(mass, rel=1e-12)
    # the same from the matrices, in global axes under unit motion across and along the member
    axes = element_transformation(mesh)
    axial = sum(m[np.ix_([0, 6], [0, 6])].sum() for m in extra.element)
    across = sum(m[np.ix_([1, 7], [1, 7])].sum() for m in extra.element)
    assert axial == pytest.approx(expected["marine_growth"] + expected["flood_water"], rel=1e-12)
    assert across == pytest.approx(sum(expected.values()), rel=1e-12)
    assert axial != pytest.approx(sum(expected.values()), rel=0.1)  # added mass has no axial part
    assert axes.shape == (4, 12, 12)
    joints = joint_mass(mesh)  # midpoint at z = -37.6: in the zone of growth, wet, below both surfaces
    assert joints.node[:2].sum() == pytest.approx(sum(joints.total_kg.values()), rel=1e-12)
    assert joints.total_kg["marine_growth"] == pytest.approx(1100.0 * ring * 30.0, rel=1e-12)


def test_level_member_is_in_or_out_of_a_zone(models):
    growth = {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -60.0, "z_top_m": -50.0}
    for top, inside in ((-50.0, True), (-50.001, False)):
        structure = models.cantilever(direction=(1, 0, 0), marine_growth=growth | {"z_top_m": top})
        mass = distributed_mass(build_mesh(structure)).total_kg["marine_growth"]
        assert (mass > 0) == inside


def test_consistent_and_joint_masses_agree_in_total_only():
    """The thesis' midpoint rule carries 15 % more growth than there is."""
    mesh = build_mesh(load_structure("oc4-thesis"))
    exact, rule = distributed_mass(mesh).total_kg, joint_mass(mesh).total_kg
    assert rule["marine_growth"] / exact["marine_growth"] == pytest.approx(1.15, abs=0.01)


def test_reactions_balance_the_loads(models):
    """Forces and moments at the supports are minus the sum of the loads, about the origin."""
    mesh = build_mesh(models.frame())
    assembly = assemble(mesh)
    rng = np.random.default_rng(1)
    nodal = rng.standard_normal((mesh.n_nodes, 6)) * [1e5, 1e5, 1e5, 1e4, 1e4, 1e4]
    supported = (mesh.node_dof == -1).all(axis=1)
    nodal[supported] = 0.0
    u = factorise(assembly.stiffness).solve(assembly.expansion.T @ nodal.reshape(-1))

    def reaction(displacement):
        force = end_force_map(assembly, displacement[:, None])[0]
        total = np.zeros(6)
        axes = element_transformation(mesh)
        for end, element in enumerate(mesh.end_element):
            node = mesh.element_node[element, end % 2]
            if supported[node]:
                turn = axes[element][:3, :3].T
                f, m = turn @ force[end, :3], turn @ force[end, 3:]
                total += np.concatenate([f, m + np.cross(mesh.node_position[node], f)])
        return total

    applied = nodal.sum(axis=0)
    applied[3:] += np.cross(mesh.node_position, nodal[:, :3]).sum(axis=0)
    assert np.abs(reaction(u) + applied).max() < 1e-7 * np.abs(applied).max()
    assert np.abs(reaction(1.001 * u) + applied).max() > 1e-4 * np.abs(applied).max()


@pytest.mark.parametrize(
    ("supports", "message"),
    [
        ({"A": [True, True, True, False, False, False]}, "free to move about"),
        ({"A": [True, True, False, True, True, True]}, "free to move along z"),
        ({"A": [False, False, False, True, True, True]}, "free to move along"),
    ],
)
def test_mechanisms_are_refused(models, supports, message):
    with pytest.raises(InputError, match=message):
        assemble(build_mesh(models.cantilever(supports=supports)))


def test_three_pins_not_in_line_are_enough(models):
    """Partial supports that together resist every motion are accepted."""
    pin = [True, True, True, False, False, False]
    assemble(build_mesh(models.frame(supports={f"a{i}": pin for i in "1234"})))


def test_a_part_without_supports_is_refused(models):
    frame = models.frame()
    data = frame.model_dump(mode="json")
    data["joints"] |= {"x": [30.0, 0.0, -10.0], "y": [30.0, 0.0, -20.0]}
    data["members"]["alone"] = {"joints": ["x", "y"], "section": "leg"}
    with pytest.raises(InputError, match="nothing connects joint x to a support"):
        assemble(build_mesh(models.frame(joints=data["joints"], members=data["members"])))


def test_singular_matrix_is_a_clear_error(models):
    assembly = assemble(build_mesh(models.frame()))
    with pytest.raises(ComputationError, match="mechanism"):
        factorise(assembly.upper_stiffness)  # a tower without its jacket
    assert partial_mass(np.ones(1), np.zeros(1), np.zeros(1), np.ones(1), np.ones(1)).sum() == 0.0
