"""Bags of tests: a run in one process as a graph records it, and what is done to a bag afterwards."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosgraph_msgs.msg import Clock

from local_graph import expected_messages
from owt_campaign.pipeline import prepare_case, stream_case
from owt_model.config import CaseConfig
from owt_model.versions import versions
from owt_postproc.bag import BagWriter
from owt_postproc.bag_source import BagSource
from owt_ros import convert, schema
from owt_ros.topics import RECORDED, TOWER_TOP_LOAD, Kind, recorded
from owt_ros.wire import time_ns

RECEIVED_NS = 1_700_000_000_000_000_000
#: Order of the topics within a block.
ORDER = (
    "/clock", "/owt/surface_elevation", "/owt/nodal_loads", TOWER_TOP_LOAD.label, "/owt/modal_state",
    "/owt/member_stress", "/owt/energy", "/owt/fatigue",
)  # fmt: skip
#: Member ends whose stress a shortened bag keeps.
ENDS = (5, 2, 117)


def begin(bag: Path, case: CaseConfig, **options: Any) -> BagWriter:
    """Begin a bag with the topics and files of a recording."""
    writer = BagWriter(bag, **options)
    for topic in recorded(case):
        name = schema.type_name(topic.message)
        text, hashed = schema.definition(name), schema.type_hash(name)
        writer.add_topic(topic.label, name, text, type_hash=hashed, latched=topic.kind is Kind.LATCHED)
    writer.attach("case.json", "application/json", case.model_dump_json().encode())
    writer.add_metadata("versions", versions())
    return writer


def run_messages(case: CaseConfig) -> Iterator[tuple[str, int, bytes]]:
    """Topic, simulated time in ns and bytes of all that a run publishes: latched, then block by block."""
    run = prepare_case(case)
    blocks = list(stream_case(run))
    found = expected_messages(run, blocks)
    found["/clock"] = [Clock(clock=convert.stamp(block.elevation.time_ns)) for block in blocks]
    found[TOWER_TOP_LOAD.label] = [
        convert.tower_top_load_message(block.tower_top) for block in blocks if block.tower_top is not None
    ]
    for topic in RECORDED:
        if topic.kind is Kind.LATCHED:
            yield topic.label, 0, serialize_message(found[topic.label][0])
    for i in range(len(blocks)):
        for label in ORDER:
            if found[label]:
                message = found[label][i]
                stamp = message.clock if label == "/clock" else message.header.stamp
                yield label, time_ns(stamp), serialize_message(message)


def write_run(bag: Path, case: CaseConfig, **options: Any) -> Path:
    """Record a run in one process, in the order of a graph."""
    with begin(bag, case, **options) as writer:
        for i, (label, at, data) in enumerate(run_messages(case)):
            writer.write(label, data, log_time_ns=RECEIVED_NS + i, publish_time_ns=at)
    return bag


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
