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

from owt_model.contracts import LoadRows
from owt_model.errors import InputError
from owt_model.mesh import Mesh
from owt_structure_node.core.pieces import Piece
from owt_structure_node.core.response_model import ResponseModel
from owt_wave_node.core.stage import WaveStage

__all__ = ["NAMES", "STRESS", "SeriesKeeper"]

STRESS = "stress "
ENERGIES = tuple(f"{kind}{of}" for kind in ("potential", "kinetic") for of in ("", "_mode", "_substructure"))
SURFACE = ("elevation_first", "elevation")
NAMES = (*SURFACE, "force", "tower_top", "coordinate", *ENERGIES)


class SeriesKeeper:
    """Collects the series asked for, piece by piece.

    Parameters
    ----------
    names : iterable of str
        What to keep.
    mesh : Mesh
        Of the structure, for the names of member ends.
    model : ResponseModel
        What turns the motion of the modes into the series.

    Raises
    ------
    InputError
        If a name is none of these.
    """

    def __init__(self, names: Iterable[str], mesh: Mesh, model: ResponseModel) -> None:
        self._parts: dict[str, list[np.ndarray]] = {name: [] for name in names}
        self._model = model
        self._end: dict[str, int] = {}
        place = {name: i for i, name in enumerate(mesh.end_name)}
        for name in self._parts:
            if name.startswith(STRESS) and name.removeprefix(STRESS) in place:
                self._end[name] = place[name.removeprefix(STRESS)]
            elif name not in NAMES:
                raise InputError(
                    "keep", name, "is no series of a case", f"Use {', '.join(NAMES)}, or 'stress END'."
                )

    def add_surface(self, wave: WaveStage, window: int) -> None:
        """Take the elevation in a window of the record, where it is asked for."""
        for name in SURFACE:
            if name in self._parts:
                self._parts[name].append(wave.surface(window)[SURFACE.index(name)].T.copy())

    def add(self, load: LoadRows, piece: Piece) -> None:
        """Take what is asked for from one piece."""
        for name, parts in self._parts.items():
            if name not in SURFACE:
                parts.append(np.array(self._take(name, load, piece)))

    def _take(self, name: str, load: LoadRows, piece: Piece) -> np.ndarray:
        motion, model = piece.motion, self._model
        if name in self._end:
            return piece.stress[self._end[name] :: len(piece.stress) // 4].T
        if name == "force":
            return np.asarray(load.nodal[:, :3].sum(axis=0).T)
        if name == "coordinate":
            return np.asarray(motion.displacement @ model.coordinate)
        if name == "tower_top":
            top = model.description.tower_top_coordinate
            return np.asarray(motion.displacement @ model.coordinate[:, top : top + 3])
        reported = slice(0, len(model.description.frequency_hz))
        if name == "potential_mode":
            energy = 0.5 * model.oscillators.stiffness * motion.displacement**2
            return np.asarray(energy[:, reported])
        if name == "kinetic_mode":
            return np.asarray(0.5 * motion.velocity[:, reported] ** 2)
        return np.asarray(getattr(piece, name))

    def series(self) -> dict[str, np.ndarray]:
        """The series, over the whole record."""
        return {name: np.concatenate(parts) for name, parts in self._parts.items()}
