"""Bags: read back by rosbags and mcap, and never half there."""

from __future__ import annotations

import errno
import json
import os
import resource
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader

from owt_model.contracts import LoadBlock, StressBlock
from owt_model.errors import ComputationError, InputError
from owt_postproc import bag as bag_module
from owt_postproc.bag import BagWriter, partial_path
from owt_postproc.bag_reader import read_bag, read_files, read_messages, to_block
from owt_postproc.message_schema import type_hash

TIME = "int32 sec\nuint32 nanosec\n"
TIME_TYPE = "builtin_interfaces/msg/Time"


def small(path, **options) -> BagWriter:
    writer = BagWriter(path, **options)
    writer.add_topic("/time", TIME_TYPE, TIME)
    return writer


def put(writer, n=3, size=0):
    for i in range(n):
        data = b"\x00\x01\x00\x00" + np.int32(i).tobytes() + b"\x00" * (4 + size)
        writer.write("/time", data, log_time_ns=1000 + i, publish_time_ns=i)


def test_rosbags_reads_every_message(bag, run, recording):
    from rosbags.highlevel import AnyReader

    store, expected = recording.store(), {}
    for block in run.blocks:
        topic, data = recording.message(block, store)
        expected.setdefault(topic, []).append(data)
    found, times = {}, []
    with AnyReader([bag]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == {
            topic: f"owt_msgs/msg/{name}" for topic, (name, _) in recording.schemas.items()
        }
        for connection, time, raw in reader.messages():
            content = reader.deserialize(raw, connection.msgtype)
            if hasattr(content, "sequence"):
                times.append(time)
                found.setdefault(connection.topic, []).append(bytes(raw))
    assert found == expected
    assert len(set(times)) == len(run.blocks)
    assert times == sorted(times)


def test_mcap_reads_files_times_and_sequence(bag, run):
    with next(bag.glob("*.mcap")).open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == len(run.blocks) + 3
        assert {a.name for a in reader.iter_attachments()} == {"case.json"}
        assert {m.name for m in reader.iter_metadata()} == {"versions", "rosbag2"}
        blocks = [b for b in run.blocks if isinstance(b, StressBlock)]
        messages = reader.iter_messages(topics=["/owt/member_stress"])
        for block, (_, _, message) in zip(blocks, messages, strict=True):
            assert message.sequence == block.sequence
            assert message.publish_time == block.time_ns
            assert message.log_time > 1_600_000_000_000_000_000


def test_metadata_is_what_rosbag2_writes(bag, run):
    info = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert info["version"] == 9
    assert info["storage_identifier"] == "mcap"
    assert info["relative_file_paths"] == ["run_0.mcap"]
    assert info["message_count"] == len(run.blocks) + 3
    topics = {t["topic_metadata"]["name"]: t for t in info["topics_with_message_count"]}
    assert topics["/owt/energy"]["message_count"] == 8
    durability = {
        name: t["topic_metadata"]["offered_qos_profiles"][0]["durability"] for name, t in topics.items()
    }
    assert durability["/owt/model"] == "transient_local"
    assert durability["/owt/energy"] == "volatile"
    for topic in topics.values():
        assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
    assert "&" not in (bag / "metadata.yaml").read_text()  # no YAML anchors


def test_type_hash_is_the_one_of_ros():
    expected = "RIHS01_b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"
    assert type_hash(TIME_TYPE, TIME) == expected
    own = "owt_msgs/msg/Anything"
    assert type_hash(own, TIME) != type_hash(own, TIME.replace("uint32", "int32"))


def test_blocks_come_back_bit_by_bit(bag, run):
    found = [block for message in read_messages(bag) if (block := to_block(message)) is not None]
    for kind in {type(block) for block in run.blocks}:
        recorded = [block for block in found if isinstance(block, kind)]
        for a, b in zip(run.of(kind), recorded, strict=True):
            for name, value in vars(a).items():
                if isinstance(value, np.ndarray):
                    np.testing.assert_array_equal(value, getattr(b, name))
                else:
                    assert value == getattr(b, name)


def test_arrays_per_topic(bag, run):
    arrays = read_bag(bag)
    stress = run.of(StressBlock)
    stream = arrays.streams["/owt/member_stress"]
    np.testing.assert_array_equal(stream["axial"], np.concatenate([b.axial for b in stress]))
    np.testing.assert_allclose(stream["time"], 0.02 * np.arange(len(stream["axial"])))
    loads = np.concatenate([b.nodal for b in run.of(LoadBlock)])
    np.testing.assert_array_equal(arrays.streams["/owt/nodal_loads"]["nodal"].reshape(loads.shape), loads)
    np.testing.assert_array_equal(arrays.streams["/owt/nodal_loads"]["node"], run.of(LoadBlock)[0].node)
    assert arrays.messages["/owt/reduced_model"][0]["reduction"] == "CB10M10"
    assert arrays.files.case == json.loads(run.case.model_dump_json())
    assert read_files(bag).metadata["versions"]["owt"] == "0.1.0"


def test_types_select(bag):
    assert set(read_bag(bag, types=["owt_msgs/msg/Energy"]).streams) == {"/owt/energy"}


def test_gap_in_a_recording_is_an_error(tmp_path, run, recording):
    store = recording.store()
    with recording.begin(tmp_path / "gap", run, store) as writer:
        for block in run.of(StressBlock):
            topic, data = recording.message(block, store)
            if block.sequence != 3:
                writer.write(topic, data, log_time_ns=block.time_ns, publish_time_ns=block.time_ns)
    with pytest.raises(ComputationError, match="/owt/member_stress: block 4 follows block 2"):
        read_bag(tmp_path / "gap")


def test_not_a_bag_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no MCAP file"):
        list(read_messages(tmp_path))
    (tmp_path / "x.mcap").write_bytes(b"nonsense")
    with pytest.raises(InputError, match=r"cannot be read.*recover"):
        list(read_messages(tmp_path))


def test_name_appears_only_when_complete(tmp_path):
    path = tmp_path / "sub" / "new"
    with small(path) as writer:
        put(writer)
        assert not path.exists()
        assert writer.folder == partial_path(path)
        assert writer.folder.is_dir()
    assert sorted(p.name for p in path.iterdir()) == ["metadata.yaml", "new_0.mcap"]
    assert [p.name for p in path.parent.iterdir()] == ["new"]


def test_files_may_be_added_before_it_appears(tmp_path):
    writer = small(tmp_path / "new")
    put(writer)
    writer.seal()
    (writer.folder / "report.html").write_text("x")
    writer.close()
    assert (tmp_path / "new" / "report.html").is_file()


def test_failure_leaves_only_the_partial_folder(tmp_path):
    def fails():
        with small(tmp_path / "new") as writer:
            put(writer)
            writer.flush()
            raise RuntimeError("producer died")

    with pytest.raises(RuntimeError):
        fails()
    assert [p.name for p in tmp_path.iterdir()] == [".new.partial"]
    assert not list((tmp_path / ".new.partial").glob("metadata.yaml"))


def test_empty_bag_is_readable(tmp_path):
    small(tmp_path / "empty").close()
    assert list(read_messages(tmp_path / "empty")) == []


def test_existing_name_is_refused(tmp_path):
    small(tmp_path / "new").close()
    with pytest.raises(InputError, match="exists already"):
        small(tmp_path / "new")


def test_overwrite_replaces_only_when_complete(tmp_path):
    with small(tmp_path / "new") as writer:
        put(writer, 1)
    writer = small(tmp_path / "new", overwrite=True)
    put(writer, 2)
    assert len(list(read_messages(tmp_path / "new"))) == 1
    writer.close()
    assert len(list(read_messages(tmp_path / "new"))) == 2
    assert [p.name for p in tmp_path.iterdir()] == ["new"]


def test_overwrite_never_replaces_another_folder(tmp_path):
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="is not a bag"):
        small(tmp_path / "home", overwrite=True)
    assert (tmp_path / "home" / "letter.txt").read_text() == "dear"


