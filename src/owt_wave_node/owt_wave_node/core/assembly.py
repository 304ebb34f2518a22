"""Loads of all members over the record: kinematics at their stations, Morison, nodal sums.

Members are worked through in batches that share the coefficients of their stations, and in threads; each
writes rows of its own, and the joints are summed afterwards in the order of the members, so that the
result does not depend on the number of threads. Kinematics are held for one piece of one member at a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.config import CaseConfig
from owt_model.errors import ComputationError, InputError
from owt_wave_node.core.field import Field, Prepared
from owt_wave_node.core.hydro_mesh import HydroMesh
from owt_wave_node.core.parallel import map_threads
from owt_wave_node.core.sea import Frame
from owt_wave_node.kernels import morison as _kernel

__all__ = ["LoadHistory", "assemble"]

#: Bytes of kinematics per thread, and of coefficients, held at a time.
MOTION_BYTES, PREPARED_BYTES = 16 * 2**20, 128 * 2**20
#: Coordinates in m that agree to this count as one point.
SAME_POINT = 1e-9


@dataclass(frozen=True)
class LoadHistory:
    """Loads over the record, one row per channel and time last; :mod:`~owt_wave_node.core.stage` cuts blocks.

    Attributes
    ----------
    node : int array [loaded]
        Mesh nodes that the water can reach below the interface.
    nodal : float array [loaded, 6, time]
        Equivalent nodal forces in N and moments in N m, global axes.
    element : int array [fixed]
        Loaded elements at member ends.
    end_rows : float array [fixed, 8, time]
        Equivalent nodal loads of these in element axes: Fy1, Mz1, Fy2, Mz2, Fz1, My1, Fz2, My2.
    """

    hydro: HydroMesh
    node: Int[np.ndarray, " loaded"]
    nodal: Float[np.ndarray, "loaded 6 time"]
    element: Int[np.ndarray, " fixed"]
    end_rows: Float[np.ndarray, "fixed 8 time"]


@dataclass(frozen=True)
class _Batch:
    """Distinct points of some members: kinematics on demand, elevation where the surface can cross."""

    z: Float[np.ndarray, " point"]
    prepared: Prepared
    eta: Float[np.ndarray, "splash time"]
    eta_row: Int[np.ndarray, " point"]  # -1 where the point always is wet

    def level(self, points: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some time"]:
        """Elevation in m at points; plus infinity at those that always are wet."""
        rows = self.eta_row[points]
        out = np.full((points.size, self.eta.shape[1]), np.inf)
        out[rows >= 0] = self.eta[rows[rows >= 0]]
        return out


def assemble(
    case: CaseConfig, hydro: HydroMesh, frame: Frame, field: Field, *, lowest: float, highest: float
) -> LoadHistory:
    """Compute the loads on all members.

    Parameters
    ----------
    case : CaseConfig
        Morison coefficients, density, time.
    hydro : HydroMesh
        Stations and segments.
    frame : Frame
        Wave axes.
    field : Field
        The waves.
    lowest, highest : float
        Levels in m: the surface neither falls below the one nor rises above the other at the jacket.

    Raises
    ------
    ComputationError
        If a load is not finite.
    """
    assembly = _Assembly(case, hydro, frame, field, lowest, highest)
    for members in assembly.batches():
        assembly.run(members)
    assembly.add_joints()
    history = LoadHistory(hydro, hydro.node, assembly.nodal, assembly.fixed, assembly.end_rows)
    # A sum is finite only if all its terms are: no array of flags as large as the history is needed.
    if not np.isfinite([history.nodal.sum(), history.end_rows.sum()]).all():
        raise ComputationError("wave loads are not finite")
    return history


class _Assembly:
    def __init__(
        self,
        case: CaseConfig,
        hydro: HydroMesh,
        frame: Frame,
        field: Field,
        lowest: float,
        highest: float,
    ) -> None:
        self.hydro, self.field, self.n = hydro, field, field.n
        self.lowest, self.highest = lowest, highest
        cd, cm = case.morison.cd, case.morison.cm
        if isinstance(cd, tuple) or isinstance(cm, tuple):
            raise InputError("morison.cd", "a table", "is not available yet", "Give one number.")
        rho, diameter = case.density_kg_m3, hydro.segment_diameter
        self.inertia = 0.25 * np.pi * rho * cm * diameter**2  # kg/m
        self.drag = 0.5 * rho * cd * diameter  # kg/m2
        mesh = hydro.mesh
        self.node_row = np.full(mesh.n_nodes, -1, dtype=np.int64)
        self.node_row[hydro.node] = np.arange(hydro.node.size)
        self.fixed = np.intersect1d(mesh.end_element, hydro.element)
        self.fixed_row = np.full(mesh.n_elements, -1, dtype=np.int64)
        self.fixed_row[self.fixed] = np.arange(self.fixed.size)
        self.nodal = np.zeros((hydro.node.size, 6, self.n))
        self.end_rows = np.zeros((self.fixed.size, 8, self.n))
        # Components of element y along the waves, and of element z along the waves and upwards.
        unit, axes = frame.axes[0], hydro.element_axes
        self.axes = np.column_stack([axes[:, 1] @ unit, axes[:, 2] @ unit, axes[:, 2, 2]])
        # Stations of the same x along the waves and the same z share their kinematics.
        place = frame.place(hydro.station)
        if field.n_axes == 2:
            place[:, 1] = 0.0
        key = np.round(place / SAME_POINT).astype(np.int64)
        _, first, self.point = np.unique(key, axis=0, return_index=True, return_inverse=True)
        self.place = place[first]

    def batches(self) -> list[list[int]]:
        """Groups of members whose coefficients fit into memory together."""
        limit = max(1, PREPARED_BYTES // (16 * self.n))
        batches: list[list[int]] = [[]]
        held = 0
        for member in range(self.hydro.n_members):
            count = len(self.hydro.segments(member)) + 1
            if batches[-1] and held + count > limit:
                batches.append([])
                held = 0
            batches[-1].append(member)
            held += count
        return batches

    def _segments(self, member: int) -> range:
        """Segments of a member whose lower end the surface can reach: consecutive, a member is straight."""
        z, every = self.hydro.station[:, 2], self.hydro.segments(member)
        reached = [s for s in every if min(z[s + member], z[s + member + 1]) <= self.highest]
        return range(reached[0], reached[-1] + 1) if reached else range(0)

    def run(self, members: list[int]) -> None:
        """Prepare the kinematics of some members' stations, then load the members, in threads."""
        active = [(m, segments) for m in members if (segments := self._segments(m))]
        if not active:
            return
        stations = [np.arange(segments.start + m, segments.stop + m + 1) for m, segments in active]
        used, where = np.unique(self.point[np.concatenate(stations)], return_inverse=True)
        points = np.split(where, np.cumsum([len(part) for part in stations])[:-1])
        place = self.place[used]
        z = place[:, 2].copy()
        # A segment that the surface can cross needs the elevation at both its ends.
        splash = np.zeros(used.size, dtype=bool)
        for part in points:
            crossed = (z[part[1:]] > self.lowest) | (z[part[:-1]] > self.lowest)
            splash[part[1:][crossed]] = splash[part[:-1][crossed]] = True
        eta = np.add(*self.field.elevation(place[splash])) if splash.any() else np.zeros((0, self.n))
        batch = _Batch(z, self.field.prepare(place), eta, np.where(splash, np.cumsum(splash) - 1, -1))
        # Long members first keeps the threads busy to the end.
        tasks = sorted(
            zip([segments for _, segments in active], points, strict=True), key=lambda task: -len(task[0])
        )
        map_threads(lambda task: self._member(task[0], task[1], batch), tasks)

    def _member(self, segments: range, points: Int[np.ndarray, " station"], batch: _Batch) -> None:
        """Load one member; `points` are its stations' rows in the batch."""
        hydro = self.hydro
        chunk = max(1, MOTION_BYTES // (32 * self.n) - 1)
        element, rows = -1, np.zeros((8, self.n))
        for piece in (segments[i : i + chunk] for i in range(0, len(segments), chunk)):
            offset = piece.start - segments.start
            here = points[offset : offset + len(piece) + 1]
            motion = batch.prepared.kinematics(here)
            for run in self._runs(piece):
                e = int(hydro.segment_element[run.start])
                if e != element:
                    self._finish(element, rows)
                    element, rows = e, np.zeros((8, self.n))
                at = slice(run.start - piece.start, run.stop - piece.start + 1)
                z = batch.z[here[at]]
                surface = bool((z > self.lowest).any())
                cut = slice(run.start, run.stop)
                _kernel.run_loads(
                    motion[at],
                    z,
                    batch.level(here[at]) if surface else np.zeros((0, 0)),
                    surface,
                    self.axes[e],
                    self.inertia[run.start],
                    self.drag[run.start],
                    np.append(hydro.segment_place[cut, 0], hydro.segment_place[run.stop - 1, 1]),
                    hydro.element_length[e],
                    hydro.weights[cut],
                    rows,
                )
        self._finish(element, rows)

    def _runs(self, piece: range) -> list[range]:
        """Consecutive segments of one element and one diameter."""
        element, diameter = self.hydro.segment_element[piece], self.hydro.segment_diameter[piece]
        new = np.flatnonzero((np.diff(element) != 0) | (np.diff(diameter) != 0)) + 1
        bounds = [0, *new.tolist(), len(piece)]
        return [piece[a:b] for a, b in pairwise(bounds)]

    def _ends(self, e: int) -> tuple[Bool[np.ndarray, " 2"], Int[np.ndarray, " 2"]]:
        """Whether either end of element `e` is an end of its member, and the rows of its nodes."""
        mesh = self.hydro.mesh
        outer = mesh.member_element[mesh.element_member[e]] == e
        return outer, self.node_row[mesh.element_node[e]]

    def _finish(self, element: int, rows: Float[np.ndarray, "8 time"]) -> None:
        """Keep the rows of an element at a member end; add them to the nodes inside the member."""
        if element < 0:
            return
        e, axes = int(self.hydro.element[element]), self.hydro.element_axes[element]
        if self.fixed_row[e] >= 0:
            self.end_rows[self.fixed_row[e]] = rows
        outer, node = self._ends(e)
        for side in np.flatnonzero(~outer):
            _kernel.add_to_node(rows, int(side), axes[1], axes[2], self.nodal[node[side]])

    def add_joints(self) -> None:
        """Add the member ends to the joints, in the order of the members."""
        place = {int(e): i for i, e in enumerate(self.hydro.element)}
        ends: dict[int, list[tuple[int, int]]] = {}
        for e in self.fixed.tolist():
            outer, node = self._ends(e)
            for side in np.flatnonzero(outer).tolist():
                ends.setdefault(int(node[side]), []).append((e, side))

        def one(row: int) -> None:
            for e, side in ends[row]:
                axes = self.hydro.element_axes[place[e]]
                _kernel.add_to_node(self.end_rows[self.fixed_row[e]], side, axes[1], axes[2], self.nodal[row])

        map_threads(one, ends)
