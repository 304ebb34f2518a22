"""Bags on ROS topics again: bytes, order, pace and choice, over real DDS from a process of its own."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from rclpy.serialization import deserialize_message

from bag_tools import begin, rewrite, run_messages, write_run
from local_graph import assert_messages_equal, read_by_rosbags
from owt_bringup.cli import main
from owt_bringup.replay_plan import ReplayPlan, Window
from owt_bringup.transport import PROFILE_VARIABLE
from owt_postproc.bag import BagWriter
from owt_postproc.bag_source import BagSource, RawMessage
from owt_ros.topics import MEMBER_STRESS, RECORDED, recorded
from owt_ros.wire import peek_stamp
from replay_listener import Listener, case, messages_of

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]

SECOND = 1_000_000_000
#: Wall time in s by which a machine under load may be late.
SLACK_S = 0.6
GOLDEN = Path(__file__).parents[1] / "bags" / "golden"
LATCHED = ("/owt/model", "/owt/sea_state", "/owt/load_basis", "/owt/reduced_model")
NESTED = f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
CDR = b"\x00\x01\x00\x00"


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("replay") / "run", case())


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory, bag: Path) -> Path:
    return rewrite(bag, tmp_path_factory.mktemp("short") / "run")


@pytest.fixture
def listener(domain: int) -> Iterator[Listener]:
    found = Listener(domain)
    yield found
    found.close()


def test_the_same_bytes_in_the_same_order(bag: Path, listener: Listener) -> None:
    """As fast as they are taken."""
    wanted = messages_of(bag)
    out = listener.replay(bag, "--rate", "0")
    assert listener.heard == wanted
    assert out == f"{sum(map(len, wanted.values()))} messages on {len(recorded(case()))} topics\n"
    # Negative control: one message in another place.
    swapped = [*wanted["/owt/energy"][1::-1], *wanted["/owt/energy"][2:]]
    assert listener.heard != wanted | {"/owt/energy": swapped}


@pytest.mark.parametrize("own_profile", [False, True], ids=["", "own profile"])
def test_nothing_is_lost_of_many_messages_to_a_slow_reader(
    tmp_path: Path, listener: Listener, own_profile: bool
) -> None:
    """Ticks without a pace of their own to a reader that pauses; also with a user's profile of Fast DDS."""
    many, n = tmp_path / "many", 2000
    if own_profile:
        listener.environment[PROFILE_VARIABLE] = os.environ.get(PROFILE_VARIABLE, str(tmp_path / "none.xml"))
    with begin(many, case()) as writer:
        for i in range(n):
            data = CDR + i.to_bytes(4, "little") + bytes(4)
            writer.write("/clock", data, log_time_ns=1 + i, publish_time_ns=i * SECOND)
    process = listener.start(many, "--rate", "0")
    listener.spin_until(lambda: listener.count >= 100)
    time.sleep(1.0)  # the pause of the reader; nothing waits for it
    listener.spin_until(lambda: process.poll() is not None and listener.count >= n)
    assert [peek_stamp(data) // SECOND for data in listener.heard["/clock"]] == list(range(n))
    assert process.communicate()[0].startswith(f"{n} messages")


def test_twice_the_rate_takes_half_the_time(bag: Path, domain: int) -> None:
    """From the first to the last tick of the recorded clock there are 5.5 s of simulated time."""
    taken = {}
    for rate in (2.0, 4.0):
        listener = Listener(domain)
        listener.replay(bag, "--rate", str(rate), "--topics", "/clock", "/owt/model")
        at = listener.at["/clock"]
        taken[rate] = at[-1] - at[0]
        steps = [later - earlier for earlier, later in pairwise(at)]
        assert max(steps) < 0.5 / rate + SLACK_S, "block by block, not all at once"
        listener.close()
    for rate, seconds in taken.items():
        assert abs(seconds - 5.5 / rate) < SLACK_S, taken
    # Negative control: the tolerance tells one rate from the other.
    assert abs(taken[4.0] - 5.5 / 2.0) > SLACK_S


def test_seek_and_duration(bag: Path, listener: Listener) -> None:
    """From 2 s for 1.5 s: latched topics, and three blocks of every stream."""
    listener.replay(bag, "--rate", "0", "--start", "2", "--duration", "1.5")

    def keep(message: RawMessage) -> bool:
        return message.topic in LATCHED or 2 * SECOND <= message.publish_time_ns < 3.5 * SECOND

    assert listener.heard == messages_of(bag, keep)
    ticks = [peek_stamp(data) for data in listener.heard["/clock"]]
    assert ticks == [2 * SECOND, 5 * SECOND // 2, 3 * SECOND]
    # Negative control: the whole bag is more.
    assert listener.heard != messages_of(bag)


def test_the_rounds_of_a_loop_are_the_same_and_ctrl_c_ends_it(bag: Path, listener: Listener) -> None:
    arguments = ("--rate", "20", "--loop", "--topics", "/clock", "/owt/sea_state", "/owt/energy")
    process = listener.start(bag, *arguments)
    listener.spin_until(lambda: len(listener.heard.get("/clock", [])) >= 30)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    listener.spin_until(lambda: process.poll() is not None, 10.0)
    assert time.monotonic() - began < 10.0, "it never ends by itself"
    out, err = process.communicate()
    assert (process.returncode, err) == (0, "")
    assert "messages on 3 topics" in out
    one = messages_of(bag, lambda message: message.topic in arguments)
    assert set(listener.heard) == set(one)
    for label, wanted in one.items():
        n = len(wanted)
        assert listener.heard[label][:n] == listener.heard[label][n : 2 * n] == wanted, label


def test_ctrl_c_before_the_end_is_no_success(bag: Path, listener: Listener) -> None:
    process = listener.start(bag, "--rate", "0.01")
    listener.spin_until(lambda: "/clock" in listener.heard)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    assert process.wait(10.0) == 130
    assert time.monotonic() - began < 10.0, "in the middle of a pause that lasts longer"
    assert process.communicate()[1] == "error: interrupted\n"


def test_an_own_clock_ticks_in_simulated_time(bag: Path, listener: Listener) -> None:
    listener.replay(bag, "--rate", "0", "--clock", "20", "--start", "1")
    ticks = [peek_stamp(data) for data in listener.heard["/clock"]]
    assert ticks == [SECOND + i * SECOND // 20 for i in range(len(ticks))]
    assert ticks[-1] >= 5.5 * SECOND, "up to the last block"
    assert len(listener.heard["/owt/nodal_loads"]) == 10


def test_a_namespace_goes_before_the_names(bag: Path, domain: int) -> None:
    listener, other = Listener(domain, "/north"), Listener(domain)
    listener.replay(bag, "--rate", "0", "--namespace", "north")
    assert listener.heard == messages_of(bag)
    other.spin_until(lambda: True)
    assert not other.heard, "negative control: the root namespace hears nothing"
    listener.close()
    other.close()


def test_a_latecomer_hears_what_is_latched(bag: Path, domain: int) -> None:
    first = Listener(domain)
    process = first.start(bag, "--rate", "0.01")
    first.spin_until(lambda: "/clock" in first.heard)
    late, volatile = Listener(domain), Listener(domain, latched=False)
    late.spin_until(lambda: set(late.heard) >= set(LATCHED))
    volatile.spin_until(lambda: True)
    assert not set(LATCHED) & set(volatile.heard), "negative control: who asks for nothing old gets nothing"
    process.send_signal(signal.SIGINT)
    assert process.wait(10.0) == 130
    process.communicate()
    for one in (first, late, volatile):
        one.close()


def test_recompute_publishes_what_the_bag_leaves_out(bag: Path, short: Path, listener: Listener) -> None:
    """Field by field: what lies between the fields to align them is not set by those who write messages."""
    wanted, left = messages_of(bag), messages_of(short)
    listener.replay(short, "--rate", "0", "--recompute")
    assert listener.heard.keys() == wanted.keys()
    for topic in recorded(case()):
        label = topic.label
        for i, messages in enumerate(zip(listener.heard.get(label, []), wanted.get(label, []), strict=True)):
            found, whole = (deserialize_message(data, topic.message) for data in messages)
            assert_messages_equal(label, found, whole)
            if label in ("/owt/modal_state", "/owt/member_stress", "/owt/energy"):  # negative control
                with pytest.raises(AssertionError):
                    assert_messages_equal(label, deserialize_message(left[label][i], topic.message), whole)


def test_without_recompute_the_bytes_are_those_of_the_bag(short: Path, listener: Listener) -> None:
    listener.replay(short, "--rate", "0", "--topics", "/owt/member_stress")
    assert listener.heard == {"/owt/member_stress": messages_of(short)["/owt/member_stress"]}


def test_a_bag_that_is_being_written_is_replayed_as_far_as_it_goes(
    tmp_path: Path, listener: Listener
) -> None:
    writer = begin(tmp_path / "run", case())
    for i, (label, at, data) in enumerate(list(run_messages(case()))[:40]):
        writer.write(label, data, log_time_ns=i, publish_time_ns=at)
    writer.flush()
    listener.replay(tmp_path / "run", "--rate", "0")
    assert listener.count == 40
    writer.abandon()


def foreign(path: Path) -> Path:
    """A bag of another system: wall time in the place of simulated time, a type that is not installed."""
    with BagWriter(path) as writer:
        writer.add_topic("/clock", "rosgraph_msgs/msg/Clock", "builtin_interfaces/Time clock\n" + NESTED)
        writer.add_topic("/odd", "nobody_msgs/msg/Odd", "int32 a\n")
        for i in range(5):
            at = 1_700_000_000 * SECOND + i * SECOND // 2
            stamp = (at // SECOND).to_bytes(4, "little") + (at % SECOND).to_bytes(4, "little")
            writer.write("/clock", CDR + stamp, log_time_ns=at, publish_time_ns=at)
            writer.write("/odd", CDR + bytes(4), log_time_ns=at, publish_time_ns=at)
    return path


def test_no_message_is_too_early_for_a_whole_bag(tmp_path: Path, bag: Path) -> None:
    """Messages sent by several machines arrive in another order; and a choice of topics moves no window."""
    with BagWriter(tmp_path / "jitter") as writer:
        writer.add_topic("/clock", "rosgraph_msgs/msg/Clock", "builtin_interfaces/Time clock\n" + NESTED)
        for received, sent in enumerate((50, 20, 70)):
            writer.write("/clock", CDR + bytes(8), log_time_ns=100 + received, publish_time_ns=sent)
    with BagSource(tmp_path / "jitter") as source:
        assert [message.publish_time_ns for message in ReplayPlan(source).round()] == [50, 20, 70]
        late = ReplayPlan(source, window=Window(10e-9)).round()
        assert [message.publish_time_ns for message in late] == [70]
    with BagSource(bag) as source:
        chosen = ReplayPlan(source, topics=["/owt/fatigue"], window=Window(2.0, 1.0)).round()
        stamps = [message.publish_time_ns for message in chosen]
    assert stamps == [int(2.4 * SECOND), int(2.9 * SECOND)]


def written_by_rosbags(path: Path, storage: str = "MCAP") -> Path:
    """The clock of :func:`foreign`, by another library."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        clock = writer.add_connection("/clock", "rosgraph_msgs/msg/Clock", typestore=types)
        for data in messages_of(foreign(path.with_name("pattern")))["/clock"]:
            writer.write(clock, peek_stamp(data), data)
    return path


@pytest.mark.parametrize("make", [foreign, written_by_rosbags])
def test_bags_of_other_systems(tmp_path: Path, listener: Listener, make: Callable[[Path], Path]) -> None:
    path = make(tmp_path / "other")
    listener.replay(path, "--rate", "10", "--topics", "/clock", "--start", "1")
    assert listener.heard == {"/clock": messages_of(path)["/clock"][2:]}


def test_an_sqlite_recording_is_told_how_to_become_readable(
    tmp_path: Path, domain: int, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new = written_by_rosbags(tmp_path / "old", "SQLITE3"), tmp_path / "new"
    assert main(["replay", str(old), "--domain", str(domain)]) == 1
    error = capsys.readouterr().err
    assert (
        "is an SQLite recording. Convert it: rosbags-convert --src BAG --dst NEW --dst-storage mcap." in error
    )
    command = [Path(sys.executable).parent / "rosbags-convert", "--src", old, "--dst", new]
    subprocess.run([*command, "--dst-storage", "mcap"], check=True)
    assert main(["replay", str(new), "--domain", str(domain), "--rate", "0"]) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--topics", "/owt/model", "/owt/magic"],
            "topics = '/owt/magic': is not in the bag, which has",
        ),
        (["--rate", "-1"], "rate = -1.0: must lie in 0 to"),
        (["--rate", "nan"], "rate = nan: must lie in 0 to"),
        (["--start", "-1"], "start = -1.0: must be 0 s or more"),
        (["--start", "1e3"], "start = 1000.0: leaves no message"),
        (["--duration", "0"], "duration = 0.0: must be more than 0 s"),
        (["--clock", "-5"], "clock = -5.0: must lie in"),
        (["--domain", "400"], "domain = 400: must lie in 0 to 232"),
        (["--namespace", "9 lives"], "namespace = '9 lives': is not allowed"),
        (["--wait", "0.2"], "wait = 0.2: s have passed and nobody subscribes"),
    ],
    ids=str,
)
def test_bad_input_is_one_line(
    bag: Path, domain: int, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = arguments if "--domain" in arguments else [*arguments, "--domain", str(domain)]
    assert main(["replay", str(bag), *given]) == 1
    found = capsys.readouterr().err
    assert found.startswith(f"error: {message}"), found
    assert found.count("\n") == 1


def test_a_type_that_cannot_be_published_is_named(
    tmp_path: Path, domain: int, capsys: pytest.CaptureFixture[str]
) -> None:
    path = foreign(tmp_path / "other")
    assert main(["replay", str(path), "--domain", str(domain)]) == 1
    found = capsys.readouterr().err
    assert "topics = '/odd': is of type nobody_msgs/msg/Odd, which is not installed" in found
    other = tmp_path / "changed"
    with BagWriter(other) as writer:
        writer.add_topic("/clock", "rosgraph_msgs/msg/Clock", "uint64 clock\n")
        writer.write("/clock", CDR + bytes(8), log_time_ns=1, publish_time_ns=1)
    assert main(["replay", str(other), "--domain", str(domain)]) == 1
    found = capsys.readouterr().err
    assert "topics = '/clock': was recorded with another definition of rosgraph_msgs/msg/Clock than" in found


def test_messages_of_an_older_definition_are_those_installed(listener: Listener) -> None:
    """The committed bag, whose stress has no list of ends and whose load basis no damping."""
    listener.replay(GOLDEN, "--rate", "0", "--topics", *(topic.label for topic in RECORDED))
    recorded_messages = read_by_rosbags(GOLDEN)
    compared = 0
    for topic in RECORDED:
        found = [deserialize_message(data, topic.message) for data in listener.heard.get(topic.label, [])]
        for one, two in zip(found, recorded_messages[topic.label], strict=topic.label in listener.heard):
            for name in two.__dataclass_fields__:
                if not name.startswith("__") and name not in ("header", "clock", "status"):
                    np.testing.assert_array_equal(getattr(one, name), getattr(two, name), name)
                    compared += 1
    assert compared > 50
    assert len(deserialize_message(listener.heard["/owt/member_stress"][0], MEMBER_STRESS.message).end) == 0
