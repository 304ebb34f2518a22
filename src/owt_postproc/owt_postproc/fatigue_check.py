"""The counting of a bag's stress against the running fatigue that was recorded with it."""

from __future__ import annotations

from typing import Any

from owt_model.contracts import FatigueBlock
from owt_model.errors import ComputationError
from owt_postproc.deviation import Deviation
from owt_ros import decode

__all__ = ["FatigueCheck"]

NAMES = ("damage", "total_stress", "max_range", "cycles")
TOPIC = "/owt/fatigue"


class FatigueCheck:
    """Compares every block, in whatever order its two sides come.

    Parameters
    ----------
    stress : Deviation, optional
        Of the stress that is counted, where it was computed again. Rounding opens and closes cycles of no
        size: their number is compared only where the stress is that of the run to the last bit.

    Attributes
    ----------
    deviation : Deviation
        What was found.
    blocks : int
        How many were compared.
    """

    def __init__(self, stress: Deviation | None = None) -> None:
        self.deviation = Deviation()
        self.blocks = 0
        self._stress = stress or Deviation()
        self._recorded: dict[int, Any] = {}
        self._counted: dict[int, FatigueBlock] = {}

    def recorded(self, message: Any) -> None:
        """Take a message of the fatigue topic."""
        sequence = int(message.sequence)
        if sequence in self._counted:
            self._compare(message, self._counted.pop(sequence))
        else:
            self._recorded[sequence] = message

    def counted(self, block: FatigueBlock) -> None:
        """Take what the counting gives for a block."""
        if block.sequence in self._recorded:
            self._compare(self._recorded.pop(block.sequence), block)
        else:
            self._counted[block.sequence] = block

    def _compare(self, message: Any, block: FatigueBlock) -> None:
        recorded = decode.to_fatigue(message, dt=block.dt)
        head = ("start", "last", "samples_counted", "sn_curve")
        for name in head:
            if getattr(recorded, name) != getattr(block, name):
                raise ComputationError(
                    f"{TOPIC}, block {block.sequence}: {name} is recorded as {getattr(recorded, name)} and "
                    f"counted again as {getattr(block, name)}"
                )
        for name in NAMES if self._stress.largest == 0.0 else NAMES[:-1]:
            self.deviation.compare(TOPIC, block.sequence, name, getattr(recorded, name), getattr(block, name))
        self.blocks += 1

    def finish(self, *, complete: bool) -> None:
        """Look back; `complete` says that all of the stress was counted.

        Raises
        ------
        ComputationError
            If fatigue and stress of a complete bag do not go together block by block.
        """
        if not complete or not self.blocks:
            return
        for found, missing, other in (
            (self._recorded, "stress", "fatigue"),
            (self._counted, "fatigue", "stress"),
        ):
            if found:
                raise ComputationError(
                    f"{TOPIC}, block {min(found)}: the bag has no {missing} that goes with its {other}"
                )
