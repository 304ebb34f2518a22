"""Publishes a bag on ROS topics, byte by byte as recorded, paced by the simulated time of its messages."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import InvalidNamespaceException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_namespace import validate_namespace
from rosgraph_msgs.msg import Clock

from owt_bringup.older_definition import to_installed
from owt_bringup.replay_plan import CLOCK, ReplayPlan
from owt_model.contracts import Block, EnergyBlock, LoadBlock, ModalBlock, StressBlock
from owt_model.errors import ComputationError, InputError
from owt_postproc.bag_source import RawMessage, RecordedTopic
from owt_ros import convert
from owt_ros.pace import Pace

__all__ = ["Player", "response_message", "stop_on_signals"]

#: Messages of a topic that its readers may not have yet. Few, as a reader that keeps only some loses the
#: others; more where an acknowledgement takes its time.
IN_FLIGHT, IN_FLIGHT_SLOW = 8, 256
#: Seconds without a new subscriber after which those there are count as all.
QUIET_S = 0.5
#: Seconds that the last messages have to arrive.
ARRIVAL_S = 10.0
#: How often a wait looks for a signal, in s.
LOOK_S = 0.1
OWN_CLOCK = RecordedTopic(CLOCK, "rosgraph_msgs/msg/Clock", "", {})
_BEST_EFFORT = ("best_effort", 2)
_MESSAGE_OF: dict[type[Block], Callable[[Any], Any]] = {
    LoadBlock: convert.nodal_loads_message,
    ModalBlock: convert.modal_message,
    StressBlock: convert.stress_message,
    EnergyBlock: convert.energy_message,
}


def response_message(block: Block) -> bytes:
    """Write a block as its node does."""
    return bytes(serialize_message(_MESSAGE_OF[type(block)](block)))


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Yield an event that SIGINT and SIGTERM set while the block lasts."""
    stop = threading.Event()
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.signal(number, lambda *_: stop.set()) for number in numbers}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _message_class(topic: RecordedTopic) -> type[Any]:
    """Class of a topic's messages.

    Raises
    ------
    InputError
        If it is not installed.
    """
    package, _, name = topic.type_name.split("/") if topic.type_name.count("/") == 2 else ("", "", "")
    try:
        found: type[Any] = getattr(import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError, ValueError):
        raise InputError(
            "topics",
            topic.name,
            f"is of type {topic.type_name or '(none)'}, which is not installed",
            "Source the workspace that has it, or select others by --topics.",
        ) from None
    return found


def _profile(topic: RecordedTopic) -> QoSProfile:
    """Recorded quality of service; what is not latched is kept until every reliable reader has it."""
    latched = topic.latched
    reliable = topic.qos.get("reliability") not in _BEST_EFFORT
    depth = int(topic.qos.get("depth") or 0)
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_LAST if latched and depth else HistoryPolicy.KEEP_ALL,
        depth=max(depth, 1),
    )


def _prefix(namespace: str) -> str:
    """What goes before the names of topics.

    Raises
    ------
    InputError
        If it is no namespace.
    """
    prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    try:
        validate_namespace(prefix or "/")
    except InvalidNamespaceException as error:
        raise InputError(
            "namespace", namespace, f"is not allowed ({error})", "Use letters, digits, _ and /."
        ) from None
    return prefix


