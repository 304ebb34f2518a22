"""The only place where messages meet arrays.

``*_message`` turns a contract into a message, ``to_*`` a message into a contract. The readers take
messages of rclpy as well as those that the rosbags library deserialises: they only look at fields. The
shape of what comes in is checked; a message that cannot be is a :class:`ComputationError` that names
the type, the sequence and the field.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from owt_msgs import msg as owt
from std_msgs.msg import Header

from owt_model.contracts import (
    Block,
    ElevationBlock,
    EnergyBlock,
    FatigueBlock,
    LoadBasis,
    LoadBlock,
    ModalBlock,
    ReducedDescription,
    SeaState,
    StressBlock,
)
from owt_model.mesh import Mesh
from owt_ros.wire import (
    doubles,
    flat_array,
    head_of,
    indices,
    read_doubles,
    stamp,
    start_index,
    time_ns,
    uint32s,
)

__all__ = [
    "NO_MEMBER",
    "elevation_message",
    "energy_message",
    "fatigue_message",
    "load_basis_message",
    "modal_message",
    "model_message",
    "nodal_loads_message",
    "reduced_model_message",
    "sea_state_message",
    "stress_message",
    "to_elevation",
    "to_energy",
    "to_fatigue",
    "to_load_basis",
    "to_modal",
    "to_nodal_loads",
    "to_reduced_model",
    "to_stress",
]

#: Member of an element that belongs to none (the tower).
NO_MEMBER = 2**32 - 1


def _fill_head(message: Any, block: Block, samples: int) -> None:
    message.header = Header(stamp=stamp(block.time_ns))
    message.sequence, message.dt = int(block.sequence), float(block.dt)
    message.samples, message.last = int(samples), bool(block.last)


def _block(message: Any) -> dict[str, Any]:
    head = head_of(message)
    return {"sequence": head.sequence, "start": head.start, "dt": head.dt, "last": head.last}


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
        duration_s=float(sea.n * sea.dt_s),
        omega_rad_s=doubles(sea.omega_rad_s),
        amplitude_m=doubles(sea.amplitude_m),
        phase_rad=doubles(sea.phase_rad),
        wavenumber_rad_m=doubles(sea.wavenumber_rad_m),
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
        total_variance=float(basis.total_variance),
    )


def to_load_basis(message: Any) -> LoadBasis:
    """Read a load basis."""
    n = len(message.node)
    return LoadBasis(
        model_hash=str(message.model_hash),
        node=indices(message.node),
        vectors=read_doubles(message, "vectors", -1, n, 6),
        singular_values=read_doubles(message, "singular_values", -1),
        total_variance=float(message.total_variance),
        mean=read_doubles(message, "mean", n, 6),
        snapshots=int(message.snapshots),
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
    )


def to_reduced_model(message: Any) -> ReducedDescription:
    """Read the description of the reduced model."""
    return ReducedDescription(
        model_name=str(message.model_name),
        model_hash=str(message.model_hash),
        reduction=str(message.reduction),
        coordinate_name=tuple(message.coordinate_name),
        frequency_hz=read_doubles(message, "frequency_hz", -1),
        damping_ratio=read_doubles(message, "damping_ratio", -1),
        end_name=tuple(message.end_name),
        tower_top_coordinate=int(message.tower_top_coordinate),
    )


# --- streams --------------------------------------------------------------------------------------


def elevation_message(block: ElevationBlock) -> owt.SurfaceElevation:
    """Write a block of surface elevation."""
    message = owt.SurfaceElevation(
        gauge_m=doubles(block.gauge), first_order=doubles(block.first_order), total=doubles(block.total)
    )
    _fill_head(message, block, len(block.total))
    return message


def to_elevation(message: Any) -> ElevationBlock:
    """Read a block of surface elevation."""
    gauge = read_doubles(message, "gauge_m", -1, 2)
    shape = (int(message.samples), len(gauge))
    return ElevationBlock(
        **_block(message),
        gauge=gauge,
        first_order=read_doubles(message, "first_order", *shape),
        total=read_doubles(message, "total", *shape),
    )


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


def to_nodal_loads(message: Any) -> LoadBlock:
    """Read a block of loads."""
    samples = int(message.samples)
    return LoadBlock(
        **_block(message),
        model_hash=str(message.model_hash),
        node=indices(message.node),
        element=indices(message.element),
        nodal=read_doubles(message, "nodal", samples, len(message.node), 6),
        fixed_end=read_doubles(message, "fixed_end", samples, len(message.element), 12),
    )


def modal_message(block: ModalBlock) -> owt.ModalState:
    """Write a block of generalised response."""
    message = owt.ModalState(
        displacement=doubles(block.displacement),
        velocity=doubles(block.velocity),
        acceleration=doubles(block.acceleration),
    )
    _fill_head(message, block, len(block.displacement))
    return message


def to_modal(message: Any) -> ModalBlock:
    """Read a block of generalised response."""
    displacement = read_doubles(message, "displacement", int(message.samples), -1)
    return ModalBlock(
        **_block(message),
        displacement=displacement,
        velocity=read_doubles(message, "velocity", *displacement.shape),
        acceleration=read_doubles(message, "acceleration", *displacement.shape),
    )


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


def to_stress(message: Any) -> StressBlock:
    """Read a block of member stress."""
    axial = read_doubles(message, "axial", int(message.samples), -1)
    return StressBlock(
        **_block(message),
        axial=axial,
        bending_y=read_doubles(message, "bending_y", *axial.shape),
        bending_z=read_doubles(message, "bending_z", *axial.shape),
        von_mises=read_doubles(message, "von_mises", *axial.shape),
    )


def energy_message(block: EnergyBlock) -> owt.Energy:
    """Write a block of energies."""
    message = owt.Energy(
        potential=doubles(block.potential),
        kinetic=doubles(block.kinetic),
        potential_mode=doubles(block.potential_mode),
        kinetic_mode=doubles(block.kinetic_mode),
    )
    _fill_head(message, block, len(block.potential))
    return message


def to_energy(message: Any) -> EnergyBlock:
    """Read a block of energies."""
    samples = int(message.samples)
    potential_mode = read_doubles(message, "potential_mode", samples, -1)
    return EnergyBlock(
        **_block(message),
        potential=read_doubles(message, "potential", samples),
        kinetic=read_doubles(message, "kinetic", samples),
        potential_mode=potential_mode,
        kinetic_mode=read_doubles(message, "kinetic_mode", *potential_mode.shape),
    )


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
    )


def to_fatigue(message: Any, *, dt: float) -> FatigueBlock:
    """Read the running fatigue result of a stress stream with time step `dt` in s."""
    n = len(message.damage)
    return FatigueBlock(
        sequence=int(message.sequence),
        start=start_index(time_ns(message.header.stamp), dt),
        dt=dt,
        last=bool(message.last),
        samples_counted=int(message.samples_counted),
        sn_curve=str(message.sn_curve),
        cycles=read_doubles(message, "cycles", n),
        damage=read_doubles(message, "damage", n),
        total_stress=read_doubles(message, "total_stress_pa", n),
        max_range=read_doubles(message, "max_range_pa", n),
    )
