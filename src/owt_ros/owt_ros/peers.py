"""Notices that a peer died or left, by the liveliness of a beacon that each node keeps.

A beacon is a topic of its own per node, on which nothing is ever published: data topics then need no
lease, which foreign tools do not offer, and no node hears its own publishers, whose liveliness Fast DDS
reports differently inside one process. Matched counts are no substitute: after a crash they stay for
twenty seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Empty

__all__ = ["Peers", "beacon"]


def beacon(name: str) -> str:
    """Return the topic that says that node `name` is alive."""
    return f"owt/alive/{name}"


class Peers:
    """The beacon of one node, and its eye on those of others.

    Parameters
    ----------
    node : Node
        Owner.
    role : str
        Name of its own beacon.
    others : iterable of str
        Names of the nodes to watch.
    lease_s : float
        Time in s after which a dead process is noticed.
    on_loss : callable
        Called with the name of a node that died or left; ``lost`` holds those that have not come back.
    """

    def __init__(
        self, node: Node, role: str, others: Iterable[str], *, lease_s: float, on_loss: Callable[[str], None]
    ) -> None:
        self._node, self._on_loss = node, on_loss
        self.lost: set[str] = set()
        profile = QoSProfile(
            depth=1,
            liveliness=LivelinessPolicy.AUTOMATIC,
            liveliness_lease_duration=Duration(nanoseconds=round(lease_s * 1e9)),
        )
        self._beacon = node.create_publisher(Empty, beacon(role), profile)
        self._watched = [
            node.create_subscription(
                Empty,
                beacon(name),
                lambda _: None,
                profile,
                event_callbacks=SubscriptionEventCallbacks(liveliness=partial(self._on_change, name)),
            )
            for name in others
        ]

    def _on_change(self, name: str, event: Any) -> None:
        if event.alive_count:
            self.lost.discard(name)
        elif event.alive_count_change < 0:
            self.lost.add(name)
            self._on_loss(name)

    def close(self) -> None:
        """Put the beacon out and stop watching."""
        self._node.destroy_publisher(self._beacon)
        for subscription in self._watched:
            self._node.destroy_subscription(subscription)
        self._watched.clear()
