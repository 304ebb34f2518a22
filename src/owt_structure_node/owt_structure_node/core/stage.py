"""The structure stage: blocks of loads in, blocks of response, stress and energy out.

The same functions serve the ROS node and the in-process run. The first block of L load samples gives
``substeps (L - 1) + 1`` rows, from t = 0 on; every later one ``substeps L``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from owt_model.config import CaseConfig
from owt_model.contracts import (
    EnergyBlock,
    LoadBasis,
    LoadBlock,
    ModalBlock,
    ReducedDescription,
    StressBlock,
)
from owt_model.errors import ComputationError
from owt_model.mesh import Mesh
from owt_model.reduction_name import parse_reduction
from owt_structure_node.core.auto import Target
from owt_structure_node.core.motion import Motion, MotionState, Oscillators, integrate, static_state
from owt_structure_node.core.recovery import (
    EndSections,
    add_fixed_end_forces,
    end_force_map,
    end_sections,
    fixed_end_columns,
    stresses,
)
from owt_structure_node.core.response import build_modal_model, describe, drag_rate, modal_damping
from owt_structure_node.core.sim import ImprovementMap, StaticImprovement

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
class ResponseModel:
    """Everything about a case that does not change over its time.

    Attributes
    ----------
    load_step : float
        Expected time step of the loads in s.
    node_basis : float array [node, 6, function]
        Basis functions at all nodes: their transpose projects nodal loads.
    amplitude : float array [mode, function], or None
        Amplitudes of the basis functions in each mode; None where the functions are the modes.
    coordinate : float array [mode, coordinate]
        Generalised coordinates per unit modal amplitude.
    strained : int array [strained]
        Basis functions that strain a member: a few, since the tower has functions of its own.
    end_force : float array [strained, end, 6]
        K_e u_e at the member ends per unit amplitude of those, in element axes.
    improvement : StaticImprovement, optional
        Static response of what the basis leaves out, added to forces and potential energy.
    """

    description: ReducedDescription
    oscillators: Oscillators
    load_step: float
    n_elements: int
    node_basis: Float[np.ndarray, "node 6 function"]
    amplitude: Float[np.ndarray, "mode function"] | None
    coordinate: Float[np.ndarray, "mode coordinate"]
    ends: EndSections
    strained: Int[np.ndarray, " strained"]
    end_force: Float[np.ndarray, "strained end 6"]
    improvement: StaticImprovement | None = None


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


def n_mta(reduction: str) -> int:
    """Number of load vectors that a reduction needs.

    Raises
    ------
    InputError
        If it is not the name of a reduction.
    """
    return parse_reduction(reduction).load_vectors


def build_response_model(case: CaseConfig, mesh: Mesh, basis: LoadBasis | None) -> ResponseModel:
    """Assemble, reduce and decouple the structure of `case`.

    Raises
    ------
    InputError
        If the reduction does not fit the structure or the basis.
    ComputationError
        If a numerical step fails.
    """
    structure = case.structure
    alpha, beta = structure.damping.alpha, structure.damping.beta
    target = Target(structure.tolerance, alpha, beta, case.time.dt_s)
    model = build_modal_model(mesh, structure.reduction, basis, target)
    rate, _ = modal_damping(model.omega_squared, alpha, beta)
    drag = drag_rate(model, basis)
    end_force = end_force_map(model.assembly, model.basis)
    strained = np.flatnonzero(end_force.reshape(len(end_force), -1).any(axis=1))
    return ResponseModel(
        description=describe(model, alpha, beta, drag),
        oscillators=Oscillators(
            model.omega_squared, rate + drag, structure.dt_s, case.substeps, structure.integrator
        ),
        load_step=case.time.dt_s,
        n_elements=mesh.n_elements,
        node_basis=model.node_basis,
        amplitude=model.amplitude,
        coordinate=model.coordinate,
        ends=end_sections(mesh),
        strained=strained,
        end_force=np.ascontiguousarray(end_force[strained]),
        improvement=model.improvement,
    )


def initial_state(model: ResponseModel) -> ResponseState:
    """State before the first block; the structure is at rest under its first load sample."""
    return ResponseState()


def step(model: ResponseModel, state: ResponseState, load: LoadBlock) -> tuple[ResponseState, Response]:
    """Integrate over one block of loads and recover the stresses.

    Parameters
    ----------
    model : ResponseModel
        From :func:`build_response_model`.
    state : ResponseState
        From :func:`initial_state` or the block before.
    load : LoadBlock
        The next block of the stream.

    Raises
    ------
    ComputationError
        If the block does not continue the stream, belongs to another structure, or holds NaN or inf.
    """
    _check_block(model, state, load)
    loads = state.loads if state.loads is not None else _load_map(model, load)
    nodal = load.nodal.reshape(len(load.nodal), -1)
    modal_load = nodal @ loads.projection
    if loads.to_modes is not None:
        modal_load = modal_load @ loads.to_modes
    first = state.motion is None
    if state.motion is None:
        before, rest = static_state(model.oscillators, modal_load[0]), modal_load[1:]
        fixed_end = load.fixed_end.copy()  # writable: one kernel signature, whatever the block came from
    else:
        assert state.fixed_end is not None
        before, rest = state.motion, modal_load
        fixed_end = np.concatenate([state.fixed_end[None], load.fixed_end])
    after, motion = integrate(model.oscillators, before, rest)
    # Row 0 is the instant before the block, part of the output for the first block only: interpolation of
    # the fixed-end forces needs it.
    motion = _with_start(before, motion)
    shown = slice(0 if first else 1, None)
    coordinate = motion.displacement if model.amplitude is None else motion.displacement @ model.amplitude
    force = _end_forces(model, coordinate)
    substeps = model.oscillators.substeps
    add_fixed_end_forces(force, fixed_end, loads.columns, substeps)
    extra_energy: Float[np.ndarray, " row"] | float = 0.0
    if loads.improvement is not None:
        improved = nodal if state.improved is None else np.concatenate([state.improved[None], nodal])
        add_fixed_end_forces(force, loads.improvement.forces(improved), loads.improvement.columns, substeps)
        extra_energy = loads.improvement.energy(improved, substeps)[shown]
    head = {
        "sequence": load.sequence,
        "start": 0 if first else substeps * (load.start - 1) + 1,
        "dt": model.oscillators.step,
        "last": load.last,
    }
    motion = Motion(motion.displacement[shown], motion.velocity[shown], motion.acceleration[shown])
    response = Response(
        modal=_modal_block(model, motion, coordinate[shown], head),
        stress=_stress_block(model, force[shown], head),
        energy=_energy_block(model, motion, head, extra_energy),
    )
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
            fixed_end=load.fixed_end[-1].copy(),
            improved=None if loads.improvement is None else nodal[-1].copy(),
        ),
        response,
    )


def _with_start(before: MotionState, motion: Motion) -> Motion:
    return Motion(
        np.concatenate([before.displacement[None], motion.displacement]),
        np.concatenate([before.velocity[None], motion.velocity]),
        np.concatenate([before.acceleration[None], motion.acceleration]),
    )


def _end_forces(
    model: ResponseModel, amplitude: Float[np.ndarray, "row function"]
) -> Float[np.ndarray, "row end 6"]:
    n_strained, n_ends = model.end_force.shape[:2]
    force = np.ascontiguousarray(amplitude[:, model.strained]) @ model.end_force.reshape(n_strained, -1)
    return np.asarray(force).reshape(-1, n_ends, 6)


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


def _stress_block(
    model: ResponseModel, force: Float[np.ndarray, "row end 6"], head: dict[str, int | float | bool]
) -> StressBlock:
    stress = stresses(force, model.ends)
    return StressBlock(
        **head,  # type: ignore[arg-type]
        axial=stress.axial,
        bending_y=stress.bending_y,
        bending_z=stress.bending_z,
        von_mises=stress.von_mises,
    )


def _energy_block(
    model: ResponseModel,
    motion: Motion,
    head: dict[str, int | float | bool],
    extra: Float[np.ndarray, " row"] | float,
) -> EnergyBlock:
    """Potential x' K x / 2 and kinetic v' M v / 2, which are sums over the modes; `extra` is potential."""
    potential = 0.5 * model.oscillators.stiffness * motion.displacement**2
    kinetic = 0.5 * motion.velocity**2
    n = len(model.description.frequency_hz)
    return EnergyBlock(
        **head,  # type: ignore[arg-type]
        potential=potential.sum(axis=1) + extra,
        kinetic=kinetic.sum(axis=1),
        potential_mode=np.ascontiguousarray(potential[:, :n]),
        kinetic_mode=np.ascontiguousarray(kinetic[:, :n]),
    )


def _load_map(model: ResponseModel, load: LoadBlock) -> LoadMap:
    n_nodes, _, n_functions = model.node_basis.shape
    for name, index, size in (("node", load.node, n_nodes), ("element", load.element, model.n_elements)):
        if len(index) and not (index.min() >= 0 and index.max() < size):
            raise ComputationError(
                f"nodal loads: {name} {int(index.min())} to {int(index.max())}, the mesh has 0 to {size - 1}"
            )
        if len(np.unique(index)) != len(index):
            raise ComputationError(f"nodal loads: the list of {name}s names one of them twice")
    projection = model.node_basis[load.node].reshape(-1, n_functions)
    moved = np.flatnonzero(projection.any(axis=0))
    return LoadMap(
        node=load.node.copy(),
        element=load.element.copy(),
        projection=np.ascontiguousarray(projection[:, moved]),
        to_modes=_columns(model.amplitude, moved),
        columns=fixed_end_columns(model.ends, load.element),
        improvement=None if model.improvement is None else model.improvement.map(load.node),
    )


def _columns(
    amplitude: Float[np.ndarray, "mode function"] | None, chosen: Int[np.ndarray, " chosen"]
) -> Float[np.ndarray, "chosen mode"] | None:
    return None if amplitude is None else np.ascontiguousarray(amplitude[:, chosen].T)


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
    if not len(load.nodal) or len(load.fixed_end) != len(load.nodal):
        raise ComputationError(
            f"{where}: {len(load.nodal)} samples of nodal loads, {len(load.fixed_end)} of fixed-end forces"
        )
    known = state.loads
    if known is not None and not (
        np.array_equal(known.node, load.node) and np.array_equal(known.element, load.element)
    ):
        raise ComputationError(f"{where}: loads other nodes or elements than the blocks before")
    for name, data in (("nodal load", load.nodal), ("fixed-end force", load.fixed_end)):
        if not np.isfinite(data).all():
            sample = int(np.argwhere(~np.isfinite(data).reshape(len(data), -1).all(axis=1))[0, 0])
            raise ComputationError(f"{where}: {name} of sample {load.start + sample} is NaN or inf")
