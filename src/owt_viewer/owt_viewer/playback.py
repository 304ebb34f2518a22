"""Which instant to show: blocks of samples arrive in steps, the picture moves with wall time.

Pure bookkeeping. Only the newest block is kept. In a run at some rate it is played at the speed at
which blocks follow each other; in a run at full speed the next block is there long before its end.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from owt_ros.topics import Topic
from owt_ros.wire import Head

__all__ = ["Pairing", "Playhead"]


class Pairing:
    """Puts blocks of two streams together that cover the same samples; the newest pair counts.

    Streams of best effort may lose a block: its partner then waits in vain and is dropped by the next one.
    """

    def __init__(self) -> None:
        self._waiting: dict[Topic, tuple[Head, bytes]] = {}

    def offer(self, topic: Topic, head: Head, cdr: bytes) -> dict[Topic, bytes] | None:
        """Take a block of a stream; return the serialised pair if this one completes it."""
        self._waiting[topic] = (head, cdr)
        heads = [known for known, _ in self._waiting.values()]
        if len(heads) < 2 or heads[0] != heads[1]:
            return None
        pair = {key: data for key, (_, data) in self._waiting.items()}
        self._waiting.clear()
        return pair


class Playhead:
    """Simulated time to show.

    Parameters
    ----------
    clock : callable
        Wall time in s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._start = self._end = 0
        self._arrived: float | None = None
        self.speed = 1.0

    def arrive(self, start_ns: int, end_ns: int) -> None:
        """Go to a block whose first and last samples are at `start_ns` and `end_ns` of simulated time."""
        now = self._clock()
        if self._arrived is not None and start_ns > self._start:
            self.speed = (start_ns - self._start) * 1e-9 / max(now - self._arrived, 1e-6)
        elif self._arrived is not None:
            self.speed = 1.0  # another run has begun
        self._start, self._end, self._arrived = start_ns, end_ns, now

    @property
    def time_ns(self) -> int:
        """Simulated time in ns that is due now, within the newest block; 0 before the first."""
        if self._arrived is None:
            return 0
        passed = round((self._clock() - self._arrived) * self.speed * 1e9)
        return min(self._start + passed, self._end)
