"""What does not change over the time of a case: the decoupled structure and its maps to results."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from owt_model.config import CaseConfig
from owt_model.contracts import LoadBasis, ReducedDescription
from owt_model.mesh import Mesh
from owt_model.reduction_name import parse_reduction
from owt_structure_node.core.auto import Target
from owt_structure_node.core.damping import idle_dashpots
from owt_structure_node.core.energies import Part, split
from owt_structure_node.core.motion import Oscillators
from owt_structure_node.core.recovery import EndSections, end_force_map, end_sections
from owt_structure_node.core.response import (
    ModalModel,
    StructureParts,
    build_modal_model,
    describe,
    model_damping,
)
from owt_structure_node.core.sim import StaticImprovement
from owt_structure_node.core.tower_top import TowerTopLoad
from owt_structure_node.core.usage import expected_stress

#: Lowest modes that blades may drive, and the share of their frequency that counts as near.
BENDING, CLOSE = 2, 0.1

__all__ = ["ResponseModel", "build_response_model", "n_mta"]


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
    end_force : float array [strained, 6, end]
        K_e u_e at the member ends per unit amplitude of those, in element axes.
    tower_top : float array [6, mode]
        Modal load per unit of each force and moment at the tower top.
    part : Part
        What tells the energies of jacket and tower apart.
    ramp_s : float
        Time in s over which the loads rise from zero.
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
    end_force: Float[np.ndarray, "strained 6 end"]
    tower_top: Float[np.ndarray, "6 mode"]
    part: Part
    ramp_s: float = 0.0
    improvement: StaticImprovement | None = None


def n_mta(reduction: str) -> int:
    """Number of load vectors that a reduction needs.

    Raises
    ------
    InputError
        If it is not the name of a reduction.
    """
    return parse_reduction(reduction).load_vectors


def build_response_model(
    case: CaseConfig,
    mesh: Mesh,
    basis: LoadBasis | None,
    tower_top_load: TowerTopLoad | None = None,
    *,
    parts: StructureParts | None = None,
) -> ResponseModel:
    """Assemble, reduce and decouple the structure of `case`.

    Parameters
    ----------
    case : CaseConfig
        The case.
    mesh : Mesh
        Of its structure.
    basis : LoadBasis, optional
        Decomposition of its loads, where the reduction needs one.
    tower_top_load : TowerTopLoad, optional
        Of which the damping is taken; its wrench comes with the blocks.
    parts : StructureParts, optional
        Of this structure and reduction, where they are known.

    Raises
    ------
    InputError
        If the reduction does not fit the structure or the basis.
    ComputationError
        If a numerical step fails.
    """
    structure = case.structure
    top_dashpots = None if tower_top_load is None else tower_top_load.dashpots
    target = Target(structure.tolerance, structure.damping, case.time.dt_s, top_dashpots)
    model = build_modal_model(mesh, structure.reduction, basis, target, parts)
    damping = model_damping(model, structure.damping, basis, top_dashpots)
    end_force, ends = end_force_map(model.assembly, model.basis), end_sections(mesh)
    description = describe(model, damping, _notes(case, model, tower_top_load))
    strained = np.flatnonzero(end_force.reshape(len(end_force), -1).any(axis=1))
    node_basis = model.node_basis
    tower_top = node_basis[mesh.tower_top]
    return ResponseModel(
        description=replace(description, end_usage=expected_stress(model, end_force, ends, basis)),
        oscillators=Oscillators(
            model.omega_squared,
            damping.rate,
            structure.dt_s,
            case.substeps,
            structure.integrator,
            damping.dashpots,
        ),
        load_step=case.time.dt_s,
        n_elements=mesh.n_elements,
        node_basis=node_basis,
        amplitude=model.amplitude,
        coordinate=model.coordinate,
        ends=ends,
        strained=strained,
        end_force=np.ascontiguousarray(end_force[strained].transpose(0, 2, 1)),
        tower_top=tower_top if model.amplitude is None else tower_top @ model.amplitude.T,
        part=split(
            model.assembly, None if model.amplitude is None else model.basis, model.coordinate.shape[1]
        ),
        ramp_s=structure.ramp_s,
        improvement=model.improvement,
    )


def _notes(case: CaseConfig, model: ModalModel, tower_top_load: TowerTopLoad | None) -> tuple[str, ...]:
    """What is to be said of loads and dashpots."""
    notes = [] if tower_top_load is None else list(tower_top_load.notes)
    structure, ramp = case.structure, case.structure.ramp_s
    if ramp > 0.0:
        notes.append(f"loads rise from zero over the first {ramp:g} s, which the results count with the rest")
    if ramp > case.time.duration_s:
        notes.append(f"the record of {case.time.duration_s:g} s ends before the loads have risen")
    notes += _resonance(model, tower_top_load)
    rotor_damps = tower_top_load is not None and len(tower_top_load.dashpots) > 0
    if rotor_damps and structure.damping.tower_top is not None:
        notes.append(
            "structure.damping.tower_top and the damping of the rotor both act at the tower top: leave one "
            "out (wind.thrust.aerodynamic_damping) if they mean the same"
        )
    idle = idle_dashpots(model.assembly.mesh, model.assembly.expansion)
    if idle:
        notes.append(f"dashpots {', '.join(idle)} do nothing: they sit on fixed joints")
    return tuple(notes)


def _resonance(model: ModalModel, load: TowerTopLoad | None) -> list[str]:
    """Say that blades pass the tower near the frequency of one of its lowest modes."""
    passing = 0.0 if load is None else load.blade_passing_hz
    own = model.frequency_hz[:BENDING]
    near = own[np.abs(own - passing) < CLOSE * own]
    if not len(near):
        return []
    return [
        f"blades pass the tower at {passing:.3f} Hz (3P), within {CLOSE:.0%} of its mode at {near[0]:.3f} "
        "Hz: the response is that of a resonance which a turbine's controller avoids"
    ]
