"""The wave stage: the sea, its elevation and its loads, cut into blocks of samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.contracts import ElevationBlock, LoadBasis, LoadBlock, SeaState
from owt_model.mesh import Mesh
from owt_model.pod import load_basis
from owt_wave_node.core.assembly import LoadHistory
from owt_wave_node.core.loads import load_history
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state

__all__ = ["WaveStage", "build_wave_stage"]

#: Where the eight bending rows of an element lie among its twelve end forces, with the sign of a
#: fixed-end force: minus the equivalent nodal load. Rows: Fy1, Mz1, Fy2, Mz2, Fz1, My1, Fz2, My2.
END_FORCE = (1, 5, 7, 11, 2, 4, 8, 10)


@dataclass(frozen=True)
class WaveStage:
    """The waves of a case and what they do to its structure, over the whole record."""

    sea_state: SeaState
    block: int
    model_hash: str
    gauge: Float[np.ndarray, "gauge 2"]
    first_order: Float[np.ndarray, "gauge time"]
    total: Float[np.ndarray, "gauge time"]
    history: LoadHistory

    @property
    def n_blocks(self) -> int:
        """Number of blocks; all are of `block` samples but the last."""
        return -(-self.sea_state.n // self.block)

    def _rows(self, i: int) -> slice:
        if not 0 <= i < self.n_blocks:
            raise IndexError(f"block {i} of {self.n_blocks}")
        return slice(i * self.block, min((i + 1) * self.block, self.sea_state.n))

    def elevation_block(self, i: int) -> ElevationBlock:
        """Elevation at the gauges in block `i`."""
        rows = self._rows(i)
        return ElevationBlock(
            sequence=i,
            start=rows.start,
            dt=self.sea_state.dt_s,
            last=i == self.n_blocks - 1,
            gauge=self.gauge,
            first_order=np.ascontiguousarray(self.first_order[:, rows].T),
            total=np.ascontiguousarray(self.total[:, rows].T),
        )

    def load_block(self, i: int) -> LoadBlock:
        """Nodal loads and fixed-end forces in block `i`."""
        rows = self._rows(i)
        history = self.history
        fixed = np.zeros((rows.stop - rows.start, history.element.size, 12))
        fixed[:, :, END_FORCE] = -history.end_rows[:, :, rows].transpose(2, 0, 1)
        return LoadBlock(
            sequence=i,
            start=rows.start,
            dt=self.sea_state.dt_s,
            last=i == self.n_blocks - 1,
            model_hash=self.model_hash,
            node=history.node,
            element=history.element,
            nodal=np.ascontiguousarray(history.nodal[:, :, rows].transpose(2, 0, 1)),
            fixed_end=fixed,
        )

    def load_basis(self, n_vectors: int) -> LoadBasis:
        """Return the `n_vectors` most energetic spatial vectors of the loads of the record."""
        return load_basis(
            self.history.nodal.transpose(2, 0, 1), self.history.node, n_vectors, model_hash=self.model_hash
        )


def build_wave_stage(case: CaseConfig, mesh: Mesh) -> WaveStage:
    """Do all the work of the wave stage for the record of `case`.

    Raises
    ------
    InputError
        If the sea, the water depth or the surface is not one that can be computed.
    ComputationError
        If a result is not finite.
    """
    sea = build_sea_state(case)
    field = make_field(case, sea)
    history = load_history(case, mesh, sea, field)
    gauge = np.array(case.gauges_m, dtype=float)
    first, second = field.elevation(Frame(sea.direction_deg).place(gauge))
    return WaveStage(
        sea_state=sea,
        block=case.stream.block,
        model_hash=mesh.structure.content_hash,
        gauge=gauge,
        first_order=first,
        total=first + second,
        history=history,
    )