class Player:
    """A node that publishes the messages of a plan; a context manager.

    Parameters
    ----------
    plan : ReplayPlan
        What to publish.
    stop : threading.Event
        Ends the replay when it is set.
    namespace : str
        Goes before the recorded names.
    domain_id : int, optional
        ROS domain; that of the environment by default.
    quick : bool
        Whether readers are asked often what they have
        (:func:`owt_bringup.transport.quick_acknowledgements`).

    Raises
    ------
    InputError
        If a type is not installed or is another by now, or the namespace cannot be.
    """

    def __init__(
        self,
        plan: ReplayPlan,
        stop: threading.Event,
        *,
        namespace: str = "",
        domain_id: int | None = None,
        quick: bool = False,
    ) -> None:
        self._plan, self._stop = plan, stop
        self._in_flight = IN_FLIGHT if quick else IN_FLIGHT_SLOW
        topics = {**plan.topics, **({CLOCK: OWN_CLOCK} if plan.has_own_clock else {})}
        classes = {name: _message_class(topic) for name, topic in topics.items()}
        self._older = {name: turn for name, topic in topics.items() if (turn := to_installed(topic))}
        prefix = _prefix(namespace)
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node("replay", context=self._context, namespace=prefix, use_global_arguments=False)
        self._publishers = {
            name: self._node.create_publisher(classes[name], prefix + name, _profile(topic))
            for name, topic in topics.items()
        }
        self._sent = dict.fromkeys(self._publishers, 0)

    @property
    def published(self) -> int:
        """Messages published so far."""
        return sum(self._sent.values())

    def wait_for_subscriber(self, seconds: float) -> None:
        """Wait until somebody listens to one of the topics, and nobody else has joined for a moment.

        Raises
        ------
        InputError
            If nobody does within `seconds`.
        """
        deadline = time.monotonic() + seconds
        readers, since = 0, time.monotonic()
        while not self._stop.is_set():
            found = sum(publisher.get_subscription_count() for publisher in self._publishers.values())
            now = time.monotonic()
            if found != readers:
                readers, since = found, now
            if readers and now - since >= QUIET_S:
                return
            if not readers and now > deadline:
                raise InputError(
                    "wait", seconds, "s have passed and nobody subscribes to any of the topics",
                    "Start the subscriber in the same ROS domain, or give more time.",
                )  # fmt: skip
            self._stop.wait(0.2 * LOOK_S)

    def play(
        self, rate: float, *, rounds: int | None = 1, progress: Callable[[int], None] | None = None
    ) -> bool:
        """Publish `rounds` rounds, any number if None; tell whether they were completed.

        Parameters
        ----------
        rate : float
            Simulated seconds per second of wall time; 0 for as fast as reliable subscribers take them.
        progress : callable, optional
            Called with the simulated time of each message in ns.

        Raises
        ------
        InputError
            If the bag is damaged.
        ComputationError
            If what is computed again is not what was recorded, or a subscriber does not take what is sent.
        """
        done = 0
        while rounds is None or done < rounds:
            pace = Pace(rate)
            pace.is_due(self._plan.begin_ns)
            before = self.published
            for message in self._plan.round():
                if not self._await(pace, message) or not self._publish(message):
                    return False
                if progress is not None:
                    progress(message.publish_time_ns)
            done += 1
            if self.published == before:
                break
        return self._all_arrived(ARRIVAL_S)

    def _await(self, pace: Pace, message: RawMessage) -> bool:
        """Wait until a message is due; tell whether it is, not so after a signal."""
        wait = pace.wait_s(message.publish_time_ns)
        return not (self._stop.wait(wait) if wait > 0.0 else self._stop.is_set())

    def _publish(self, message: RawMessage) -> bool:
        """Publish a message; tell whether to go on."""
        publisher = self._publishers[message.topic]
        if message.data:
            turn = self._older.get(message.topic)
            publisher.publish(message.data if turn is None else turn(message.data))
        else:
            sec, nanosec = divmod(message.publish_time_ns, 1_000_000_000)
            publisher.publish(Clock(clock=Time(sec=sec, nanosec=nanosec)))
        self._sent[message.topic] += 1
        return self._sent[message.topic] % self._in_flight != 0 or self._taken(publisher)

    def _taken(self, publisher: Any) -> bool:
        """Wait until all reliable readers have the messages of one publisher."""
        while not publisher.wait_for_all_acked(Duration(seconds=LOOK_S)):
            if self._stop.is_set():
                return False
        return not self._stop.is_set()

    def _all_arrived(self, seconds: float) -> bool:
        """Wait for the last messages, so that the end of this process takes none of them along."""
        deadline = time.monotonic() + seconds
        for name, publisher in self._publishers.items():
            while not publisher.wait_for_all_acked(Duration(seconds=LOOK_S)):
                if self._stop.is_set():
                    return False
                if time.monotonic() > deadline:
                    raise ComputationError(
                        f"{name}: a subscriber has not taken the last messages within {seconds:g} s"
                    )
        return True

    def close(self) -> None:
        """Leave the domain."""
        self._node.destroy_node()
        self._context.try_shutdown()

    def __enter__(self) -> Player:
        """Return the player."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the domain."""
        self.close()
