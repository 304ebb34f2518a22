"""The structure stage: blocks of loads in, blocks of response, stress and energy out.

The same functions serve the ROS node and the in-process run. The first block of L load samples gives
``substeps (L - 1) + 1`` rows, from t = 0 on; every later one ``substeps L``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from owt_model.contracts import EnergyBlock, LoadBlock, ModalBlock, StressBlock, WrenchBlock
from owt_model.errors import ComputationError
from owt_structure_node.core.load_map import LoadMap, check_values, map_loads, ramp
from owt_structure_node.core.motion import Motion, MotionState, integrate_from, static_state
from owt_structure_node.core.recovery import EndStress, end_samples, stresses
from owt_structure_node.core.response_model import ResponseModel, build_response_model, n_mta

__all__ = [
    "Response",
    "ResponseModel",
    "ResponseState",
    "build_response_model",
    "initial_state",
    "n_mta",
    "step",
]


@dataclass(frozen=True)
class ResponseState:
    """What one block leaves for the next."""

    sequence: int = 0
    start: int = 0
    finished: bool = False
    loads: LoadMap | None = None
    motion: MotionState | None = None
    fixed_end: Float[np.ndarray, "fixed 12"] | None = None
    improved: Float[np.ndarray, " load"] | None = None


@dataclass(frozen=True)
class Response:
    """The results of one block, at the integration step."""

    modal: ModalBlock
    stress: StressBlock
    energy: EnergyBlock


def initial_state(model: ResponseModel) -> ResponseState:
    """State before the first block; the structure is at rest under its first load sample."""
    return ResponseState()


def step(
    model: ResponseModel,
    state: ResponseState,
    load: LoadBlock,
    wrench: WrenchBlock | None = None,
) -> tuple[ResponseState, Response]:
    """Integrate over one block of loads and recover the stresses.

    Parameters
    ----------
    model : ResponseModel
        From :func:`build_response_model`.
    state : ResponseState
        From :func:`initial_state` or the block before.
    load : LoadBlock
        The next block of the stream.
    wrench : WrenchBlock, optional
        Load at the tower top at the same times.

    Raises
    ------
    ComputationError
        If the block does not continue the stream, belongs to another structure, or holds NaN or inf.
    """
    _check_block(model, state, load)
    loads = state.loads if state.loads is not None else _load_map(model, load)
    nodal, fixed_end, modal_load = _loads(model, loads, load, wrench)
    first = state.motion is None
    if state.motion is None:
        before, rest = static_state(model.oscillators, modal_load[0]), modal_load[1:]
        ends = fixed_end.copy()  # writable: one kernel signature, whatever the block came from
    else:
        assert state.fixed_end is not None
        before, rest = state.motion, modal_load
        ends = np.concatenate([state.fixed_end[None], fixed_end])
    # Row 0 is the instant before the block, part of the output for the first block only: interpolation of
    # the fixed-end forces needs it.
    after, motion = integrate_from(model.oscillators, before, rest)
    shown = slice(0 if first else 1, None)
    coordinate = motion.displacement if model.amplitude is None else motion.displacement @ model.amplitude
    fixed = end_samples(ends, loads.columns)
    substeps = model.oscillators.substeps
    extra_energy: Float[np.ndarray, " row"] | float = 0.0
    if loads.improvement is not None:
        improved = nodal if state.improved is None else np.concatenate([state.improved[None], nodal])
        fixed += end_samples(loads.improvement.forces(improved), loads.improvement.columns)
        extra_energy = loads.improvement.energy(improved, substeps)[shown]
    stress = stresses(_end_forces(model, coordinate), model.ends, fixed, substeps)
    head = {
        "sequence": load.sequence,
        "start": 0 if first else substeps * (load.start - 1) + 1,
        "dt": model.oscillators.step,
        "last": load.last,
    }
    motion = Motion(motion.displacement[shown], motion.velocity[shown], motion.acceleration[shown])
    modal = _modal_block(model, motion, coordinate[shown], head)
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused below
        energy = _energy_block(model, motion, modal, head, extra_energy)
    response = Response(modal, _stress_block(stress, shown, head), energy)
    if not (np.isfinite(response.energy.potential).all() and np.isfinite(response.stress.von_mises).all()):
        raise ComputationError(
            f"response: not finite in block {load.sequence}; the loads are too large to integrate"
        )
    return (
        replace(
            state,
            sequence=load.sequence + 1,
            start=load.start + len(load.nodal),
            finished=load.last,
            loads=loads,
            motion=after,
            fixed_end=fixed_end[-1].copy(),
            improved=None if loads.improvement is None else nodal[-1].copy(),
        ),
        response,
    )


def _load_map(model: ResponseModel, load: LoadBlock) -> LoadMap:
    return map_loads(
        load,
        node_basis=model.node_basis,
        amplitude=model.amplitude,
        ends=model.ends,
        n_elements=model.n_elements,
        improvement=model.improvement,
    )


def _loads(
    model: ResponseModel,
    loads: LoadMap,
    load: LoadBlock,
    wrench: WrenchBlock | None,
) -> tuple[
    Float[np.ndarray, "sample load"], Float[np.ndarray, "sample fixed 12"], Float[np.ndarray, "sample mode"]
]:
    """Nodal loads, fixed-end forces and modal loads of a block, wrench and ramp included."""
    nodal, fixed_end = load.nodal.reshape(len(load.nodal), -1), load.fixed_end
    modal_load = nodal @ loads.projection
    if loads.to_modes is not None:
        modal_load = modal_load @ loads.to_modes
    if wrench is not None:
        _check_wrench(load, wrench)
        modal_load = modal_load + wrench.wrench @ model.tower_top
    factor = ramp(load, model.ramp_s)
    if factor is None:
        return nodal, fixed_end, modal_load
    return factor[:, None] * nodal, factor[:, None, None] * fixed_end, factor[:, None] * modal_load


def _end_forces(
    model: ResponseModel, amplitude: Float[np.ndarray, "row function"]
) -> Float[np.ndarray, "row 6 end"]:
    n_strained, _, n_ends = model.end_force.shape
    force = np.ascontiguousarray(amplitude[:, model.strained]) @ model.end_force.reshape(n_strained, -1)
    return np.asarray(force).reshape(-1, 6, n_ends)


def _modal_block(
    model: ResponseModel,
    motion: Motion,
    amplitude: Float[np.ndarray, "row function"],
    head: dict[str, int | float | bool],
) -> ModalBlock:
    reported = model.coordinate is model.amplitude  # the basis functions are the coordinates
    return ModalBlock(
        **head,  # type: ignore[arg-type]
        displacement=amplitude if reported else motion.displacement @ model.coordinate,
        velocity=motion.velocity @ model.coordinate,
        acceleration=motion.acceleration @ model.coordinate,
    )


def _stress_block(stress: EndStress, shown: slice, head: dict[str, int | float | bool]) -> StressBlock:
    return StressBlock(
        **head,  # type: ignore[arg-type]
        axial=stress.axial[shown],
        bending_y=stress.bending_y[shown],
        bending_z=stress.bending_z[shown],
        von_mises=stress.von_mises[shown],
    )


def _energy_block(
    model: ResponseModel,
    motion: Motion,
    modal: ModalBlock,
    head: dict[str, int | float | bool],
    extra: Float[np.ndarray, " row"] | float,
) -> EnergyBlock:
    """Potential x' K x / 2 and kinetic v' M v / 2, which are sums over the modes; `extra` is potential."""
    potential = 0.5 * model.oscillators.stiffness * motion.displacement**2
    kinetic = 0.5 * motion.velocity**2
    total, moving, part = potential.sum(axis=1) + extra, kinetic.sum(axis=1), model.part
    n = len(model.description.frequency_hz)
    return EnergyBlock(
        **head,  # type: ignore[arg-type]
        potential=total,
        kinetic=moving,
        potential_mode=np.ascontiguousarray(potential[:, :n]),
        kinetic_mode=np.ascontiguousarray(kinetic[:, :n]),
        potential_substructure=part.share(part.stiffness, modal.displacement, total, extra),
        kinetic_substructure=part.share(part.mass, modal.velocity, moving),
    )


def _check_wrench(load: LoadBlock, wrench: WrenchBlock) -> None:
    where = f"tower-top load, block {wrench.sequence}"
    if (wrench.start, len(wrench.wrench), wrench.dt) != (load.start, len(load.nodal), load.dt):
        raise ComputationError(
            f"{where}: {len(wrench.wrench)} samples from {wrench.start} on do not go with "
            f"{len(load.nodal)} of the nodal loads from {load.start} on"
        )
    if not np.isfinite(wrench.wrench).all():
        raise ComputationError(f"{where}: holds NaN or inf")


def _check_block(model: ResponseModel, state: ResponseState, load: LoadBlock) -> None:
    """Refuse a block that is not the next one of this stream."""
    where = f"nodal loads, block {load.sequence}"
    if load.model_hash != model.description.model_hash:
        raise ComputationError(
            f"{where}: made for structure {load.model_hash[:12]}, this is "
            f"{model.description.model_name} {model.description.model_hash[:12]}"
        )
    if state.finished:
        raise ComputationError(f"{where}: comes after the block marked last ({state.sequence - 1})")
    if load.sequence != state.sequence or load.start != state.start:
        raise ComputationError(
            f"{where} from sample {load.start}: expected block {state.sequence} from sample {state.start}"
        )
    if abs(load.dt - model.load_step) > 1e-9 * model.load_step:
        raise ComputationError(f"{where}: time step {load.dt} s, the case has {model.load_step} s")
    check_values(load)
    known = state.loads
    if known is not None and not (
        np.array_equal(known.node, load.node) and np.array_equal(known.element, load.element)
    ):
        raise ComputationError(f"{where}: loads other nodes or elements than the blocks before")
