"""The wave stage: the sea, its elevation and its loads, cut into blocks of samples.

Loads and elevation are computed window by window and one window is held: memory does not grow with the
record. Blocks in order cost each window once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.contracts import END_FORCE, ElevationBlock, LoadBasis, LoadBlock, LoadRows
from owt_model.mesh import Mesh
from owt_model.parallel import slices
from owt_model.pod import Scatter, load_basis
from owt_model.timing import sample_time_ns
from owt_wave_node.core.assembly import LoadHistory
from owt_wave_node.core.hydro_damping import drag_damping
from owt_wave_node.core.hydro_mesh import HydroMesh
from owt_wave_node.core.loads import LoadWindows, prepare_loads
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import build_sea_state
from owt_wave_node.core.window import window_of

__all__ = ["WaveStage", "build_wave_stage", "cut_elevation", "cut_loads"]

Series = Float[np.ndarray, "gauge time"]


class WaveStage:
    """The waves of a case and what they do to its structure.

    Parameters
    ----------
    case, mesh
        The case and its structure.
    hydro : HydroMesh, optional
        Stations of the structure in its water, where they are known.
    """

    def __init__(self, case: CaseConfig, mesh: Mesh, *, hydro: HydroMesh | None = None) -> None:
        self.sea_state = build_sea_state(case)
        self.block = case.stream.block
        self.model_hash = mesh.structure.content_hash
        self.gauge = np.array(case.gauges_m, dtype=float)
        self.windows: LoadWindows = prepare_loads(
            case, mesh, self.sea_state, make_field(case, self.sea_state), hydro=hydro
        )
        self._loads: tuple[int, LoadHistory] | None = None
        self._elevation: tuple[int, Series, Series] | None = None

    @property
    def n_blocks(self) -> int:
        """Number of blocks; all are of `block` samples but the last."""
        return -(-self.sea_state.n // self.block)

    @property
    def error_estimate(self) -> float:
        """Error of the second order relative to its standard deviation; zero where all pairs are summed."""
        return self.windows.error_estimate

    def history(self, window: int = 0) -> LoadHistory:
        """Loads in a window of the record, the one that is held from now on."""
        if self._loads is None or self._loads[0] != window:
            self._loads = None  # before the next one is there
            self._loads = (window, self.windows.window(window))
        return self._loads[1]

    def load_rows(self, window: int, piece: int) -> Iterator[LoadRows]:
        """Loads of a window, `piece` samples at a time; nothing is copied.

        Raises
        ------
        ComputationError
            If a load is not finite.
        """
        rows, history = self.windows.rows(window), self.history(window)
        for part in slices(rows.stop - rows.start, piece):
            yield LoadRows(
                start=rows.start + part.start,
                dt=self.sea_state.dt_s,
                node=history.node,
                element=history.element,
                nodal=history.nodal[:, :, part],
                end_rows=history.end_rows[:, :, part],
            )

    def surface(self, window: int) -> tuple[Series, Series]:
        """First-order and total elevation at the gauges in a window."""
        if self._elevation is None or self._elevation[0] != window:
            rows, field = self.windows.rows(window), self.windows.field
            part = window_of(field, rows.start, rows.stop - rows.start)
            first, second = part.elevation(self.windows.frame.place(self.gauge))
            self._elevation = (window, first, first + second)
        return self._elevation[1:]

    def _rows(self, i: int) -> tuple[int, slice]:
        """Window of block `i`, and its samples there."""
        if not 0 <= i < self.n_blocks:
            raise IndexError(f"block {i} of {self.n_blocks}")
        rows = slice(i * self.block, min((i + 1) * self.block, self.sea_state.n))
        window, start = divmod(rows.start, self.windows.length)
        return window, slice(start, start + rows.stop - rows.start)

    def time_ns(self, i: int) -> int:
        """Simulated time in ns of the first sample of block `i`."""
        return sample_time_ns(i * self.block, self.sea_state.dt_s)

    def elevation_block(self, i: int) -> ElevationBlock:
        """Elevation at the gauges in block `i`."""
        window, part = self._rows(i)
        first, total = self.surface(window)
        return cut_elevation(first, total, part, gauge=self.gauge, **self._head(i))

    def load_block(self, i: int) -> LoadBlock:
        """Nodal loads and fixed-end forces in block `i`.

        Raises
        ------
        ComputationError
            If a load is not finite.
        """
        window, part = self._rows(i)
        return cut_loads(self.history(window), part, model_hash=self.model_hash, **self._head(i))

    def _head(self, i: int) -> dict[str, Any]:
        last = i == self.n_blocks - 1
        return {"sequence": i, "start": i * self.block, "dt": self.sea_state.dt_s, "last": last}

    def load_basis(self, n_vectors: int) -> LoadBasis:
        """Return the `n_vectors` most energetic spatial vectors of the loads of the record.

        A record of several windows is computed once more for it.
        """
        node = self.windows.hydro.node
        if len(self.windows) == 1:
            nodal = self.history().nodal.transpose(2, 0, 1)
            return self._damped(load_basis(nodal, node, n_vectors, model_hash=self.model_hash))
        scatter = Scatter()
        for i in range(len(self.windows)):
            scatter.add(self.history(i).nodal.transpose(2, 0, 1))
        return self._damped(scatter.basis(node, n_vectors, model_hash=self.model_hash))

    def _damped(self, basis: LoadBasis) -> LoadBasis:
        """Add the damping by the drag on the structure's own motion where the case asks for it."""
        windows = self.windows
        if not windows.case.morison.hydrodynamic_damping:
            return basis
        total = np.zeros((len(basis.node), 3, 3))
        for i in range(len(windows)):
            rows = windows.rows(i)
            part = window_of(windows.field, rows.start, rows.stop - rows.start)
            total += part.n * drag_damping(
                windows.case, windows.hydro, windows.frame, part,
                lowest=windows.lowest, highest=windows.highest,
            )  # fmt: skip
        return replace(basis, damping=total / windows.field.n)


def cut_elevation(
    first: Series, total: Series, part: slice, *, gauge: Float[np.ndarray, "gauge 2"], **head: Any
) -> ElevationBlock:
    """Block of the samples `part` of elevations in m; `head` is what every block carries."""
    return ElevationBlock(
        **head,
        gauge=gauge,
        first_order=np.ascontiguousarray(first[:, part].T),
        total=np.ascontiguousarray(total[:, part].T),
    )


def cut_loads(history: LoadHistory, part: slice, *, model_hash: str, **head: Any) -> LoadBlock:
    """Block of the samples `part` of a history; `head` is what every block carries."""
    fixed = np.zeros((part.stop - part.start, history.element.size, 12))
    fixed[:, :, END_FORCE[: history.end_rows.shape[1]]] = -history.end_rows[:, :, part].transpose(2, 0, 1)
    return LoadBlock(
        **head,
        model_hash=model_hash,
        node=history.node,
        element=history.element,
        nodal=np.ascontiguousarray(history.nodal[:, :, part].transpose(2, 0, 1)),
        fixed_end=fixed,
    )


def build_wave_stage(case: CaseConfig, mesh: Mesh) -> WaveStage:
    """Do the work of the wave stage that all windows share, and the loads of the first one.

    Raises
    ------
    InputError
        If the sea, the water depth or the surface is not one that can be computed.
    ComputationError
        If a result is not finite.
    """
    stage = WaveStage(case, mesh)
    stage.history()
    return stage
