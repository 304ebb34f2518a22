"""Weights, buoyancy and axial forces at rest, and what they do to frequencies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array

from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.parts import StaticState
from owt_model.section import area
from owt_model.structure import load_structure
from owt_structure_node.core.assembly import assemble, element_stiffness, element_transformation
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.static import rest, weights

G = 9.81


def at_rest(structure, **state):
    mesh, state = build_mesh(structure), StaticState(**state)
    assembly = assemble(mesh)
    transform = element_transformation(mesh)
    local = element_stiffness(mesh)
    nodes = np.zeros((6 * mesh.n_nodes, 6 * mesh.n_nodes))
    for e, pair in enumerate(mesh.element_node):
        dof = (6 * pair[:, None] + np.arange(6)).reshape(-1)
        nodes[np.ix_(dof, dof)] += transform[e].T @ local[e] @ transform[e]
    found = rest(mesh, state, assembly.expansion, local, transform, csr_array(nodes))
    return mesh, found, -weights(mesh, state, transform)[1][:, 2].sum()


def test_axial_force_of_a_mast_is_the_weight_above(models):
    """Wall, growth, water and top mass; buoyancy of the displaced water; at the middle of each element."""
    more = {
        "transition_piece": {"mass_kg": 3e4},
        "marine_growth": {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -50.0, "z_top_m": -45.0},
        "flooding": {"density_kg_m3": 1025.0, "free_surface_z_m": -40.0},
        "added_mass": {"density_kg_m3": 1025.0, "free_surface_z_m": -35.0, "coefficient": 0.7},
        "members": {"M": {"joints": ["A", "B"], "section": "tube", "flooded": True}},
    }
    d, t = models.diameter, models.thickness
    steel = models.rho * float(area(np.array([d]), np.array([t]))[0])
    ring, inside, outer = ((d + 0.2) ** 2 - d**2, (d - 2 * t) ** 2, d**2)
    quarter = np.pi / 4

    def above(z, buoyancy):
        mass = 3e4 + steel * (-30.0 - z)
        mass += 1100.0 * quarter * ring * max(-45.0 - z, 0.0) + 1025.0 * quarter * inside * max(
            -40.0 - z, 0.0
        )
        mass -= buoyancy * 1025.0 * quarter * (outer * max(-35.0 - z, 0.0) + ring * max(-45.0 - z, 0.0))
        return mass * G

    for buoyancy in (True, False):
        mesh, found, weight = at_rest(models.cantilever(**more), buoyancy=buoyancy)
        middle = mesh.node_position[mesh.element_node, 2].mean(axis=1)
        # Boundaries of the zones are those of elements: linear in each, the middle is exact.
        assert found.axial == pytest.approx([-above(z, buoyancy) for z in middle], rel=1e-9)
        assert weight == pytest.approx(above(-50.0, buoyancy), rel=1e-12)
    assert above(-50.0, True) < 0.9 * above(-50.0, False)


def test_weights_of_a_frame_go_to_the_supports(models):
    """What the members hand over at the feet and what rests on the interface add to the weight."""
    structure = models.frame()
    mesh, found, weight = at_rest(structure)
    top = structure.transition_piece.mass_kg + structure.rotor_nacelle.mass_kg
    top += assemble(mesh).mass_kg["tower"]
    # the jacket carries the top by the forces that the interface joints pass to the transition piece
    assert found.handed_over[mesh.interface_node, 2].sum() == pytest.approx(top * G, rel=1e-9)
    assert weight > top * G
    assert found.displacement[mesh.transition_piece, 2] < 0.0


def test_report_of_the_static_state():
    """The weight of tower and rotor lowers the first frequency of the turbine by about 1 %."""
    structure = load_structure("oc4")
    report = eigen_report(structure, n_modes=5, static=True)
    state = report["static_state"]
    without = eigen_report(structure, n_modes=5)
    assert "static_state" not in without
    assert state["frequencies_hz"] == pytest.approx(without["frequencies_hz"], rel=1e-9)
    assert -1.5 < state["change_percent"][0] < -0.8
    assert 35.0 < state["buckling_factor"] < 50.0
    # Dunkerley's estimate: 1 - P/Pcr of the lowest buckling load bounds what the weight takes
    assert state["change_percent"][0] == pytest.approx(
        100 * (np.sqrt(1 - 1 / state["buckling_factor"]) - 1), rel=0.2
    )


def test_small_structures_and_reductions_have_a_report(models):
    mast = models.cantilever(transition_piece={"mass_kg": 5e4}, elements=2)
    one = eigen_report(mast, static=True, n_modes=2)
    other = eigen_report(mast, "CB00", static=True, n_modes=2)
    assert one["static_state"]["buckling_factor"] == other["static_state"]["buckling_factor"] > 1.0
    hung = models.cantilever(direction=(0, 0, -1), transition_piece={"mass_kg": 5e4})
    pulled = eigen_report(hung, static=True, n_modes=2)["static_state"]
    assert pulled["buckling_factor"] is None
    assert pulled["change_percent"][0] > 0.0


def test_option_in_the_file_is_the_option_of_the_report(models):
    inside = eigen_report(models.frame(static_state={"gravity_m_s2": 9.81}), n_modes=3)
    assert inside["frequencies_hz"] == eigen_report(models.frame(), n_modes=3, static=True)["frequencies_hz"]
    weightless = eigen_report(models.frame(static_state={"p_delta": False}), n_modes=3)
    assert weightless["frequencies_hz"] == eigen_report(models.frame(), n_modes=3)["frequencies_hz"]


def test_what_buckles_is_refused(models):
    heavy = models.cantilever(transition_piece={"mass_kg": 5e7}, static_state={})
    with pytest.raises(InputError, match="buckles"):
        assemble(build_mesh(heavy))
