"""Total stress of many sea states on one or several structures: loads once per sea, and no counting.

The sum of range times count of a rainflow count is half the total variation of the signal, exactly; so the
thesis' total stress (chapter 5) of von Mises stress needs no count.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from owt_campaign.engine import SharedModel
from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_structure_node.core.pieces import Pieces
from owt_wave_node.core.stage import WaveStage

__all__ = ["PIECE", "TotalStress", "total_stress"]

#: Load samples worked on at a time.
PIECE = 250


class TotalStress:
    """Half the total variation of stresses that come piece by piece: their sum of range times count."""

    def __init__(self) -> None:
        self._sum: Float[np.ndarray, " signal"] | None = None
        self._last: Float[np.ndarray, "signal 1"] | None = None

    def add(self, stress: Float[np.ndarray, "signal sample"]) -> None:
        """Take the next samples of every signal."""
        before = stress[:, :1] if self._last is None else self._last
        moved = np.abs(np.diff(stress, axis=1, prepend=before)).sum(axis=1)
        self._sum = moved if self._sum is None else self._sum + moved
        self._last = stress[:, -1:].copy()

    @property
    def value(self) -> Float[np.ndarray, " signal"]:
        """Sum of range times count of each signal, in its unit."""
        if self._sum is None:
            raise ValueError("no stress was added")
        return 0.5 * self._sum


def total_stress(case: CaseConfig, models: Mapping[str, SharedModel]) -> dict[str, Float[np.ndarray, " end"]]:
    """Sum of range times count of the von Mises stress in Pa at each member end, for each structure.

    Parameters
    ----------
    case : CaseConfig
        The sea; its structure counts for nothing.
    models : mapping
        Structures of one geometry, whatever their stiffness, with their load vectors, from
        :func:`owt_campaign.engine.prepare_model`.

    Raises
    ------
    InputError
        If a model has no response of its own, since its reduction needs load vectors, or another geometry.
    ComputationError
        If a result cannot be trusted.
    """
    first = next(iter(models.values()))
    wave = WaveStage(case, first.mesh, hydro=first.hydro)
    found = {}
    for name, model in models.items():
        if model.response is None:
            raise InputError("model", name, "has no response of its own", "Give prepare_model a load basis.")
        if not np.array_equal(model.mesh.node_position, first.mesh.node_position):
            raise InputError("model", name, "has another geometry", "Evaluate it apart.")
        total, pieces, state = TotalStress(), None, None
        for window in range(len(wave.windows)):
            for load in wave.load_rows(window, PIECE):
                pieces = Pieces(model.response, load) if pieces is None else pieces
                state, piece = pieces.step(state, load)
                total.add(piece.von_mises)
        found[name] = total.value
    return found
