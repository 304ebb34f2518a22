"""Both ends of a topic inside a node: outlets that respect credits, inlets that check and acknowledge."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from owt_msgs.msg import Credit
from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher

from owt_ros.credits import CreditWindow, Flow, StreamGuard
from owt_ros.pace import Patience
from owt_ros.qos import qos_for
from owt_ros.topics import Kind, Topic
from owt_ros.wire import Head, head_of, peek_head

__all__ = ["Inlet", "Outlet"]


class Outlet:
    """A topic that a node publishes.

    A data topic is published block by block while the window is open and every consumer is connected.
    In real time the window never closes, and consumers that exceed it are late.

    Parameters
    ----------
    node : LifecycleNode
        Owner.
    topic : Topic
        What is published.
    flow : Flow
        Of the graph.
    stall_s : float
        Longest wall time in s that consumers may hold it without acknowledging anything.
    """

    def __init__(self, node: LifecycleNode, topic: Topic, *, flow: Flow, stall_s: float) -> None:
        self.topic, self._node = topic, node
        self.publisher = node.create_lifecycle_publisher(
            topic.message, topic.name, qos_for(topic, window=flow.most)
        )
        self.credit = CreditWindow(flow, topic.consumers)
        self._held, self._acknowledged = Patience(stall_s), 0
        self._connected = not topic.consumers
        self._ended = topic.kind is not Kind.DATA

    @property
    def missing(self) -> tuple[str, ...]:
        """Consumers that are not connected yet.

        A consumer counts when the graph knows its subscription and as many subscriptions are matched as
        the graph knows: only then does a reliable publisher keep its messages for it.
        """
        if self._connected:
            return ()
        known = self._node.get_subscriptions_info_by_topic(self.publisher.topic_name)
        names = {endpoint.node_name for endpoint in known}
        absent = tuple(name for name in self.topic.consumers if name not in names)
        if not absent and self.publisher.get_subscription_count() < len(known):
            absent = self.topic.consumers
        self._connected = not absent
        return absent

    @property
    def is_open(self) -> bool:
        """Whether a block may be published now."""
        return self._connected and self.credit.is_open

    @property
    def owed_to(self) -> tuple[str, ...]:
        """Consumers that have not acknowledged the block marked last."""
        return () if self._ended and not self.credit.in_flight else self.topic.consumers

    @property
    def stall(self) -> str:
        """Say who has held this stream for too long; empty if nobody has.

        To be asked often: the wait begins with the first question after the last acknowledgement.
        """
        if self.credit.acknowledged != self._acknowledged:
            self._acknowledged = self.credit.acknowledged
            self._held.restart()
        if not self._held.is_over(waiting=not self.credit.is_open):
            return ""
        return (
            f"{self.credit.slowest} has not acknowledged block {self._acknowledged} of {self.topic.label} "
            f"for {self._held.limit_s:g} s: it hangs, or raise stall_s"
        )

    @property
    def lateness(self) -> str:
        """Say who is late, in one line; empty if nobody is."""
        credit = self.credit
        if not credit.behind:
            return ""
        line = f"{credit.slowest} has {credit.in_flight} blocks of {self.topic.label} to process"
        return f"{line}, {credit.lost} of which are lost" if credit.lost else line

    def send(self, message: Any) -> None:
        """Publish a message; on a data topic it must be the next block."""
        if self.topic.kind is Kind.DATA:
            self.credit.send(int(message.sequence))
            self._ended = bool(message.last)
        self.publisher.publish(message)


class Inlet:
    """A topic that a node subscribes to.

    Parameters
    ----------
    node : LifecycleNode
        Owner.
    topic : Topic
        What is received.
    handler : callable
        Called with the message, in order; on raw data topics with the head and the CDR bytes.
    receive : callable
        Takes ``(handle, message)`` from the subscription and decides when to call ``handle(message)``.
    raw : bool
        Hand over CDR bytes instead of a message.
    flow : Flow
        Of the graph.
    acknowledge : Publisher
        Of credits.
    consumer : str
        Name on the credits.
    """

    def __init__(
        self,
        node: LifecycleNode,
        topic: Topic,
        handler: Callable[..., None],
        *,
        receive: Callable[[Callable[[Any], None], Any], None],
        acknowledge: Publisher[Credit],
        consumer: str,
        flow: Flow,
        raw: bool = False,
    ) -> None:
        self.topic, self.guard = topic, StreamGuard(topic.label)
        self._handler, self._raw = handler, raw
        self._acknowledge, self._consumer, self._every = acknowledge, consumer, flow.every
        self.subscription = node.create_subscription(
            topic.message,
            topic.name,
            lambda message: receive(self._handle, message),
            qos_for(topic, window=flow.most),
            raw=raw,
        )

    def _handle(self, message: Any) -> None:
        if self.topic.kind is not Kind.DATA:
            self._handler(message)
            return
        head: Head = peek_head(message, self.topic.label) if self._raw else head_of(message)
        self.guard.check(sequence=head.sequence, time_ns=head.time_ns, end_ns=head.end_ns, last=head.last)
        if self._raw:
            self._handler(head, message)
        else:
            self._handler(message)

    def arrived(self) -> Iterator[Any]:
        """Take the messages that have arrived and wait for their turn: topics have no order among them."""
        with self.subscription.handle:
            while (taken := self.subscription.handle.take_message(self.topic.message, self._raw)) is not None:
                yield taken[0]

    def acknowledge(self, sequence: int) -> None:
        """Give credit for all blocks up to `sequence`; in real time for the first, then some at a time."""
        if sequence and (sequence + 1) % self._every and not self.guard.finished:
            return
        self._acknowledge.publish(
            Credit(consumer=self._consumer, topic=self.topic.label, sequence=int(sequence))
        )

    def is_owed_by(self, peer: str) -> bool:
        """Tell whether `peer` has to send more blocks of this stream."""
        return self.topic.producer == peer and self.topic.kind is Kind.DATA and not self.guard.finished
