"""Quality of service, in one place.

Reliable transport alone loses messages when a history is full, so every numbered stream is kept inside
its history by credits (:mod:`owt_ros.credits`): the depth is the most blocks in flight plus two.
"""

from __future__ import annotations

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from owt_ros.topics import CREDIT, Kind, Topic

__all__ = ["CREDIT_DEPTH", "EVENT_DEPTH", "qos_for"]

#: Acknowledgements kept for a producer that is discovered late.
CREDIT_DEPTH = 512
#: Small messages without flow control: far more than a reader can fall behind by.
EVENT_DEPTH = 1000


def qos_for(topic: Topic, *, window: int = 1) -> QoSProfile:
    """Return the profile of `topic`, the same for its publishers and its subscriptions.

    Parameters
    ----------
    topic : Topic
        What the profile is for.
    window : int
        Blocks in flight of a data topic.
    """
    latched = topic.kind is Kind.LATCHED
    if topic is CREDIT:
        depth = CREDIT_DEPTH
    elif latched:
        depth = 1
    else:
        depth = window + 2 if topic.kind is Kind.DATA else EVENT_DEPTH
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if latched or topic is CREDIT
        else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_ALL if topic.kind is Kind.INPUT else HistoryPolicy.KEEP_LAST,
        depth=depth,
    )
