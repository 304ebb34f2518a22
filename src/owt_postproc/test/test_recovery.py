"""What is saved of truncated, damaged and killed recordings: every complete chunk, and nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from mcap.reader import make_reader

from owt_model.errors import InputError
from owt_postproc.bag_reader import read_files, read_messages
from owt_postproc.bag_recovery import recover, recover_report

KILLED = """
import sys, time
from owt_postproc.bag import BagWriter
writer = BagWriter(sys.argv[1], chunk_size=5000)
writer.add_topic("/time", "builtin_interfaces/msg/Time", "int32 sec\\nuint32 nanosec\\n")
i = 0
while True:
    for _ in range(100):
        data = b"\\x00\\x01\\x00\\x00" + i.to_bytes(4, "little") + bytes(4)
        writer.write("/time", data, log_time_ns=i, publish_time_ns=i)
        i += 1
    print(i, flush=True)
    time.sleep(0.002)
"""


@pytest.fixture(scope="module")
def chunked(tmp_path_factory, recording):
    """An invented run in small chunks."""
    return recording.write(
        tmp_path_factory.mktemp("chunked") / "run", recording.run(20.0, 10), chunk_size=50_000
    )


def contents(path):
    return [(m.topic, m.log_time_ns) for m in read_messages(path)]


def chunks(file):
    """Start, end and number of messages of each chunk."""
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    sizes = []
    for index in summary.chunk_indexes:
        with file.open("rb") as stream:
            count = 0
            for channel, offset in index.message_index_offsets.items():
                stream.seek(offset + 1)
                count += (int.from_bytes(stream.read(8), "little") - 6) // 16
                assert channel
        sizes.append((index.chunk_start_offset, index.chunk_start_offset + index.chunk_length, count))
    return sizes


def cut(source: Path, folder: Path, size: int) -> Path:
    """A recording that broke off after `size` bytes: no metadata, no footer."""
    folder.mkdir()
    file = next(source.glob("*.mcap"))
    (folder / file.name).write_bytes(file.read_bytes()[:size])
    return folder


@pytest.mark.parametrize("share", [0.06, 0.3, 0.6, 0.99])
def test_truncated_recording_keeps_every_complete_chunk(tmp_path, chunked, share):
    file = next(chunked.glob("*.mcap"))
    size = int(share * file.stat().st_size)
    expected = sum(count for _, end, count in chunks(file) if end <= size)
    assert len(chunks(file)) > 20
    broken = cut(chunked, tmp_path / ".run.partial", size)
    assert recover(broken, tmp_path / "new") == expected
    found = contents(tmp_path / "new")
    assert found == contents(chunked)[: len(found)]
    assert len(found) == expected


def test_cut_at_the_end_of_a_chunk(tmp_path, chunked):
    spans = chunks(next(chunked.glob("*.mcap")))
    for extra in (0, -1):
        size = spans[10][1] + extra
        broken = cut(chunked, tmp_path / f"cut{extra}", size)
        expected = sum(count for _, end, count in spans if end <= size)
        assert recover(broken, tmp_path / f"new{extra}") == expected


def test_only_the_damaged_chunk_is_lost(tmp_path, chunked):
    file = next(chunked.glob("*.mcap"))
    spans = chunks(file)
    broken = cut(chunked, tmp_path / "broken", file.stat().st_size)
    data = bytearray((broken / file.name).read_bytes())
    middle = (spans[7][0] + spans[7][1]) // 2
    data[middle : middle + 50] = bytes(50)
    (broken / file.name).write_bytes(data)
    report = recover_report(broken, tmp_path / "new")
    assert report.messages == sum(count for *_, count in spans) - spans[7][2]
    assert not report.intact
    assert len(report.damaged) == 1


def test_files_in_the_bag_are_restored(tmp_path, chunked):
    broken = cut(chunked, tmp_path / "broken", 1_500_000)
    recover(broken, tmp_path / "new")
    old, new = read_files(chunked), read_files(tmp_path / "new")
    assert new.case == old.case
    assert new.metadata["versions"] == old.metadata["versions"]


def test_intact_bag_is_copied_byte_by_byte(tmp_path, chunked):
    report = recover_report(chunked, tmp_path / "copy")
    assert report.intact
    assert report.messages == len(contents(chunked))
    names = sorted(p.name for p in chunked.iterdir())
    assert sorted(p.name for p in (tmp_path / "copy").iterdir()) == names
    for name in names:
        assert (tmp_path / "copy" / name).read_bytes() == (chunked / name).read_bytes()


def test_recovery_twice_is_a_copy(tmp_path, chunked):
    broken = cut(chunked, tmp_path / "broken", 1_700_000)
    recover(broken, tmp_path / "new")
    assert recover_report(tmp_path / "new", tmp_path / "again").intact


def test_lost_metadata_is_made_anew(tmp_path, chunked):
    file = next(chunked.glob("*.mcap"))
    broken = cut(chunked, tmp_path / "broken", file.stat().st_size)
    assert recover(broken, tmp_path / "new") == len(contents(chunked))
    assert contents(tmp_path / "new") == contents(chunked)


def test_name_of_an_unfinished_bag_finds_its_partial_folder(tmp_path, chunked):
    cut(chunked, tmp_path / ".demo.partial", 1_000_000)
    assert recover(tmp_path / "demo", tmp_path / "new") > 0


def test_source_is_left_alone(tmp_path, chunked):
    broken = cut(chunked, tmp_path / "broken", 1_400_000)
    before = {p.name: p.read_bytes() for p in broken.iterdir()}
    recover(broken, tmp_path / "new")
    assert {p.name: p.read_bytes() for p in broken.iterdir()} == before


@pytest.mark.parametrize("content", [b"", b"nonsense" * 100, b"\x89MCAP0\r\n"])
def test_nothing_to_recover_is_one_clear_line(tmp_path, content):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(InputError, match="holds nothing that can be read"):
        recover(tmp_path / "x.mcap", tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_missing_bag_and_existing_target(tmp_path, chunked):
    with pytest.raises(InputError, match="holds no MCAP file"):
        recover(tmp_path / "nowhere", tmp_path / "new")
    (tmp_path / "new").mkdir()
    with pytest.raises(InputError, match="exists already"):
        recover(chunked, tmp_path / "new")


def test_killed_recorder(tmp_path):
    """A recorder killed while it writes: what it had written in whole chunks is there."""
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path / "run")],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ),
    )
    assert process.stdout is not None
    written = 0
    while written < 2000:
        written = int(process.stdout.readline())
    process.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.05)
    assert not (tmp_path / "run").exists()
    restored = recover(tmp_path / "run", tmp_path / "new")
    times = [m.log_time_ns for m in read_messages(tmp_path / "new")]
    assert times == list(range(restored))
    assert restored >= written - 200  # one chunk holds about 117 messages
