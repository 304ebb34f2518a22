"""Reading bags without ROS: by the message definitions that the bag itself holds.

Messages of this project are told by their type, so that a graph in a namespace reads alike.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from owt_model.contracts import Block
from owt_model.errors import ComputationError, InputError
from owt_postproc.bag_source import BagFiles, BagSource, RawMessage
from owt_ros import decode

__all__ = [
    "PREFIX",
    "BagArrays",
    "BagFiles",
    "BagMessage",
    "decoded",
    "read_bag",
    "read_files",
    "read_messages",
    "to_block",
]

PREFIX = "owt_msgs/msg/"


@dataclass(frozen=True)
class BagMessage:
    """One message: where and when it was, its deserialised fields, and how it was recorded."""

    topic: str
    type_name: str
    log_time_ns: int
    content: Any
    raw: RawMessage


@dataclass(frozen=True)
class BagArrays:
    """A whole bag as arrays.

    Attributes
    ----------
    streams : dict
        ``streams[topic][field]``: fields by sample joined over the blocks, [sample, ...]; ``time`` is the
        simulated time in s; a field without samples is that of the first block. What a bag leaves out has no
        columns.
    messages : dict
        ``messages[topic]``: the messages of every other topic, each a dict of its fields.
    """

    streams: dict[str, dict[str, np.ndarray]]
    messages: dict[str, list[dict[str, Any]]]
    files: BagFiles


def decoded(source: BagSource, *, types: Collection[str] | None = None) -> Iterator[BagMessage]:
    """Yield the messages of an open bag, complete or not, with their fields.

    Parameters
    ----------
    source : BagSource
        The bag.
    types : collection of str, optional
        Full names of the message types wanted.

    Raises
    ------
    InputError
        If it is damaged.
    """
    from rosbags.typesys import Stores, get_typestore

    from owt_postproc.message_schema import types_of

    topics = {
        name: topic for name, topic in source.topics.items() if types is None or topic.type_name in types
    }
    store = get_typestore(Stores.EMPTY)
    try:
        for topic in topics.values():
            definitions = types_of(topic.type_name, topic.schema)
            store.register({name: d for name, d in definitions.items() if name not in store.types})
    except Exception as error:  # the parser raises what it likes
        raise _unreadable(source.path, error) from None
    for raw in source.messages(topics):
        try:
            content = store.deserialize_cdr(raw.data, raw.type_name)
        except Exception as error:
            raise _unreadable(source.path, error) from None
        yield BagMessage(raw.topic, raw.type_name, raw.log_time_ns, content, raw)


def read_messages(bag: str | Path, *, types: Collection[str] | None = None) -> Iterator[BagMessage]:
    """Yield the messages of a complete bag in the order of their log time.

    Parameters
    ----------
    bag : path
        Bag folder or MCAP file.
    types : collection of str, optional
        Full names of the message types wanted.

    Raises
    ------
    InputError
        If it is not a readable, complete bag.
    """
    with _complete(bag) as source:
        yield from decoded(source, types=types)


def read_files(bag: str | Path) -> BagFiles:
    """Attachments and metadata records of a complete bag.

    Raises
    ------
    InputError
        If it is not a readable, complete bag.
    """
    with _complete(bag) as source:
        return source.files


def _complete(bag: str | Path) -> BagSource:
    source = BagSource(bag)
    if not source.finished:
        source.close()
        raise _unreadable(bag, ValueError("it was not finished"))
    return source


def _unreadable(bag: str | Path, error: Exception) -> InputError:
    reason = " ".join(str(error).split()) or type(error).__name__
    return InputError("bag", str(bag), f"cannot be read ({reason})", "Try to recover it first.")


def read_bag(bag: str | Path, *, types: Collection[str] | None = None) -> BagArrays:
    """Read a bag into arrays.

    Parameters
    ----------
    bag, types
        See :func:`read_messages`.
    """
    blocks: dict[str, list[dict[str, Any]]] = {}
    messages: dict[str, list[dict[str, Any]]] = {}
    for message in read_messages(bag, types=types):
        values = _fields(message.content)
        if "samples" in values and "dt" in values:
            blocks.setdefault(message.topic, []).append(values)
        else:
            messages.setdefault(message.topic, []).append(values)
    streams = {}
    for topic in list(blocks):
        streams[topic] = _join(topic, blocks.pop(topic))
    return BagArrays(streams, messages, read_files(bag))


#: Fields of block messages that do not run over the samples.
_PER_BLOCK = ("gauge_m", "node", "element", "end")


def _fields(content: Any) -> dict[str, Any]:
    return {
        name: getattr(content, name) for name in content.__dataclass_fields__ if not name.startswith("__")
    }


def _join(topic: str, blocks: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    dt = float(blocks[0]["dt"])
    _check_sequence(topic, [int(values["sequence"]) for values in blocks])
    samples = [int(values["samples"]) for values in blocks]
    joined: dict[str, np.ndarray] = {"time": np.arange(sum(samples)) * dt + _seconds(blocks[0]["header"])}
    for name, value in blocks[0].items():
        if not isinstance(value, np.ndarray):
            continue
        if name in _PER_BLOCK:
            joined[name] = value
        else:
            parts = [values[name].reshape(n, -1) for values, n in zip(blocks, samples, strict=True)]
            if name == "filled":  # empty in a block without such samples
                parts = [p if p.size else np.zeros((len(p), 1), p.dtype) for p in parts]
            joined[name] = np.concatenate(parts)
    return joined


def _check_sequence(topic: str, sequence: list[int]) -> None:
    for expected, got in enumerate(sequence, start=sequence[0]):
        if got != expected:
            raise ComputationError(
                f"{topic}: block {got} follows block {expected - 1}; the recording has a gap."
            )


def _seconds(header: Any) -> float:
    return float(header.stamp.sec + 1e-9 * header.stamp.nanosec)


def to_block(message: BagMessage) -> Block | None:
    """The block of samples that a message carries, None for messages that carry none.

    Raises
    ------
    ComputationError
        If its arrays do not fit its number of samples.
    """
    read = decode.BLOCKS.get(message.type_name.removeprefix(PREFIX))
    return None if read is None else read(message.content)
