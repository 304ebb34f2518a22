"""Hydrodynamic mesh: the stations along the members at which Morison's equation is evaluated."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from owt_model.axes import rotation
from owt_model.config import CaseConfig
from owt_model.mesh import Mesh
from owt_wave_node.core.coefficients import levels_of
from owt_wave_node.kernels import morison as _kernel

__all__ = ["HydroMesh", "Run", "build_hydro_mesh", "case_hydro_mesh", "interface_level"]

#: Parts of a segment below which two breaks count as one.
SLIVER = 1e-9
#: Gauss points of a submerged span: at least so many, and one more per so many m.
GAUSS_LEAST, GAUSS_SPACING = 3, 4.0


@dataclass(frozen=True)
class Run:
    """Consecutive stations of one member, of one diameter, that load one element or, by Gauss points, more.

    Attributes
    ----------
    stations : range
        Rows of :attr:`HydroMesh.station`; runs of stations that touch share the row between them.
    elements : range
        Loaded elements, indices into :attr:`HydroMesh.element`.
    diameter : float
        m, marine growth included if it was asked for.
    place : float array [place]
        Positions x / length of the stations along the element; empty at Gauss points.
    weights : float array [segment, node, shape]
        Nodal loads per unit force per length at the nodes of each segment [eq. 4.66].
    wet : float array [element, station, shape]
        The same per station where all of the run is wet.
    """

    stations: range
    elements: range
    diameter: float
    place: Float[np.ndarray, " place"]
    weights: Float[np.ndarray, "segment node shape"]
    wet: Float[np.ndarray, "element station shape"]

    @property
    def is_gauss(self) -> bool:
        """Whether the stations are Gauss points, which the surface must never reach."""
        return len(self.place) == 0

    @property
    def stride(self) -> int:
        """Stations per segment."""
        return int(self.weights.shape[1]) - 1

    def cut(self, first: int, stop: int) -> Run:
        """Segments `first` to `stop` - 1 as a run of their own."""
        step = self.stride
        weights = self.weights[first:stop]
        at = slice(step * first, step * stop + 1)
        return replace(
            self, stations=self.stations[at], place=self.place[at], weights=weights, wet=_wet(weights)
        )


def _wet(weights: Float[np.ndarray, "segment node shape"]) -> Float[np.ndarray, "1 station shape"]:
    """Sum the weights of the segments at their stations."""
    out = np.empty((1, (weights.shape[1] - 1) * len(weights) + 1, weights.shape[2]))
    _kernel.station_weights(weights, out[0])
    return out


@dataclass(frozen=True)
class HydroMesh:
    """Stations member by member, and the runs that they form.

    Attributes
    ----------
    element, node : int arrays
        Loaded elements and nodes of the finite element mesh: those that the water can reach below the
        lowest interface joint, in ascending order.
    station : float array [station, 3]
        Positions in m.
    member : tuple of int
        The loaded members.
    runs : tuple of tuples of Run
        Per loaded member, in order from its first to its second joint.
    element_axes : float array [loaded, 3, 3]
        Rotation to element axes, see :mod:`owt_model.axes`.
    """

    mesh: Mesh
    element: Int[np.ndarray, " loaded"]
    node: Int[np.ndarray, " node"]
    station: Float[np.ndarray, "station 3"]
    member: tuple[int, ...]
    runs: tuple[tuple[Run, ...], ...]
    element_axes: Float[np.ndarray, "loaded 3 3"]
    element_length: Float[np.ndarray, " loaded"]


def interface_level(mesh: Mesh) -> float:
    """Level in m of the lowest interface joint, which the water must not reach."""
    return float(mesh.node_position[mesh.interface_node, 2].min())


def case_hydro_mesh(case: CaseConfig, mesh: Mesh, *, lowest: float) -> HydroMesh:
    """Return the hydrodynamic mesh that a case asks for.

    Parameters
    ----------
    case : CaseConfig
        Its water depth and Morison options.
    mesh : Mesh
        Finite element mesh.
    lowest : float
        Level in m below which the surface never falls: Gauss points are used below it.
    """
    morison = case.morison
    return build_hydro_mesh(
        mesh,
        water_depth=case.water_depth_m,
        longest=morison.discretisation_m,
        marine_growth=morison.marine_growth,
        distribution=morison.distribution,
        levels=levels_of(morison.cd) + levels_of(morison.cm),
        gauss_below=lowest if morison.points == "gauss" else None,
    )


def build_hydro_mesh(
    mesh: Mesh,
    *,
    water_depth: float,
    longest: float,
    marine_growth: bool = False,
    distribution: str = "linear",
    levels: Iterable[float] = (),
    gauss_below: float | None = None,
) -> HydroMesh:
    """Divide the members below the interface and above the sea bed into segments of at most `longest` m.

    Segments are equal between breaks; breaks are the structural nodes, the sea bed, still water, `levels`,
    and the ends of the growth zone where growth counts. Tower elements carry no wave load.

    Parameters
    ----------
    mesh : Mesh
        Finite element mesh.
    water_depth : float
        m.
    longest : float
        Longest segment in m.
    marine_growth : bool
        Add twice the growth's thickness to the diameter within its zone, for drag and inertia alike.
    distribution : str
        Of the force in a segment: ``linear`` between its ends; ``quadratic``, with a station amid each
        segment; ``constant``, the mean of the ends as a point force at the middle (thesis figure 4.3).
    levels : iterable of float
        Further levels in m at which segments end.
    gauss_below : float, optional
        Level in m; elements below it get Gauss points instead of stations.
    """
    growth = mesh.structure.marine_growth if marine_growth else None
    breaks = [-water_depth, 0.0, *levels]
    if growth is not None:
        breaks += [growth.z_bottom_m, growth.z_top_m]
    elements = _loaded_elements(mesh, water_depth)
    builder = _Builder(mesh, elements, longest, distribution, breaks, water_depth)
    for e in range(len(elements)):
        z = mesh.node_position[mesh.element_node[elements[e]], 2]
        builder.add(e, submerged=gauss_below is not None and bool(z.max() < gauss_below))
    builder.close()
    ends = mesh.node_position[mesh.element_node[elements]]
    station = np.array(builder.station).reshape(-1, 3)
    return HydroMesh(
        mesh=mesh,
        element=elements,
        node=np.unique(mesh.element_node[elements]),
        station=station,
        member=tuple(builder.runs),
        runs=tuple(
            tuple(_with_growth(run, mesh, station) if growth is not None else run for run in runs)
            for runs in builder.runs.values()
        ),
        element_axes=rotation(ends[:, 0], ends[:, 1]),
        element_length=mesh.element_length[elements],
    )


def _loaded_elements(mesh: Mesh, water_depth: float) -> Int[np.ndarray, " loaded"]:
    """Elements of members that lie at least in part above the bed and below the interface."""
    z = mesh.node_position[mesh.element_node, 2]
    wet = (z.min(axis=1) < interface_level(mesh)) & (z.max(axis=1) > -water_depth)
    return np.flatnonzero((mesh.element_member >= 0) & wet)


def _with_growth(run: Run, mesh: Mesh, station: Float[np.ndarray, "station 3"]) -> Run:
    """Thicken a run that lies within the growth zone."""
    growth = mesh.structure.marine_growth
    assert growth is not None
    middle = 0.5 * (station[run.stations[0], 2] + station[run.stations[-1], 2])
    inside = growth.z_bottom_m < middle < growth.z_top_m
    return replace(run, diameter=run.diameter + 2.0 * growth.thickness_m) if inside else run


class _Builder:
    """Runs, in the order in which the elements come."""

    def __init__(
        self,
        mesh: Mesh,
        elements: Int[np.ndarray, " loaded"],
        longest: float,
        distribution: str,
        levels: list[float],
        water_depth: float,
    ) -> None:
        self.mesh, self.elements, self.longest, self.levels = mesh, elements, longest, levels
        self.constant, self.stride = distribution == "constant", 2 if distribution == "quadratic" else 1
        self.bed = -water_depth
        self.member = mesh.element_member[elements].tolist()
        self.ends = mesh.node_position[mesh.element_node[elements]]
        self.length = mesh.element_length[elements].tolist()
        self.station: list[Float[np.ndarray, " 3"]] = []
        self.runs: dict[int, list[Run]] = {}
        self.submerged: list[int] = []

    def _ends(self, e: int) -> tuple[int, Float[np.ndarray, "2 3"], float]:
        """Member, end positions and length of a loaded element."""
        return self.member[e], self.ends[e], self.length[e]

    def add(self, e: int, *, submerged: bool) -> None:
        """Add the runs of a loaded element, or keep it for the Gauss points of its span."""
        member = self._ends(e)[0]
        if self.submerged and (not submerged or self._ends(self.submerged[0])[0] != member):
            self.close()
        if submerged:
            self.submerged.append(e)
            return
        _, (a, b), length = self._ends(e)
        for s0, s1 in pairwise(_breaks(float(a[2]), float(b[2]), self.levels, self.bed)):
            count = max(1, math.ceil((s1 - s0) * length / self.longest - 1e-9))
            place = s0 + (s1 - s0) * np.arange(self.stride * count + 1) / (self.stride * count)
            weights = np.empty((count, self.stride + 1, 6))
            _kernel.segment_weights(place, length, self.stride, self.constant, weights)
            stations = self._stations(member, a + place[:, None] * (b - a), share=True)
            self._run(member, stations, range(e, e + 1), place, weights, _wet(weights))

    def close(self) -> None:
        """Give the submerged elements kept so far their Gauss points."""
        if not self.submerged:
            return
        elements = range(self.submerged[0], self.submerged[-1] + 1)
        self.submerged = []
        member, (a, _), _ = self._ends(elements[0])
        b = self._ends(elements[-1])[1][1]
        for s0, s1 in pairwise(_breaks(float(a[2]), float(b[2]), self.levels, self.bed)):
            start, stop = a + s0 * (b - a), a + s1 * (b - a)
            length = float(np.linalg.norm(stop - start))
            count = max(GAUSS_LEAST, 1 + math.ceil(length / GAUSS_SPACING))
            x = _gauss(count)[0]
            wet = np.stack([self._gauss_weights(e, start, stop, x) for e in elements])
            used = np.flatnonzero(wet.any(axis=(1, 2)))
            of = range(elements[used[0]], elements[used[-1]] + 1)
            stations = self._stations(member, start + x[:, None] * (stop - start), share=False)
            self._run(member, stations, of, np.zeros(0), np.zeros((0, 2, 6)), wet[used[0] : used[-1] + 1])

    def _gauss_weights(
        self,
        e: int,
        start: Float[np.ndarray, " 3"],
        stop: Float[np.ndarray, " 3"],
        x: Float[np.ndarray, " station"],
    ) -> Float[np.ndarray, "station shape"]:
        """Nodal loads of an element per unit force per length at the points x of the span it lies in.

        The force is the polynomial through the points; its product with the shapes is integrated exactly.
        """
        _, (a, b), length = self._ends(e)
        span = float(np.linalg.norm(stop - start))
        along = (stop - start) / span
        first, last = ((end - start) @ along / span for end in (a, b))
        low, high = max(first, 0.0), min(last, 1.0)
        if high - low <= SLIVER:
            return np.zeros((x.size, 6))
        point, weight = _gauss(x.size // 2 + 2)
        where = low + (high - low) * point
        shape = np.empty((where.size, 6))
        for row, s in zip(shape, (where - first) / (last - first), strict=True):
            _kernel.hermite(s, length, row)
        return np.asarray(_lagrange(x.size, where).T @ (shape * ((high - low) * span * weight)[:, None]))

    def _stations(self, member: int, points: Float[np.ndarray, "station 3"], *, share: bool) -> range:
        """Append stations; the first one is that of the run before where that one's last lies there."""
        before = self.runs.get(member)
        first = len(self.station)
        if share and before and not before[-1].is_gauss:
            points, first = points[1:], first - 1
        self.station.extend(points)
        return range(first, len(self.station))

    def _run(
        self,
        member: int,
        stations: range,
        elements: range,
        place: Float[np.ndarray, " place"],
        weights: Float[np.ndarray, "segment node shape"],
        wet: Float[np.ndarray, "element station shape"],
    ) -> None:
        diameter = float(self.mesh.element_diameter[self.elements[elements[0]]])
        run = Run(stations, elements, diameter, place, weights, np.ascontiguousarray(wet))
        self.runs.setdefault(member, []).append(run)


