"""Loads of a stream: where they act, and whether they can be integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_model.contracts import LoadBlock, LoadRows
from owt_model.errors import ComputationError
from owt_structure_node.core.recovery import EndSections, fixed_end_columns
from owt_structure_node.core.sim import ImprovementMap, StaticImprovement

__all__ = ["LoadMap", "check_values", "map_loads", "ramp", "ramp_factor"]


@dataclass(frozen=True)
class LoadMap:
    """Where the loads of a stream act: fixed by its first block.

    Attributes
    ----------
    projection : float array [loaded*6, function]
        From nodal loads to generalised loads on the basis functions that any of them moves.
    to_modes : float array [function, mode], or None
        From those to modal loads.
    columns : int array [end, 2]
        From fixed-end forces to member ends.
    improvement : ImprovementMap, optional
        From nodal loads to the static response of what the basis leaves out.
    """

    node: Int[np.ndarray, " loaded"]
    element: Int[np.ndarray, " fixed"]
    projection: Float[np.ndarray, "load moved"]
    to_modes: Float[np.ndarray, "moved mode"] | None
    columns: Int[np.ndarray, "end 2"]
    improvement: ImprovementMap | None = None


def map_loads(
    load: LoadBlock | LoadRows,
    *,
    node_basis: Float[np.ndarray, "node 6 function"],
    amplitude: Float[np.ndarray, "mode function"] | None,
    ends: EndSections,
    n_elements: int,
    improvement: StaticImprovement | None,
) -> LoadMap:
    """Map the loads of a stream, by its first block, to modes and member ends.

    Parameters
    ----------
    load : LoadBlock or LoadRows
        Its first block.
    node_basis : float array [node, 6, function]
        Basis functions at all nodes.
    amplitude : float array [mode, function], or None
        Amplitudes of the basis functions in each mode; None where the functions are the modes.
    ends : EndSections
        Member ends.
    n_elements : int
        Number of elements of the mesh.
    improvement : StaticImprovement, optional
        Static response of what the basis leaves out.

    Raises
    ------
    ComputationError
        If it loads nodes or elements that the mesh does not have, or one of them twice.
    """
    n_nodes, _, n_functions = node_basis.shape
    for name, index, size in (("node", load.node, n_nodes), ("element", load.element, n_elements)):
        if len(index) and not (index.min() >= 0 and index.max() < size):
            raise ComputationError(
                f"nodal loads: {name} {int(index.min())} to {int(index.max())}, the mesh has 0 to {size - 1}"
            )
        if len(np.unique(index)) != len(index):
            raise ComputationError(f"nodal loads: the list of {name}s names one of them twice")
    projection = node_basis[load.node].reshape(-1, n_functions)
    moved = np.flatnonzero(projection.any(axis=0))
    return LoadMap(
        node=load.node.copy(),
        element=load.element.copy(),
        projection=np.ascontiguousarray(projection[:, moved]),
        to_modes=None if amplitude is None else np.ascontiguousarray(amplitude[:, moved].T),
        columns=fixed_end_columns(ends, load.element),
        improvement=None if improvement is None else improvement.map(load.node),
    )


def check_values(load: LoadBlock) -> None:
    """Refuse a block of which samples are missing or no numbers.

    Raises
    ------
    ComputationError
        Naming the block and the sample.
    """
    where = f"nodal loads, block {load.sequence}"
    if not len(load.nodal) or len(load.fixed_end) != len(load.nodal):
        raise ComputationError(
            f"{where}: {len(load.nodal)} samples of nodal loads, {len(load.fixed_end)} of fixed-end forces"
        )
    for name, data in (("nodal load", load.nodal), ("fixed-end force", load.fixed_end)):
        if not np.isfinite(data).all():
            sample = int(np.argwhere(~np.isfinite(data).reshape(len(data), -1).all(axis=1))[0, 0])
            raise ComputationError(f"{where}: {name} of sample {load.start + sample} is NaN or inf")


def ramp(load: LoadBlock, duration: float) -> Float[np.ndarray, " sample"] | None:
    """Factor on the loads of a block, from 0 to 1 in `duration` s as half a cosine; None after it."""
    return ramp_factor(load.start, len(load.nodal), load.dt, duration)


def ramp_factor(start: int, samples: int, dt: float, duration: float) -> Float[np.ndarray, " sample"] | None:
    """The same for `samples` samples of the time step `dt` from the one of index `start` on."""
    time = dt * np.arange(start, start + samples)
    if not time[0] < duration:
        return None
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(time / duration, 1.0)))
