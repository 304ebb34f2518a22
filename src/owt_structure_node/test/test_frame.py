"""Lumped mass, elastic supports, released ends, rigid links, tapered members: details and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_model.mesh import DOF_TIED, build_mesh
from owt_structure_node.core.assembly import assemble, element_transformation
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.elements import lumped_mass, partial_mass
from owt_structure_node.core.masses import distributed_mass
from owt_structure_node.core.modes import factorise
from owt_structure_node.core.recovery import end_force_map
from owt_structure_node.core.stage import build_response_model, initial_state, step


def released(first=None, last=None, **more):
    return {"joints": ["A", "B"], "section": "tube", "release_first": first, "release_last": last} | more


def test_lumped_and_consistent_mass_weigh_the_same(models):
    """Zones, total and centre are the same; only the lumped matrix is diagonal."""
    length = np.array([7.0])
    args = (length, np.array([0.2]), np.array([0.7]), np.array([3.0]), np.array([2.0]))
    lumped, consistent = lumped_mass(*args)[0], partial_mass(*args)[0]
    assert np.array_equal(lumped, np.diag(np.diag(lumped)))
    for dofs in ([0, 6], [1, 7], [2, 8]):
        one, other = lumped[np.ix_(dofs, dofs)], consistent[np.ix_(dofs, dofs)]
        assert one.sum() == pytest.approx(other.sum(), rel=1e-13)
    assert 7.0 * lumped[6, 6] / lumped[[0, 6], [0, 6]].sum() == pytest.approx(0.45 * 7.0, rel=1e-13)
    uniform = lumped_mass(length, np.zeros(1), np.ones(1), np.array([3.0]), np.array([2.0]))[0]
    # Hinton, Rock and Zienkiewicz: the consistent diagonal, scaled to half the mass at a node
    whole = partial_mass(length, np.zeros(1), np.ones(1), np.array([3.0]), np.array([2.0]))[0]
    scale = 21.0 / 2.0 / whole[1, 1]
    assert uniform[4, 4] == pytest.approx(scale * whole[4, 4], rel=1e-13)
    one, other = (eigen_report(models.frame(mass=mass)) for mass in ("consistent", "lumped"))
    assert other["masses_kg"] == pytest.approx(one["masses_kg"], rel=1e-12)
    ratio = np.array(other["frequencies_hz"][:6]) / one["frequencies_hz"][:6]
    assert np.abs(ratio - 1.0).max() < 0.03  # two elements per member
    assert np.abs(ratio - 1.0).max() > 1e-4


def test_rotary_inertia_of_lumped_mass(models):
    plain, rotary = (
        eigen_report(models.cantilever(mass="lumped", rotary_inertia=flag))["frequencies_hz"]
        for flag in (False, True)
    )
    assert rotary[0] < plain[0]
    assert rotary[0] == pytest.approx(plain[0], rel=1e-2)


def test_released_end_has_rotations_of_its_own(models):
    mesh = build_mesh(models.cantilever(members={"M": released(last={"about": "xz"})}, elements=2))
    end = mesh.node_name.index("M:B")
    assert mesh.element_node[-1, 1] == end
    assert mesh.member_node[0, 1] == mesh.node_name.index("B") == mesh.node_leader[end]
    assert (mesh.node_dof[end] >= 0).tolist() == [False] * 3 + [True, False, True]
    assert mesh.node_dof[end, 0] == DOF_TIED
    assert mesh.end_name == ("M:A", "M:B")


def test_no_moment_about_a_released_axis(models):
    """Section forces of an inclined member hinged about its local z: no such moment there, all others."""
    rng = np.random.default_rng(2)
    frame = models.frame().model_dump(mode="json")
    frame["members"]["bracea1"]["release_last"] = {"about": "z"}
    assembly = assemble(build_mesh(models.frame(members=frame["members"])))
    load = rng.standard_normal(assembly.mesh.n_dof) * 1e5
    force = end_force_map(assembly, factorise(assembly.stiffness).solve(load)[:, None])[0]
    end = assembly.mesh.end_name.index("bracea1:b2")
    free = assembly.mesh.node_dof[assembly.mesh.node_name.index("bracea1:b2"), 5]
    # a moment on the free end itself goes into the member, and nothing else does
    assert force[end, 5] == pytest.approx(load[free], rel=1e-6)
    load[free] = 0.0
    force = np.abs(end_force_map(assembly, factorise(assembly.stiffness).solve(load)[:, None])[0, end])
    assert force[5] < 1e-7 * force[4]
    assert force[3] > 1e-4 * force[4]


def loaded(models, mesh, on):
    """Bending at the ends of member bracea1 at rest under a load along it; `on`: node of its loaded end."""
    member = mesh.member_name.index("bracea1")
    elements = np.arange(mesh.member_element[member, 0], mesh.member_element[member, 1] + 1)
    axes = element_transformation(mesh)[elements]
    half = mesh.element_length[elements[0]] / 2.0
    fixed = np.zeros((3, len(elements), 12))
    for i in range(len(elements)):
        clamped = np.zeros(12)
        clamped[[1, 7]] = -1e4 * half
        clamped[[5, 11]] = -1e4 * half**2 / 3.0, 1e4 * half**2 / 3.0
        fixed[:, i] = clamped
    nodal = np.zeros((3, mesh.n_nodes, 6))
    for i, element in enumerate(elements):
        force = -np.einsum("ji,tj->ti", axes[i], fixed[:, i]).reshape(3, 2, 6)
        for side, node in enumerate(mesh.element_node[element]):
            end = "bracea1:b2" if mesh.node_name[node] == "bracea1:b2" else ""
            nodal[:, mesh.node_name.index(on) if end else node] += force[:, side]
    case = models.parse_case({"structure": {"model": "oc4", "reduction": "full"}})
    model = build_response_model(case, mesh, None)
    block = models.block(mesh, nodal, element=elements, fixed_end=fixed)
    stress = step(model, initial_state(model), block)[1].stress
    ends = [mesh.end_name.index(f"bracea1:{joint}") for joint in ("a1", "b2")]
    return np.abs(stress.bending_y[:, ends]).max(axis=0) + np.abs(stress.bending_z[:, ends]).max(axis=0)


def test_distributed_load_does_not_bend_a_released_end(models):
    """Loads by element node and fixed-end forces through the whole stage; wrong if they go to the joint."""
    data = models.frame().model_dump(mode="json")
    data["members"]["bracea1"]["release_last"] = {"about": "yz"}
    mesh = build_mesh(models.frame(members=data["members"]))
    held, free = loaded(models, mesh, "bracea1:b2")
    assert free < 1e-6 * held
    held, free = loaded(models, mesh, "b2")
    assert free > 1e-3 * held


@pytest.mark.parametrize(
    ("member", "message"),
    [
        (released({"about": "xyz"}), r"'B'.*moves freely"),
        (released(last={"about": "y"}), r"'B'.*moves freely about y"),
        (released({"about": "yz"}, {"hinge": [0.0, 1.0, 0.0]}), "moves freely"),
        (released({"about": "x"}, {"about": "x"}), "moves freely about z"),
    ],
)
def test_mechanisms_of_released_ends_are_named(models, member, message):
    with pytest.raises(InputError, match=message):
        assemble(build_mesh(models.cantilever(members={"M": member})))


def test_a_sprung_release_is_no_mechanism(models):
    stiff = released({"about": "xyz", "stiffness_nm_rad": 1e14})
    one = eigen_report(models.cantilever(members={"M": stiff}))["frequencies_hz"]
    assert one[:4] == pytest.approx(eigen_report(models.cantilever())["frequencies_hz"][:4], rel=1e-4)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        ([1e9, 1e9, 1e9, 1e9, 1e9, 0.0], "free to move about z"),
        ([1e9, 1e9, 0.0, 1e9, 1e9, 1e9], "free to move along z"),
        ((np.outer([1, 0, 0, 0, 20, 0], [1, 0, 0, 0, 20, 0]) * 1e6).tolist(), "free to move"),
    ],
)
def test_springs_must_hold_the_structure(models, stiffness, message):
    more = {"supports": {}, "support_springs": {"A": {"stiffness": stiffness}}}
    with pytest.raises(InputError, match=message):
        assemble(build_mesh(models.cantilever(**more)))


def test_stiff_springs_are_a_clamp(models):
    more = {"supports": {}, "support_springs": {"A": {"stiffness": [1e14] * 6}}}
    sprung = eigen_report(models.cantilever(**more))["frequencies_hz"][:6]
    assert sprung == pytest.approx(eigen_report(models.cantilever())["frequencies_hz"][:6], rel=1e-4)


def two_parts(models, stiffness, place=(0.0, 0.0, -40.0), **more):
    """A mast cut in two at half its height, its halves on joints C and D, a spring between them."""
    return models.cantilever(
        joints={"A": [0.0, 0.0, -50.0], "C": [0.0, 0.0, -40.0], "D": list(place), "B": [0.0, 0.0, -30.0]},
        members={
            "M": {"joints": ["A", "C"], "section": "tube"},
            "N": {"joints": ["D", "B"], "section": "tube"},
        },
        joint_springs={"S": {"joints": ["C", "D"], "stiffness": stiffness}},
        **more,
    )


def test_spring_between_joints_on_one_place(models):
    """Tip flexibility: that of the mast, and h^2/k of a rotational spring at half its height."""

    def tip(structure):
        assembly = assemble(build_mesh(structure))
        load = np.zeros(assembly.mesh.n_dof)
        load[assembly.internal] = 1.0
        return factorise(assembly.stiffness).solve(load)[assembly.internal]

    stiff, soft = 1e15, 2e9
    sprung = tip(two_parts(models, [stiff] * 4 + [soft, stiff]))
    assert sprung - tip(models.cantilever()) == pytest.approx(10.0**2 / soft, rel=1e-4)
    # apart, the spring sits at its second joint and the rest of the way is rigid
    apart = tip(two_parts(models, [stiff] * 4 + [soft, stiff], (0.0, 0.0, -38.0)))
    assert apart < sprung
    rigid = tip(two_parts(models, [stiff] * 6, (0.0, 0.0, -38.0)))
    assert apart - rigid == pytest.approx(8.0**2 / soft, rel=1e-4)


def test_springs_between_joints_that_do_not_hold(models):
    with pytest.raises(InputError, match=r"joint_springs.*moves freely along x"):
        assemble(build_mesh(two_parts(models, [1e9] * 4 + [0.0, 1e9])))
    with pytest.raises(InputError, match="lies on another joint"):
        models.cantilever(joints={"A": [0.0, 0.0, -50.0], "B": [0.0, 0.0, -30.0], "C": [0.0, 0.0, -30.0]})
    with pytest.raises(InputError, match="joint_springs"):
        models.cantilever(joint_springs={"S": {"joints": ["A", "X"], "stiffness": [1.0] * 6}})


def test_rigid_links_chain_to_the_interface_and_to_supports(models):
    """Joints of chained links follow one leader; rigid motion of the leader moves them rigidly."""
    data = models.frame().model_dump(mode="json")
    links = {"one": {"joints": ["b1", "b2"]}, "two": {"joints": ["b3", "b2"]}}
    mesh = build_mesh(models.frame(rigid_links=links))
    leader = {name: mesh.node_name[mesh.node_leader[i]] for i, name in enumerate(data["joints"])}
    assert [leader[f"b{i}"] for i in range(1, 5)] == ["b1", "b1", "b1", "b4"]
    assembly = assemble(mesh)
    b1, b3 = (mesh.node_name.index(name) for name in ("b1", "b3"))
    u = np.zeros(mesh.n_dof)
    u[mesh.node_dof[b1]] = [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]
    moved = (assembly.expansion @ u).reshape(-1, 6)
    arm = mesh.node_position[b3] - mesh.node_position[b1]
    assert moved[b3, :3] == pytest.approx(u[mesh.node_dof[b1]][:3] + np.cross([0.01, 0.02, 0.03], arm))
    assert moved[b3, 3:] == pytest.approx([0.01, 0.02, 0.03])
    to_top = build_mesh(models.frame(rigid_links={"one": {"joints": ["b1", "c1"]}}))
    assert to_top.node_leader[to_top.node_name.index("b1")] == to_top.transition_piece
    to_foot = build_mesh(models.frame(rigid_links={"one": {"joints": ["b1", "a1"]}}))
    assert to_foot.node_leader[to_foot.node_name.index("b1")] == to_foot.node_name.index("a1")


@pytest.mark.parametrize("joints", [["a1", "a2"], ["a1", "c1"], ["a1", "b9"]])
def test_rigid_links_that_cannot_be(models, joints):
    with pytest.raises(InputError, match="rigid_links"):
        models.frame(rigid_links={"one": {"joints": joints}})


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"members": {"M": released({"about": "z", "hinge": [0.0, 1.0, 0.0]})}}, "excludes"),
        ({"members": {"M": released({"hinge": [0.0, 0.0, 0.0]})}}, "direction"),
        ({"members": {"M": released({"about": "w"})}}, "about"),
        ({"members": {"M": released(section_last="none")}}, "section_last"),
        ({"support_springs": {"A": {"stiffness": [1.0] * 5}}}, "stiffness"),
        ({"support_springs": {"A": {"stiffness": [-1.0] + [1.0] * 5}}}, "negative"),
        ({"support_springs": {"A": {"stiffness": np.tri(6).tolist()}}}, "symmetric"),
        ({"support_springs": {"C": {"stiffness": [1.0] * 6}}}, "not a joint"),
        ({"support_springs": {"B": {"stiffness": [1.0] * 6}}}, "also supports"),
        ({"supports": {}}, "at least one joint"),
    ],
)
def test_refusals(models, more, message):
    with pytest.raises(InputError, match=message):
        models.cantilever(**more)


def test_tapered_members_are_as_at_their_middles(models):
    """Each element has the tube at its middle; masses at joints take the member's middle."""
    thin = {"diameter_m": 0.6, "thickness_m": 0.02, "youngs_modulus_pa": models.E,
            "shear_modulus_pa": models.G, "density_kg_m3": models.rho}  # fmt: skip
    thick = thin | {"diameter_m": models.diameter, "thickness_m": models.thickness}
    more = {"sections": {"tube": thick, "thin": thin}, "added_mass": {"density_kg_m3": 1000.0}}
    mesh = build_mesh(models.cantilever(members={"M": released(section_last="thin")}, **more))
    assert mesh.element_diameter == pytest.approx([1.125, 0.975, 0.825, 0.675], rel=1e-14)
    assert mesh.element_thickness == pytest.approx([0.04625, 0.03875, 0.03125, 0.02375], rel=1e-14)
    exact = np.pi / 4 * 1000.0 * 5.0 * np.square(mesh.element_diameter).sum()
    assert distributed_mass(mesh).total_kg["added_mass"] == pytest.approx(exact, rel=1e-12)
    joints = assemble(build_mesh(models.cantilever(extra_mass="joints", **more))).mass_kg
    assert joints["added_mass"] == pytest.approx(np.pi / 4 * 1000.0 * 20.0 * 1.2**2, rel=1e-12)


def test_free_structures_need_a_held_interface(models):
    structure = models.cantilever(supports={}, free=True)
    held = eigen_report(structure, fixed_interface=True)["frequencies_hz"]
    # held at the top and free at the foot: the cantilever upside down
    assert held[:4] == pytest.approx(eigen_report(models.cantilever())["frequencies_hz"][:4], rel=1e-9)
    with pytest.raises(InputError, match="--fixed-interface"):
        eigen_report(structure)
