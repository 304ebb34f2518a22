"""How far numbers that were computed again are from those recorded: equal to the bit, or within rounding."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from owt_model.errors import ComputationError

__all__ = ["TOLERANCE", "Deviation"]

#: Of the largest value of a quantity. Another machine's BLAS rounds otherwise, and stress passes through
#: eigenvectors: 6e-10 was seen between two machines.
TOLERANCE = 1e-8


@dataclass
class Deviation:
    """Compares block by block and keeps the largest difference.

    Attributes
    ----------
    values : int
        How many were compared.
    largest : float
        Largest difference relative to the largest value of its quantity so far; 0 where all are equal.
    """

    tolerance: float = TOLERANCE
    values: int = 0
    largest: float = 0.0
    _scale: dict[str, float] = field(default_factory=dict)

    def compare(
        self, place: str, sequence: int, name: str, recorded: Float[np.ndarray, ...], again: np.ndarray
    ) -> None:
        """Compare one array of a block.

        Parameters
        ----------
        place, sequence, name : str, int, str
            Topic, block and quantity, for the error.
        recorded, again : float arrays
            What was recorded and what was computed.

        Raises
        ------
        ComputationError
            If they differ by more than the tolerance.
        """
        where = f"{place}, block {sequence}"
        if recorded.shape != again.shape:
            raise ComputationError(
                f"{where}: {name} is recorded as {list(recorded.shape)} values, computed again as "
                f"{list(again.shape)}"
            )
        self.values += recorded.size
        if not recorded.size:
            return
        key = f"{place}.{name}"
        scale = self._scale[key] = max(self._scale.get(key, 0.0), float(np.abs(recorded).max()))
        if np.array_equal(recorded, again):
            return
        error = np.abs(again - recorded)
        at = np.unravel_index(int(np.argmax(np.where(np.isnan(error), np.inf, error))), error.shape)
        worst = float(error[at])
        if not worst <= self.tolerance * scale:
            raise ComputationError(
                f"{where}: {name} {[int(i) for i in at]} is recorded as {recorded[at]:.17g} and computed "
                f"again as {again[at]:.17g}, further apart than {self.tolerance:g} of the largest value: the "
                "bag was changed, or made by a version that computes otherwise"
            )
        self.largest = max(self.largest, worst / scale)

    def __str__(self) -> str:
        """Return what was found, as a part of a sentence."""
        if self.largest == 0.0:
            return "bit for bit"
        return f"to {self.largest:.1g} of the largest value"
