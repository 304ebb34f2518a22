"""Drag on the velocity relative to a moving structure, and its linear part as damping.

With the velocity x' of a member the drag per length is rho Cd D / 2 |v - x'| (v - x'). To first order in x'
it is that on the fixed member minus c x', c = rho Cd D / 2 |v| (I + v v' / |v|^2), v the water's velocity
across the member [thesis 4.3.2 leaves the motion out]. The mean of c over the record is a damping per length.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.parallel import map_threads
from owt_wave_node.core.assembly import Sections
from owt_wave_node.core.field import Field
from owt_wave_node.core.hydro_mesh import HydroMesh
from owt_wave_node.core.sea import Frame

__all__ = ["drag_damping", "relative_force"]

Vectors = Float[np.ndarray, "*sample 3"]


def relative_force(
    water: tuple[Vectors, Vectors],
    body: tuple[Vectors, Vectors],
    *,
    axis: Float[np.ndarray, " 3"],
    diameter: float,
    cd: float,
    cm: float,
    density: float,
) -> Vectors:
    """Morison force per length in N/m on a moving member, relative-velocity form.

    rho pi D^2 / 4 [Cm a - (Cm - 1) x''] + rho Cd D / 2 |v - x'| (v - x'), all across the member.

    Parameters
    ----------
    water, body : pairs of float arrays [..., 3]
        Velocity in m/s and acceleration in m/s2 of the water, and of the member.
    axis : float array [3]
        Unit vector along the member.
    """
    normal = np.eye(3) - np.outer(axis, axis)
    relative = (water[0] - body[0]) @ normal
    acceleration = (cm * water[1] - (cm - 1.0) * body[1]) @ normal
    speed = np.linalg.norm(relative, axis=-1, keepdims=True)
    return np.asarray(
        0.25 * np.pi * density * diameter**2 * acceleration + 0.5 * density * cd * diameter * speed * relative
    )


def drag_damping(
    case: CaseConfig, hydro: HydroMesh, frame: Frame, field: Field, *, lowest: float, highest: float
) -> Float[np.ndarray, "loaded 3 3"]:
    """Mean damping of the translations of every loaded node in N s/m, global axes.

    The damping per length at the stations, while they are wet, goes to the nodes of its element by linear
    shape functions, lumped: rotations stay undamped.

    Parameters
    ----------
    case, hydro, frame, field, lowest, highest
        As for :func:`~owt_wave_node.core.assembly.assemble`.
    """
    sections, mesh = Sections(case, hydro, frame), hydro.mesh
    row = np.full(mesh.n_nodes, -1, dtype=np.int64)
    row[hydro.node] = np.arange(hydro.node.size)

    def one(member: int) -> list[tuple[int, Float[np.ndarray, "3 3"]]]:
        found: list[tuple[int, Float[np.ndarray, "3 3"]]] = []
        for run in hydro.runs[member]:
            stations = np.arange(run.stations.start, run.stations.stop)
            reached = hydro.station[stations, 2] <= highest
            if not reached.any():
                continue
            place = frame.place(hydro.station[stations[reached]])
            motion = field.prepare(place).kinematics(np.arange(len(place)))
            wet = np.ones((len(place), field.n), dtype=bool)
            if place[:, 2].max() > lowest:
                wet = np.add(*field.elevation(place)) >= place[:, 2:]
            axes = sections.axes[run.elements[0]][:, [0, 1, 2] if field.n_axes == 3 else [0, 2]]
            velocity = np.einsum("ij,sjt->ist", axes, motion[:, : field.n_axes])
            velocity += sections.current(run)[reached].T[:, :, None]
            drag = sections.coefficient(run)[reached, 1]
            local = drag[:, None, None] * _mean_rate(velocity[1:], wet)
            normal = hydro.element_axes[run.elements[0]][1:]
            rate = np.einsum("ia,sij,jb->sab", normal, local, normal)
            for e, weights in zip(run.elements, run.wet, strict=True):
                ends = mesh.element_node[hydro.element[e]]
                for node, weight in zip(ends, weights[reached, 4:].T, strict=True):
                    found.append((int(row[node]), np.einsum("s,sab->ab", weight, rate)))
        return found

    out = np.zeros((hydro.node.size, 3, 3))
    for part in map_threads(one, range(len(hydro.runs))):
        for at, damping in part:
            out[at] += damping
    return out


def _mean_rate(
    velocity: Float[np.ndarray, "2 station time"], wet: np.ndarray
) -> Float[np.ndarray, "station 2 2"]:
    """Mean over time of |v| I + v v' / |v| while wet."""
    speed = np.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
    weight = np.divide(wet, speed, out=np.zeros_like(speed), where=speed > 0.0)
    rate = np.einsum("ist,jst,st->sij", velocity, velocity, weight) / speed.shape[1]
    return np.asarray(rate + np.mean(speed * wet, axis=1)[:, None, None] * np.eye(2))
