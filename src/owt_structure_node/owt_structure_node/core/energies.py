"""Energies of the response: total, per mode, and per substructure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_array

from owt_structure_node.core.assembly import Assembly

__all__ = ["SUBSTRUCTURES", "UpperPart", "upper_part"]

#: Parts of the structure: jacket with supports and interface; transition piece, tower and rotor-nacelle.
SUBSTRUCTURES = ("jacket", "tower")


@dataclass(frozen=True)
class UpperPart:
    """What stands on the jacket, over the six motions of the transition piece and those of the tower.

    In every reduction, and in the unreduced model, these motions are generalised coordinates: the first six
    and the last ones. Its matrices are sparse, so that its energy costs little; that of the jacket is the
    rest.
    """

    stiffness: csr_array
    mass: csr_array

    def energy(
        self, matrix: csr_array, coordinate: Float[np.ndarray, "row coordinate"]
    ) -> Float[np.ndarray, " row"]:
        """U' matrix u / 2 of the part's motions u among all generalised coordinates."""
        above = matrix.shape[0] - 6
        motion = np.hstack([coordinate[:, :6], coordinate[:, coordinate.shape[1] - above :]]).T
        motion = np.ascontiguousarray(motion)
        return np.asarray(0.5 * np.einsum("cr,cr->r", motion, matrix @ motion))

    def share(
        self,
        matrix: csr_array,
        coordinate: Float[np.ndarray, "row coordinate"],
        total: Float[np.ndarray, " row"],
    ) -> Float[np.ndarray, "row 2"]:
        """Energy of each of :data:`SUBSTRUCTURES`, which add up to `total`."""
        upper = self.energy(matrix, coordinate)
        return np.stack([total - upper, upper], axis=1)


def upper_part(assembly: Assembly) -> UpperPart:
    """Take the upper part out of an assembly."""
    n = assembly.internal
    return UpperPart(
        csr_array(assembly.upper_stiffness[n:, n:]),
        csr_array(assembly.upper_mass[n:, n:]),
    )
