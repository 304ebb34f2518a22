"""Notices that a peer died or left, by the liveliness of a beacon that each node keeps.

A beacon is a topic of its own per node: data topics then need no lease, which foreign tools do not offer, and
no node hears its own publishers, whose liveliness Fast DDS reports differently inside one process. One empty
message is kept for whoever comes: until its first message or its first assertion, most of a lease later, a
reader does not count a writer as alive, and would not notice its death. Matched counts are no substitute:
after a crash they stay for twenty seconds.

Discovery can take seconds for single endpoints. Who has been heard from and shows no beacon by then, died
before it was discovered.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile
from std_msgs.msg import Empty

__all__ = ["Peers", "beacon"]

#: Longest time in s that discovery of one endpoint takes: Fast DDS repeats what was lost after 3 s.
DISCOVERY_S = 5.0


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
        self._seen: set[str] = set()
        self._heard: dict[str, float] = {}
        profile = QoSProfile(
            depth=1,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            liveliness=LivelinessPolicy.AUTOMATIC,
            liveliness_lease_duration=Duration(nanoseconds=round(lease_s * 1e9)),
        )
        self._beacon = node.create_publisher(Empty, beacon(role), profile)
        self._beacon.publish(Empty())
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

    def hear(self, name: str) -> None:
        """Note that a message of a node has come."""
        self._heard.setdefault(name, time.monotonic())

    @property
    def unseen(self) -> list[str]:
        """Nodes that were heard from and whose beacon should have been discovered since."""
        now = time.monotonic()
        return [n for n, at in self._heard.items() if n not in self._seen and now - at > DISCOVERY_S]

    def _on_change(self, name: str, event: Any) -> None:
        if event.alive_count:
            self.lost.discard(name)
            self._seen.add(name)
        elif event.alive_count_change < 0:
            self.lost.add(name)
            self._on_loss(name)

    def close(self) -> None:
        """Put the beacon out and stop watching."""
        self._node.destroy_publisher(self._beacon)
        for subscription in self._watched:
            self._node.destroy_subscription(subscription)
        self._watched.clear()
