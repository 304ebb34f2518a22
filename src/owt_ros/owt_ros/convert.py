"""The only place where messages meet arrays: this half writes messages, :mod:`owt_ros.decode` reads them."""

from __future__ import annotations

from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from owt_msgs import msg as owt
from std_msgs.msg import Header

from owt_model.contracts import (
    Block,
    ElevationBlock,
    EnergyBlock,
    FatigueBlock,
    LoadBasis,
    LoadBlock,
    MeasuredBlock,
    ModalBlock,
    ReducedDescription,
    SeaState,
    StressBlock,
    WrenchBlock,
)
from owt_model.mesh import Mesh
from owt_ros.wire import NO_MEMBER, doubles, flat_array, uint32s

__all__ = [
    "elevation_message",
    "energy_message",
    "fatigue_message",
    "load_basis_message",
    "measured_message",
    "modal_message",
    "model_message",
    "nodal_loads_message",
    "reduced_model_message",
    "sea_state_message",
    "stamp",
    "stress_message",
    "tower_top_load_message",
]


def stamp(ns: int) -> Time:
    """Return simulated time `ns` in ns as a message."""
    seconds, rest = divmod(int(ns), 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)


def _fill_head(message: Any, block: Block, samples: int) -> None:
    message.header = Header(stamp=stamp(block.time_ns))
    message.sequence, message.dt = int(block.sequence), float(block.dt)
    message.samples, message.last = int(samples), bool(block.last)


# --- latched descriptions -------------------------------------------------------------------------


def model_message(mesh: Mesh) -> owt.ModelDescription:
    """Describe the mesh; elements of the tower belong to member ``NO_MEMBER``."""
    first = mesh.member_element[:, 0]
    owner = np.where(mesh.element_member < 0, NO_MEMBER, mesh.element_member)
    return owt.ModelDescription(
        model_name=mesh.structure.name,
        model_hash=mesh.structure.content_hash,
        node_name=list(mesh.node_name),
        node_position_m=doubles(mesh.node_position),
        node_dof=flat_array("i", np.int32, mesh.node_dof),
        member_name=list(mesh.member_name),
        member_node=uint32s(mesh.member_node),
        member_diameter_m=doubles(mesh.element_diameter[first]),
        member_thickness_m=doubles(mesh.element_thickness[first]),
        end_diameter_m=doubles(mesh.element_diameter[mesh.end_element]),
        end_thickness_m=doubles(mesh.element_thickness[mesh.end_element]),
        element_member=uint32s(owner),
        element_node=uint32s(mesh.element_node),
    )


def sea_state_message(sea: SeaState) -> owt.SeaState:
    """Describe the sea as realised."""
    return owt.SeaState(
        hs_m=float(sea.hs_m),
        tp_s=float(sea.tp_s),
        gamma=float(sea.gamma),
        direction_deg=float(sea.direction_deg),
        seed=int(sea.seed),
        order=int(sea.order),
        stretching=str(sea.stretching),
        cutoff_rad_s=float(sea.cutoff_rad_s),
        water_depth_m=float(sea.water_depth_m),
        gravity_m_s2=float(sea.gravity_m_s2),
        density_kg_m3=float(sea.density_kg_m3),
        duration_s=float(sea.duration_s),
        omega_rad_s=doubles(sea.omega_rad_s),
        amplitude_m=doubles(sea.amplitude_m),
        phase_rad=doubles(sea.phase_rad),
        wavenumber_rad_m=doubles(sea.wavenumber_rad_m),
        component_direction_deg=doubles(sea.component_direction_deg),
        source=str(sea.source),
    )


def load_basis_message(basis: LoadBasis) -> owt.LoadBasis:
    """Describe the load basis."""
    return owt.LoadBasis(
        model_hash=basis.model_hash,
        node=uint32s(basis.node),
        snapshots=int(basis.snapshots),
        mean=doubles(basis.mean),
        vectors=doubles(basis.vectors),
        singular_values=doubles(basis.singular_values),
        damping=doubles(basis.damping),
        total_variance=float(basis.total_variance),
        spectrum=doubles(basis.spectrum),
        highest_frequency=float(basis.highest_frequency),
    )


