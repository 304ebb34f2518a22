"""The wave stage of an elevation that is measured while the graph runs.

The samples of one gauge go on the time grid as they come. Windows of that record, tapered at both ends, are
decomposed into first-order components (:mod:`~owt_wave_node.core.measured`); of the loads of a window only
its middle is used, `lag` and more away from its end, and one window fades into the next with weights that
sum to one, so that loads are continuous. Windows lie on the grid, not on what has arrived: the same record
gives the same loads, bit for bit. The record begins at t = 0, so that over the first `lag` the waves rise
from still water; it goes on for `lag` after the last sample of the case.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig, SeaStateConfig, Time
from owt_model.contracts import ElevationBlock, LoadBasis, LoadBlock, MeasuredBlock
from owt_model.errors import ComputationError, InputError
from owt_model.live_samples import LiveRules, SampleBuffer
from owt_model.mesh import Mesh
from owt_model.timing import sample_time_ns
from owt_wave_node.core.assembly import LoadHistory
from owt_wave_node.core.hydro_mesh import case_hydro_mesh
from owt_wave_node.core.loads import prepare_loads
from owt_wave_node.core.measured import Band, Gauge, Series, Spectrum
from owt_wave_node.core.route import EXACT, component_field
from owt_wave_node.core.sea import Frame, Waves, build_sea_state
from owt_wave_node.core.stage import WaveStage, build_wave_stage, cut_elevation, cut_loads
from owt_wave_node.core.tiling import Tiling
from owt_wave_node.core.window import window_of

__all__ = ["LiveStage", "case_stage", "live_stage_from_record"]

#: Difference in m of a gauge from its place that is rounding.
SAME_PLACE = 1e-3
#: Standard deviation in m of a window below which it is still water.
STILL = 1e-9
#: Cycles per lag by which the tapers spread a component: so much is the band wider than that of the sea.
WIDER = 0.5
#: Change of a component, over the largest one, that ends the search for the first order.
TOLERANCE = 1e-3
#: Lowest frequency over the peak's of the first order, where the whole band has none that gives the record.
SHORTER = (0.3, 0.6)
#: Highest frequency of the band times the time step.
NYQUIST = 0.49
#: Factor on the lowest surface of the expected sea down to which live waves may fall, with Gauss points.
ROOM = 2.0


@dataclass(frozen=True)
class _Part:
    """What one window gives over the samples that it is used for."""

    rows: range
    loads: LoadHistory
    first: Float[np.ndarray, "gauge sample"]
    total: Float[np.ndarray, "gauge sample"]


class LiveStage:
    """Waves measured at one gauge and what they do to the structure; the interface of the wave stage.

    Parameters
    ----------
    case : CaseConfig
        With `live` set.
    mesh : Mesh
        Its structure.

    Raises
    ------
    InputError
        If the expected sea is refused.
    """

    def __init__(self, case: CaseConfig, mesh: Mesh) -> None:
        assert case.live is not None
        assert case.sea_state is not None
        live, sea = case.live, case.sea_state
        self._case, self._mesh = case, mesh
        self.tiling = Tiling(case.time.n, *live.samples(case.time.dt_s))
        self.sea_state = replace(build_sea_state(case), source="live")
        self.block, self.model_hash = case.stream.block, mesh.structure.content_hash
        self._gauges = np.array(case.gauges_m, dtype=float)
        self._place = np.array(live.place_m, dtype=float)
        # The expected sea alone, no longer than a basis needs.
        shorter = Time(dt_s=case.time.dt_s, n=min(case.time.n, EXACT))
        self.expected = WaveStage(case.model_copy(update={"live": None, "time": shorter}), mesh)
        direction = sea.direction_deg if live.direction_deg is None else live.direction_deg
        self._frame = Frame(direction)
        self._gauge = self._gauge_of(self._band(sea))
        self._heading = replace(
            self.sea_state,
            omega_rad_s=self._gauge.omega,
            wavenumber_rad_m=self._gauge.k,
            amplitude_m=np.ones(self._gauge.k.size),
            phase_rad=np.zeros(self._gauge.k.size),
            component_direction_deg=np.full(self._gauge.k.size, direction),
            direction_deg=direction,
        )
        self._lowest = ROOM * self.expected.windows.lowest
        self._hydro = case_hydro_mesh(case, mesh, lowest=self._lowest)
        self.samples = SampleBuffer(
            "measured elevation",
            1,
            LiveRules.of(missing=live.missing, max_gap_s=live.max_gap_s, reorder_s=live.reorder_s),
        )
        self._record = np.zeros(self.tiling.record)
        self.known = 0
        self._parts: dict[int, _Part] = {}
        self._shortened: list[int] = []

    def _band(self, sea: SeaStateConfig) -> Band:
        """What is first order: the band of the expected sea, as wide as the tapers spread it."""
        wider = WIDER / (self.tiling.lag * self._case.time.dt_s) if self.tiling.lag else 0.0
        lowest = sea.cutin_over_peak * sea.peaks_hz()[0] - wider
        highest = min(sea.cutoff_hz(self._case.gravity_m_s2) + wider, NYQUIST / self._case.time.dt_s)
        return Band(2.0 * np.pi * max(lowest, 0.0), 2.0 * np.pi * highest, TOLERANCE)

    def _gauge_of(self, band: Band) -> Gauge:
        case = self._case
        return Gauge(
            self.tiling.window,
            dt=case.time.dt_s,
            depth=case.water_depth_m,
            gravity=case.gravity_m_s2,
            band=band,
            order=case.wave.order,
        )

    # --- the record -------------------------------------------------------------------------------

    @property
    def n_records(self) -> int:
        """Number of blocks of the record."""
        return -(-self.tiling.record // self.block)

    def add(self, time_ns: int, elevation: float, place: Float[np.ndarray, " 2"] | None = None) -> None:
        """Take a sample, in any order.

        Parameters
        ----------
        time_ns : int
            Stamp in simulated time, in ns.
        elevation : float
            m.
        place : float array [2], optional
            Where it was measured, x and y in m.

        Raises
        ------
        ComputationError
            Where a missing sample is an error: if it is not finite, comes from elsewhere or too late.
        """
        away = 0.0 if place is None else float(np.hypot(*(place - self._place)))
        refusal = "" if away <= SAME_PLACE else f"was measured {away:.4g} m from live.place_m"
        self.samples.add(time_ns, np.array([elevation]), refusal=refusal)

    def _record_rows(self, j: int) -> range:
        return range(j * self.block, min((j + 1) * self.block, self.tiling.record))

    def record_time_ns(self, j: int) -> int:
        """Simulated time in ns of the last sample of block `j` of the record."""
        return sample_time_ns(self._record_rows(j)[-1], self.sea_state.dt_s)

    def reach_record(self, j: int) -> bool:
        """Tell whether all samples of block `j` of the record are known, or known to be missing."""
        return self.samples.reach(self.record_time_ns(j))

    def record_block(self, j: int, *, forced: bool = False) -> MeasuredBlock:
        """Put block `j` of the record, the next one, on the grid.

        Parameters
        ----------
        j : int
            Its number.
        forced : bool
            Go on although it is not reached; what has not come is missing.

        Raises
        ------
        ComputationError
            If a sample is missing and that is an error, or the block is not the next one or not reached.
        """
        rows, dt = self._record_rows(j), self.sea_state.dt_s
        if rows.start != self.known:
            raise ComputationError(f"measured elevation: block {j} is not the next one")
        times = np.array([sample_time_ns(i, dt) for i in rows], dtype=np.int64)
        found, filled = self.samples.take(times, forced=forced)
        self.extend(found[:, 0])
        return MeasuredBlock(
            j, rows.start, dt, j == self.n_records - 1, elevation=found[:, 0].copy(), filled=filled
        )

    def extend(self, elevation: Series) -> None:
        """Append samples in m that are on the grid already."""
        stop = self.known + elevation.size
        self._record[self.known : stop] = elevation
        self.known = stop

    # --- the stage --------------------------------------------------------------------------------

    @property
    def n_blocks(self) -> int:
        """Number of blocks of loads; all are of `block` samples but the last."""
        return -(-self.sea_state.n // self.block)

    def time_ns(self, i: int) -> int:
        """Simulated time in ns of the first sample of block `i`."""
        return sample_time_ns(i * self.block, self.sea_state.dt_s)

    def _rows(self, i: int) -> range:
        """Samples of block `i` of the loads."""
        if not 0 <= i < self.n_blocks:
            raise IndexError(f"block {i} of {self.n_blocks}")
        return range(i * self.block, min((i + 1) * self.block, self.tiling.n))

    def reach(self, i: int) -> bool:
        """Tell whether the record is as long as block `i` of the loads needs."""
        return self.known >= self.tiling.end(self.tiling.windows(self._rows(i))[-1])

    def load_basis(self, n_vectors: int) -> LoadBasis:
        """Return the `n_vectors` most energetic spatial vectors of the loads of the expected sea."""
        return self.expected.load_basis(n_vectors)

    def elevation_block(self, i: int) -> ElevationBlock:
        """Elevation at the gauges of the case in block `i`; blocks are asked for in order."""
        rows = self._rows(i)
        first, total = (self._faded(rows, name) for name in ("first", "total"))
        return cut_elevation(first, total, slice(0, len(rows)), gauge=self._gauges, **self._head(i))

    def load_block(self, i: int) -> LoadBlock:
        """Nodal loads and fixed-end forces in block `i`; blocks are asked for in order.

        Raises
        ------
        ComputationError
            If the record does not reach that far, its waves cannot be decomposed or reach the interface.
        """
        rows = self._rows(i)
        nodal, ends = (self._faded(rows, name) for name in ("nodal", "end_rows"))
        loads = next(iter(self._parts.values())).loads
        history = replace(loads, nodal=nodal, end_rows=ends)
        return cut_loads(history, slice(0, len(rows)), model_hash=self.model_hash, **self._head(i))

    def _head(self, i: int) -> dict[str, Any]:
        return {
            "sequence": i,
            "start": i * self.block,
            "dt": self.sea_state.dt_s,
            "last": i == self.n_blocks - 1,
        }

    def _faded(self, rows: range, name: str) -> Float[np.ndarray, "*channel sample"]:
        """Sum of what the windows give for some samples, weighted."""
        windows, out = self.tiling.windows(rows), None
        self._parts = {k: part for k, part in self._parts.items() if k >= windows[0]}
        for k in windows:
            if k not in self._parts:
                self._parts[k] = self._window(k)
            part = self._parts[k]
            values = getattr(part.loads if name in ("nodal", "end_rows") else part, name)
            here = range(max(rows.start, part.rows.start), min(rows.stop, part.rows.stop))
            if out is None:
                out = np.zeros((*values.shape[:-1], len(rows)))
            piece = values[..., here.start - part.rows.start : here.stop - part.rows.start]
            out[..., here.start - rows.start : here.stop - rows.start] += self.tiling.weight(k, here) * piece
        assert out is not None
        return out

    # --- one window -------------------------------------------------------------------------------

    def _window(self, k: int) -> _Part:
        """Decompose a window and compute its loads over the samples that it is used for."""
        tiling, rows, end = self.tiling, self.tiling.used(k), self.tiling.end(k)
        begin = end - tiling.window
        if end > self.known:
            raise ComputationError(f"measured elevation: sample {end - 1} asked for, known are {self.known}")
        where = f"measured elevation, {max(begin, 0) * self.sea_state.dt_s:g} to "
        where += f"{(end - 1) * self.sea_state.dt_s:g} s"
        try:
            field = component_field(self._decomposed(k, begin, end), self._case.wave.route)
            part = window_of(field, rows.start - begin, len(rows))
            windows = prepare_loads(self._case, self._mesh, self._heading, part, hydro=self._hydro)
            if windows.lowest < self._lowest and self._case.morison.points == "gauss":
                raise ComputationError(
                    f"the surface falls below z = {self._lowest:.2f} m, {ROOM:g} times that of the expected "
                    "sea: raise sea_state.hs_m or set morison.points to stations"
                )
            loads = replace(windows, length=part.n).window(0)
        except InputError as error:
            raise ComputationError(f"{where}: {error.limit}. {error.remedy}") from None
        except ComputationError as error:
            raise ComputationError(f"{where}: {error}") from None
        first, second = part.elevation(self._frame.place(self._gauges))
        return _Part(rows, loads, first, first + second)

    def _decomposed(self, k: int, begin: int, end: int) -> Waves:
        """Components of a window; their time begins with it."""
        taper = self.tiling.taper(k)
        inside = slice(max(-begin, 0), self.tiling.window)
        series = np.zeros(self.tiling.window)
        series[inside] = self._record[max(begin, 0) : end]
        series -= float(taper @ series) / float(taper.sum())  # the datum of a gauge is not known
        series *= taper
        gauge, A = self._gauge, np.zeros(self._gauge.omega.size, dtype=complex)
        if float(series.std()) > STILL:
            gauge, A = self._solved(series, k)
        A = gauge.at_origin(A, float(self._frame.place(self._place[None])[0, 0]))
        return gauge.waves(A, stretching=self._case.wave.stretching)

    def _solved(self, series: Series, k: int) -> tuple[Gauge, Spectrum]:
        """Amplitudes at the gauge, and the gauge in whose band they were found.

        A record with gaps holds long waves that never were, and whose second order exceeds them: the search
        is then repeated without the longest waves.
        """
        peak = 2.0 * np.pi * self._case.sea_state.peaks_hz()[0]  # type: ignore[union-attr]
        gauge = self._gauge
        for lowest in SHORTER:
            try:
                return gauge, gauge.solve(series)[0]
            except ComputationError:
                gauge = self._gauge_of(replace(gauge.band, cutin=lowest * peak))
            if self._shortened[-1:] != [k]:
                self._shortened.append(k)
        return gauge, gauge.solve(series)[0]

    def take_note(self) -> str:
        """What was changed in the method for the windows since the last call, empty if nothing was."""
        if not self._shortened:
            return ""
        dt, spans = self.sea_state.dt_s, [self.tiling.used(k) for k in self._shortened]
        self._shortened = []
        return (
            f"no first order of the measured elevation found for loads from {spans[0].start * dt:g} to "
            f"{(spans[-1].stop - 1) * dt:g} s with the longest waves: they were left out, up to "
            f"{SHORTER[0]:g} of the peak frequency, or {SHORTER[1]:g} where that did not do"
        )


def case_stage(case: CaseConfig, mesh: Mesh) -> LiveStage | WaveStage:
    """The wave stage of a case: of a measured elevation where there is one, else of its own sea.

    Raises
    ------
    InputError, ComputationError
        See :func:`~owt_wave_node.core.stage.build_wave_stage`.
    """
    return build_wave_stage(case, mesh) if case.live is None else LiveStage(case, mesh)


def live_stage_from_record(case: CaseConfig, mesh: Mesh, elevation: Series) -> LiveStage:
    """The stage of a record that is known: the same loads, bit for bit, as while it was measured.

    Parameters
    ----------
    case : CaseConfig
        With `live` set.
    mesh : Mesh
        Its structure.
    elevation : float array [time]
        The whole of ``/owt/measured_elevation_used`` in m, filled samples included.

    Raises
    ------
    InputError
        If the record is not as long as the case needs, or not finite.
    """
    stage = LiveStage(case, mesh)
    needed = stage.tiling.record
    if elevation.shape != (needed,) or not np.isfinite(elevation).all():
        raise InputError(
            "live",
            f"{elevation.shape[0]} samples",
            f"needs a record of {needed} finite samples: those of the case and live.lag_s more",
            "Give the whole of /owt/measured_elevation_used.",
        )
    stage.extend(elevation)
    return stage
