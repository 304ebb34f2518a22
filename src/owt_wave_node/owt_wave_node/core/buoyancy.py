"""Hydrostatic load of still water on the members, apart from the wave loads.

Outer surfaces, marine growth included if the loads are on it, feel the pressure of the water up to still
water, and the walls of flooded members that of the water inside as well, which stands as high as the sea.
Every member counts as a closed tube: rho g A upwards per length, A the area of its section, without the bore
where it is flooded. A member that ends at the sea bed stands on it, and no water presses on its foot: there
the pressure rho g d A of the closed tube is taken off. Overlaps of members at the joints count twice, as in
the wave loads.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.mesh import Mesh
from owt_wave_node.core.hydro_mesh import HydroMesh, Run, build_hydro_mesh
from owt_wave_node.kernels import morison as _kernel

__all__ = ["buoyancy"]

#: Longest segment in m: none needs to be cut for its length.
LONGEST = 1e3
#: Distance in m from the bed within which a station counts as a foot.
AT_BED = 1e-6


def buoyancy(case: CaseConfig, mesh: Mesh) -> Float[np.ndarray, "node 6"]:
    """Equivalent nodal forces in N and moments in N m at every node of the mesh, global axes.

    Parameters
    ----------
    case : CaseConfig
        Water depth, density, gravity, and whether growth counts.
    mesh : Mesh
        Finite element mesh.
    """
    # Runs break at still water and at the bed, and a uniform load is integrated exactly over any segment.
    hydro = build_hydro_mesh(
        mesh,
        water_depth=case.water_depth_m,
        longest=LONGEST,
        marine_growth=case.morison.marine_growth,
    )
    out = np.zeros((mesh.n_nodes, 6, 1))
    for member, runs in zip(hydro.member, hydro.runs, strict=True):
        for run in runs:
            z = hydro.station[[run.stations[0], run.stations[-1]], 2]
            if z.mean() >= 0.0:
                continue
            weight = case.density_kg_m3 * case.gravity_m_s2 * _area(hydro, member, run)
            for e, wet in zip(run.elements, run.wet, strict=True):
                rows = _rows(wet.sum(axis=0), weight * hydro.element_axes[e, :, 2])
                rows += _foot(run, z, weight * case.water_depth_m, bed=-case.water_depth_m)
                for side, node in enumerate(mesh.element_node[hydro.element[e]]):
                    _kernel.add_to_node(rows, side, hydro.element_axes[e], out[node])
    return out[:, :, 0].copy()


def _area(hydro: HydroMesh, member: int, run: Run) -> float:
    """Area in m2 on which the difference of the pressures acts."""
    mesh, e = hydro.mesh, hydro.element[run.elements[0]]
    bore = mesh.element_diameter[e] - 2.0 * mesh.element_thickness[e] if mesh.member_flooded[member] else 0.0
    return float(0.25 * np.pi * (run.diameter**2 - bore**2))


def _rows(shape: Float[np.ndarray, " shape"], force: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "10 1"]:
    """Nodal loads of a uniform force per length in element axes, from the integrals of the shapes."""
    x, y, z = force
    turn = np.array([1.0, -1.0, 1.0, -1.0])
    return np.concatenate([y * shape[:4], z * turn * shape[:4], x * shape[4:]])[:, None]


def _foot(run: Run, z: Float[np.ndarray, " 2"], pressure: float, *, bed: float) -> Float[np.ndarray, "10 1"]:
    """Nodal loads that take the pressure off an end that stands on the bed."""
    rows, shape = np.zeros((10, 1)), np.empty(6)
    for end, sign in ((0, -1.0), (-1, 1.0)):
        if z[end] - bed < AT_BED and z[0] != z[1]:
            _kernel.hermite(run.place[end], 1.0, shape)
            rows[8:, 0] += sign * pressure * shape[4:]
    return rows