def test_unfinished_recording_is_put_aside(tmp_path):
    for _ in range(2):
        small(tmp_path / "new").abandon()
    small(tmp_path / "new").close()
    assert sorted(p.name for p in tmp_path.iterdir()) == [".new.partial.1", ".new.partial.2", "new"]


def test_name_being_recorded_is_refused(tmp_path):
    first = small(tmp_path / "new")
    with pytest.raises(InputError, match="being recorded by another process"):
        small(tmp_path / "new", overwrite=True)
    first.close()


@pytest.mark.parametrize("name", ["file/bag", "/proc/nowhere/bag", "/"])
def test_unwritable_place_is_one_clear_line(tmp_path, name):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(InputError, match=r"^bag = ") as error:
        small(tmp_path / name)
    assert "\n" not in str(error.value)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_too_little_space_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match="MiB are free"):
        small(tmp_path / "new", expected_bytes=1 << 60)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
def test_full_disk_while_recording(tmp_path, monkeypatch, code):
    writer = small(tmp_path / "new", chunk_size=1000)
    put(writer, 100)

    def full(fd, data):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(bag_module.os, "write", full)
    with pytest.raises(ComputationError, match=r"\.new\.partial\.$") as error:
        put(writer, 100)
    assert ("the disk is full" in str(error.value)) == (code == errno.ENOSPC)
    monkeypatch.undo()
    writer.abandon()
    assert [p.name for p in tmp_path.iterdir()] == [".new.partial"]


def test_file_that_may_not_grow(tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = small(tmp_path / "new")
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, hard))

    def fill():
        noise = np.random.default_rng(0)
        with writer:
            for i in range(100):
                writer.write("/time", noise.bytes(100_000), log_time_ns=i, publish_time_ns=i)

    try:
        with pytest.raises(ComputationError, match=r"bag .*new: File too large"):
            fill()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert [p.name for p in tmp_path.iterdir()] == [".new.partial"]


def test_topic_twice_is_refused(tmp_path):
    writer = small(tmp_path / "new")
    with pytest.raises(ValueError, match="already"):
        writer.add_topic("/time", TIME_TYPE, TIME)
    writer.abandon()


def test_writer_needs_no_ros(tmp_path):
    import subprocess
    import sys

    code = (
        "import sys; import owt_postproc.bag, owt_postproc.bag_report, owt_postproc.report; "
        "ros = {'rclpy', 'owt_msgs', 'std_msgs', 'builtin_interfaces', 'plotly'}; "
        "assert not ros & {name.split('.')[0] for name in sys.modules}"
    )
    folder = Path(bag_module.__file__).parents[2]
    model = folder.parent / "owt_model"
    env = {**os.environ, "PYTHONPATH": f"{folder}:{model}"}
    assert subprocess.run([sys.executable, "-c", code], env=env, cwd=tmp_path, check=False).returncode == 0
