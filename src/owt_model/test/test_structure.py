"""Structures: what is shipped, and what is refused."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_model.mesh import DOF_FIXED, DOF_TIED, build_mesh
from owt_model.structure import load_structure, parse_structure, shipped_structures

TUBE = {
    "diameter_m": 1.0, "thickness_m": 0.05, "youngs_modulus_pa": 2.1e11, "shear_modulus_pa": 8e10,
    "density_kg_m3": 7850.0,
}  # fmt: skip
TOWER = {
    "height_m": 68.8, "diameter_base_m": 5.5, "diameter_top_m": 3.1, "thickness_base_m": 0.0387,
    "thickness_mid_m": 0.035, "thickness_top_m": 0.0175, "youngs_modulus_pa": 2.1e11,
    "shear_modulus_pa": 8e10, "density_kg_m3": 7850.0,
}  # fmt: skip
CANTILEVER: dict[str, Any] = {
    "name": "cantilever",
    "mudline_z_m": -10.0,
    "sections": {"tube": TUBE},
    "joints": {"A": [0.0, 0.0, -10.0], "B": [0.0, 0.0, 5.0]},
    "members": {"AB": {"joints": ["A", "B"], "section": "tube"}},
    "supports": {"A": [True] * 6},
    "interface": {"joints": ["B"], "reference_m": [0.0, 0.0, 5.0]},
}


def change(**values: Any) -> Callable[[dict[str, Any]], None]:
    return lambda data: data.update(values)


def rename(old: str, new: str) -> Callable[[dict[str, Any]], None]:
    """Give a joint another name, wherever it is named."""

    def changed(data: dict[str, Any]) -> None:
        text = json.dumps(data).replace(f'"{old}"', f'"{new}"')
        data.clear()
        data.update(json.loads(text))

    return changed


TAKEN = ("TP", "tower_top", "AB.1", "AB:A")
REFUSED = [
    *(
        (rename("B", name), f"joints.{name}", "name of another node")
        for name in ("TP", "tower_top", "AB.1", "AB:A")
    ),
    (change(unknown=1), "unknown", "not a known key"),
    (change(supports={}), "supports", "at least one"),
    (change(supports={"Z": [True] * 6}), "supports", "not a joint"),
    (change(members={"AB": {"joints": ["A", "Z"], "section": "tube"}}), "members.AB.joints", "not a joint"),
    (
        change(members={"AB": {"joints": ["A", "B"], "section": "pipe"}}),
        "members.AB.section",
        "not a section",
    ),
    (
        change(members={**CANTILEVER["members"], "BB": {"joints": ["B", "B"], "section": "tube"}}),
        "members.BB",
        "starts where it ends",
    ),
    (change(joints={**CANTILEVER["joints"], "C": [0.0, 0.0, 5.0]}), "joints.B", "lies on another"),
    (change(joints={**CANTILEVER["joints"], "C": [1.0, 0.0, 5.0]}), "joints.C", "connected to no member"),
    (
        change(interface={"joints": ["A"], "reference_m": [0.0, 0.0, 5.0]}),
        "interface.joints",
        "also supports",
    ),
    (change(sections={"tube": {**TUBE, "thickness_m": -0.1}}), "sections.tube.thickness_m", "greater than 0"),
    (
        change(sections={"tube": {**TUBE, "thickness_m": 0.6}}),
        "sections.*.thickness_m",
        "half of the diameter",
    ),
    (change(rotor_nacelle={"mass_kg": 1.0}), "rotor_nacelle", "needs a tower"),
    (change(interface={"joints": ["B", "B"], "reference_m": [0.0, 0.0, 5.0]}), "interface.joints", "twice"),
    (
        change(
            marine_growth={"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -2.0, "z_top_m": -40.0}
        ),
        "marine_growth.z_bottom_m",
        "must lie below",
    ),
    (change(tower={**TOWER, "thickness_mid_m": 0.001}), "tower.thickness_mid_m", "thick at"),
]


@pytest.mark.parametrize(("edit", "field", "limit"), REFUSED)
def test_refuses_with_field_and_limit(edit: Callable[[dict[str, Any]], None], field: str, limit: str) -> None:
    data = copy.deepcopy(CANTILEVER)
    edit(data)
    with pytest.raises(InputError) as caught:
        parse_structure(data, source="test")
    assert caught.value.field == field
    assert limit in caught.value.limit


def test_unknown_model_names_what_is_shipped() -> None:
    with pytest.raises(InputError, match="oc4, oc4-thesis"):
        load_structure("oc5")


def test_oc4_has_64_joints_112_members_6_sections() -> None:
    structure = load_structure("oc4")
    assert (len(structure.joints), len(structure.members), len(structure.sections)) == (64, 112, 6)
    assert structure.sources
    assert shipped_structures() == ["oc4", "oc4-thesis"]


def test_water_depth_must_fit_the_mudline() -> None:
    structure = load_structure("oc4")
    structure.check_water_depth(50.9)
    with pytest.raises(InputError, match="mudline"):
        structure.check_water_depth(51.1)


def test_content_hash_sees_every_number() -> None:
    data = copy.deepcopy(CANTILEVER)
    reference = parse_structure(data, source="test").content_hash
    assert parse_structure(copy.deepcopy(data), source="test").content_hash == reference
    data["sections"]["tube"]["thickness_m"] = 0.05 * (1 + 1e-12)
    assert parse_structure(data, source="test").content_hash != reference


def test_mesh_covers_every_member_once() -> None:
    mesh = build_mesh(load_structure("oc4"))
    start, end = mesh.node_position[mesh.element_node].transpose(1, 0, 2)
    length = np.linalg.norm(end - start, axis=1)
    for m in range(mesh.n_members):
        first, last = mesh.node_position[mesh.member_node[m]]
        own = mesh.element_member == m
        assert np.isclose(length[own].sum(), np.linalg.norm(last - first), rtol=1e-14)
        elements = mesh.element_node[mesh.member_element[m, 0] : mesh.member_element[m, 1] + 1]
        assert (elements[:-1, 1] == elements[1:, 0]).all()
        assert (elements[0, 0], elements[-1, 1]) == tuple(mesh.member_node[m])
    assert len(mesh.end_name) == 224
    assert mesh.end_name[0] == "M001:J01"


def test_degrees_of_freedom() -> None:
    mesh = build_mesh(load_structure("oc4-thesis"))
    inner_joints, internal_nodes, tower_nodes = 60 - 4 - 8, 108, 17
    assert mesh.n_dof == 6 * (inner_joints + internal_nodes + 1 + tower_nodes)
    assert np.count_nonzero(mesh.node_dof == DOF_FIXED) == 24
    assert np.count_nonzero(mesh.node_dof == DOF_TIED) == 48
    free = np.sort(mesh.node_dof[mesh.node_dof >= 0])
    assert (free == np.arange(mesh.n_dof)).all()
    assert mesh.node_name[mesh.tower_top] == "tower.17"
    assert np.isclose(mesh.node_position[mesh.tower_top, 2], 20.15 + 68.8)


@pytest.mark.parametrize(
    "text",
    [
        "&a {name: *a}", "name: 2001-99-99", "name: !!int x", "name: !!timestamp foo", "name: !!bool x",
        "[" * 3000, "name: " + "9" * 5000, "name: a\nname: b", "? [a, b]\n: c", "%", "\t: x",
    ],
    ids=lambda text: text[:20],
)  # fmt: skip
def test_hostile_yaml_is_one_clear_error(tmp_path: Path, text: str) -> None:
    path = tmp_path / "structure.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_structure(str(path))
    assert "\n" not in str(caught.value)


def test_numbers_of_yaml_may_have_a_plain_exponent(tmp_path: Path) -> None:
    """YAML 1.1 takes 1e8 and 6.1e4 for text; names that look like numbers in quotes stay names."""
    data = copy.deepcopy(CANTILEVER)
    data["support_springs"] = {"A": {"stiffness": [1e8, 2e8, 6.1e4, 1e7, 1e7, 1e-3]}}
    del data["supports"]
    text = json.dumps(data).replace("100000000.0", "1e8").replace("61000.0", "6.1e4").replace("0.001", "1e-3")
    assert "1e8" in text
    path = tmp_path / "mast.yaml"
    path.write_text(text)
    assert load_structure(str(path)).support_springs["A"].stiffness == (1e8, 2e8, 6.1e4, 1e7, 1e7, 1e-3)
