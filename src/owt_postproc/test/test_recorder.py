"""The order of a recording: that of the case, whatever arrives when."""

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.rosbag2 import Reader

from owt_model.config import CaseConfig, parse_case
from owt_model.contracts import ReducedDescription
from owt_model.errors import ComputationError
from owt_model.structure import case_structure
from owt_postproc.bag_reader import read_messages
from owt_postproc.recorder import Recorder
from owt_ros import topics
from owt_ros.cdr import canonical
from owt_ros.convert import stamp
from owt_ros.selection import Selection, most_used
from owt_ros.topics import Kind, Topic, recorded
from owt_ros.wire import doubles

BLOCKS = 5
SECOND = 1_000_000_000
#: What a block of one sample must hold.
SAMPLE: dict[Topic, dict[str, list[float]]] = {
    topics.ENERGY: {"potential": [1.0], "kinetic": [2.0]},
    topics.TOWER_TOP_LOAD: {"wrench": [0.0] * 6},
}


def messages(case: CaseConfig) -> dict[Topic, list[tuple[bytes, int, bool]]]:
    """A short run: what is latched once, and five blocks of a second of everything else."""
    found, model_hash = {}, case_structure(case.structure).content_hash
    for topic in recorded(case):
        if topic is topics.DIAGNOSTICS:
            continue
        count = 1 if topic.kind is Kind.LATCHED else BLOCKS
        made = []
        for i in range(count):
            message = topic.message()
            if topic.kind is Kind.DATA:
                message.sequence, message.last = i, i == count - 1
            for name, value in {"dt": 1.0, "samples": 1, "model_hash": model_hash}.items():
                if hasattr(message, name):
                    setattr(message, name, value)
            for name, numbers in SAMPLE.get(topic, {}).items():
                setattr(message, name, doubles(numbers))
            if topic is topics.CLOCK:
                message.clock = stamp(i * SECOND)
            made.append((bytes(serialize_message(message)), i * SECOND, i == count - 1))
        found[topic] = made
    return found


def new(path: Path, case: CaseConfig, **options: Any) -> Recorder:
    selection = Selection(everything=options.get("everything", True), ends=2)
    return Recorder(str(path), case, overwrite=False, selection=selection)


def shuffled(queues: dict[Topic, list[Any]], seed: int) -> list[tuple[Topic, Any]]:
    """An order of arrival: that of each topic is kept."""
    rng, left = random.Random(seed), {topic: list(queue) for topic, queue in queues.items()}
    order = []
    while any(left.values()):
        topic = rng.choice([topic for topic, queue in left.items() if queue])
        order.append((topic, left[topic].pop(0)))
    return order


def content(bag: Path) -> list[tuple[str, int]]:
    return [(m.topic, getattr(m.content, "sequence", 0)) for m in read_messages(bag)]


@pytest.mark.parametrize("wind", [None, {"thrust": {}}])
def test_the_order_does_not_depend_on_what_arrives_when(tmp_path: Path, wind: Any) -> None:
    case = parse_case({"wind": wind})
    queues, orders = messages(case), set()
    for seed in range(8):
        recorder = new(tmp_path / str(seed), case)
        arrival = shuffled(queues, seed)
        for i, (topic, (cdr, time_ns, last)) in enumerate(arrival):
            assert not recorder.is_complete, i
            recorder.put(topic, cdr, time_ns=time_ns, last=last)
        assert recorder.is_complete
        assert recorder.held == 0
        recorder.close()
        orders.add(tuple(content(tmp_path / str(seed))))
        assert [topic.label for topic, _ in arrival] != [label for label, _ in min(orders)]
    (order,) = orders
    latched = [t.label for t in recorded(case) if t.kind is Kind.LATCHED]
    chain = [t.label for t in recorded(case) if t.kind is Kind.DATA or t is topics.CLOCK]
    assert [label for label, _ in order] == latched + chain * BLOCKS


def test_a_recording_that_breaks_off_keeps_what_waited(tmp_path: Path) -> None:
    case = parse_case({})
    queues = messages(case)
    recorder = new(tmp_path / "bag", case)
    for topic in (topics.MODEL, topics.NODAL_LOADS, topics.ENERGY):
        for cdr, time_ns, last in queues[topic]:
            recorder.put(topic, cdr, time_ns=time_ns, last=last)
    assert recorder.held == 2 * BLOCKS
    recorder.break_off()
    found = content(tmp_path / ".bag.partial")
    assert sorted(found) == sorted(
        [("/owt/model", 0)] + [(t, i) for t in ("/owt/nodal_loads", "/owt/energy") for i in range(BLOCKS)]
    )


def test_a_mark_stands_where_the_recording_is(tmp_path: Path) -> None:
    case = parse_case({})
    recorder = new(tmp_path / "bag", case)
    order = shuffled(messages(case), 1)
    for i, (topic, (cdr, time_ns, last)) in enumerate(order):
        if i == len(order) // 2:
            recorder.put(topics.DIAGNOSTICS, bytes(serialize_message(DiagnosticArray())), time_ns=0)
        recorder.put(topic, cdr, time_ns=time_ns, last=last)
    recorder.close()
    marks = [i for i, (label, _) in enumerate(content(tmp_path / "bag")) if label == "/diagnostics"]
    assert len(marks) == 1
    assert 0 < marks[0] < len(order)


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        (topics.MODEL, "a second message on /owt/model: only one node may publish it"),
        (topics.CLOCK, "/clock went from 4 s to 4 s: only one node may publish it"),
    ],
)
def test_a_second_producer_is_an_error(tmp_path: Path, topic: Topic, message: str) -> None:
    case = parse_case({})
    recorder = new(tmp_path / "bag", case)
    queue = messages(case)[topic]
    for cdr, time_ns, last in queue:
        recorder.put(topic, cdr, time_ns=time_ns, last=last)
    with pytest.raises(ComputationError, match=message):
        recorder.put(topic, queue[-1][0], time_ns=queue[-1][1])
    recorder.break_off()


