"""What tests do to bags: leave out what can be computed again, change a number, cut one off."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from owt_postproc.bag import BagWriter
from owt_postproc.bag_source import BagSource

#: Member ends whose stress a shortened bag keeps.
ENDS = (5, 2, 117)


def shorten(kind: str, content: Any) -> None:
    """Leave out of a message what a bag by default leaves out."""
    none = np.zeros(0)
    if kind == "ModalState":
        content.velocity, content.acceleration = none, none
    elif kind == "Energy":
        content.potential_mode, content.kinetic_mode = none, none
    elif kind == "MemberStress":
        content.end = np.array(ENDS, dtype=np.uint32)
        for name in ("axial", "bending_y", "bending_z", "von_mises"):
            values = getattr(content, name).reshape(content.samples, -1)
            setattr(content, name, np.ascontiguousarray(values[:, ENDS]).ravel())


def rewrite(
    bag: Path,
    new: Path,
    change: Callable[[str, Any], Any] = shorten,
    *,
    schemas: Callable[[str, str], str] = lambda kind, text: text,
    **options: Any,
) -> Path:
    """Write a bag again, each message changed in place; one for which `change` gives False is dropped.

    `schemas` changes the definition of a kind of message, for what older definitions lack.
    """
    with BagSource(bag) as source, BagWriter(new, **options) as writer:
        old, store = get_typestore(Stores.EMPTY), get_typestore(Stores.EMPTY)
        for topic in source.topics.values():
            kind = topic.type_name.split("/")[-1]
            text = schemas(kind, topic.schema)
            for types, definition in ((old, topic.schema), (store, text)):
                found = get_types_from_msg(definition, topic.type_name)
                types.register({k: v for k, v in found.items() if k not in types.types})
            writer.add_topic(topic.name, topic.type_name, text, latched=topic.latched)
        for name, data in source.files.attachments.items():
            writer.attach(name, "application/json", data)
        for name, values in source.files.metadata.items():
            if name != "rosbag2":
                writer.add_metadata(name, values)
        for raw in source.messages():
            content = old.deserialize_cdr(raw.data, raw.type_name)
            if change(raw.type_name.split("/")[-1], content) is False:
                continue
            writer.write(
                raw.topic,
                bytes(store.serialize_cdr(content, raw.type_name)),
                log_time_ns=raw.log_time_ns,
                publish_time_ns=raw.publish_time_ns,
            )
    return new
