"""Which instant to show: blocks of samples arrive in steps, the picture moves with wall time.

Pure bookkeeping. A few blocks are kept. In a run at some rate they are played at the speed at which they
follow each other; in a run at full speed the picture leaps from one of the newest to the next.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from owt_ros.topics import Topic
from owt_ros.wire import Head

__all__ = ["KEPT", "Pairing", "Playhead"]

#: Blocks that are kept to be played.
KEPT = 4
#: Blocks whose arrival gives the speed.
_ARRIVALS = 8


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

    Blocks may come in bunches, so their speed is taken over several of them, and the time never jumps back
    within a run: it goes at that speed, no further than the newest block reaches and no earlier than the
    oldest one that is kept.

    Parameters
    ----------
    clock : callable
        Wall time in s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=_ARRIVALS)
        self._spans: deque[tuple[int, int]] = deque(maxlen=KEPT)
        self._at = 0.0
        self._looked = 0.0

    @property
    def speed(self) -> float:
        """Simulated seconds per second of wall time; 1 until two blocks have come."""
        (first, start), (last, end) = self._arrivals[0], self._arrivals[-1]
        return (end - start) * 1e-9 / max(last - first, 1e-3) if end > start else 1.0

    def arrive(self, start_ns: int, end_ns: int) -> bool:
        """Know of a block with its first and last samples at these times; tell if a run begins."""
        begins = not self._spans or start_ns <= self._spans[-1][0]
        if begins:
            self._arrivals.clear()
            self._spans.clear()
            self._at, self._looked = float(start_ns), self._clock()
        self._arrivals.append((self._clock(), start_ns))
        self._spans.append((start_ns, end_ns))
        return begins

    @property
    def time_ns(self) -> int:
        """Simulated time in ns that is due now, within the blocks that are kept; 0 before the first."""
        if not self._spans:
            return 0
        now = self._clock()
        due = self._at + (now - self._looked) * self.speed * 1e9
        self._at, self._looked = min(max(due, float(self._spans[0][0])), float(self._spans[-1][1])), now
        return round(self._at)
