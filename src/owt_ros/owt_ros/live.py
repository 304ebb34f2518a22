"""Samples from outside inside a node: waited for, gone on without where the case says so, and reported."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from owt_model.errors import StreamError
from owt_model.live_config import LiveSamples
from owt_model.live_samples import SampleBuffer
from owt_ros.lifecycle import StageNode
from owt_ros.pace import Pace, Patience
from owt_ros.topics import Topic

__all__ = ["LiveInput"]

#: Longest time in s between two looks at what waits.
TICK_S = 0.25
#: What is said of samples that were made up, and of messages that were dropped.
_SAID = {
    "filled": "no message gives them, so they were made up",
    "late": "their time was counted before they came, so they were dropped",
    "repeated": "another message has their stamp, so they were dropped",
    "refused": "they cannot be samples, so they were dropped",
}


class LiveInput:
    """A topic that somebody outside the graph publishes, block by block.

    A block is taken when the messages reach its end. If the highest stamp does not rise for `timeout_s` of
    wall time while a block waits, that is an error, or the block is taken as it is. In real time the next
    ones then do not wait either, until a message comes: the graph keeps its pace.

    Parameters
    ----------
    node : StageNode
        Owner.
    topic : Topic
        What is listened to.
    key : str
        Key of the case that holds `options`.
    options : LiveSamples
        What is done without messages.
    rate : float
        Simulated seconds per second of wall time; 0 for no limit.
    samples : SampleBuffer
        Where `receive` puts the messages.
    receive : callable
        Takes a message.
    waiting : callable
        Description of what waits for messages, empty if nothing does.
    """

    def __init__(
        self,
        node: StageNode,
        topic: Topic,
        *,
        key: str,
        options: LiveSamples,
        rate: float,
        samples: SampleBuffer,
        receive: Callable[[Any], None],
        waiting: Callable[[], str],
    ) -> None:
        self._node, self._topic, self._key, self._rate = node, topic, key, rate
        self._samples, self._receive, self._waiting = samples, receive, waiting
        self._patience, self._pace = Patience(options.timeout_s), Pace(rate)
        self._silent = False
        node.inlet(topic, self._on_message)

    def start(self) -> None:
        """Watch over the topic from now on, while the node is active."""
        self._patience.restart()
        self._pace.restart()
        self._node.every(min(0.25 * self._patience.limit_s, TICK_S), self._watch)

    def _on_message(self, message: Any) -> None:
        newest = self._samples.newest_ns
        self._receive(message)
        if self._samples.newest_ns != newest:
            self._silent = False
            self._patience.restart()
        self._node.advance()

    def _watch(self) -> None:
        self.report()
        waiting = self._waiting()
        if self._silent:
            self._node.advance()
        if self._silent or not self._patience.is_over(waiting=bool(waiting)):
            return
        if self._samples.rules.missing == "error":
            raise StreamError(
                f"no message on {self._topic.label} reaches the end of {waiting} within "
                f"{self._patience.limit_s:g} s: publish it, stamped in simulated time, or raise "
                f"{self._key}.timeout_s"
            )
        self._silent = True
        self._node.advance()

    def may_take(self, *, known: bool, time_ns: int) -> bool:
        """Tell whether a block is to be taken now; one that is not `known` ends at `time_ns`."""
        due = self._pace.is_due(time_ns) if known or self._silent else False
        return known or (self._silent and due)

    def taken(self, *, forced: bool) -> None:
        """Note that a block was taken, and report what it lacked."""
        self._patience.restart()
        if forced and self._rate == 0.0:
            self._silent = False  # nothing but the wait paces the graph
        self.report()

    def report(self) -> None:
        """Publish a warning for what was made up or dropped since the last one."""
        for kind, number, first, last in self._samples.take_counts():
            what = "samples" if kind == "filled" else "messages"
            text = f"{self._topic.label}: {number} {what} from {first:.9g} to {last:.9g} s: {_SAID[kind]}"
            if kind == "filled":
                text += f" ({self._key}.missing is {self._samples.rules.missing})"
            self._node.get_logger().warning(text)
            self._node.diagnose(
                DiagnosticStatus.WARN,
                text,
                topic=self._topic.label,
                kind=kind,
                number=number,
                from_s=f"{first:.9g}",
                to_s=f"{last:.9g}",
                total=self._samples.totals[kind],
            )
