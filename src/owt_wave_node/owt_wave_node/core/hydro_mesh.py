"""Hydrodynamic mesh: the stations along the members at which Morison's equation is evaluated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from owt_model.axes import rotation
from owt_model.mesh import Mesh
from owt_wave_node.kernels import morison as _kernel

__all__ = ["HydroMesh", "build_hydro_mesh", "interface_level"]

#: Parts of a segment below which two breaks count as one.
SLIVER = 1e-9


@dataclass(frozen=True)
class HydroMesh:
    """Stations member by member, and the segments between consecutive stations of a member.

    Segment i of a member lies between its stations i and i + 1: with `member_station` the first station
    of each loaded member (and one past the last), member m has segments ``member_station[m] - m`` to
    ``member_station[m + 1] - m - 2``.

    Attributes
    ----------
    element, node : int arrays
        Loaded elements and nodes of the finite element mesh: those that the water can reach below the
        lowest interface joint, in ascending order.
    station : float array [station, 3]
        Positions in m.
    member_station : int array [member + 1]
        Bounds of the stations of each loaded member.
    segment_element : int array [segment]
        Index into `element`.
    segment_place : float array [segment, 2]
        Ends of the segment as x / length along its element.
    segment_diameter : float array [segment]
        Diameter in m, marine growth included if it was asked for.
    weights : float array [segment, 2, 4]
        Integrals in m of the shape functions times the linear hats [eq. 4.66].
    element_axes : float array [loaded, 3, 3]
        Rotation to element axes, see :mod:`owt_model.axes`.
    """

    mesh: Mesh
    element: Int[np.ndarray, " loaded"]
    node: Int[np.ndarray, " node"]
    station: Float[np.ndarray, "station 3"]
    member_station: Int[np.ndarray, " bound"]
    segment_element: Int[np.ndarray, " segment"]
    segment_place: Float[np.ndarray, "segment 2"]
    segment_diameter: Float[np.ndarray, " segment"]
    weights: Float[np.ndarray, "segment 2 4"]
    element_axes: Float[np.ndarray, "loaded 3 3"]
    element_length: Float[np.ndarray, " loaded"]

    @property
    def n_members(self) -> int:
        """Number of loaded members."""
        return len(self.member_station) - 1

    def segments(self, member: int) -> range:
        """Segments of a loaded member."""
        return range(
            int(self.member_station[member]) - member, int(self.member_station[member + 1]) - member - 1
        )


def interface_level(mesh: Mesh) -> float:
    """Level in m of the lowest interface joint, which the water must not reach."""
    return float(mesh.node_position[mesh.interface_node, 2].min())


def build_hydro_mesh(
    mesh: Mesh, *, water_depth: float, longest: float, marine_growth: bool = False
) -> HydroMesh:
    """Divide the members below the interface and above the sea bed into segments of at most `longest` m.

    Segments are equal between breaks; breaks are the structural nodes, the sea bed, still water, and the
    ends of the growth zone where growth counts. Tower elements carry no wave load.

    Parameters
    ----------
    mesh : Mesh
        Finite element mesh.
    water_depth : float
        m.
    longest : float
        Longest segment in m.
    marine_growth : bool
        Add twice the growth's thickness to the diameter within its zone.
    """
    top = interface_level(mesh)
    growth = mesh.structure.marine_growth if marine_growth else None
    levels = [0.0] if growth is None else [0.0, growth.z_bottom_m, growth.z_top_m]
    elements: list[int] = []
    stations: list[Float[np.ndarray, "station 3"]] = []
    bounds, owner, places, diameters, weights = [0], [], [], [], []
    last_member = -1
    for e in np.flatnonzero(mesh.element_member >= 0):
        a, b = mesh.node_position[mesh.element_node[e]]
        low, high = min(a[2], b[2]), max(a[2], b[2])
        if low >= top or high <= -water_depth:
            continue
        place = _divide(a, b, [-water_depth, *levels], -water_depth, longest)
        member, length = int(mesh.element_member[e]), float(np.linalg.norm(b - a))
        points = a + place[:, None] * (b - a)
        if member == last_member:
            stations.append(points[1:])
        else:
            stations.append(points)
            bounds.append(bounds[-1])
            last_member = member
        bounds[-1] += len(stations[-1])
        middle = 0.5 * (points[1:, 2] + points[:-1, 2])
        diameter = np.full(len(place) - 1, mesh.element_diameter[e])
        if growth is not None:
            inside = (middle > growth.z_bottom_m) & (middle < growth.z_top_m)
            diameter[inside] += 2.0 * growth.thickness_m
        weight = np.empty((len(place) - 1, 2, 4))
        _kernel.segment_weights(place, length, weight)
        owner.append(np.full(len(place) - 1, len(elements)))
        places.append(np.column_stack([place[:-1], place[1:]]))
        diameters.append(diameter)
        weights.append(weight)
        elements.append(int(e))
    element = np.array(elements, dtype=np.int64)
    ends = mesh.node_position[mesh.element_node[element]]
    return HydroMesh(
        mesh=mesh,
        element=element,
        node=np.unique(mesh.element_node[element]),
        station=np.concatenate(stations) if stations else np.zeros((0, 3)),
        member_station=np.array(bounds, dtype=np.int64),
        segment_element=np.concatenate(owner) if owner else np.zeros(0, dtype=np.int64),
        segment_place=np.concatenate(places) if places else np.zeros((0, 2)),
        segment_diameter=np.concatenate(diameters) if diameters else np.zeros(0),
        weights=np.concatenate(weights) if weights else np.zeros((0, 2, 4)),
        element_axes=rotation(ends[:, 0], ends[:, 1]),
        element_length=mesh.element_length[element],
    )


def _divide(
    a: Float[np.ndarray, " 3"], b: Float[np.ndarray, " 3"], levels: list[float], bed: float, longest: float
) -> Float[np.ndarray, " station"]:
    """Places x / length of the stations of an element from a to b, the part below the bed left out."""
    breaks = [0.0, 1.0]
    rise = b[2] - a[2]
    if rise != 0.0:
        crossings = [(level - a[2]) / rise for level in levels]
        breaks += [s for s in crossings if SLIVER < s < 1.0 - SLIVER]
    breaks = sorted(set(breaks))
    if rise != 0.0:
        breaks = [s for s in breaks if a[2] + s * rise >= bed - SLIVER * (1.0 + abs(bed))]
    length = float(np.linalg.norm(b - a))
    parts = []
    for s0, s1 in pairwise(breaks):
        count = max(1, math.ceil((s1 - s0) * length / longest - 1e-9))
        parts.append(s0 + (s1 - s0) * np.arange(count) / count)
    return np.concatenate([*parts, [breaks[-1]]])
