"""The one error that bad input raises, and those that a computation and a stream raise."""

from __future__ import annotations

from typing import Any

__all__ = ["ComputationError", "InputError", "OwtError", "StreamError"]


class OwtError(Exception):
    """Base of every error this project raises on purpose; edges print it as one line."""


class InputError(OwtError, ValueError):
    """A value that the model refuses.

    Parameters
    ----------
    field : str
        Path of the offending value as the user wrote it, e.g. ``sea_state.hs_m``.
    value : object
        What was given.
    limit : str
        The rule that it breaks, e.g. ``must be > 0 m``.
    remedy : str
        What to do about it.
    """

    def __init__(self, field: str, value: Any, limit: str, remedy: str) -> None:
        self.field, self.value, self.limit, self.remedy = field, value, limit, remedy
        shown = repr(value)
        if len(shown) > 120:
            shown = shown[:117] + "..."
        super().__init__(f"{field} = {shown}: {limit}. {remedy}")


class ComputationError(OwtError, ArithmeticError):
    """A computation that did not produce a trustworthy number (no convergence, NaN, a gap)."""


class StreamError(ComputationError):
    """What a computation needs did not arrive, or could not be recorded (a gap, a dead node, a full disk)."""
