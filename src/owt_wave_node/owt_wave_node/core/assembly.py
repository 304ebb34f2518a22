"""Loads of all members over the record: kinematics at their stations, Morison, nodal sums.

Members are worked through in batches that share the coefficients of their stations, and in threads; each
writes rows of its own, and the joints are summed afterwards in the order of the members, so that the
result does not depend on the number of threads. Kinematics are held for one piece of one member at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.config import CaseConfig
from owt_model.errors import ComputationError
from owt_model.parallel import map_threads
from owt_wave_node.core.coefficients import coefficient_at
from owt_wave_node.core.current import current_velocity
from owt_wave_node.core.diffraction import extra_acceleration, refuse_impossible
from owt_wave_node.core.ends import end_loads
from owt_wave_node.core.field import Field, Prepared
from owt_wave_node.core.hydro_mesh import HydroMesh, Run
from owt_wave_node.core.sea import Frame
from owt_wave_node.kernels import morison as _kernel
from owt_wave_node.kernels.sections import sectional
from owt_wave_node.kernels.surface import surface_loads

__all__ = ["LoadHistory", "Sections", "assemble"]

#: Bytes of kinematics per thread, and of coefficients, held at a time.
MOTION_BYTES, PREPARED_BYTES = 2 * 2**20, 64 * 2**20
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
    end_rows : float array [fixed, row, time]
        Equivalent nodal loads of these in element axes: Fy1, Mz1, Fy2, Mz2, Fz1, My1, Fz2, My2, and, where
        the case asks for loads along the members, Fx1, Fx2.
    """

    hydro: HydroMesh
    node: Int[np.ndarray, " loaded"]
    nodal: Float[np.ndarray, "loaded 6 time"]
    element: Int[np.ndarray, " fixed"]
    end_rows: Float[np.ndarray, "fixed row time"]


class Sections:
    """What Morison's equation needs of a run besides the kinematics.

    Per length of a member of diameter D, with v and a the components across it and v_x, a_x along it:
    rho Cm pi D^2 / 4 a + rho Cd D / 2 |v| v [eq. 4.64, corrected], and along it
    rho axial_ca pi D^2 / 4 a_x + rho axial_cd D / 2 |v_x| v_x (tangential drag of DNV-RP-C205, on D).
    """

    def __init__(self, case: CaseConfig, hydro: HydroMesh, frame: Frame) -> None:
        morison, self._case, self._hydro = case.morison, case, hydro
        self.axial = morison.axial_cd > 0.0 or morison.axial_ca > 0.0
        z = hydro.station[:, 2]
        self._factor = np.column_stack(
            [
                0.25 * np.pi * case.density_kg_m3 * coefficient_at(morison.cm, z),
                0.5 * case.density_kg_m3 * coefficient_at(morison.cd, z),
                np.full(z.size, 0.25 * np.pi * case.density_kg_m3 * morison.axial_ca),
                np.full(z.size, 0.5 * case.density_kg_m3 * morison.axial_cd),
            ]
        )
        #: Element axes x, y, z by row, in wave axes.
        self.axes = np.ascontiguousarray(hydro.element_axes @ frame.axes.T)

    def coefficient(self, run: Run) -> Float[np.ndarray, "station 4"]:
        """Coefficients of :func:`~owt_wave_node.kernels.sections.sectional` at the stations of a run."""
        d = run.diameter
        factor = self._factor[run.stations.start : run.stations.stop]
        return np.asarray(factor * np.array([d * d, d, d * d, d]))

    def current(self, run: Run) -> Float[np.ndarray, "station 3"]:
        """Velocity in m/s of the current at the stations of a run, in element axes."""
        z = self._hydro.station[run.stations.start : run.stations.stop, 2].copy()
        if self._case.current is None:
            return np.zeros((z.size, 3))
        turn = self._hydro.element_axes[run.elements[0]][:, :2]
        return np.ascontiguousarray(current_velocity(self._case, z) @ turn.T)


