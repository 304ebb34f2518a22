"""Morison loads of a case on the jacket: nodal loads, total force and moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_model.errors import InputError
from owt_model.mesh import Mesh
from owt_wave_node.core.assembly import LoadHistory, assemble
from owt_wave_node.core.field import Field
from owt_wave_node.core.hydro_mesh import build_hydro_mesh, interface_level
from owt_wave_node.core.profile import check_extrapolation
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state, sea_field

__all__ = ["LoadHistory", "Loads", "jacket_loads", "load_history", "surface_range"]

#: Gauges per shortest wave over the width of the jacket; between them a maximum can hide 8 %.
GAUGES_PER_WAVE = 8
MAX_GAUGES = 400
#: Factor and length in m added to the range of the surface, to be sure of what stays wet or dry.
SAFETY, MARGIN = 1.1, 0.05


@dataclass(frozen=True)
class Loads:
    """Wave loads on a jacket: what ``owt loads`` writes.

    Attributes
    ----------
    t : float array [time]
        s.
    force, moment : float arrays [time, 3]
        Total force in N and total moment in N m about the origin, global axes.
    """

    t: Float[np.ndarray, " time"]
    force: Float[np.ndarray, "time 3"]
    moment: Float[np.ndarray, "time 3"]
    history: LoadHistory

    def nodal(self) -> Float[np.ndarray, "time node 6"]:
        """Forces in N and moments in N m at every node of the mesh, zero where no load can reach."""
        out = np.zeros((len(self.t), self.history.hydro.mesh.n_nodes, 6))
        for i, node in enumerate(self.history.node):
            out[:, node] = self.history.nodal[i].T
        return out


def jacket_loads(case: CaseConfig, mesh: Mesh) -> Loads:
    """Compute the Morison loads of `case` on the jacket of `mesh`.

    Raises
    ------
    InputError
        If the water depth is not that of the structure, or the surface reaches the interface.
    ComputationError
        If a load is not finite.
    """
    sea = build_sea_state(case)
    history = load_history(case, mesh, sea, make_field(case, sea))
    nodal = history.nodal.reshape(6 * len(history.node), -1)
    # Resultants about the origin: force F, moment M + r x F.
    resultant = np.zeros((6, len(history.node), 6))
    resultant[range(6), :, range(6)] = 1.0
    x, y, z = mesh.node_position[history.node].T
    resultant[3, :, 1], resultant[3, :, 2] = -z, y
    resultant[4, :, 0], resultant[4, :, 2] = z, -x
    resultant[5, :, 0], resultant[5, :, 1] = -y, x
    total = np.ascontiguousarray((resultant.reshape(6, -1) @ nodal).T)
    return Loads(
        t=np.arange(case.time.n) * case.time.dt_s,
        force=total[:, :3].copy(),
        moment=total[:, 3:].copy(),
        history=history,
    )


def surface_range(field: Field, place: Float[np.ndarray, "point 3"], shortest: float) -> tuple[float, float]:
    """Lowest and highest surface in m over the record and over the width that `place` spans along the waves.

    Parameters
    ----------
    field : Field
        The waves.
    place : float array [point, 3]
        Places in m in wave axes.
    shortest : float
        Length in m of the shortest wave.
    """
    x = place[:, 0]
    width = float(np.ptp(x))
    count = int(min(MAX_GAUGES, np.ceil(width / shortest * GAUGES_PER_WAVE) + 1))
    gauges = np.zeros((count, 3))
    gauges[:, 0] = np.linspace(float(x.min()), float(x.max()), count)
    first, second = field.elevation(gauges)
    total = first + second
    return float(total.min()), float(total.max())


def load_history(case: CaseConfig, mesh: Mesh, sea: SeaState, field: Field) -> LoadHistory:
    """Compute the loads of the sea on the members of `mesh` over the whole record.

    Raises
    ------
    InputError
        If the water depth is not that of the structure, or the surface reaches the interface.
    ComputationError
        If a load is not finite.
    """
    mesh.structure.check_water_depth(case.water_depth_m)
    hydro = build_hydro_mesh(
        mesh,
        water_depth=case.water_depth_m,
        longest=case.morison.discretisation_m,
        marine_growth=case.morison.marine_growth,
    )
    frame = Frame(sea.direction_deg)
    highest_wavenumber = float(sea.wavenumber_rad_m[sea.amplitude_m > 0.0].max(initial=1e-3))
    jacket = np.setdiff1d(np.arange(mesh.n_nodes), mesh.tower_node)
    low, high = surface_range(
        field, frame.place(mesh.node_position[jacket]), 2.0 * np.pi / (sea.order * highest_wavenumber)
    )
    limit = interface_level(mesh)
    if high > limit:
        raise InputError(
            sea_field(case),
            case.sea_state.hs_m if case.sea_state is not None else float(sea.amplitude_m.max()),
            f"raises the surface to z = {high:.2f} m at the jacket, above its lowest interface joint at "
            f"z = {limit:g} m",
            "Use lower waves: nothing above the interface can carry wave load.",
        )
    highest = min(SAFETY * max(high, 0.0) + MARGIN, limit)
    check_extrapolation(sea.stretching, sea.wavenumber_rad_m, highest + case.morison.discretisation_m)
    return assemble(case, hydro, frame, field, lowest=SAFETY * min(low, 0.0) - MARGIN, highest=highest)
