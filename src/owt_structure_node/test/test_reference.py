"""The OC4 jacket against SubDyn, an independent frame code, and the thesis' tables."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.modes import lowest_modes
from owt_structure_node.core.reduction import guyan


def bare_steel(**update):
    """The OC4 jacket as SubDyn has it: no growth, water, added mass or tower."""
    none = dict.fromkeys(("tower", "rotor_nacelle", "marine_growth", "flooding", "added_mass"))
    structure = load_structure("oc4").model_copy(update=none | {"rotary_inertia": True} | update)
    return structure.model_copy(update={"transition_piece": type(structure.transition_piece)()})


def worst(found, expected):
    found, expected = np.array(found), np.array(expected)
    return np.abs(found[: len(expected)] / expected - 1).max()


@pytest.mark.parametrize("case", ["nd1_EB", "nd1_T", "nd2_EB", "nd2_T"])
def test_bare_steel_against_subdyn(reference, case):
    """Fixed-interface and Guyan frequencies to SubDyn's print precision, Guyan matrices to round-off."""
    subdyn, model = reference("subdyn"), case.split("_")[1]
    expected = subdyn["cases"][case]
    beam = {"EB": "euler-bernoulli", "T": "timoshenko"}[model]
    report = eigen_report(bare_steel(beam=beam, elements_per_member=int(case[2])))
    assert report["mass_kg"] == pytest.approx(subdyn["mass_kg"], abs=0.05)
    assert worst(report["fixed_interface_frequencies_hz"], expected["fixed_interface_hz"]) < 1e-6
    k, m = np.array(report["guyan_stiffness"]), np.array(report["guyan_mass"])
    assert worst(np.sqrt(eigh(k, m, eigvals_only=True)) / (2 * np.pi), expected["guyan_hz"]) < 1e-6
    assert np.abs(k - expected["guyan_stiffness"]).max() < 1e-9 * np.abs(k).max()
    assert np.abs(m - expected["guyan_mass"]).max() < 1e-9 * np.abs(m).max()


@pytest.mark.parametrize("wrong", [{"rotary_inertia": False}, {"beam": "euler-bernoulli"}])
def test_subdyn_comparison_would_notice(reference, wrong):
    """Without rotary inertia, or without shear, the frequencies are off by far more than the tolerance."""
    report = eigen_report(bare_steel(**({"beam": "timoshenko", "elements_per_member": 2} | wrong)))
    expected = reference("subdyn")["cases"]["nd2_T"]["fixed_interface_hz"]
    assert worst(report["fixed_interface_frequencies_hz"], expected) > 1e-4


def test_thesis_model_against_independent_code(reference):
    """Model oc4-thesis: masses, fixed-interface modes, whole turbine, reductions, boundary matrices."""
    expected, structure = reference("oc4_thesis"), load_structure("oc4-thesis")
    report = eigen_report(structure)
    kinds = {"members": "steel", "marine_growth": "mg", "flood_water": "flood", "added_mass": "added"}
    for kind, short in kinds.items():
        assert report["masses_kg"][kind] == pytest.approx(1e3 * expected["mass_t"][short], rel=1e-9)
    assert worst(report["fixed_interface_frequencies_hz"], expected["fixed_interface_hz"][:20]) < 1e-6
    assert worst(report["frequencies_hz"], expected["full_hz"]) < 1e-5
    assert worst(report["logdec_percent"], expected["logdec_reference_percent"]) < 1e-5
    for reduction in ("CB00", "CB20"):
        found = eigen_report(structure, reduction)["frequencies_hz"]
        assert worst(found, expected[f"{reduction}_hz"]) < 1e-7
    for name in ("guyan_stiffness", "guyan_mass"):
        found = np.array(report[name])
        assert np.abs(found - expected[name]).max() < 1e-9 * np.abs(found).max()
    soft = eigen_report(structure.model_copy(update={"jacket_stiffness_factor": 0.37}))
    assert worst(soft["frequencies_hz"], expected["frequency_model_hz"]) < 1e-5
    assert worst(soft["frequencies_hz"], expected["full_hz"]) > 0.1


def test_converged_model_against_independent_code(reference):
    """Distributed masses integrated exactly: each zone adds what it should, to four decimals."""
    expected, oc4 = reference("oc4"), load_structure("oc4")

    def fixed(**update):
        report = eigen_report(oc4.model_copy(update=update))
        return report["fixed_interface_frequencies_hz"], report["masses_kg"]

    found, mass = fixed()
    assert worst(found, expected["fixed_interface_hz"]) < 2e-5
    for kind, key in (("members", "steel"), ("marine_growth", "marine_growth")):
        assert mass[kind] == pytest.approx(1e3 * expected["mass_t"][key], abs=10)
    assert mass["flood_water"] == pytest.approx(204.58e3, abs=10)
    assert mass["added_mass"] == pytest.approx(678.16e3, abs=10)
    two: dict[str, object] = {"elements_per_member": 2, "added_mass": None}
    assert worst(fixed(**two)[0], expected["growth_flood_ndiv2_hz"]) < 2e-5
    two |= {"flooding": None}
    assert worst(fixed(**two)[0], expected["growth_ndiv2_hz"]) < 2e-5
    two |= {"marine_growth": None}
    assert worst(fixed(**two)[0], expected["steel_only_ndiv2_hz"]) < 2e-5
    assert worst(fixed(beam="timoshenko")[0], expected["timoshenko_ndiv4_hz"]) < 2e-5
    assert worst(fixed(extra_mass="joints")[0], expected["fixed_interface_hz"]) > 1e-2