@dataclass(frozen=True)
class _Batch:
    """Distinct points of some members: kinematics on demand, elevation where the surface can cross."""

    place: Float[np.ndarray, "point 3"]
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
    case: CaseConfig,
    hydro: HydroMesh,
    frame: Frame,
    field: Field,
    *,
    lowest: float,
    highest: float,
    keep_ends: bool = True,
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
    keep_ends : bool
        Whether the loads of the elements at member ends are wanted; if not, they are held for one batch of
        members at a time, and the result has none.

    Raises
    ------
    ComputationError
        If a load is not finite.
    """
    assembly = _Assembly(case, hydro, frame, field, lowest, highest, keep_ends)
    for members in assembly.batches():
        assembly.run(members)
    for node, force in end_loads(case, hydro, frame, field, highest=highest).items():
        assembly.nodal[assembly.node_row[node], :3] += force
    kept = assembly.fixed.size if keep_ends else 0
    return LoadHistory(hydro, hydro.node, assembly.nodal, assembly.fixed[:kept], assembly.end_rows[:kept])


class _Assembly:
    def __init__(
        self,
        case: CaseConfig,
        hydro: HydroMesh,
        frame: Frame,
        field: Field,
        lowest: float,
        highest: float,
        keep_ends: bool,
    ) -> None:
        refuse_impossible(case)
        self.case, self.hydro, self.field, self.n = case, hydro, field, field.n
        self.lowest, self.highest = lowest, highest
        self.sections = Sections(case, hydro, frame)
        self.rule = 2 if case.morison.surface == "midpoint" else int(case.morison.distribution == "constant")
        self.n_rows = 10 if self.sections.axial else 8
        mesh = hydro.mesh
        self.node_row = np.full(mesh.n_nodes, -1, dtype=np.int64)
        self.node_row[hydro.node] = np.arange(hydro.node.size)
        self.keep_ends = keep_ends
        self.fixed = np.zeros(0, dtype=np.int64)
        self.fixed_row = np.full(mesh.n_elements, -1, dtype=np.int64)
        self.nodal = np.zeros((hydro.node.size, 6, self.n))
        self.end_rows = np.zeros((0, self.n_rows, self.n))
        if keep_ends:
            self._hold(hydro.element)
        # Stations of the same place share their kinematics; in plane waves so do those abreast.
        place = frame.place(hydro.station)
        if field.n_axes == 2:
            place[:, 1] = 0.0
        key = np.round(place / SAME_POINT).astype(np.int64)
        _, first, self.point = np.unique(key, axis=0, return_index=True, return_inverse=True)
        self.place = place[first]

    def _hold(self, elements: Int[np.ndarray, " some"]) -> None:
        """Make room for the rows of the elements at member ends among some, in place of what was held."""
        self.fixed = np.intersect1d(self.hydro.mesh.end_element, elements)
        self.fixed_row[:] = -1
        self.fixed_row[self.fixed] = np.arange(self.fixed.size)
        if len(self.end_rows) < self.fixed.size:
            self.end_rows = np.zeros((self.fixed.size, self.n_rows, self.n))
        else:
            self.end_rows[: self.fixed.size] = 0.0

    def batches(self) -> list[list[tuple[Run, ...]]]:
        """Groups of members, as the runs that water can reach, whose coefficients fit into memory."""
        limit = max(1, PREPARED_BYTES // (8 * self.field.n_axes * self.n))
        batches: list[list[tuple[Run, ...]]] = [[]]
        held = 0
        for member in self.hydro.runs:
            reached = tuple(part for run in member if (part := self._reached(run)) is not None)
            if not reached:
                continue
            count = reached[-1].stations.stop - reached[0].stations.start
            if batches[-1] and held + count > limit:
                batches.append([])
                held = 0
            batches[-1].append(reached)
            held += count
        return batches

    def _reached(self, run: Run) -> Run | None:
        """Segments of a run whose lower end the surface can reach: consecutive, a member is straight."""
        if run.is_gauss:
            return run
        z = self.hydro.station[run.stations.start : run.stations.stop : run.stride, 2]
        if z.max() <= self.highest:
            return run
        reached = np.flatnonzero(np.minimum(z[1:], z[:-1]) <= self.highest)
        return run.cut(int(reached[0]), int(reached[-1]) + 1) if reached.size else None

    def run(self, members: list[tuple[Run, ...]]) -> None:
        """Prepare the kinematics of some members' stations, then load the members, in threads."""
        if not members:
            return
        elements = self.hydro.element[
            np.unique([e for runs in members for run in runs for e in run.elements])
        ]
        if not self.keep_ends:
            self._hold(elements)
        stations = [np.arange(runs[0].stations.start, runs[-1].stations.stop) for runs in members]
        used, where = np.unique(self.point[np.concatenate(stations)], return_inverse=True)
        points = np.split(where, np.cumsum([len(part) for part in stations])[:-1])
        place = self.place[used]
        z = place[:, 2].copy()
        # A segment that the surface can cross needs the elevation at all its stations.
        splash = np.zeros(used.size, dtype=bool)
        for runs, part in zip(members, points, strict=True):
            for run in runs:
                if not run.is_gauss:
                    at = part[run.stations.start - runs[0].stations.start :][: len(run.stations)]
                    ends = z[at[:: run.stride]]
                    if ends.max() <= self.lowest:
                        continue
                    crossed = np.flatnonzero(np.maximum(ends[1:], ends[:-1]) > self.lowest)
                    for j in range(run.stride + 1):
                        splash[at[run.stride * crossed + j]] = True
        eta = np.add(*self.field.elevation(place[splash])) if splash.any() else np.zeros((0, self.n))
        batch = _Batch(place, self.field.prepare(place), eta, np.where(splash, np.cumsum(splash) - 1, -1))
        # Long members first keeps the threads busy to the end.
        tasks = sorted(zip(members, points, strict=True), key=lambda task: -len(task[1]))
        map_threads(lambda task: self._member(task[0], task[1], batch), tasks)
        self._add_joints(np.intersect1d(self.fixed, elements))

    def _pieces(self, runs: tuple[Run, ...]) -> Iterator[list[Run]]:
        """Runs in groups whose kinematics fit into memory together; long runs are cut."""
        limit = max(4, MOTION_BYTES // (16 * self.field.n_axes * self.n))
        piece: list[Run] = []
        for whole in runs:
            step = max(1, (limit - 1) // whole.stride)
            count = len(whole.weights)
            parts = [whole] if whole.is_gauss or count <= step else [
                whole.cut(i, min(i + step, count)) for i in range(0, count, step)
            ]  # fmt: skip
            for run in parts:
                if piece and run.stations.stop - piece[0].stations.start > limit:
                    yield piece
                    piece = []
                piece.append(run)
        yield piece

    def _member(self, runs: tuple[Run, ...], points: Int[np.ndarray, " station"], batch: _Batch) -> None:
        """Load one member; `points` are its stations' rows in the batch."""
        begin = runs[0].stations.start
        open_rows: dict[int, Float[np.ndarray, "row time"]] = {}
        for piece in self._pieces(runs):
            first = piece[0].stations.start
            motion = batch.prepared.kinematics(points[first - begin : piece[-1].stations.stop - begin])
            for run in piece:
                for e in [e for e in open_rows if e < run.elements[0]]:
                    self._finish(e, open_rows.pop(e))
                at = slice(run.stations.start - begin, run.stations.stop - begin)
                here = motion[run.stations.start - first : run.stations.stop - first]
                self._load(run, here, points[at], batch, open_rows)
        for e, rows in open_rows.items():
            self._finish(e, rows)

    def _load(
        self,
        run: Run,
        motion: Float[np.ndarray, "station channel time"],
        points: Int[np.ndarray, " station"],
        batch: _Batch,
        open_rows: dict[int, Float[np.ndarray, "row time"]],
    ) -> None:
        """Add the loads of one run to the rows of its elements."""
        sections, case, n_axes = self.sections, self.case, self.field.n_axes
        if case.morison.diffraction != "none":
            motion = motion.copy()
            motion[:, n_axes:] += extra_acceleration(
                self.field, batch.place[points], run.diameter, water_depth=case.water_depth_m,
                stretching=case.wave.stretching,
            )  # fmt: skip
        axes = sections.axes[run.elements[0]]
        coefficient, current = sections.coefficient(run), sections.current(run)
        q = np.empty((len(run.stations), 3 if sections.axial else 2, self.n))
        sectional(motion, axes, coefficient, current, q)
        z = batch.place[points, 2]
        for e in run.elements:
            if e not in open_rows:
                # Rows of an element at a member end are kept: they are filled where they stay.
                kept = self.fixed_row[self.hydro.element[e]]
                open_rows[e] = self.end_rows[kept] if kept >= 0 else np.zeros((self.n_rows, self.n))
        if not run.is_gauss and (z > self.lowest).any():
            e = run.elements[0]
            surface_loads(
                q, motion, z, batch.level(points), self.rule, run.stride, axes, coefficient, current,
                run.place, self.hydro.element_length[e], run.weights, open_rows[e],
            )  # fmt: skip
            return
        for e, weights in zip(run.elements, run.wet, strict=True):
            _kernel.add_stations(q, weights, open_rows[e])

    def _ends(self, e: int) -> tuple[Bool[np.ndarray, " 2"], Int[np.ndarray, " 2"]]:
        """Whether either end of element `e` is an end of its member, and the rows of its nodes."""
        mesh = self.hydro.mesh
        outer = mesh.member_element[mesh.element_member[e]] == e
        return outer, self.node_row[mesh.element_node[e]]

    def _finish(self, element: int, rows: Float[np.ndarray, "row time"]) -> None:
        """Add the rows of an element to the nodes inside its member."""
        # A sum is finite only if all its terms are.
        if not np.isfinite(rows.sum()):
            raise ComputationError("wave loads are not finite")
        e, axes = int(self.hydro.element[element]), self.hydro.element_axes[element]
        outer, node = self._ends(e)
        for side in np.flatnonzero(~outer):
            _kernel.add_to_node(rows, int(side), axes, self.nodal[node[side]])

    def _add_joints(self, elements: Int[np.ndarray, " some"]) -> None:
        """Add elements at member ends to the joints, in their order."""
        place = {int(e): i for i, e in enumerate(self.hydro.element)}
        ends: dict[int, list[tuple[int, int]]] = {}
        for e in elements.tolist():
            outer, node = self._ends(e)
            for side in np.flatnonzero(outer).tolist():
                ends.setdefault(int(node[side]), []).append((e, side))

        def one(row: int) -> None:
            for e, side in ends[row]:
                axes = self.hydro.element_axes[place[e]]
                _kernel.add_to_node(self.end_rows[self.fixed_row[e]], side, axes, self.nodal[row])

        map_threads(one, ends)
