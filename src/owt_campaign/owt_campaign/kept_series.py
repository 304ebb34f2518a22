"""Series of a case that are kept on request.

- ``elevation``, ``elevation_first`` [load sample, gauge]: elevation in m, total and of the first order
- ``force`` [load sample, 3]: sum of the nodal wave loads in N
- ``tower_top`` [sample, 3]: displacement of the tower top in m
- ``coordinate`` [sample, coordinate]: generalised displacements
- ``potential``, ``kinetic`` [sample]: energies in J
- ``potential_mode``, ``kinetic_mode`` [sample, mode]: energies in J of the modes of the model
- ``potential_substructure``, ``kinetic_substructure`` [sample, part]: energies in J of jacket and tower
- ``stress END`` [sample, 4]: axial, bending_y, bending_z and von Mises stress in Pa of the member end END

Samples are those of the integration, ``structure.dt_s`` apart, load samples are ``time.dt_s`` apart; both
begin at t = 0.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from owt_model.contracts import LoadBlock, ReducedDescription
from owt_model.errors import InputError
from owt_model.mesh import Mesh
from owt_structure_node.core.stage import Response
from owt_wave_node.core.stage import WaveStage

__all__ = ["NAMES", "STRESS", "SeriesKeeper"]

STRESS = "stress "
ENERGIES = tuple(f"{kind}{of}" for kind in ("potential", "kinetic") for of in ("", "_mode", "_substructure"))
NAMES = ("elevation", "elevation_first", "force", "tower_top", "coordinate", *ENERGIES)


class SeriesKeeper:
    """Collects the series asked for, block by block.

    Parameters
    ----------
    names : iterable of str
        What to keep.
    mesh : Mesh
        Of the structure, for the names of member ends.

    Raises
    ------
    InputError
        If a name is none of these.
    """

    def __init__(self, names: Iterable[str], mesh: Mesh) -> None:
        self._parts: dict[str, list[np.ndarray]] = {name: [] for name in names}
        self._end = {}
        place = {name: i for i, name in enumerate(mesh.end_name)}
        for name in self._parts:
            if name.startswith(STRESS) and name.removeprefix(STRESS) in place:
                self._end[name] = place[name.removeprefix(STRESS)]
            elif name not in NAMES:
                raise InputError(
                    "keep", name, "is no series of a case", f"Use {', '.join(NAMES)}, or 'stress END'."
                )

    def add(
        self, wave: WaveStage, block: int, load: LoadBlock, out: Response, description: ReducedDescription
    ) -> None:
        """Take what is asked for from one block."""
        for name, parts in self._parts.items():
            parts.append(self._take(name, wave, block, load, out, description).copy())

    def _take(
        self,
        name: str,
        wave: WaveStage,
        block: int,
        load: LoadBlock,
        out: Response,
        description: ReducedDescription,
    ) -> np.ndarray:
        if name in self._end:
            stress, end = out.stress, self._end[name]
            four = (stress.axial, stress.bending_y, stress.bending_z, stress.von_mises)
            return np.stack([part[:, end] for part in four], axis=1)
        if name == "force":
            return np.asarray(load.nodal[:, :, :3].sum(axis=1))
        if name.startswith("elevation"):
            elevation = wave.elevation_block(block)
            return elevation.total if name == "elevation" else elevation.first_order
        if name == "coordinate":
            return out.modal.displacement
        if name == "tower_top":
            top = description.tower_top_coordinate
            return out.modal.displacement[:, top : top + 3]
        return np.asarray(getattr(out.energy, name))

    def series(self) -> dict[str, np.ndarray]:
        """The series, over the whole record."""
        return {name: np.concatenate(parts) for name, parts in self._parts.items()}