def symmetry_classes(mesh, shapes):
    """Class of each mode under a quarter turn about z: A alike, B reversed, E neither (a pair)."""
    n_joints = len(mesh.structure.joints)
    position = mesh.node_position[:n_joints]
    turned = position[:, [1, 0, 2]] * [-1, 1, 1]
    image = [int(np.abs(position - point).sum(axis=1).argmin()) for point in turned]
    classes = ""
    for shape in shapes.T:
        motion = shape.reshape(-1, 6)[:n_joints, :3]
        rotated = motion[:, [1, 0, 2]] * [-1, 1, 1]
        likeness = np.sum(rotated * motion[image]) / np.sum(motion**2)
        classes += "A" if likeness > 0.9 else "B" if likeness < -0.9 else "E"
    return classes


def by_class(frequencies, classes):
    return {kind: [f for f, c in zip(frequencies, classes, strict=True) if c == kind] for kind in "ABE"}


def test_thesis_table_b2(reference, models):
    """Fixed-interface frequencies of thesis table B.2, mode matched to mode by symmetry: within 1.3 %."""
    table = reference("thesis_tables")
    mesh, assembly = models.shipped("oc4-thesis").mesh, models.shipped("oc4-thesis").assembly
    n = assembly.internal
    omega2, phi = lowest_modes(assembly.jacket_stiffness[:n, :n], assembly.jacket_mass[:n, :n], 10)
    shapes = np.zeros((mesh.n_dof, 10))
    shapes[:n] = phi
    nodal = assembly.expansion @ shapes
    classes = symmetry_classes(mesh, nodal)
    found = by_class(np.sqrt(omega2) / (2 * np.pi), classes)
    expected = by_class(table["table_B2_hz"], table["table_B2_class"])
    assert {k: len(v) for k, v in found.items()} == {k: len(v) for k, v in expected.items()}
    assert max(worst(found[kind], expected[kind]) for kind in "ABE") < 0.013
    no_added = lowest_modes(*_without_added_mass(), 10)[0]
    assert worst(np.sqrt(no_added) / (2 * np.pi), table["table_B2_hz"]) > 0.1


def _without_added_mass():
    structure = load_structure("oc4-thesis").model_copy(update={"added_mass": None})
    assembly = assemble(build_mesh(structure))
    n = assembly.internal
    return assembly.jacket_stiffness[:n, :n], assembly.jacket_mass[:n, :n]


def test_thesis_table_b1_and_b3(reference):
    """Whole turbine: ten modes within 1 %, twenty within 3 %; damping of ten modes within 1 %.

    Tower wall, rotor-nacelle assembly and transition piece are fitted to these tables, so that this shows
    that the model is the fitted one; it is no prediction.
    """
    table = reference("thesis_tables")
    for name, factor, limit in (("reference", 1.0, 0.03), ("frequency", 0.37, 0.05)):
        damping = {"reference": (0.027, 0.002), "frequency": (0.021, 0.0024)}[name]
        report = eigen_report(
            load_structure("oc4-thesis").model_copy(update={"jacket_stiffness_factor": factor}),
            damping=_damping(*damping),
        )
        printed = table["table_B3"][name]
        assert worst(report["frequencies_hz"][:10], printed["frequency_hz"][:10]) < 0.01
        assert worst(report["frequencies_hz"], printed["frequency_hz"]) < limit
        assert worst(report["logdec_percent"][:10], printed["logdec_percent"][:10]) < 0.01
    full = eigen_report(load_structure("oc4-thesis"))["frequencies_hz"]
    assert worst(full, table["table_B1_hz"]["full"]) < 0.03
    assert worst(full, table["table_B1_hz"]["CB00"]) > 0.03


def _damping(alpha, beta):
    from owt_model.config import Damping

    return Damping(alpha=alpha, beta=beta)


def test_reduction_errors_are_those_of_the_thesis(reference):
    """CB00 stiffens modes 8 to 13 by 10 to 90 %, CB20 none of twenty by more than 1 %."""
    structure, table = load_structure("oc4-thesis"), reference("thesis_tables")["table_B1_hz"]
    full = np.array(eigen_report(structure)["frequencies_hz"])
    for reduction, limit in (("CB00", 0.4), ("CB20", 0.01)):
        error = np.array(eigen_report(structure, reduction)["frequencies_hz"]) / full - 1
        printed = np.array(table[reduction]) / np.array(table["full"]) - 1
        assert (error > -1e-9).all()
        assert np.abs(error - printed)[:13].max() < limit
        assert (error[7:13].max() > 0.5) == (reduction == "CB00")


def test_grouted_piles_are_indispensable(reference):
    """Without the grouted section between -49.5 and -45.5 m the first frequency falls by a fifth."""
    structure = load_structure("oc4-thesis")
    leg = {"section": "leg_bottom"}
    members = {
        name: member.model_copy(update=leg) if member.section == "grouted_pile" else member
        for name, member in structure.members.items()
    }
    changed = structure.model_copy(update={"members": members})
    first = eigen_report(changed, n_modes=1)["fixed_interface_frequencies_hz"][0]
    assert first / reference("oc4_thesis")["fixed_interface_hz"][0] == pytest.approx(0.8, abs=0.03)


def test_guyan_mass_includes_members_inside_the_rigid_piece(models):
    """The mass of the jacket along z under rigid heave of the whole: all of it but what the supports hold."""
    assembly = models.shipped("oc4").assembly
    static = guyan(assembly)
    assert 0.2 * 673882 < static.mass[2, 2] < 673882 + 180671 + 204576 + 678158
