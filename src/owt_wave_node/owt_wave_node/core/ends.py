"""Loads on the discs at free member ends: drag and added mass along the member (off by default).

A free end is a joint with one member that is neither supported nor tied to the interface. With n along the
member, F = [rho end_cd A / 2 |v.n| v.n + rho end_ca V a.n] n, A the area of the disc and V = 2/3 pi (D/2)^3
that of half a sphere, the reference volume of HydroDyn and QBlade, which add the dynamic pressure on the
disc: it is left out here. The load acts while the joint is under water.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.mesh import Mesh
from owt_wave_node.core.current import current_velocity
from owt_wave_node.core.field import Field
from owt_wave_node.core.hydro_mesh import HydroMesh
from owt_wave_node.core.sea import Frame

__all__ = ["end_loads", "free_ends"]


def free_ends(mesh: Mesh) -> list[tuple[int, int]]:
    """Member and side (0 first, 1 last) of every free end."""
    joints = {name: i for i, name in enumerate(mesh.node_name)}
    structure = mesh.structure
    linked = [joint for link in structure.rigid_links.values() for joint in link.joints]
    held = {joints[name] for name in (*structure.supports, *structure.support_springs, *linked)}
    held |= set(mesh.interface_node.tolist())
    count = np.bincount(mesh.member_node.reshape(-1), minlength=mesh.n_nodes)
    return [
        (m, side)
        for m, nodes in enumerate(mesh.member_node.tolist())
        for side, node in enumerate(nodes)
        if count[node] == 1 and node not in held
    ]


def end_loads(
    case: CaseConfig, hydro: HydroMesh, frame: Frame, field: Field, *, highest: float
) -> dict[int, Float[np.ndarray, "3 time"]]:
    """Forces in N in global axes, by mesh node.

    Parameters
    ----------
    highest : float
        Level in m that the surface never exceeds.
    """
    morison, mesh, rho = case.morison, hydro.mesh, case.density_kg_m3
    out: dict[int, Float[np.ndarray, "3 time"]] = {}
    if not (morison.end_cd > 0.0 or morison.end_ca > 0.0):
        return out
    runs = dict(zip(hydro.member, hydro.runs, strict=True))
    for member, side in free_ends(mesh):
        node = int(mesh.member_node[member, side])
        position = mesh.node_position[node]
        if member not in runs or not -case.water_depth_m < position[2] <= highest:
            continue
        run = runs[member][-side]
        place = frame.place(position[None])
        motion = field.prepare(place).kinematics(np.array([0]))[0]
        axis = hydro.element_axes[run.elements[-side], 0]
        along = (frame.axes @ axis)[[0, 1, 2] if field.n_axes == 3 else [0, 2]]
        velocity = along @ motion[: field.n_axes] + current_velocity(case, position[2:])[0] @ axis[:2]
        area, volume = 0.25 * np.pi * run.diameter**2, np.pi / 12.0 * run.diameter**3
        force = 0.5 * rho * morison.end_cd * area * np.abs(velocity) * velocity
        force += rho * morison.end_ca * volume * (along @ motion[field.n_axes :])
        wet = np.add(*field.elevation(place))[0] >= position[2]
        out[node] = np.outer(axis, np.where(wet, force, 0.0))
    return out
