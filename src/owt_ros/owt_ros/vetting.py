"""Refuses messages that cannot be: numbers that are none, arrays that do not fit, another structure."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from owt_model.errors import StreamError
from owt_ros import decode
from owt_ros.topics import Topic

__all__ = ["check_model", "check_numbers"]


def check_model(message: Any, topic: Topic, own: str, name: str) -> None:
    """Refuse what belongs to another structure.

    Parameters
    ----------
    message : message
        With a ``model_hash``.
    topic : Topic
        That it came on.
    own : str
        Content hash of this node's structure.
    name : str
        What the case calls it.

    Raises
    ------
    StreamError
        If the hashes differ.
    """
    if message.model_hash != own:
        raise StreamError(
            f"{topic.label} belongs to model {message.model_hash[:12] or '(none)'}, this node has "
            f"{own[:12]} ({name}): give all nodes the same structure.model"
        )


def check_numbers(message: Any, topic: Topic) -> None:
    """Refuse a message whose arrays do not fit each other, or that holds NaN or inf.

    Raises
    ------
    StreamError
        Naming the topic, the block and the field.
    """
    if read := decode.BLOCKS.get(topic.message.__name__):
        read(message)
    for field in _real_fields(topic):
        values = np.asarray(getattr(message, field))
        if not np.isfinite(values).all():
            place = f" block {int(message.sequence)}" if hasattr(message, "sequence") else ""
            raise StreamError(f"{topic.label}{place}: {field} holds NaN or inf")


@cache
def _real_fields(topic: Topic) -> tuple[str, ...]:
    """Fields of a topic's messages that hold real numbers."""
    kinds = topic.message.get_fields_and_field_types().items()
    return tuple(name for name, kind in kinds if "double" in kind or "float" in kind)
