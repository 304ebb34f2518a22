"""Flow control: a producer keeps at most a window of blocks in flight, a consumer acknowledges each.

In real time a producer waits for nobody who has begun: the window then says from where on a consumer is late,
and the history of the transport how late it may be.
Pure bookkeeping, no ROS: the node base wires it to ``/owt/credit``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from owt_model.config import CaseConfig
from owt_model.errors import InputError, StreamError

__all__ = ["CreditWindow", "Flow", "StreamGuard", "flow_of"]


#: Wall time in s between two acknowledgements in real time, where they only tell who is late.
ACKNOWLEDGE_S = 0.2


@dataclass(frozen=True)
class Flow:
    """How the streams of a graph flow.

    Attributes
    ----------
    window : int
        Blocks in flight beyond which a producer waits, or a consumer is late.
    most : int
        Most blocks in flight that the transport keeps.
    waits : bool
        Whether a producer waits.
    every : int
        Blocks that a consumer acknowledges at a time.
    """

    window: int = 1
    most: int = 1
    waits: bool = True
    every: int = 1


def flow_of(case: CaseConfig) -> Flow:
    """Return the flow of a case: credits at full speed, a deep history in real time."""
    stream = case.stream
    if stream.rate == 0.0:
        return Flow(stream.window, stream.window)
    per_second = stream.rate / (stream.block * case.time.dt_s)
    every = max(1, math.floor(ACKNOWLEDGE_S * per_second))
    window = max(stream.window, 2 * every)
    return Flow(window, window + math.ceil(stream.late_s * per_second), waits=False, every=every)


class CreditWindow:
    """What a producer knows about one of its streams.

    Parameters
    ----------
    flow : Flow
        Of the graph.
    consumers : iterable of str
        Names of the nodes that acknowledge; the slowest counts. Without any, the window is always open.
    """

    def __init__(self, flow: Flow, consumers: Iterable[str]) -> None:
        if flow.window < 1:
            raise InputError("stream.window", flow.window, "must be at least 1", "Use 4.")
        self._flow = flow
        self._acknowledged = dict.fromkeys(consumers, 0)
        self._sent = 0

    @property
    def sent(self) -> int:
        """Number of blocks sent, which is the sequence of the next one."""
        return self._sent

    @property
    def in_flight(self) -> int:
        """Blocks sent that the slowest consumer has not acknowledged."""
        return self._sent - min(self._acknowledged.values(), default=self._sent)

    @property
    def is_open(self) -> bool:
        """Whether one more block may be sent.

        In real time too the second block waits until every consumer has acknowledged the first: only then is
        each known to receive, since discovery ends on either side at a time of its own.
        """
        if self._flow.waits:
            return self.in_flight < self._flow.window
        return self._sent == 0 or min(self._acknowledged.values(), default=1) > 0

    @property
    def behind(self) -> int:
        """Blocks by which the slowest consumer exceeds the window: it is late."""
        return max(0, self.in_flight - self._flow.window)

    @property
    def lost(self) -> int:
        """Blocks that the slowest consumer can no longer get: the transport has dropped them."""
        return max(0, self.in_flight - self._flow.most)

    @property
    def acknowledged(self) -> int:
        """Blocks that every consumer has acknowledged."""
        return self._sent - self.in_flight

    @property
    def slowest(self) -> str:
        """Name of the consumer that is furthest behind; empty without consumers."""
        return min(self._acknowledged, key=lambda name: self._acknowledged[name], default="")

    def send(self, sequence: int) -> None:
        """Count one block as sent.

        Raises
        ------
        StreamError
            If the window is closed or `sequence` is not the next number.
        """
        if sequence != self._sent:
            raise StreamError(f"block {sequence} cannot be sent: the next one is {self._sent}")
        if not self.is_open:
            raise StreamError(f"block {sequence} cannot be sent: {self.in_flight} blocks are in flight")
        self._sent += 1

    def acknowledge(self, consumer: str, sequence: int) -> bool:
        """Take the credit that `consumer` gives for all blocks up to `sequence`; tell if it was news.

        Credits of unknown consumers, repeated ones and those for blocks that were never sent (left over
        from an earlier stream) are no news.
        """
        if consumer not in self._acknowledged or not self._acknowledged[consumer] <= sequence < self._sent:
            return False
        self._acknowledged[consumer] = sequence + 1
        return True


class StreamGuard:
    """What a consumer knows about one incoming stream: which block comes next.

    Parameters
    ----------
    topic : str
        Name used in messages.
    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._next = 0
        self._next_time_ns = 0
        self._finished = False

    @property
    def received(self) -> int:
        """Number of blocks received in order."""
        return self._next

    @property
    def finished(self) -> bool:
        """Whether the block marked `last` has arrived."""
        return self._finished

    def check(self, *, sequence: int, time_ns: int, end_ns: int, last: bool) -> None:
        """Accept the next block of the stream.

        Parameters
        ----------
        sequence : int
            Number of the block.
        time_ns, end_ns : int
            Simulated time of its first sample and of the sample that follows its last one, in ns.
        last : bool
            Whether it ends the stream.

        Raises
        ------
        StreamError
            If a block is missing, repeated, out of order, or comes after the end.
        """
        expected, got = self._next, f"{self._topic}: block {sequence} arrived"
        if self._finished:
            raise StreamError(f"{got} after the block marked last ({expected - 1})")
        if sequence > expected:
            raise StreamError(f"{got}, {expected} was expected: gap of {sequence - expected}")
        if sequence < expected:
            raise StreamError(f"{got}, {expected} was expected: duplicate or out of order")
        if sequence > 0 and time_ns != self._next_time_ns:
            raise StreamError(
                f"{got} with time {time_ns} ns, {self._next_time_ns} ns was expected: the clock jumped"
            )
        self._next += 1
        self._next_time_ns = end_ns
        self._finished = last
