"""Bags in the hands of standard readers: the layout of rosbag2, every reader alike, also before the end."""

from __future__ import annotations

import pytest
import yaml
from mcap.reader import make_reader

from owt_model.errors import InputError
from owt_postproc.bag import BagWriter
from owt_postproc.bag_reader import read_messages
from owt_postproc.bag_source import BagSource

TIME = "int32 sec\nuint32 nanosec\n"
TIME_TYPE = "builtin_interfaces/msg/Time"


def put(writer, n):
    for i in range(n):
        data = b"\x00\x01\x00\x00" + i.to_bytes(4, "little") + bytes(4)
        writer.write("/time", data, log_time_ns=1000 + i, publish_time_ns=i)


#: What rosbag2 of Jazzy and Kilted writes in version 9 of metadata.yaml, level by level.
METADATA_FIELDS = {
    "": {
        "version", "storage_identifier", "duration", "starting_time", "message_count",
        "topics_with_message_count", "compression_format", "compression_mode", "relative_file_paths", "files",
        "custom_data", "ros_distro",
    },
    "topics_with_message_count": {"topic_metadata", "message_count"},
    "topic_metadata": {
        "name", "type", "serialization_format", "offered_qos_profiles", "type_description_hash",
    },
    "offered_qos_profiles": {
        "history", "depth", "reliability", "durability", "deadline", "lifespan", "liveliness",
        "liveliness_lease_duration", "avoid_ros_namespace_conventions",
    },
    "files": {"path", "starting_time", "duration", "message_count"},
}  # fmt: skip


def check_metadata_fields(info: dict) -> None:
    topics = info["topics_with_message_count"]
    levels = {
        "": [info],
        "topics_with_message_count": topics,
        "topic_metadata": [topic["topic_metadata"] for topic in topics],
        "offered_qos_profiles": [q for t in topics for q in t["topic_metadata"]["offered_qos_profiles"]],
        "files": info["files"],
    }
    for level, found in levels.items():
        assert found, level
        assert all(set(fields) == METADATA_FIELDS[level] for fields in found), level
    assert set(info["duration"]) == {"nanoseconds"}
    assert set(info["starting_time"]) == {"nanoseconds_since_epoch"}


def test_metadata_has_the_fields_of_version_9(bag):
    info = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    check_metadata_fields(info)
    with next(bag.glob("*.mcap")).open("rb") as stream:  # rosbag2 puts the same into the file
        (inside,) = (m.metadata for m in make_reader(stream).iter_metadata() if m.name == "rosbag2")
    assert yaml.safe_load(inside["serialized_metadata"]) == info
    # Negative control: the layout of version 8 has no type hashes.
    for topic in info["topics_with_message_count"]:
        del topic["topic_metadata"]["type_description_hash"]
    with pytest.raises(AssertionError, match="topic_metadata"):
        check_metadata_fields(info)


def test_every_standard_reader_gives_the_same_messages(bag):
    """rosbags, by folder; mcap by index, as a stream, and record by record; our own."""
    from mcap.reader import NonSeekingReader
    from mcap.records import Message
    from mcap.stream_reader import StreamReader
    from rosbags.rosbag2 import Reader

    with BagSource(bag) as source:
        own = [(m.topic, m.log_time_ns, m.data) for m in source.messages()]
        assert source.finished
        assert {name for name, topic in source.topics.items() if topic.latched} == {
            "/owt/model", "/owt/sea_state", "/owt/reduced_model",
        }  # fmt: skip
        part = [m.data for m in source.messages(["/owt/energy"])]
    assert part == [data for topic, _, data in own if topic == "/owt/energy"]
    assert len(part) == 8
    with Reader(bag) as reader:
        assert [(c.topic, t, bytes(raw)) for c, t, raw in reader.messages()] == own
    file = next(bag.glob("*.mcap"))
    for make in (make_reader, NonSeekingReader):
        with file.open("rb") as stream:
            found = make(stream).iter_messages()
            assert [(c.topic, m.log_time, m.data) for _, c, m in found] == own
    with file.open("rb") as stream:
        records = StreamReader(stream, validate_crcs=True).records
        data = [record.data for record in records if isinstance(record, Message)]
    assert data == [data for _, _, data in own]


def test_a_bag_being_written_is_read_as_far_as_it_goes(tmp_path):
    """By us, by its later name too, and by mcap's reader of streams; the index is not there yet."""
    from mcap.exceptions import McapError
    from mcap.reader import NonSeekingReader

    writer = BagWriter(tmp_path / "new")
    writer.add_topic("/time", TIME_TYPE, TIME)
    writer.attach("case.json", "application/json", b'{"time": {"n": 7}}')
    put(writer, 3)
    writer.flush()
    put(writer, 2)  # not written yet
    for path in (tmp_path / "new", writer.folder, writer.file):
        with BagSource(path) as source:
            assert not source.finished
            assert [m.publish_time_ns for m in source.messages()] == [0, 1, 2]
            assert source.topics["/time"].type_name == TIME_TYPE
            assert source.files.case == {"time": {"n": 7}}
            assert source.damaged == []
    with writer.file.open("rb") as stream:
        found = NonSeekingReader(stream).iter_messages(log_time_order=False)
        assert [next(found)[2].publish_time for _ in range(3)] == [0, 1, 2]
        with pytest.raises((McapError, EOFError)):
            next(found)
    with pytest.raises(InputError, match="it was not finished"):
        list(read_messages(writer.folder))
    with BagSource(tmp_path / "new") as source:
        writer.close()  # renamed meanwhile: what was open stays so, as it was
        assert len(list(source.messages())) == 3
    with BagSource(tmp_path / "new") as source:
        assert len(list(source.messages())) == 5


def test_a_bag_of_several_files_is_read_in_the_order_of_time(tmp_path):
    """As rosbag2 splits them; their names sort otherwise."""
    for i in range(11):
        with BagWriter(tmp_path / f"part{i}") as writer:
            writer.add_topic("/time", TIME_TYPE, TIME)
            for k in range(2):
                at = 2 * i + k
                data = b"\x00\x01\x00\x00" + at.to_bytes(4, "little") + bytes(4)
                writer.write("/time", data, log_time_ns=at, publish_time_ns=at)
    (tmp_path / "all").mkdir()
    for i in range(11):
        (tmp_path / f"part{i}" / f"part{i}_0.mcap").rename(tmp_path / "all" / f"all_{i}.mcap")
    with BagSource(tmp_path / "all") as source:
        assert [message.publish_time_ns for message in source.messages()] == list(range(22))
        assert list(source.topics) == ["/time"]


def test_messages_that_rosbag2_compressed_are_refused(tmp_path):
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    for mode in (CompressionMode.MESSAGE, CompressionMode.NONE):
        writer = Writer(tmp_path / mode.name, version=9, storage_plugin=StoragePlugin.MCAP)
        if mode is not CompressionMode.NONE:
            writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer:
            types = get_typestore(Stores.ROS2_JAZZY)
            time = writer.add_connection("/time", TIME_TYPE, typestore=types)
            writer.write(time, 1, b"\x00\x01\x00\x00" + bytes(8))
    with pytest.raises(InputError, match=r"is compressed by message.*rosbags-convert"):
        BagSource(tmp_path / "MESSAGE")
    with BagSource(tmp_path / "NONE") as source:
        assert len(list(source.messages())) == 1
