"""Forces and stresses at the ends of members (thesis 4.3.2).

The forces that the nodes exert on an element are f_e = K_e u_e + f_fixed, in element axes. Eq. 4.69 has
the first term only and is wrong under distributed load: f_fixed is what a fully clamped element needs,
minus the equivalent nodal loads (:class:`owt_model.contracts.LoadBlock`).

Signs. Section forces act on the face that looks along the element: N is positive in tension, M_y and M_z
are such that the normal stress is N/A + M_y z/I - M_z y/I. At the second node of an element they are the
element forces, at the first node their negatives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_model.mesh import Mesh
from owt_model.section import area, bending_inertia, polar_inertia
from owt_structure_node.core.assembly import Assembly, element_stiffness, element_transformation
from owt_structure_node.kernels.stress import end_stress

__all__ = [
    "EndSections",
    "EndStress",
    "end_force_map",
    "end_samples",
    "end_sections",
    "fixed_end_columns",
    "stresses",
]


@dataclass(frozen=True)
class EndSections:
    """Which element end each member end is, and what turns its forces into stress.

    Attributes
    ----------
    element, side : int arrays [end]
        Element and its end: 0 first node, 1 second node.
    sign : float array [end]
        From element force to section force: -1 at the first, +1 at the second node.
    factor : float array [4, end]
        1/A (4.72) in 1/m2, r/I (4.73) and r/J (4.78) in 1/m3, and the factor of the resultant shear
        force in eq. 4.77 in 1/m2; r is the outer radius.
    """

    element: Int[np.ndarray, " end"]
    side: Int[np.ndarray, " end"]
    sign: Float[np.ndarray, " end"]
    factor: Float[np.ndarray, "4 end"]


@dataclass(frozen=True)
class EndStress:
    """Stress in Pa at member ends [sample, end], as :class:`owt_model.contracts.StressBlock` defines it."""

    axial: Float[np.ndarray, "sample end"]
    bending_y: Float[np.ndarray, "sample end"]
    bending_z: Float[np.ndarray, "sample end"]
    von_mises: Float[np.ndarray, "sample end"]


def end_sections(mesh: Mesh) -> EndSections:
    """Elements, sides and section factors of all member ends, in the order of ``Mesh.end_name``."""
    element = mesh.end_element
    side = np.arange(len(element), dtype=np.int64) % 2
    diameter, thickness = mesh.element_diameter[element], mesh.element_thickness[element]
    r_o, r_i = diameter / 2.0, diameter / 2.0 - thickness
    a = area(diameter, thickness)
    shear = 4.0 / (3.0 * a) * (r_o**2 + r_o * r_i + r_i**2) / (r_o**2 + r_i**2)
    columns = [
        1.0 / a,
        r_o / bending_inertia(diameter, thickness),
        r_o / polar_inertia(diameter, thickness),
        shear,
    ]
    factor = np.array(columns)
    return EndSections(element, side, np.where(side == 0, -1.0, 1.0), factor)


def end_force_map(
    assembly: Assembly, shapes: Float[np.ndarray, "dof function"]
) -> Float[np.ndarray, "function end 6"]:
    """Linear map from the amplitudes of shape functions to K_e u_e at the member ends [eq. 4.69].

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    shapes : float array [dof, function]
        Mode shapes or basis functions over the free degrees of freedom.

    Returns
    -------
    float array [function, end, 6]
        Forces in N and moments in N m on the element's end per unit amplitude, in element axes.
    """
    mesh = assembly.mesh
    ends = end_sections(mesh)
    rows = 6 * ends.side[:, None] + np.arange(6)
    local = element_stiffness(mesh)[ends.element]
    half = np.take_along_axis(local, rows[:, :, None], axis=1) @ element_transformation(mesh)[ends.element]
    motion = (assembly.expansion @ shapes).reshape(mesh.n_nodes, 6, -1)
    of_element = motion[mesh.element_node[ends.element]].reshape(len(rows), 12, -1)
    return np.ascontiguousarray(np.moveaxis(half @ of_element, -1, 0))


def fixed_end_columns(
    ends: EndSections, loaded_element: Int[np.ndarray, " fixed"]
) -> Int[np.ndarray, "end 2"]:
    """Where the fixed-end forces of each member end stand in a load block, -1 for an unloaded element."""
    place = {int(element): i for i, element in enumerate(loaded_element)}
    source = [place.get(int(element), -1) for element in ends.element]
    return np.stack([np.array(source, dtype=np.int64), 6 * ends.side], axis=1)


def end_samples(
    fixed_end: Float[np.ndarray, "sample fixed 12"], columns: Int[np.ndarray, "end 2"]
) -> Float[np.ndarray, "sample 6 end"]:
    """Fixed-end forces of loaded elements at the member ends, zero at the others.

    Parameters
    ----------
    fixed_end : float array [sample, fixed, 12]
        Fixed-end forces of the loaded elements, in element axes.
    columns : int array [end, 2]
        From :func:`fixed_end_columns`.
    """
    source, first = columns.T
    if not fixed_end.shape[1]:
        return np.zeros((len(fixed_end), 6, len(columns)))
    place = 12 * np.maximum(source, 0) + first + np.arange(6)[:, None]
    found = np.take(fixed_end.reshape(len(fixed_end), -1), place, axis=1)
    found[:, :, source < 0] = 0.0
    return np.asarray(found)


def stresses(
    force: Float[np.ndarray, "row 6 end"],
    ends: EndSections,
    fixed: Float[np.ndarray, "sample 6 end"] | None = None,
    substeps: int = 1,
) -> EndStress:
    """Stress at member ends from element end forces [eq. 4.70-4.79].

    The von Mises stress is as printed: resultant moment and resultant shear force, unsigned, with the
    normal force positive in tension and the torsional shear added by its amount, since a point of the
    section exists where the two shear stresses add.

    Parameters
    ----------
    force : float array [1 + substeps (samples - 1), 6, end]
        K_e u_e in N and N m on the ends of elements, element axes, the first row at the first sample of
        `fixed`.
    ends : EndSections
        Of the same ends.
    fixed : float array [sample, 6, end], optional
        From :func:`end_samples`: what is added, linear between the samples; nothing where left out.
    substeps : int
        Integration steps per load step.
    """
    added = np.zeros((1, *force.shape[1:])) if fixed is None else fixed
    shape = (force.shape[0], force.shape[2])
    axial, bending_y, bending_z, von_mises = (np.empty(shape) for _ in range(4))
    steps = max(len(force) - 1, 1) if fixed is None else substeps
    end_stress(force, added, steps, ends.sign, ends.factor, axial, bending_y, bending_z, von_mises)
    return EndStress(axial, bending_y, bending_z, von_mises)