@cache
def _gauss(count: int) -> tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]:
    """Points and weights of Gauss and Legendre's rule on (0, 1)."""
    point, weight = np.polynomial.legendre.leggauss(count)
    return 0.5 + 0.5 * point, 0.5 * weight


@cache
def _modes(count: int) -> Float[np.ndarray, "station mode"]:
    """Coefficients of Legendre polynomials that are one at one Gauss point and zero at the others."""
    values = np.polynomial.legendre.legvander(2.0 * _gauss(count)[0] - 1.0, count - 1)
    return np.asarray(np.linalg.inv(values))


def _lagrange(count: int, s: Float[np.ndarray, " point"]) -> Float[np.ndarray, "point station"]:
    """Values at s of the polynomials that are one at one Gauss point and zero at the others."""
    return np.asarray(np.polynomial.legendre.legvander(2.0 * s - 1.0, count - 1) @ _modes(count))


def _breaks(bottom: float, top: float, levels: list[float], bed: float) -> list[float]:
    """Places x / length at which the part above the bed of a line between levels begins, breaks and ends."""
    breaks = [0.0, 1.0]
    rise = top - bottom
    if rise == 0.0:
        return breaks
    for s in sorted((level - bottom) / rise for level in levels):
        if 0.0 < s < 1.0 and all(abs(s - other) > SLIVER for other in breaks):
            breaks.append(s)
    return [s for s in sorted(breaks) if bottom + s * rise >= bed - SLIVER * (1.0 + abs(bed))]
