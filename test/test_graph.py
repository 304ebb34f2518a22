"""The graph as processes: recorded, read back by an independent library, compared, broken on purpose."""

import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml
from lifecycle_msgs.msg import Transition
from owt_msgs.msg import NodeStatus

from local_graph import assert_messages_equal, expected_messages, node_processes, read_by_rosbags, short_case
from owt_bringup.domain import own_domain
from owt_bringup.graph import Timeouts, run_graph
from owt_bringup.process import Child, find_executable
from owt_bringup.supervisor import Supervisor
from owt_bringup.transport import shared_memory_profile
from owt_campaign.pipeline import prepare_case, stream_case
from owt_model.config import parse_case
from owt_model.errors import InputError, OwtError
from owt_postproc.bag_reader import read_files
from owt_ros.topics import POSTPROC, RECORDED, STRUCTURE, WAVE

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]


def partial_of(bag: Path) -> Path:
    return bag.with_name(f".{bag.name}.partial")


def test_the_bag_holds_the_numbers_of_the_run_in_one_process(tmp_path: Path) -> None:
    case, bag = short_case(wave={"order": 2}), tmp_path / "bags" / "run"
    seen: list[tuple[float, float]] = []
    result = run_graph(
        case, bag, record="all", progress=lambda reached, duration: seen.append((reached, duration))
    )
    assert result.bag == bag
    assert sorted(p.name for p in bag.iterdir()) == ["log", "metadata.yaml", "run_0.mcap"]
    assert [p.name for p in bag.parent.iterdir()] == ["run"], "nothing is left beside the bag"
    assert seen[-1][1] == case.time.duration_s
    assert [reached for reached, _ in seen] == sorted(reached for reached, _ in seen)
    recorded, run = read_by_rosbags(bag), prepare_case(case)
    assert set(recorded) == {topic.label for topic in RECORDED}
    for label, messages in expected_messages(run, list(stream_case(run))).items():
        assert len(recorded[label]) == len(messages), label
        for one, two in zip(messages, recorded[label], strict=True):
            assert_messages_equal(label, one, two)
    assert [clock.clock.sec for clock in recorded["/clock"]] == [0, 5, 10, 15]
    assert result.statistics["messages"] == {label: len(found) for label, found in recorded.items()}
    names = {status.name for entry in recorded["/diagnostics"] for status in entry.status}
    assert names <= {WAVE, STRUCTURE, POSTPROC}, "rates hold wall time and are not recorded"
    metadata = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert metadata["message_count"] == sum(len(found) for found in recorded.values())


