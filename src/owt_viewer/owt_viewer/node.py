"""The viewer node: publishes the picture of a running graph. It acknowledges nothing and slows nobody."""

from __future__ import annotations

import os
import sys
import time
import traceback
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from visualization_msgs.msg import MarkerArray

from owt_model.errors import OwtError
from owt_ros import topics
from owt_ros.parameters import NodeParameters
from owt_ros.process import run
from owt_ros.qos import qos_for
from owt_ros.topics import Kind, Topic
from owt_viewer.cdr import marker_array
from owt_viewer.feed import WATCHED, Feed
from owt_viewer.options import ViewerOptions
from owt_viewer.picture import Picture

if TYPE_CHECKING:
    from owt_viewer.live_server import LiveServer

__all__ = ["MARKERS", "ViewerNode", "main"]

MARKERS = Topic("owt/markers", MarkerArray, Kind.LATCHED, topics.VIEWER)
#: Streams are watched without any guarantee: a lost block is one that is not shown.
_NEWEST = QoSProfile(depth=2, history=HistoryPolicy.KEEP_LAST, reliability=ReliabilityPolicy.BEST_EFFORT)
_DESCRIPTIONS = (topics.MODEL, topics.SEA_STATE, topics.LOAD_BASIS, topics.REDUCED_MODEL)


def _serve(options: ViewerOptions) -> LiveServer:
    from owt_viewer.live_server import LiveServer  # here: markers need no WebSocket library

    return LiveServer(options.host, options.port)


class ViewerNode(Node):
    """Keeps the newest messages as they came; reads them when a picture is due and somebody looks.

    Raises
    ------
    InputError
        If a parameter is refused or the port is taken.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(topics.VIEWER, automatically_declare_parameters_from_overrides=True, **kwargs)
        case, options = NodeParameters(self, ViewerOptions).read()
        self._picture = Picture(
            case.structure, colour=options.colour, exaggeration=options.exaggeration,
            extent_m=options.grid_extent_m, points=options.grid_points,
        )  # fmt: skip
        self._known: dict[Topic, Any] = {}
        self._feed = Feed()
        self._complaint, self._afresh = "", True
        self._shown, self._shown_at = (-1, -1, True), 0.0
        self._server = _serve(options) if options.port else None
        self._markers = self.create_publisher(MarkerArray, MARKERS.name, qos_for(MARKERS))
        self._diagnostics = self.create_publisher(
            DiagnosticArray, topics.DIAGNOSTICS.name, qos_for(topics.DIAGNOSTICS)
        )
        for topic in _DESCRIPTIONS:
            self._listen(topic, partial(self._on_description, topic))
        for topic in WATCHED:
            self._listen(topic, partial(self._feed.take, topic))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / options.fps, partial(self._guarded, self._show), clock=steady)

    def _listen(self, topic: Topic, handler: Callable[[Any], None]) -> None:
        latched = topic.kind is Kind.LATCHED
        self.create_subscription(
            topic.message, topic.name, partial(self._guarded, handler),
            qos_for(topic) if latched else _NEWEST, raw=not latched,
        )  # fmt: skip

    def _guarded(self, call: Callable[..., None], *arguments: Any) -> None:
        """Run `call`; what cannot be shown becomes a diagnostic, once."""
        try:
            call(*arguments)
        except OwtError as error:
            self._complain(str(error))
        except Exception as error:
            self.get_logger().debug(traceback.format_exc())
            self._complain(f"a message cannot be shown: {type(error).__name__}: {error}")

    def _complain(self, message: str) -> None:
        message = " ".join(message.split())
        if message == self._complaint:
            return
        self._complaint = message
        self.get_logger().warning(message)
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN, name=topics.VIEWER, message=message, hardware_id="owt"
        )
        self._diagnostics.publish(DiagnosticArray(status=[status]))

    # --- what arrives -----------------------------------------------------------------------------

    def _on_description(self, topic: Topic, message: Any) -> None:
        self._known[topic], self._afresh = message, True
        if topic is topics.SEA_STATE:
            self._picture.describe_sea(message)
        elif topics.MODEL in self._known:
            known = (self._known.get(each) for each in (topics.REDUCED_MODEL, topics.LOAD_BASIS))
            self._picture.describe_structure(self._known[topics.MODEL], *known)

    # --- what is shown ----------------------------------------------------------------------------

    def _show(self) -> None:
        """Publish the picture that is due, if somebody looks and it is another one or a second old."""
        viewers, now = self._markers.get_subscription_count(), time.monotonic()
        served = self._server is not None and self._server.is_watched
        state = (self._feed.time_ns, viewers, self._afresh)
        if not (viewers or served) or (state == self._shown and now - self._shown_at < 1.0):
            return
        self._shown, self._shown_at = state, now
        moment = self._feed.moment()
        items, numbers = self._picture.items(moment)
        cdr = marker_array(items, moment.time_ns, afresh=self._afresh)
        self._afresh = False
        if viewers:
            self._markers.publish(cdr)
        if self._server is not None:
            self._server.send(cdr, numbers, moment.time_ns)

    def close(self) -> None:
        """Close the connections."""
        if self._server is not None:
            self._server.stop()
            self._server = None


def main(arguments: list[str] | None = None) -> int:
    """Run the node, behind everything else that wants the processor."""
    os.nice(10)
    return run(ViewerNode, arguments)


if __name__ == "__main__":
    sys.exit(main())
