"""Ties simulated time to wall time, where a graph is not to run as fast as it can."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Pace"]


class Pace:
    """Says when a block is due.

    Parameters
    ----------
    rate : float
        Simulated seconds per second of wall time; 0 for no limit.
    clock : callable
        Wall time in s.
    """

    def __init__(self, rate: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._clock = rate, clock
        self._origin: tuple[float, int] | None = None

    def restart(self) -> None:
        """Count anew from the next block on."""
        self._origin = None

    def is_due(self, time_ns: int) -> bool:
        """Tell whether the moment of simulated time `time_ns` has come; the first one asked for has."""
        if self._rate == 0.0:
            return True
        if self._origin is None:
            self._origin = self._clock(), time_ns
        then, origin = self._origin
        return (self._clock() - then) * self._rate >= (time_ns - origin) * 1e-9

    def period_s(self, step_s: float) -> float:
        """Wall time in s that `step_s` of simulated time takes; 0 without a limit."""
        return step_s / self._rate if self._rate > 0.0 else 0.0
