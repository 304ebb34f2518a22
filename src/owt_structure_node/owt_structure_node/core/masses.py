"""Masses that are not steel: marine growth, flood water, added mass, lumped bodies.

Two ways to carry growth, water and added mass (``structure.extra_mass``):

``distributed``
    Masses over the part of each element that lies in the zone, consistent or lumped as the steel is.
    Growth and water move with the member in all directions, added mass across its axis only.
``joints``
    The thesis' way: each member's extra mass, its zones decided by its midpoint, goes in halves to its
    two end joints as point masses that are equal in all directions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.mesh import Mesh
from owt_model.structure import PointMass
from owt_structure_node.core.elements import lumped_mass, partial_mass

__all__ = ["ExtraMass", "body_matrix", "distributed_mass", "joint_mass", "weight_matrices"]


@dataclass(frozen=True)
class ExtraMass:
    """Element matrices in element axes, nodal masses, and totals by kind.

    Attributes
    ----------
    element : float array [element, 12, 12]
        Masses in kg, kg m, kg m2.
    node : float array [node]
        Point masses in kg.
    total_kg : dict
        ``marine_growth``, ``flood_water``, ``added_mass``: the mass that moves transversely.
    """

    element: Float[np.ndarray, "element 12 12"]
    node: Float[np.ndarray, " node"]
    total_kg: dict[str, float]


def body_matrix(body: PointMass) -> Float[np.ndarray, "6 6"]:
    """Mass matrix of a rigid body about its node, global axes.

    The six inertias are the entries Jxx, Jyy, Jzz, Jxy, Jxz, Jyz of the inertia matrix about the
    centre of gravity (SubDyn's convention: products are entries, not their negatives).
    """
    m, (x, y, z) = body.mass_kg, body.offset_m
    jxx, jyy, jzz, jxy, jxz, jyz = body.inertia_kg_m2
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result = np.zeros((6, 6))
    result[:3, :3] = m * np.eye(3)
    result[:3, 3:] = -m * skew
    result[3:, :3] = m * skew
    result[3:, 3:] = np.array([[jxx, jxy, jxz], [jxy, jyy, jyz], [jxz, jyz, jzz]]) - m * skew @ skew
    return result


def distributed_mass(mesh: Mesh) -> ExtraMass:
    """Growth, flood water and added mass along the members."""
    structure = mesh.structure
    z, length = mesh.node_position[mesh.element_node, 2], mesh.element_length
    line_mass = lumped_mass if structure.mass == "lumped" else partial_mass
    coefficient = structure.added_mass.coefficient if structure.added_mass is not None else 0.0
    matrices = np.zeros((mesh.n_elements, 12, 12))
    total = {"marine_growth": 0.0, "flood_water": 0.0, "added_mass": 0.0}
    for kind, zone, line in _lines(mesh):
        begin, end = _covered(z, *zone)
        if kind == "displaced":
            kind, line, axial = "added_mass", coefficient * line, np.zeros_like(line)
        else:
            axial = line
        matrices += line_mass(length, begin, end, line, axial)
        total[kind] += float(np.sum(line * (end - begin) * length))
    return ExtraMass(matrices, np.zeros(mesh.n_nodes), total)


def weight_matrices(mesh: Mesh, *, buoyancy: bool) -> Float[np.ndarray, "element 12 12"]:
    """Consistent matrices in element axes of what weighs along the members: growth and flood water.

    With `buoyancy`, less the displaced water, so that a fall of all nodes gives the submerged weight.
    """
    z, length = mesh.node_position[mesh.element_node, 2], mesh.element_length
    matrices = np.zeros((mesh.n_elements, 12, 12))
    for kind, zone, line in _lines(mesh):
        if kind != "displaced":
            matrices += partial_mass(length, *_covered(z, *zone), line, line)
        elif buoyancy:
            matrices -= partial_mass(length, *_covered(z, *zone), line, line)
    return matrices


def _lines(mesh: Mesh) -> Iterator[tuple[str, tuple[float, float], Float[np.ndarray, " element"]]]:
    """Kind, levels and mass per length in kg/m of growth, flood water and displaced water."""
    structure, member = mesh.structure, ~mesh.is_tower
    diameter, thickness = mesh.element_diameter, mesh.element_thickness
    growth, flood, added = structure.marine_growth, structure.flooding, structure.added_mass
    ring = np.zeros(mesh.n_elements)
    if growth is not None:
        ring = np.where(member, np.pi / 4.0 * ((diameter + 2.0 * growth.thickness_m) ** 2 - diameter**2), 0.0)
        yield "marine_growth", (growth.z_bottom_m, growth.z_top_m), growth.density_kg_m3 * ring
    if flood is not None:
        inside = np.pi / 4.0 * (diameter - 2.0 * thickness) ** 2
        flooded = np.where(member, mesh.member_flooded[mesh.element_member], False)
        yield "flood_water", (-np.inf, flood.free_surface_z_m), flood.density_kg_m3 * inside * flooded
    if added is not None:
        surface = added.free_surface_z_m
        whole = np.where(member, added.density_kg_m3 * np.pi / 4.0 * diameter**2, 0.0)
        yield "displaced", (-np.inf, surface), whole
        if growth is not None:  # where growth covers the member it displaces more water
            zone = (min(growth.z_bottom_m, surface), min(growth.z_top_m, surface))
            yield "displaced", zone, added.density_kg_m3 * ring


def joint_mass(mesh: Mesh) -> ExtraMass:
    """Growth, flood water and added mass as isotropic point masses at the members' joints."""
    structure = mesh.structure
    ends = mesh.node_position[mesh.member_node]
    z, length = ends[:, :, 2].mean(axis=1), np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    diameter, thickness = (
        _of_members(mesh, array) for array in (mesh.element_diameter, mesh.element_thickness)
    )
    mass = {kind: np.zeros(mesh.n_members) for kind in ("marine_growth", "flood_water", "added_mass")}
    growth, flood, added = structure.marine_growth, structure.flooding, structure.added_mass
    outer = diameter.copy()
    if growth is not None:
        covered = (growth.z_bottom_m <= z) & (z <= growth.z_top_m)
        outer = np.where(covered, diameter + 2.0 * growth.thickness_m, diameter)
        mass["marine_growth"] = growth.density_kg_m3 * np.pi / 4.0 * (outer**2 - diameter**2) * length
    if flood is not None:
        wet = mesh.member_flooded & (z < flood.free_surface_z_m)
        inside = np.pi / 4.0 * (diameter - 2.0 * thickness) ** 2
        mass["flood_water"] = np.where(wet, flood.density_kg_m3 * inside * length, 0.0)
    if added is not None:
        factor = added.coefficient * added.density_kg_m3 * np.pi / 4.0
        mass["added_mass"] = np.where(z < added.free_surface_z_m, factor * outer**2 * length, 0.0)
    node = np.zeros(mesh.n_nodes)
    for of_member in mass.values():
        for side in (0, 1):
            np.add.at(node, mesh.member_node[:, side], 0.5 * of_member)
    total = {kind: float(of_member.sum()) for kind, of_member in mass.items()}
    return ExtraMass(np.zeros((mesh.n_elements, 12, 12)), node, total)


def _of_members(mesh: Mesh, array: Float[np.ndarray, " element"]) -> Float[np.ndarray, " member"]:
    """Value at the middle of each member, whose elements vary linearly."""
    return np.asarray(array[mesh.member_element].mean(axis=1))


def _covered(
    z: Float[np.ndarray, "element 2"], bottom: float, top: float
) -> tuple[Float[np.ndarray, " element"], Float[np.ndarray, " element"]]:
    """Fractions of each element, from its first node, between which it lies in a zone of levels."""
    rise = z[:, 1] - z[:, 0]
    level = np.abs(rise) < 1e-12
    safe = np.where(level, 1.0, rise)
    at_bottom = (np.maximum(bottom, -1e30) - z[:, 0]) / safe
    at_top = (np.minimum(top, 1e30) - z[:, 0]) / safe
    begin = np.clip(np.minimum(at_bottom, at_top), 0.0, 1.0)
    end = np.clip(np.maximum(at_bottom, at_top), 0.0, 1.0)
    inside = (bottom <= z[:, 0]) & (z[:, 0] <= top)
    begin = np.where(level, 0.0, begin)
    end = np.where(level, inside.astype(float), end)
    return begin, np.maximum(end, begin)
