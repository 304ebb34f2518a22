"""Wall time: ties simulated time to it, and says when something has been waited for too long."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Pace", "Patience"]


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

    def restart(self, time_ns: int | None = None) -> None:
        """Count anew, from simulated time `time_ns` being now, or from the next block on."""
        self._origin = None if time_ns is None else (self._clock(), time_ns)

    def is_due(self, time_ns: int) -> bool:
        """Tell whether the moment of simulated time `time_ns` has come; the first one asked for has."""
        return self.wait_s(time_ns) <= 0.0

    def wait_s(self, time_ns: int) -> float:
        """Wall time in s until the moment of simulated time `time_ns`; the first one asked for is now."""
        if self._rate == 0.0:
            return 0.0
        if self._origin is None:
            self._origin = self._clock(), time_ns
        then, origin = self._origin
        return (time_ns - origin) * 1e-9 / self._rate - (self._clock() - then)

    def period_s(self, step_s: float) -> float:
        """Wall time in s that `step_s` of simulated time takes; 0 without a limit."""
        return step_s / self._rate if self._rate > 0.0 else 0.0


class Patience:
    """Says when something has been waited for too long.

    Parameters
    ----------
    limit_s : float
        Longest wait in s.
    clock : callable
        Wall time in s.
    """

    def __init__(self, limit_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self.limit_s, self._clock = limit_s, clock
        self._since: float | None = None

    def restart(self) -> None:
        """Begin anew: what was waited for has moved."""
        self._since = None

    def is_over(self, *, waiting: bool) -> bool:
        """Tell whether the wait has been too long; a wait begins with the first call that says so."""
        if not waiting:
            self._since = None
            return False
        now = self._clock()
        self._since = now if self._since is None else self._since
        return now - self._since > self.limit_s