def reduced_model_message(description: ReducedDescription) -> owt.ReducedModel:
    """Describe the reduced model; the ends come in pairs, member by member."""
    ends = np.arange(len(description.end_name))
    return owt.ReducedModel(
        model_name=description.model_name,
        model_hash=description.model_hash,
        reduction=description.reduction,
        coordinate_name=list(description.coordinate_name),
        tower_top_coordinate=int(description.tower_top_coordinate),
        frequency_hz=doubles(description.frequency_hz),
        damping_ratio=doubles(description.damping_ratio),
        end_name=list(description.end_name),
        end_member=uint32s(ends // 2),
        end_side=flat_array("B", np.uint8, ends % 2),
        end_usage=doubles(description.end_usage),
        notes=list(description.notes),
        substructure_name=list(description.substructure_name),
    )


# --- streams --------------------------------------------------------------------------------------


def elevation_message(block: ElevationBlock) -> owt.SurfaceElevation:
    """Write a block of surface elevation."""
    message = owt.SurfaceElevation(
        gauge_m=doubles(block.gauge), first_order=doubles(block.first_order), total=doubles(block.total)
    )
    _fill_head(message, block, len(block.total))
    return message


def nodal_loads_message(block: LoadBlock) -> owt.NodalLoads:
    """Write a block of loads."""
    message = owt.NodalLoads(
        model_hash=block.model_hash,
        node=uint32s(block.node),
        element=uint32s(block.element),
        nodal=doubles(block.nodal),
        fixed_end=doubles(block.fixed_end),
    )
    _fill_head(message, block, len(block.nodal))
    return message


def tower_top_load_message(block: WrenchBlock) -> owt.TowerTopLoad:
    """Write a block of tower-top loads."""
    message = owt.TowerTopLoad(wrench=doubles(block.wrench), filled=flat_array("B", np.uint8, block.filled))
    _fill_head(message, block, len(block.wrench))
    return message


def measured_message(block: MeasuredBlock) -> owt.MeasuredElevation:
    """Write a block of the measured elevation as it is used."""
    message = owt.MeasuredElevation(
        elevation=doubles(block.elevation), filled=flat_array("B", np.uint8, block.filled)
    )
    _fill_head(message, block, len(block.elevation))
    return message


def modal_message(block: ModalBlock) -> owt.ModalState:
    """Write a block of generalised response."""
    message = owt.ModalState(
        displacement=doubles(block.displacement),
        velocity=doubles(block.velocity),
        acceleration=doubles(block.acceleration),
    )
    _fill_head(message, block, len(block.displacement))
    return message


def stress_message(block: StressBlock) -> owt.MemberStress:
    """Write a block of member stress."""
    message = owt.MemberStress(
        axial=doubles(block.axial),
        bending_y=doubles(block.bending_y),
        bending_z=doubles(block.bending_z),
        von_mises=doubles(block.von_mises),
    )
    _fill_head(message, block, len(block.axial))
    return message


def energy_message(block: EnergyBlock) -> owt.Energy:
    """Write a block of energies."""
    message = owt.Energy(
        potential=doubles(block.potential),
        kinetic=doubles(block.kinetic),
        potential_mode=doubles(block.potential_mode),
        kinetic_mode=doubles(block.kinetic_mode),
        potential_substructure=doubles(block.potential_substructure),
        kinetic_substructure=doubles(block.kinetic_substructure),
    )
    _fill_head(message, block, len(block.potential))
    return message


def fatigue_message(block: FatigueBlock) -> owt.FatigueState:
    """Write the running fatigue result; its stamp is the time up to which stress has been counted."""
    return owt.FatigueState(
        header=Header(stamp=stamp(block.time_ns)),
        sequence=int(block.sequence),
        last=bool(block.last),
        samples_counted=int(block.samples_counted),
        sn_curve=block.sn_curve,
        cycles=doubles(block.cycles),
        damage=doubles(block.damage),
        total_stress_pa=doubles(block.total_stress),
        max_range_pa=doubles(block.max_range),
        side=flat_array("B", np.uint8, block.side),
        angle_deg=doubles(block.angle_deg),
    )
