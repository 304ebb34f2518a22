"""Flow control: a producer keeps at most a window of blocks in flight, a consumer acknowledges each.

Pure bookkeeping, no ROS: the node base wires it to ``/owt/credit``.
"""

from __future__ import annotations

from collections.abc import Iterable

from owt_model.errors import InputError, StreamError

__all__ = ["CreditWindow", "StreamGuard"]


class CreditWindow:
    """What a producer knows about one of its streams.

    Parameters
    ----------
    window : int
        Most blocks in flight.
    consumers : iterable of str
        Names of the nodes that acknowledge; the slowest counts. Without any, the window is always open.
    """

    def __init__(self, window: int, consumers: Iterable[str]) -> None:
        if window < 1:
            raise InputError("stream.window", window, "must be at least 1", "Use 4.")
        self._window = window
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
        """Whether one more block may be sent."""
        return self.in_flight < self._window

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