def test_the_case_of_a_bag_runs_again_without_the_file_of_its_sea(tmp_path: Path) -> None:
    """A measured record: the bag's case holds components, and gives the numbers that were recorded."""
    record, bag = tmp_path / "record.csv", tmp_path / "run"
    record.write_text("".join(f"{i * 0.5:.1f},{math.sin(0.9 * i * 0.5)!r}\n" for i in range(100)))
    case = short_case(sea_state=None, measured={"path": str(record), "cutoff_rad_s": 2.0})
    run_graph(case, bag, record="all")
    record.unlink()
    again = parse_case(read_files(bag).case)
    assert again.measured is None
    assert again.components is not None
    run, recorded = prepare_case(again), read_by_rosbags(bag)
    for label, messages in expected_messages(run, list(stream_case(run))).items():
        for one, two in zip(messages, recorded[label], strict=True):
            assert_messages_equal(label, one, two)
    with pytest.raises(InputError, match=r"record\.csv"):  # the case as it was given needs its file
        run_graph(case, tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_a_bag_is_replaced_only_on_demand(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    run_graph(short_case(), bag)
    before = (bag / "bag_0.mcap").stat().st_ino
    with pytest.raises(InputError, match="exists already"):
        run_graph(short_case(), bag)
    run_graph(short_case(), bag, overwrite=True)
    assert (bag / "bag_0.mcap").stat().st_ino != before


def test_two_graphs_at_a_time_do_not_hear_each_other(tmp_path: Path) -> None:
    results: dict[int, Any] = {}

    def run(seed: int) -> None:
        case = short_case(sea_state={"hs_m": 1.0, "tp_s": 8.0, "seed": seed})
        results[seed] = run_graph(case, tmp_path / str(seed))

    threads = [threading.Thread(target=run, args=(seed,)) for seed in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results[1].domain != results[2].domain
    for seed, result in results.items():
        (sea,) = read_by_rosbags(result.bag)["/owt/sea_state"]
        assert sea.seed == seed


def long_case() -> Any:
    """A run of about a minute of wall time, whatever the machine."""
    return short_case(time={"n": 600}, stream={"rate": 1.0, "block": 5})


def during_run(progress: list[float], act: Callable[[], None]) -> threading.Thread:
    """Call `act` when the run has progressed a little."""

    def wait() -> None:
        deadline = time.monotonic() + 60.0
        while not (progress and progress[-1] > 1.0) and time.monotonic() < deadline:
            time.sleep(0.02)
        act()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


@contextmanager
def gone_within(children: dict[str, Child], seconds: float) -> Iterator[None]:
    """Check that no child outlives the block by more than `seconds`."""
    yield
    deadline = time.monotonic() + seconds
    for child in children.values():
        while child.exit_code is None:
            assert time.monotonic() < deadline, f"{child.name} is still running"
            time.sleep(0.05)


@pytest.mark.parametrize("victim", [WAVE, STRUCTURE, POSTPROC])
def test_a_killed_node_ends_the_run_within_ten_seconds(tmp_path: Path, victim: str) -> None:
    bag, progress, killed = tmp_path / "bag", [], []  # type: ignore[var-annotated]
    children: dict[str, Child] = {}

    def started(processes: dict[str, Child]) -> None:
        children.update(processes)
        during_run(progress, kill)

    def kill() -> None:
        killed.append(time.monotonic())
        os.kill(children[victim].pid, signal.SIGKILL)

    with gone_within(children, 0.0), pytest.raises(OwtError, match=victim) as error:
        run_graph(long_case(), bag, progress=lambda t, _: progress.append(t), on_start=started)
    assert time.monotonic() - killed[0] < 10.0
    assert "\n" not in str(error.value)
    assert "SIGKILL" in str(error.value)
    assert not bag.exists()
    assert list(partial_of(bag).glob("*.mcap"))
    assert (partial_of(bag) / "log" / f"{victim}.log").is_file()
    assert [p.name for p in tmp_path.iterdir()] == [partial_of(bag).name]


@contextmanager
def started_graph(
    folder: Path, domain: int, case: Any
) -> Iterator[tuple[Supervisor, dict[str, Child], dict[str, Child]]]:
    """Start the processes of a graph without the bring-up's reaction to faults.

    Yields the supervisor, the processes, and those of them that it watches.
    """
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    with node_processes(case, folder, environment) as children:
        watched = dict(children)
        with Supervisor(domain, watched, lambda: None) as graph:
            graph.await_services(60.0)
            yield graph, children, watched


def activate(graph: Supervisor, children: dict[str, Child]) -> None:
    """Bring all nodes to work."""
    graph.change_states(list(children), Transition.TRANSITION_CONFIGURE, 60.0)
    for name in children:
        graph.change_states([name], Transition.TRANSITION_ACTIVATE, 60.0)
    graph.spin_until(lambda: graph.status[POSTPROC].time_s > 1.0, 60.0, "no start")


def test_the_survivors_notice_by_themselves(tmp_path: Path, domain: int) -> None:
    """Without the bring-up: the peers of a killed node report an error within seconds."""
    with started_graph(tmp_path, domain, long_case()) as (graph, children, watched):
        activate(graph, children)
        os.kill(children[STRUCTURE].pid, signal.SIGKILL)
        children[STRUCTURE].wait(5.0)
        watched.clear()  # only listen from now on
        began = time.monotonic()

        def failed(name: str) -> bool:
            return bool(graph.status[name].code == NodeStatus.ERROR)

        graph.spin_until(lambda: failed(WAVE) and failed(POSTPROC), 10.0, "nobody noticed")
        assert time.monotonic() - began < 5.0
        for name in (WAVE, POSTPROC):
            assert "structure_node died or left before the end of" in graph.status[name].message
    assert not (tmp_path / "bag").exists()
    assert read_by_rosbags(partial_of(tmp_path / "bag"))["/owt/member_stress"], "ended cleanly"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("state", ["unconfigured", "configuring", "active"])
def test_a_node_ends_cleanly_within_two_seconds(
    tmp_path: Path, domain: int, number: signal.Signals, state: str
) -> None:
    case = long_case() if state == "active" else short_case(time={"n": 20_000}, wave={"order": 2})
    with started_graph(tmp_path, domain, case) as (graph, children, watched):
        if state == "active":
            activate(graph, children)
        if state == "configuring":
            with pytest.raises(OwtError, match="wave_node not configured within 1 s"):
                graph.change_states(list(children), Transition.TRANSITION_CONFIGURE, 1.0)
        watched.clear()
        for child in children.values():
            child.signal(number)
        began = time.monotonic()
        for child in children.values():
            assert child.wait(5.0), child.name
        took = time.monotonic() - began
        assert {name: child.exit_code for name, child in children.items()} == dict.fromkeys(children, 0)
    assert took < 2.0
    assert not (tmp_path / "bag").exists()
    if state == "active":
        assert read_by_rosbags(partial_of(tmp_path / "bag"))["/owt/energy"]


def test_a_node_that_refuses_ends_the_run_with_its_reason(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    with pytest.raises(OwtError, match=r"^wave_node: water_depth_m = 45\.0: lies more than 1 m from"):
        run_graph(short_case(water_depth_m=45.0), bag)
    assert not bag.exists()


def test_an_unwritable_place_is_refused_before_anything_starts(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        run_graph(short_case(), tmp_path / "file" / "bag", on_start=lambda _: pytest.fail("started"))


def test_timeouts_say_what_was_awaited(tmp_path: Path) -> None:
    with pytest.raises(OwtError, match="could not be reached within 0 s"):
        run_graph(short_case(), tmp_path / "bag", timeouts=Timeouts(start=0.0))


RUNNER = """
import sys, json
from pathlib import Path
sys.path.insert(0, {here!r})
from local_graph import short_case
from owt_bringup.graph import run_graph
case = short_case(time={{"n": 600}}, stream={{"rate": 1.0, "block": 5}})
pids = lambda children: print(json.dumps([c.pid for c in children.values()]), flush=True)
try:
    run_graph(case, Path({bag!r}), on_start=pids, progress=lambda t, _: print(t, flush=True))
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 1), (signal.SIGKILL, -9)]
)
def test_signals_to_the_bring_up_leave_no_process(tmp_path: Path, number: signal.Signals, code: int) -> None:
    bag = tmp_path / "bag"
    script = RUNNER.format(here=str(Path(__file__).parent), bag=str(bag))
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as runner:
        assert runner.stdout is not None
        pids = json.loads(runner.stdout.readline())
        while float(runner.stdout.readline()) < 1.0:
            pass
        runner.send_signal(number)
        began = time.monotonic()
        assert runner.wait(10.0) == code
    while any(_is_running(pid) for pid in pids):
        assert time.monotonic() - began < 10.0
        time.sleep(0.05)
    assert time.monotonic() - began < 5.0
    assert not bag.exists()
    assert read_by_rosbags(partial_of(bag))["/owt/energy"], "the partial bag is closed and readable"


def _is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_nodes_run_under_their_name(tmp_path: Path) -> None:
    def check(children: dict[str, Child]) -> None:
        time.sleep(0.3)
        for name, child in children.items():
            command = Path(f"/proc/{child.pid}/cmdline").read_bytes().decode().split("\0")
            assert any(part.endswith(f"/{name}") for part in command), command
            assert os.getpgid(child.pid) == child.pid

    run_graph(short_case(), tmp_path / "bag", on_start=check)


def test_domains_are_distinct_and_checked() -> None:
    with own_domain() as one, own_domain() as two:
        assert one != two
    with own_domain(42) as domain:
        assert domain == 42
    with pytest.raises(InputError, match="must lie in 0 to 101"), own_domain(500):
        pass


def test_an_executable_that_is_not_installed_is_named() -> None:
    with pytest.raises(InputError, match="owt_wave_node nothing"):
        find_executable("owt_wave_node", "nothing")
    with pytest.raises(InputError, match="no_such_package"):
        find_executable("no_such_package", "nothing")


def test_scarce_shared_memory_keeps_the_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from collections import namedtuple

    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage(64 << 20, 0, 64 << 20))
    profile = shared_memory_profile(3, tmp_path)
    assert profile is not None
    assert f"<segment_size>{(64 << 20) // 6}<" in profile
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage(8 << 20, 0, 8 << 20))
    assert shared_memory_profile(3, tmp_path) is None
