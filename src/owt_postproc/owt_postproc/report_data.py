"""What a report shows, collected block by block, alike from a run in process and from a bag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from owt_model.contracts import (
    Block,
    ElevationBlock,
    EnergyBlock,
    LoadBlock,
    ModalBlock,
    ReducedDescription,
    StressBlock,
    WrenchBlock,
)
from owt_model.errors import ComputationError
from owt_model.mesh import Mesh
from owt_postproc.core.stage import FatigueResult

__all__ = ["Geometry", "ReportCollector", "ReportData", "mesh_geometry"]


@dataclass(frozen=True)
class Geometry:
    """Lines of the structure.

    Attributes
    ----------
    node : float array [node, 3]
        Positions in m.
    member_node : int array [member, 2]
        Ends 2 m and 2 m + 1 of the results are first and last node of member m.
    tower_node : int array [segment, 2]
        Nodes of the elements that belong to no member.
    node_name : tuple of str [node]
    member_name : tuple of str [member]
    member_diameter : float array [member]
        Outer diameter in m at the first node; empty where not recorded.
    """

    node: Float[np.ndarray, "node 3"]
    member_node: Int[np.ndarray, "member 2"]
    tower_node: Int[np.ndarray, "segment 2"]
    node_name: tuple[str, ...]
    member_name: tuple[str, ...]
    member_diameter: Float[np.ndarray, " diameter"]


def mesh_geometry(mesh: Mesh) -> Geometry:
    """Lines of a mesh."""
    return Geometry(
        node=mesh.node_position,
        member_node=mesh.member_node,
        tower_node=mesh.element_node[mesh.is_tower],
        node_name=mesh.node_name,
        member_name=mesh.member_name,
        member_diameter=mesh.element_diameter[mesh.member_element[:, 0]],
    )


@dataclass(frozen=True)
class ReportData:
    """Arrays and facts of one run; SI units.

    Attributes
    ----------
    case : mapping
        The case file as plain data.
    sea_state : mapping
        Facts of the sea as realised (``hs_m``, ``tp_s``, ``direction_deg``, ...); may be empty.
    versions : mapping
        What made the numbers.
    wave_time : float array [wave sample]
        Of elevation and loads, in s.
    elevation_first, elevation_total : float arrays [wave sample]
        At the first gauge, in m.
    wave_force : float array [wave sample, 3]
        Sum of the nodal loads in N: base shear of the waves in its first two columns.
    time : float array [sample]
        Of the response, in s.
    tower_top : float array [sample, 3], optional
        Displacement of the tower top in m.
    stress_end, stress_spot : int
        Member end of largest damage, and its hot spot of largest damage.
    stress_normal, stress_von_mises : float arrays [sample]
        There, in Pa; hot-spot stress signed; von Mises nominal.
    potential, kinetic : float arrays [sample]
        Energies in J.
    potential_substructure, kinetic_substructure : float arrays [sample, part]
        Energies in J of the parts that ``reduced`` names; none of a recording that lacks them.
    tower_top_load : float array [wave sample, 6], optional
        Force in N and moment in N m on the tower top; None of a run without.
    complete : bool
        False where the stress does not reach the end of the record.
    """

    case: Mapping[str, Any]
    sea_state: Mapping[str, Any]
    versions: Mapping[str, str]
    reduced: ReducedDescription
    fatigue: FatigueResult
    geometry: Geometry | None
    wave_time: Float[np.ndarray, " wave_sample"]
    elevation_first: Float[np.ndarray, " wave_sample"]
    elevation_total: Float[np.ndarray, " wave_sample"]
    wave_force: Float[np.ndarray, "wave_sample 3"]
    time: Float[np.ndarray, " sample"]
    tower_top: Float[np.ndarray, "sample 3"] | None
    stress_end: int
    stress_spot: int
    stress_normal: Float[np.ndarray, " sample"]
    stress_von_mises: Float[np.ndarray, " sample"]
    potential: Float[np.ndarray, " sample"]
    kinetic: Float[np.ndarray, " sample"]
    potential_substructure: Float[np.ndarray, "sample part"]
    kinetic_substructure: Float[np.ndarray, "sample part"]
    tower_top_load: Float[np.ndarray, "wave_sample 6"] | None = None
    complete: bool = True
    title: str = "Response and fatigue in one sea state"

    @property
    def end_name(self) -> str:
        """Name of the member end whose stress is shown."""
        return self.reduced.end_name[self.stress_end]

    @property
    def directions(self) -> tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]]:
        """Horizontal unit vectors along and across the waves."""
        b = np.deg2rad(float(self.sea_state.get("direction_deg", 0.0)))
        return np.array([np.cos(b), np.sin(b)]), np.array([-np.sin(b), np.cos(b)])

    @property
    def spot_name(self) -> str:
        """Name of the hot spot whose stress is shown."""
        return self.fatigue.hot_spots.name[self.stress_spot]


@dataclass
class ReportCollector:
    """Keeps of every block what a report shows.

    The stress of all member ends is kept until the most damaged one is known: 32 bytes per sample and end.
    """

    tower_top_coordinate: int
    _blocks: dict[str, list[Any]] = field(default_factory=dict)
    _next: dict[str, int] = field(default_factory=dict)
    _dt: dict[str, float] = field(default_factory=dict)
    _complete: bool = False

    def add(self, block: Block) -> None:
        """Take a block of any stream; others than those shown are ignored.

        Raises
        ------
        ComputationError
            If it is not the next of its stream.
        """
        if isinstance(block, ElevationBlock):
            self._keep("elevation", block, (block.first_order[:, 0].copy(), block.total[:, 0].copy()))
        elif isinstance(block, LoadBlock):
            self._keep("load", block, (block.nodal[:, :, :3].sum(axis=1),))
        elif isinstance(block, WrenchBlock):
            self._keep("wrench", block, (block.wrench.copy(),))
        elif isinstance(block, ModalBlock):
            top = self.tower_top_coordinate
            self._keep("modal", block, (block.displacement[:, top : top + 3].copy() if top >= 0 else None,))
        elif isinstance(block, StressBlock):
            self._keep("stress", block, (block.axial, block.bending_y, block.bending_z, block.von_mises))
        elif isinstance(block, EnergyBlock):
            parts = block.potential_substructure.copy(), block.kinetic_substructure.copy()
            self._keep("energy", block, (block.potential.copy(), block.kinetic.copy(), *parts))

    def _keep(self, stream: str, block: Block, parts: tuple[Any, ...]) -> None:
        if block.sequence != self._next.get(stream, 0):
            expected = self._next.get(stream, 0)
            raise ComputationError(
                f"{stream} sequence {block.sequence}: expected {expected}; the stream has a gap."
            )
        self._next[stream] = block.sequence + 1
        self._complete = self._complete or (stream == "stress" and block.last)
        self._dt[stream] = block.dt
        self._blocks.setdefault(stream, []).append(parts)

    def finish(
        self,
        *,
        case: Mapping[str, Any],
        reduced: ReducedDescription,
        fatigue: FatigueResult,
        geometry: Geometry | None = None,
        sea_state: Mapping[str, Any] | None = None,
        versions: Mapping[str, str] | None = None,
    ) -> ReportData:
        """Put the blocks together.

        Raises
        ------
        ComputationError
            If a stream has not delivered anything.
        """
        end = fatigue.worst_end
        spots, spot = fatigue.hot_spots, int(fatigue.worst_spot[end])
        first, total = self._series("elevation", 2)
        (force,) = self._series("load", 1)
        (top,) = self._series("modal", 1)
        potential, kinetic, *parts = self._series("energy", 4)
        blocks = self._parts("stress")
        normal = np.concatenate([spots.stress(spot, *parts[:3]) for parts in blocks])
        von_mises = np.concatenate([parts[3][:, end] for parts in blocks])
        # A recording that broke off holds streams of unequal length: what all of them have is shown.
        wrench = self._series("wrench", 1)[0] if "wrench" in self._blocks else None
        waves = slice(min(len(total), len(force), len(force if wrench is None else wrench)))
        response = slice(min(len(normal), len(potential), len(normal if top is None else top)))
        return ReportData(
            case=case,
            sea_state=sea_state or {},
            versions=versions or {},
            reduced=reduced,
            fatigue=fatigue,
            geometry=geometry,
            wave_time=np.arange(waves.stop) * self._dt["elevation"],
            elevation_first=first[waves],
            elevation_total=total[waves],
            wave_force=force[waves],
            time=np.arange(response.stop) * self._dt["stress"],
            tower_top=None if top is None else top[response],
            stress_end=end,
            stress_spot=spot,
            stress_normal=normal[response],
            stress_von_mises=von_mises[response],
            potential=potential[response],
            kinetic=kinetic[response],
            potential_substructure=parts[0][response],
            kinetic_substructure=parts[1][response],
            tower_top_load=None if wrench is None else wrench[waves],
            complete=self._complete,
        )

    def _parts(self, stream: str) -> list[Any]:
        if stream not in self._blocks:
            raise ComputationError(f"{stream}: no block has arrived, there is nothing to report.")
        return self._blocks[stream]

    def _series(self, stream: str, n: int) -> tuple[Any, ...]:
        blocks = self._parts(stream)
        return tuple(
            None if blocks[0][i] is None else np.concatenate([parts[i] for parts in blocks]) for i in range(n)
        )
