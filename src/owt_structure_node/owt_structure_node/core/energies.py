"""Energies of the response: per substructure, beside the total."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_structure_node.core.assembly import Assembly

__all__ = ["SUBSTRUCTURES", "Part", "split"]

#: Parts of the structure: jacket with supports and interface; transition piece, tower and rotor-nacelle.
SUBSTRUCTURES = ("jacket", "tower")


@dataclass(frozen=True)
class Part:
    """The part of a reduced structure that has the fewer coordinates; the energy of the other is the rest.

    Attributes
    ----------
    place : int
        Which of :data:`SUBSTRUCTURES` it is.
    coordinate : int array [own]
        Its generalised coordinates.
    stiffness, mass : float arrays [own, own]
        Its matrices over them.
    """

    place: int
    coordinate: Int[np.ndarray, " own"]
    stiffness: Float[np.ndarray, "own own"]
    mass: Float[np.ndarray, "own own"]

    def share(
        self,
        matrix: Float[np.ndarray, "own own"],
        coordinate: Float[np.ndarray, "row coordinate"],
        total: Float[np.ndarray, " row"],
        improvement: Float[np.ndarray, " row"] | float = 0.0,
    ) -> Float[np.ndarray, "row 2"]:
        """Energies u' matrix u / 2 of :data:`SUBSTRUCTURES`, which add up to `total`.

        Parameters
        ----------
        matrix : float array [own, own]
            Stiffness or mass.
        coordinate : float array [row, coordinate]
            Displacements or velocities.
        total : float array [row]
            Energy of the whole in J.
        improvement : float array [row], optional
            What static improvement adds to the jacket, in the total already.
        """
        return self.share_of(matrix, coordinate[:, self.coordinate], total, improvement)

    def share_of(
        self,
        matrix: Float[np.ndarray, "own own"],
        motion: Float[np.ndarray, "row own"],
        total: Float[np.ndarray, " row"],
        improvement: Float[np.ndarray, " row"] | float = 0.0,
    ) -> Float[np.ndarray, "row 2"]:
        """The same from the displacements or velocities of the part's own coordinates."""
        own = 0.5 * np.einsum("rc,rc->r", motion @ matrix, motion)
        if self.place == 0:
            own += improvement
        parts = (own, total - own) if self.place == 0 else (total - own, own)
        return np.stack(parts, axis=1)


def split(assembly: Assembly, shapes: Float[np.ndarray, "dof coordinate"] | None, n_coordinates: int) -> Part:
    """Take the smaller part out of a structure.

    In every reduction the generalised coordinates are the transition piece's six motions, those inside the
    jacket, and the tower's; in the unreduced model those of transition piece and tower are reported.

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    shapes : float array [dof, coordinate], optional
        Basis of a reduced model.
    n_coordinates : int
        Number of generalised coordinates.
    """
    n = assembly.internal
    above = assembly.mesh.n_dof - n - 6
    if shapes is None or n_coordinates > 2 * above:
        upper = np.concatenate([np.arange(6), np.arange(n_coordinates - above, n_coordinates)])
        matrices = (assembly.upper_stiffness[n:, n:], assembly.upper_mass[n:, n:])
        return Part(1, upper, *(matrix.toarray() for matrix in matrices))
    own = np.arange(n_coordinates - above)
    below = np.ascontiguousarray(shapes[:, own])
    return Part(0, own, *(below.T @ (a @ below) for a in (assembly.jacket_stiffness, assembly.jacket_mass)))
