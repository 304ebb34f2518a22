"""Reads messages into the contracts; the other half of :mod:`owt_ros.convert`.

Only fields are looked at, and no ROS is imported: messages of rclpy and those that the rosbags library
deserialises read alike. The shape of what comes in is checked; a message that cannot be is a
:class:`ComputationError` that names the type, the sequence and the field.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float, Int

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
    StressBlock,
    WrenchBlock,
)
from owt_model.errors import StreamError
from owt_model.frame import Frame, tied_nodes
from owt_model.timing import sample_index
from owt_ros.wire import head_of, indices, read_doubles, read_flags, read_integers, time_ns

__all__ = [
    "BLOCKS",
    "is_whole",
    "stress_ends",
    "to_elevation",
    "to_energy",
    "to_fatigue",
    "to_frame",
    "to_load_basis",
    "to_measured",
    "to_modal",
    "to_nodal_loads",
    "to_point",
    "to_reduced_model",
    "to_stress",
    "to_tower_top_load",
    "to_wrench",
]


def _block(message: Any) -> dict[str, Any]:
    head = head_of(message)
    return {"sequence": head.sequence, "start": head.start, "dt": head.dt, "last": head.last}


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
        damping=read_doubles(message, "damping", -1, 3, 3),
        spectrum=_spectrum(message),
        highest_frequency=float(message.highest_frequency),
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
        # older recordings have none of these
        notes=tuple(getattr(message, "notes", ())),
        substructure_name=tuple(getattr(message, "substructure_name", ())),
        end_usage=_or_empty(message, "end_usage"),
    )


def _or_empty(message: Any, name: str) -> Float[np.ndarray, " value"]:
    """Field `name`, empty in recordings older than it."""
    return read_doubles(message, name, -1) if hasattr(message, name) else np.zeros(0)


def _spectrum(message: Any) -> Float[np.ndarray, "shape band"]:
    if not len(message.spectrum):
        return np.zeros((0, 0))
    return read_doubles(message, "spectrum", len(message.singular_values), -1)


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


def to_tower_top_load(message: Any) -> WrenchBlock:
    """Read a block of tower-top loads."""
    samples = int(message.samples)
    filled = getattr(message, "filled", ())  # older recordings have none
    return WrenchBlock(
        **_block(message),
        wrench=read_doubles(message, "wrench", samples, 6),
        filled=read_flags(message, "filled", samples) if len(filled) else np.zeros(0, dtype=bool),
    )


def to_measured(message: Any) -> MeasuredBlock:
    """Read a block of the measured elevation as it was used."""
    samples = int(message.samples)
    return MeasuredBlock(
        **_block(message),
        elevation=read_doubles(message, "elevation", samples),
        filled=read_flags(message, "filled", samples),
    )


def to_point(message: Any) -> tuple[int, Float[np.ndarray, " 3"]]:
    """Read a stamped point: simulated time in ns, and x, y, z in m."""
    point = message.point
    return time_ns(message.header.stamp), np.array([point.x, point.y, point.z], dtype=np.float64)


def to_wrench(message: Any) -> tuple[int, Float[np.ndarray, " 6"]]:
    """Read a stamped wrench: simulated time in ns, and forces in N and moments in N m."""
    force, torque = message.wrench.force, message.wrench.torque
    values = [force.x, force.y, force.z, torque.x, torque.y, torque.z]
    return time_ns(message.header.stamp), np.array(values, dtype=np.float64)


def to_modal(message: Any) -> ModalBlock:
    """Read a block of generalised response."""
    displacement = read_doubles(message, "displacement", int(message.samples), -1)
    return ModalBlock(
        **_block(message),
        displacement=displacement,
        velocity=_unless_left_out(message, "velocity", *displacement.shape),
        acceleration=_unless_left_out(message, "acceleration", *displacement.shape),
    )


def _unless_left_out(message: Any, name: str, samples: int, n: int) -> Float[np.ndarray, "sample column"]:
    """Read a field that a bag may leave out; it has no columns then."""
    return read_doubles(message, name, samples, n if len(getattr(message, name)) else 0)


def is_whole(message: Any) -> bool:
    """Tell whether a message holds all that was published; a bag leaves out what can be computed again."""
    names = ("velocity", "acceleration", "potential_mode", "kinetic_mode")
    return stress_ends(message) is None and all(len(getattr(message, name, "-")) for name in names)


def stress_ends(message: Any) -> Int[np.ndarray, " column"] | None:
    """Member ends that a block of stress is given for, None for all of them."""
    listed = indices(getattr(message, "end", ()))  # older recordings have no such field
    return listed if len(listed) else None


def to_stress(message: Any) -> StressBlock:
    """Read a block of member stress, its columns those of :func:`stress_ends`."""
    ends = stress_ends(message)
    axial = read_doubles(message, "axial", int(message.samples), -1 if ends is None else len(ends))
    return StressBlock(
        **_block(message),
        axial=axial,
        bending_y=read_doubles(message, "bending_y", *axial.shape),
        bending_z=read_doubles(message, "bending_z", *axial.shape),
        von_mises=read_doubles(message, "von_mises", *axial.shape),
    )


def to_energy(message: Any) -> EnergyBlock:
    """Read a block of energies."""
    samples = int(message.samples)
    potential_mode = read_doubles(message, "potential_mode", samples, -1)
    parts = np.zeros((samples, 0)), np.zeros((samples, 0))  # older recordings have none
    if hasattr(message, "potential_substructure"):
        potential = read_doubles(message, "potential_substructure", samples, -1)
        parts = potential, read_doubles(message, "kinetic_substructure", *potential.shape)
    return EnergyBlock(
        **_block(message),
        potential=read_doubles(message, "potential", samples),
        kinetic=read_doubles(message, "kinetic", samples),
        potential_mode=potential_mode,
        kinetic_mode=_unless_left_out(message, "kinetic_mode", *potential_mode.shape),
        potential_substructure=parts[0],
        kinetic_substructure=parts[1],
    )


def to_fatigue(message: Any, *, dt: float) -> FatigueBlock:
    """Read the running fatigue result of a stress stream with time step `dt` in s."""
    n = len(message.damage)
    return FatigueBlock(
        sequence=int(message.sequence),
        start=sample_index(time_ns(message.header.stamp), dt),
        dt=dt,
        last=bool(message.last),
        samples_counted=int(message.samples_counted),
        sn_curve=str(message.sn_curve),
        cycles=read_doubles(message, "cycles", n),
        damage=read_doubles(message, "damage", n),
        total_stress=read_doubles(message, "total_stress_pa", n),
        max_range=read_doubles(message, "max_range_pa", n),
        side=np.asarray(getattr(message, "side", ()), dtype=np.int64),  # an older recording has neither
        angle_deg=np.asarray(getattr(message, "angle_deg", ()), dtype=np.float64),
    )


def to_frame(message: Any) -> Frame:
    """Read lines and walls of the members from a ModelDescription."""
    nodes, members = len(message.node_name), len(message.member_name)
    node = read_integers(message, "member_node", members, 2)
    if node.size and node.max() >= nodes:
        raise StreamError(f"ModelDescription: member_node names node {node.max()} of {nodes}")

    def of_ends(kind: str) -> Float[np.ndarray, " end"]:
        if len(getattr(message, f"end_{kind}_m", ())):
            return read_doubles(message, f"end_{kind}_m", 2 * members)
        return np.repeat(read_doubles(message, f"member_{kind}_m", members), 2)  # of an older recording

    return Frame(
        node_name=tuple(message.node_name),
        node_position=read_doubles(message, "node_position_m", nodes, 3),
        node_tied=tied_nodes(read_integers(message, "node_dof", nodes, 6)),
        member_name=tuple(message.member_name),
        member_node=node,
        end_diameter=of_ends("diameter"),
        end_thickness=of_ends("thickness"),
    )


#: Readers of the messages that hold a block of samples, by the name of their type.
BLOCKS: dict[str, Callable[[Any], Block]] = {
    "SurfaceElevation": to_elevation,
    "NodalLoads": to_nodal_loads,
    "ModalState": to_modal,
    "MemberStress": to_stress,
    "Energy": to_energy,
    "TowerTopLoad": to_tower_top_load,
    "MeasuredElevation": to_measured,
}
