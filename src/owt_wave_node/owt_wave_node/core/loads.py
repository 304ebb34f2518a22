"""Morison loads of a case on the jacket: nodal loads, total force and moment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_model.errors import InputError
from owt_model.mesh import Mesh
from owt_model.parallel import slices
from owt_wave_node.core.assembly import LoadHistory, assemble
from owt_wave_node.core.field import Field
from owt_wave_node.core.hydro_mesh import HydroMesh, case_hydro_mesh, interface_level
from owt_wave_node.core.kinematics import check_bed
from owt_wave_node.core.profile import check_extrapolation
from owt_wave_node.core.route import EXACT, make_field
from owt_wave_node.core.sea import Frame, build_sea_state, sea_field, sea_height
from owt_wave_node.core.window import Windowed, window_of

__all__ = [
    "LoadHistory",
    "LoadWindows",
    "Loads",
    "jacket_loads",
    "nodal_rows",
    "prepare_loads",
    "resultant",
    "surface_range",
    "window_length",
]

#: Gauges per shortest wave over the width of the jacket; between them a maximum can hide 8 %.
GAUGES_PER_WAVE = 8
MAX_GAUGES = 400
#: Factor and length in m added to the range of the surface, to be sure of what stays wet or dry.
SAFETY, MARGIN = 1.1, 0.05
#: Bytes of loads of a long record that are held at a time.
HELD_BYTES = 220e6
#: Gauges of a record, in samples times gauges, whose elevation is held at a time.
GAUGE_SAMPLES = 2**21


@dataclass(frozen=True)
class Loads:
    """Wave loads on a jacket over the whole record.

    Attributes
    ----------
    t : float array [time]
        s.
    force, moment : float arrays [time, 3]
        Total force in N and total moment in N m about the origin, global axes.
    error_estimate : float
        Error of the second order relative to its standard deviation; zero where all pairs were summed.
    """

    t: Float[np.ndarray, " time"]
    force: Float[np.ndarray, "time 3"]
    moment: Float[np.ndarray, "time 3"]
    history: LoadHistory
    error_estimate: float = 0.0

    def nodal(self) -> Float[np.ndarray, "time node 6"]:
        """Forces in N and moments in N m at every node of the mesh, zero where no load can reach."""
        return nodal_rows(self.history, slice(0, len(self.t)))


def nodal_rows(history: LoadHistory, rows: slice) -> Float[np.ndarray, "sample node 6"]:
    """Forces in N and moments in N m at every node of the mesh, at some samples of a history."""
    out = np.zeros((rows.stop - rows.start, history.hydro.mesh.n_nodes, 6))
    for i, node in enumerate(history.node):
        out[:, node] = history.nodal[i, :, rows].T
    return out


def resultant(history: LoadHistory) -> Float[np.ndarray, "sample 6"]:
    """Total force in N and moment in N m about the origin, M + r x F, at the samples of a history."""
    size = len(history.node)
    lever = np.zeros((6, size, 6))
    lever[range(6), :, range(6)] = 1.0
    x, y, z = history.hydro.mesh.node_position[history.node].T
    lever[3, :, 1], lever[3, :, 2] = -z, y
    lever[4, :, 0], lever[4, :, 2] = z, -x
    lever[5, :, 0], lever[5, :, 1] = -y, x
    return np.ascontiguousarray((lever.reshape(6, -1) @ history.nodal.reshape(6 * size, -1)).T)


@dataclass(frozen=True)
class LoadWindows:
    """The loads of a sea on a structure, computed window by window when asked for.

    Attributes
    ----------
    lowest, highest : float
        Levels in m: over the whole record the surface neither falls below nor rises above them.
    length : int
        Samples per window; the last one can be shorter.
    keep_ends : bool
        Whether the windows hold the loads of the elements at member ends.
    """

    case: CaseConfig
    hydro: HydroMesh
    frame: Frame
    field: Field
    lowest: float
    highest: float
    length: int
    keep_ends: bool = True

    @property
    def error_estimate(self) -> float:
        """Error of the second order relative to its standard deviation; zero where all pairs are summed."""
        return float(getattr(window_of(self.field, 0, min(self.length, self.field.n)), "error_estimate", 0.0))

    def __len__(self) -> int:
        """Number of windows."""
        return -(-self.field.n // self.length)

    def rows(self, i: int) -> slice:
        """Samples of a window."""
        return slice(i * self.length, min((i + 1) * self.length, self.field.n))

    def window(self, i: int) -> LoadHistory:
        """Loads in a window.

        Raises
        ------
        ComputationError
            If a load is not finite, or the second order not accurate.
        """
        rows = self.rows(i)
        part = window_of(self.field, rows.start, rows.stop - rows.start)
        return assemble(
            self.case, self.hydro, self.frame, part,
            lowest=self.lowest, highest=self.highest, keep_ends=self.keep_ends,
        )  # fmt: skip

    def __iter__(self) -> Iterator[LoadHistory]:
        """All windows in order."""
        return (self.window(i) for i in range(len(self)))


def window_length(case: CaseConfig, hydro: HydroMesh) -> int:
    """Samples of loads that are held at a time, a multiple of the stream's block unless they are all.

    As asked for; else the whole record up to 6000 samples, and equal parts of at most 6000 samples and
    220 MB of a longer one.
    """
    n, block = case.time.n, case.stream.block
    if case.wave.window is not None:
        limit = case.wave.window
    elif n <= EXACT:
        limit = n
    else:
        ends = np.intersect1d(hydro.mesh.end_element, hydro.element).size
        limit = min(EXACT, int(HELD_BYTES / (8 * (6 * hydro.node.size + 8 * ends))))
    if limit >= n:
        return n
    parts = -(-n // max(limit, block))
    return -(-n // (parts * block)) * block


def jacket_loads(case: CaseConfig, mesh: Mesh) -> Loads:
    """Compute the Morison loads of `case` on the jacket of `mesh`, and hold them all.

    Raises
    ------
    InputError
        If the water depth is not that of the structure, or the surface reaches the interface.
    ComputationError
        If a load is not finite.
    """
    sea = build_sea_state(case)
    windows = prepare_loads(case, mesh, sea, make_field(case, sea))
    parts = list(windows)
    history = parts[0]
    if len(parts) > 1:
        nodal, ends = (
            np.concatenate([getattr(p, name) for p in parts], axis=2) for name in ("nodal", "end_rows")
        )
        history = replace(history, nodal=nodal, end_rows=ends)
    total = resultant(history)
    return Loads(
        t=np.arange(case.time.n) * case.time.dt_s,
        force=total[:, :3].copy(),
        moment=total[:, 3:].copy(),
        history=history,
        error_estimate=windows.error_estimate,
    )


def surface_range(field: Field, place: Float[np.ndarray, "point 3"], shortest: float) -> tuple[float, float]:
    """Lowest and highest surface in m over the record, and over the width that `place` spans along the waves.

    Short crests are lower at some places across the heading than at others: over the area that `place` spans.

    Parameters
    ----------
    field : Field
        The waves.
    place : float array [point, 3]
        Places in m in wave axes.
    shortest : float
        Length in m of the shortest wave.
    """
    crossing = field.n_axes == 3
    most = math.isqrt(MAX_GAUGES) if crossing else MAX_GAUGES

    def line(x: Float[np.ndarray, " point"]) -> Float[np.ndarray, " gauge"]:
        count = min(most, math.ceil(float(np.ptp(x)) / shortest * GAUGES_PER_WAVE) + 1)
        return np.linspace(float(x.min()), float(x.max()), count)

    along, across = line(place[:, 0]), line(place[:, 1]) if crossing else np.zeros(1)
    x, y = np.meshgrid(along, across)
    gauges = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    low, high = np.inf, -np.inf
    for part, places in _pieces(field, gauges):
        first, second = part.elevation(places)
        total = np.add(first, second, out=first)
        low, high = min(low, float(total.min())), max(high, float(total.max()))
    return low, high


def _pieces(
    field: Field, gauges: Float[np.ndarray, "gauge 3"]
) -> Iterator[tuple[Field, Float[np.ndarray, "gauge 3"]]]:
    """Windows of a long record, or some gauges at a time of a short one or where a field has no windows."""
    step = max(1, GAUGE_SAMPLES // len(gauges))
    if isinstance(field, Windowed) and field.n > EXACT:
        for rows in slices(field.n, step):
            yield window_of(field, rows.start, rows.stop - rows.start), gauges
    else:
        for rows in slices(len(gauges), max(1, GAUGE_SAMPLES // field.n)):
            yield field, gauges[rows]


def prepare_loads(
    case: CaseConfig, mesh: Mesh, sea: SeaState, field: Field, *, hydro: HydroMesh | None = None
) -> LoadWindows:
    """Prepare the loads of the sea on the members of `mesh`, and look at the surface of the whole record.

    Parameters
    ----------
    case, mesh, sea, field
        What is loaded, and the waves.
    hydro : HydroMesh, optional
        Stations to use instead of those that the surface of the record asks for.

    Raises
    ------
    InputError
        If the water depth is not that of the structure, or the surface reaches the interface or the sea bed.
    ComputationError
        If the second order is not accurate.
    """
    mesh.structure.check_water_depth(case.water_depth_m)
    frame = Frame(sea.direction_deg)
    highest_wavenumber = float(sea.wavenumber_rad_m[sea.amplitude_m > 0.0].max(initial=1e-3))
    jacket = np.setdiff1d(np.arange(mesh.n_nodes), mesh.tower_node)
    low, high = surface_range(
        field, frame.place(mesh.node_position[jacket]), 2.0 * np.pi / (sea.order * highest_wavenumber)
    )
    check_bed(case, low)
    limit = interface_level(mesh)
    if high > limit:
        raise InputError(
            sea_field(case),
            sea_height(case),
            f"raises the surface to z = {high:.2f} m at the jacket, above its lowest interface joint at "
            f"z = {limit:g} m",
            "Use lower waves: nothing above the interface can carry wave load.",
        )
    highest = min(SAFETY * max(high, 0.0) + MARGIN, limit)
    check_extrapolation(sea.stretching, sea.wavenumber_rad_m, highest + case.morison.discretisation_m)
    lowest = SAFETY * min(low, 0.0) - MARGIN
    hydro = case_hydro_mesh(case, mesh, lowest=lowest) if hydro is None else hydro
    return LoadWindows(
        case=case,
        hydro=hydro,
        frame=frame,
        field=field,
        lowest=lowest,
        highest=highest,
        length=window_length(case, hydro),
    )
