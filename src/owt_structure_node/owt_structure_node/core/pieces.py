"""The structure stage in one process: long pieces of the record, one row per channel and time last.

The numbers of :mod:`~owt_structure_node.core.stage` to round-off, without blocks to send: only what strains a
member is recovered, stress is worked out for a few member ends at a time while it is in cache, and energies
are those of the whole and of the substructures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_model.contracts import END_FORCE, LoadRows
from owt_model.errors import ComputationError
from owt_structure_node.core.load_map import LoadMap, map_loads, ramp_factor
from owt_structure_node.core.motion import Motion, MotionState, integrate_from, static_state
from owt_structure_node.core.recovery import EndSections
from owt_structure_node.core.response_model import ResponseModel
from owt_structure_node.kernels.energy import modal_energies
from owt_structure_node.kernels.stress import end_stress_rows

__all__ = ["Piece", "PieceState", "Pieces"]

#: Member ends whose forces are held at a time.
TILE = 8


@dataclass(frozen=True)
class PieceState:
    """What one piece leaves for the next: motion, carried loads of member ends, and nodal loads."""

    motion: MotionState
    carried: Float[np.ndarray, " component"]
    nodal: Float[np.ndarray, " load"]


@dataclass(frozen=True)
class Piece:
    """Results of one piece at the integration step.

    Attributes
    ----------
    start : int
        Index of the first row in the response, whose time is ``start * structure.dt_s``.
    motion : Motion
        Of the modes [row, mode].
    stress : float array [4 end, row]
        Axial, bending_y, bending_z and von Mises stress in Pa, each of all ends, as in
        :class:`owt_model.contracts.StressBlock`.
    potential, kinetic : float arrays [row]
        Energies in J.
    potential_substructure, kinetic_substructure : float arrays [row, part]
        Energies in J of jacket and tower.
    """

    start: int
    motion: Motion
    stress: Float[np.ndarray, "channel row"]
    potential: Float[np.ndarray, " row"]
    kinetic: Float[np.ndarray, " row"]
    potential_substructure: Float[np.ndarray, "row part"]
    kinetic_substructure: Float[np.ndarray, "row part"]

    @property
    def von_mises(self) -> Float[np.ndarray, "end row"]:
        """Von Mises stress in Pa of all ends."""
        return self.stress[3 * (len(self.stress) // 4) :]


class Pieces:
    """Steps through the loads of one record.

    Parameters
    ----------
    model : ResponseModel
        The structure.
    first : LoadRows
        The first piece, which says where loads act.

    Raises
    ------
    ComputationError
        If it loads what the mesh does not have.
    """

    def __init__(self, model: ResponseModel, first: LoadRows) -> None:
        self.model = model
        self.loads: LoadMap = map_loads(
            first,
            node_basis=model.node_basis,
            amplitude=model.amplitude,
            ends=model.ends,
            n_elements=model.n_elements,
            improvement=model.improvement,
        )
        n_strained, _, self.n_ends = model.end_force.shape
        # Forces end by end, so that those of a few ends are one product.
        self._end_force = np.ascontiguousarray(model.end_force.transpose(2, 1, 0)).reshape(-1, n_strained)
        self._end_row = _end_row(self.loads, first.end_rows.shape[1])
        amplitude, coordinate = model.amplitude, model.coordinate
        own = model.part.coordinate
        self._strain = None if amplitude is None else np.ascontiguousarray(amplitude[:, model.strained])
        self._own = np.ascontiguousarray(coordinate[:, own])
        # The part's own coordinates are those that strain members in most reductions.
        self._shared = (
            amplitude is not None and coordinate is amplitude and np.array_equal(own, model.strained)
        )

    def step(
        self,
        state: PieceState | None,
        load: LoadRows,
        wrench: Float[np.ndarray, "sample 6"] | None = None,
    ) -> tuple[PieceState, Piece]:
        """Integrate over one piece of loads and recover the stresses.

        Parameters
        ----------
        state : PieceState, optional
            From the piece before; None for the first one, which begins at rest under its first sample.
        load : LoadRows
            The next piece.
        wrench : float array [sample, 6], optional
            Load at the tower top at the same times.

        Raises
        ------
        ComputationError
            If the response is not finite.
        """
        model = self.model
        nodal, carried, modal_load = self._loads(load, wrench)
        improvement = self.loads.improvement
        if improvement is not None:  # the member ends come in the order of its components
            carried -= improvement.end_force.T @ nodal
        if state is None:
            before, rest = static_state(model.oscillators, modal_load[0]), modal_load[1:]
        else:
            before, rest = state.motion, modal_load
            carried = np.concatenate([state.carried[:, None], carried], axis=1)
        lead = int(state is None)
        after, full = integrate_from(model.oscillators, before, rest)
        shown = slice(1 - lead, None)
        motion = Motion(full.displacement[shown], full.velocity[shown], full.acceleration[shown])
        substeps = model.oscillators.substeps
        extra: Float[np.ndarray, " row"] | float = 0.0
        if improvement is not None:
            improved = nodal if state is None else np.concatenate([state.nodal[:, None], nodal], axis=1)
            extra = improvement.energy(np.ascontiguousarray(improved.T), substeps)[shown]
        strain = (
            motion.displacement[:, model.strained]
            if self._strain is None
            else motion.displacement @ self._strain
        )
        stress = self._stress(strain, carried, lead)
        start = 0 if lead else substeps * (load.start - 1) + 1
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused below
            piece = Piece(start, motion, stress, *self._energies(motion, strain, extra))
            finite = np.isfinite(piece.potential.sum()) and np.isfinite(piece.von_mises.sum())
        if not finite:
            raise ComputationError(
                f"response: not finite after {load.start * load.dt:g} s; the loads are too large to integrate"
            )
        return PieceState(after, carried[:, -1].copy(), nodal[:, -1].copy()), piece

    def _loads(
        self, load: LoadRows, wrench: Float[np.ndarray, "sample 6"] | None
    ) -> tuple[
        Float[np.ndarray, "load sample"],
        Float[np.ndarray, "component sample"],
        Float[np.ndarray, "sample mode"],
    ]:
        """Nodal loads, what member ends carry, and modal loads of a piece, wrench and ramp included."""
        model, loads = self.model, self.loads
        samples = load.nodal.shape[2]
        nodal = load.nodal.reshape(-1, samples)
        modal_load = nodal.T @ loads.projection
        if loads.to_modes is not None:
            modal_load = modal_load @ loads.to_modes
        if wrench is not None:
            modal_load = modal_load + wrench @ model.tower_top
        carried = np.zeros((6 * self.n_ends, samples))
        at, row = self._end_row
        carried[at] = load.end_rows.reshape(-1, samples)[row]
        factor = ramp_factor(load.start, samples, load.dt, model.ramp_s)
        if factor is None:
            return nodal, carried, modal_load
        return factor * nodal, factor * carried, factor[:, None] * modal_load

    def _stress(
        self,
        strain: Float[np.ndarray, "row strained"],
        carried: Float[np.ndarray, "component sample"],
        lead: int,
    ) -> Float[np.ndarray, "channel row"]:
        """Stress of all ends, a tile of them at a time."""
        ends: EndSections = self.model.ends
        n, rows = self.n_ends, len(strain)
        out, amplitude = np.empty((4, n, rows)), strain.T
        force, work = np.empty((6 * TILE, rows)), np.empty((6, rows))
        for first in range(0, n, TILE):
            stop = min(first + TILE, n)
            of = slice(6 * first, 6 * stop)
            here = np.matmul(self._end_force[of], amplitude, out=force[: 6 * (stop - first)])
            end_stress_rows(
                here, carried[of], lead, self.model.oscillators.substeps,
                ends.sign[first:stop], np.ascontiguousarray(ends.factor[:, first:stop]), work,
                *(out[i, first:stop] for i in range(4)),
            )  # fmt: skip
        return out.reshape(4 * n, rows)

    def _energies(
        self,
        motion: Motion,
        strain: Float[np.ndarray, "row strained"],
        extra: Float[np.ndarray, " row"] | float,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Potential and kinetic energy, and those of the substructures; `extra` is potential."""
        part = self.model.part
        potential, kinetic = np.empty(len(strain)), np.empty(len(strain))
        modal_energies(
            motion.displacement, motion.velocity, self.model.oscillators.stiffness, potential, kinetic
        )
        potential += extra
        own = strain if self._shared else motion.displacement @ self._own
        return (
            potential,
            kinetic,
            part.share_of(part.stiffness, own, potential, extra),
            part.share_of(part.mass, motion.velocity @ self._own, kinetic),
        )


def _end_row(loads: LoadMap, n_rows: int) -> tuple[Int[np.ndarray, " carried"], Int[np.ndarray, " carried"]]:
    """Components of member ends (six per end) that carry loads, and the rows of what they carry."""
    at, rows = [], []
    for end, (source, first) in enumerate(loads.columns.tolist()):
        for row, component in enumerate(END_FORCE[:n_rows]):
            if source >= 0 and first <= component < first + 6:
                at.append(6 * end + component - first)
                rows.append(n_rows * source + row)
    return np.array(at, dtype=np.int64), np.array(rows, dtype=np.int64)
