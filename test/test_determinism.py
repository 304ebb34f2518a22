"""The same case and seed give the same bytes: in two runs of the graph, and in one process."""

from pathlib import Path
from typing import Any

import pytest
from mcap.records import Attachment, Channel, Chunk, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from rosbags.rosbag2 import Reader

from local_graph import expected_bytes, short_case
from owt_bringup.graph import run_graph
from owt_ros.topics import MEMBER_STRESS

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]


def recording(bag: Path) -> list[tuple[Any, ...]]:
    """Everything in a bag but its receive times, in the order of the file, chunk by chunk."""
    found: list[tuple[Any, ...]] = []
    kept = (Schema, Channel, Attachment, Metadata)  # the one called rosbag2 holds receive times
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream:
        for record in StreamReader(stream, emit_chunks=True).records:
            if isinstance(record, Chunk):
                inside = [r for r in breakup_chunk(record) if isinstance(r, Message)]
                found.append(tuple((m.channel_id, m.sequence, m.publish_time, bytes(m.data)) for m in inside))
            elif isinstance(record, kept) and getattr(record, "name", "") != "rosbag2":
                found.append((str(record),))
    return found


def messages(bag: Path) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {}
    with Reader(bag) as reader:
        for connection, _, raw in reader.messages():
            found.setdefault(connection.topic, []).append(bytes(raw))
    return found


@pytest.mark.parametrize("record", ["default", "all"])
def test_two_runs_and_the_run_in_one_process_give_the_same_bytes(tmp_path: Path, record: str) -> None:
    case = short_case(wave={"order": 2}, stream={"block": 20})
    bags = [tmp_path / "one", tmp_path / "two"]
    for bag in bags:
        run_graph(case, bag, record=record)
    one, two = map(recording, bags)
    assert one == two
    assert len([entry for entry in one if entry and isinstance(entry[0], tuple)]) >= 2, "several chunks"
    found, wanted = messages(bags[0]), expected_bytes(case, everything=record == "all")
    for label, expected in wanted.items():
        assert found[label] == expected, label
    kept = expected_bytes(case, everything=record != "all")
    assert found[MEMBER_STRESS.label] != kept[MEMBER_STRESS.label], "the other choice differs"


def test_another_seed_gives_other_bytes(tmp_path: Path) -> None:
    first, second = (short_case(sea_state={"hs_m": 2.0, "tp_s": 8.0, "seed": seed}) for seed in (3, 4))
    run_graph(first, tmp_path / "bag")
    found, other = messages(tmp_path / "bag"), expected_bytes(second, everything=False)
    same = [label for label, expected in other.items() if found[label] == expected]
    assert set(same) <= {"/owt/model"}, "what the sea changes differs"