@pytest.mark.parametrize(
    ("topic", "field", "message"),
    [
        (topics.SEA_STATE, "hs_m", "/owt/sea_state: hs_m holds NaN or inf"),
        (topics.SURFACE_ELEVATION, "dt", "SurfaceElevation 0: dt = nan s with 1 samples is no block"),
        (topics.ENERGY, "kinetic", "/owt/energy block 0: kinetic holds NaN or inf"),
        (topics.ENERGY, "potential", r"Energy 0: potential has 2 values, not those of \[1\]"),
        (topics.NODAL_LOADS, "model_hash", "/owt/nodal_loads belongs to model aaaaaaaaaaaa, this node has "),
        (topics.REDUCED_MODEL, "model_hash", "/owt/reduced_model belongs to model aaaaaaaaaaaa"),
    ],
)
def test_what_cannot_be_is_not_recorded(tmp_path: Path, topic: Topic, field: str, message: str) -> None:
    case = parse_case({})
    cdr, time_ns, last = messages(case)[topic][0]
    wrong = deserialize_message(cdr, topic.message)
    bad = {"potential": [1.0, 2.0], "model_hash": "a" * 64}.get(field, float("nan"))
    if isinstance(getattr(wrong, field), (str, float)):
        setattr(wrong, field, bad)
    else:
        setattr(wrong, field, doubles(bad))
    recorder = new(tmp_path / "bag", case)
    with pytest.raises(ComputationError, match=message):
        recorder.put(topic, bytes(serialize_message(wrong)), time_ns=time_ns, last=last)
    recorder.put(topic, cdr, time_ns=time_ns, last=last)
    recorder.break_off()


def test_log_times_increase(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Readers sort by log time: a clock of the machine that steps back does not change the order."""
    case = parse_case({})
    times = iter(range(10_000, 0, -1))
    monkeypatch.setattr("owt_postproc.recorder.time.time_ns", lambda: next(times))
    recorder = new(tmp_path / "bag", case)
    for topic, (cdr, time_ns, last) in shuffled(messages(case), 3):
        recorder.put(topic, cdr, time_ns=time_ns, last=last)
    recorder.close()
    logged = [m.log_time_ns for m in read_messages(tmp_path / "bag")]
    assert logged == sorted(set(logged))


def reduced(usage: list[float]) -> ReducedDescription:
    names = tuple(f"M{i}" for i in range(len(usage)))
    return ReducedDescription(
        "m", "h", "CB10", (), np.zeros(0), np.zeros(0), names, -1, end_usage=np.array(usage)
    )


def test_the_default_keeps_what_the_rest_is_computed_from() -> None:
    selection = Selection(everything=False, ends=2)
    selection.learn(reduced([1.0, 5.0, 2.0, 4.0]))
    stress = topics.MEMBER_STRESS.message(samples=2, axial=doubles(range(8)), von_mises=doubles(range(8, 16)))
    for name in ("bending_y", "bending_z"):
        setattr(stress, name, doubles(range(8)))
    cdr = bytes(serialize_message(stress))
    copy = deserialize_message(cdr, topics.MEMBER_STRESS.message)
    kept = deserialize_message(selection.of(topics.MEMBER_STRESS, cdr, copy), topics.MEMBER_STRESS.message)
    assert list(kept.end) == [1, 3]
    assert list(kept.axial) == [1.0, 3.0, 5.0, 7.0]
    assert list(kept.von_mises) == [9.0, 11.0, 13.0, 15.0]
    whole = Selection(everything=True, ends=2)
    whole.learn(reduced([1.0, 5.0, 2.0, 4.0]))
    assert whole.of(topics.MEMBER_STRESS, cdr, stress) == cdr
    modal = topics.MODAL_STATE.message(
        samples=1, displacement=doubles([1.0]), velocity=doubles([2.0]), acceleration=doubles([3.0])
    )
    kept = deserialize_message(selection.of(topics.MODAL_STATE, b"", modal), topics.MODAL_STATE.message)
    assert (list(kept.displacement), list(kept.velocity), list(kept.acceleration)) == ([1.0], [], [])


def test_equal_ends_are_chosen_in_their_order() -> None:
    usage = np.array([1.0, 3.0, 3.0 + 1e-14, 3.0 - 1e-14, 2.0])
    assert list(most_used(usage, 2)) == [1, 2]
    assert list(most_used(usage, 9)) == [0, 1, 2, 3, 4]
    assert list(most_used(np.zeros(3), 1)) == [0]


def test_bytes_in_the_bag_are_canonical(tmp_path: Path) -> None:
    case = parse_case({})
    recorder = new(tmp_path / "bag", case, everything=False)
    classes = {topic.label: topic.message for topic in recorded(case)}
    for topic, (cdr, time_ns, last) in shuffled(messages(case), 5):
        recorder.put(topic, cdr + b"rest", time_ns=time_ns, last=last)
    recorder.close()
    with Reader(tmp_path / "bag") as reader:
        for connection, _, raw in reader.messages():
            assert canonical(classes[connection.topic], bytes(raw)) == bytes(raw)
