"""The action RunSeaState and the case check as an operator meets them: a server process, a client by DDS."""

import json
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
import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import WrenchStamped
from owt_msgs.action import RunSeaState
from owt_msgs.msg import NodeStatus
from owt_msgs.srv import CheckCase
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile

from local_graph import assert_messages_equal, expected_messages, read_by_rosbags, short_case
from owt_bringup.domain import own_domain
from owt_bringup.goals import CancelledError, Speed, _status_of, check_case
from owt_bringup.process import Child, find_executable
from owt_bringup.supervisor import NodeError
from owt_campaign.pipeline import prepare_case, stream_case
from owt_model.config import CaseConfig, parse_case
from owt_model.errors import ComputationError, InputError, OwtError, StreamError
from owt_postproc.partial_folder import partial_path
from owt_ros.qos import qos_for
from owt_ros.topics import POSTPROC, STATUS, STRUCTURE, WAVE

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]

ROOT = Path(__file__).parents[1]
Status = RunSeaState.Result


def slow_case() -> CaseConfig:
    """A minute of wall time, whatever the machine."""
    return short_case(time={"n": 600}, stream={"rate": 1.0, "block": 5})


class Operator:
    """A client, and what it hears."""

    def __init__(self, domain: int, namespace: str) -> None:
        self.domain, self.namespace = domain, namespace
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("operator", context=self.context, namespace=namespace, use_global_arguments=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.client = ActionClient(self.node, RunSeaState, "owt/run_sea_state")
        self.check = self.node.create_client(CheckCase, "owt/check_case")
        self.feedback: list[Any] = []
        self.status: list[NodeStatus] = []
        profile = qos_for(STATUS)
        profile.depth = 200
        self.node.create_subscription(NodeStatus, STATUS.name, self.status.append, profile)
        self.spin_until(self.client.server_is_ready)
        self.spin_until(self.check.service_is_ready)

    def spin_until(self, ready: Callable[[], bool], seconds: float = 90.0) -> None:
        deadline = time.monotonic() + seconds
        while not ready():
            assert time.monotonic() < deadline, self.status[-3:]
            self.executor.spin_once(timeout_sec=0.05)

    def wait(self, future: Any) -> Any:
        self.spin_until(future.done)
        return future.result()

    def send(self, case: CaseConfig | str, bag: Path | str, record: str = "") -> Any:
        """Send a goal; return its handle."""
        self.feedback.clear()
        text = case if isinstance(case, str) else case.model_dump_json()
        goal = RunSeaState.Goal(case_json=text, bag=str(bag), record=record)
        return self.wait(self.client.send_goal_async(goal, lambda m: self.feedback.append(m.feedback)))

    def result(self, handle: Any) -> tuple[int, Any]:
        """Wait for the end of a goal; return its state and its result."""
        assert handle.accepted
        answer = self.wait(handle.get_result_async())
        return answer.status, answer.result

    def run(self, *goal: Any) -> tuple[int, Any]:
        return self.result(self.send(*goal))

    def moves(self) -> bool:
        return bool(self.feedback) and self.feedback[-1].time_s > 1.0

    def close(self) -> None:
        self.client.destroy()
        self.executor.shutdown(timeout_sec=1.0)
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        del self.executor, self.node, self.client, self.check, self.context


@contextmanager
def server_and_operator(folder: Path, domain: int, namespace: str) -> Iterator[tuple[Child, Operator]]:
    command = [str(find_executable("owt_bringup", "bringup_node")), "--ros-args", "-r", f"__ns:={namespace}"]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    server = Child("bringup_node", command, folder / "server.log", environment)
    operator = None
    try:
        operator = Operator(domain, namespace)
        yield server, operator
    finally:
        if operator is not None:
            operator.close()
        server.signal(signal.SIGTERM)
        assert server.wait(8.0), server.last_line
    assert server.exit_code == 0, server.log.read_text()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Child, Operator]]:
    """One server for the tests that leave it as it was."""
    with (
        own_domain() as domain,
        server_and_operator(tmp_path_factory.mktemp("server"), domain, "/deck") as both,
    ):
        yield both


def nodes_of(server: Child) -> dict[str, int]:
    """Process ids of the nodes that a server runs, by name."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            command = (entry / "cmdline").read_bytes().decode().split("\0")
        except (OSError, IndexError):
            continue
        name = next(
            (Path(part).name for part in command if Path(part).name in (WAVE, STRUCTURE, POSTPROC)), ""
        )
        if parent == server.pid and name:
            found[name] = int(entry.name)
    return found


def test_a_goal_gives_progress_statistics_and_the_bag_of_the_run_in_one_process(
    place: tuple[Child, Operator], tmp_path: Path
) -> None:
    _, operator = place
    case, bag = short_case(wave={"order": 2}), tmp_path / "bag"
    state, result = operator.run(case, bag, "all")
    assert (state, result.status, result.message) == (GoalStatus.STATUS_SUCCEEDED, Status.SUCCEEDED, "")
    assert result.bag == str(bag)
    assert json.loads(result.statistics_json) == json.loads((bag / "summary.json").read_text())
    assert (bag / "report.html").is_file()
    times = [entry.time_s for entry in operator.feedback]
    assert times == sorted(times)
    assert times[0] == 0.0
    assert times[-1] == case.time.duration_s
    assert {entry.duration_s for entry in operator.feedback} == {case.time.duration_s}
    run, recorded = prepare_case(case), read_by_rosbags(bag)
    for label, messages in expected_messages(run, list(stream_case(run))).items():
        assert len(recorded[label]) == len(messages), label
        for one, two in zip(messages, recorded[label], strict=True):
            assert_messages_equal(label, one, two)


@pytest.mark.parametrize(
    ("case", "bag", "record", "message"),
    [
        ("{", "new", "", "case_json = '{': is not JSON"),
        ('{"sea_state": {"hs_m": -1}}', "new", "", "sea_state.hs_m = -1"),
        ('{"water_depth_m": 45.0}', "new", "", "water_depth_m = 45.0: lies more than 1 m from"),
        ('{"structure": {"model": "no_such"}}', "new", "", "structure.model = 'no_such'"),
        ('{"fatigue": {"sn_curve": "Q"}}', "new", "", "fatigue.sn_curve = 'Q'"),
        ("{}", "", "", "bag = '': is missing"),
        ("{}", ".", "", "exists already"),
        ("{}", "new", "some", "record = 'some': must be one of: default, all"),
    ],
)
def test_a_refused_goal_says_why(
    place: tuple[Child, Operator], tmp_path: Path, case: str, bag: str, record: str, message: str
) -> None:
    state, result = place[1].run(case, str(tmp_path / bag) if bag else "", record)
    assert (state, result.status) == (GoalStatus.STATUS_ABORTED, Status.INPUT_ERROR), result.message
    assert message in result.message
    assert result.statistics_json == ""
    assert not (tmp_path / "new").exists()


def test_what_to_record_reaches_the_node_that_records(place: tuple[Child, Operator], tmp_path: Path) -> None:
    for name in ("all", "default"):
        _, result = place[1].run(short_case(), tmp_path / name, name)
        assert result.status == Status.SUCCEEDED
        first = read_by_rosbags(Path(result.bag))["/owt/modal_state"][0]
        assert bool(len(first.velocity)) == (name == "all")


def test_cancelling_closes_the_bag_and_another_goal_meanwhile_is_rejected(
    place: tuple[Child, Operator], tmp_path: Path
) -> None:
    server, operator = place
    bag = tmp_path / "bag"
    handle = operator.send(slow_case(), bag)
    operator.spin_until(lambda: operator.moves() and operator.feedback[-1].time_s > 3.0)
    assert operator.feedback[-1].speed == pytest.approx(1.0, abs=0.5), "real time"
    nodes = nodes_of(server)
    assert set(nodes) == {WAVE, STRUCTURE, POSTPROC}
    second = operator.send(short_case(), tmp_path / "other")
    assert not second.accepted
    operator.spin_until(lambda: any("rejected" in m.message for m in operator.status))
    (reason,) = {m.message for m in operator.status if "rejected" in m.message}
    assert f"a run into {bag} is under way" in reason
    assert reason in server.log.read_text()
    began = time.monotonic()
    assert operator.wait(handle.cancel_goal_async()).goals_canceling
    state, result = operator.result(handle)
    assert time.monotonic() - began < 10.0, "not the minute of the run"
    assert (state, result.status) == (GoalStatus.STATUS_CANCELED, Status.CANCELLED)
    assert result.message == "cancelled"
    assert result.bag == str(partial_path(bag))
    assert not any(Path(f"/proc/{pid}").exists() for pid in nodes.values())
    assert not bag.exists()
    recorded = read_by_rosbags(Path(result.bag))
    assert recorded["/owt/energy"], "the partial bag is closed and readable"
    assert [m.sequence for m in recorded["/owt/energy"]] == list(range(len(recorded["/owt/energy"])))


def test_cancelling_while_the_nodes_compute_ends_them(place: tuple[Child, Operator], tmp_path: Path) -> None:
    """A second-order sea of minutes: the wave node is still configuring."""
    server, operator = place
    operator.status.clear()
    handle = operator.send(short_case(time={"n": 20_000}, wave={"order": 2}), tmp_path / "bag")
    operator.spin_until(lambda: (POSTPROC, "configured") in [(m.node, m.message) for m in operator.status])
    nodes, began = nodes_of(server), time.monotonic()
    assert operator.wait(handle.cancel_goal_async()).goals_canceling
    state, result = operator.result(handle)
    assert time.monotonic() - began < 10.0, "sooner than it is configured"
    assert (state, result.status) == (GoalStatus.STATUS_CANCELED, Status.CANCELLED)
    assert len(nodes) == 3
    assert not any(Path(f"/proc/{pid}").exists() for pid in nodes.values())
    assert operator.feedback[-1].time_s == 0.0
    assert set(read_by_rosbags(Path(result.bag))) >= {"/owt/energy"}, "readable, and empty"


def test_a_number_that_is_none_is_an_error_of_numerics(place: tuple[Child, Operator], tmp_path: Path) -> None:
    """Somebody's load at the tower top is NaN, on the topic of the namespace."""
    _, operator = place
    publisher = operator.node.create_publisher(WrenchStamped, "owt/tower_top_wrench", QoSProfile(depth=10))
    try:
        handle = operator.send(short_case(wind={"topic": {}}), tmp_path / "bag")
        operator.spin_until(lambda: publisher.get_subscription_count() > 0)
        message = WrenchStamped()
        message.wrench.force.x = float("nan")
        publisher.publish(message)
        state, result = operator.result(handle)
    finally:
        operator.node.destroy_publisher(publisher)
    assert (state, result.status) == (GoalStatus.STATUS_ABORTED, Status.NUMERICS_ERROR), result.message
    assert result.message.startswith("structure_node: tower-top wrench at 0")


def test_a_killed_node_is_an_error_of_the_stream_and_the_next_goal_runs(
    place: tuple[Child, Operator], tmp_path: Path
) -> None:
    server, operator = place
    handle = operator.send(slow_case(), tmp_path / "bag")
    operator.spin_until(operator.moves)
    os.kill(nodes_of(server)[STRUCTURE], signal.SIGKILL)
    state, result = operator.result(handle)
    assert (state, result.status) == (GoalStatus.STATUS_ABORTED, Status.STREAM_ERROR)
    assert "structure_node" in result.message
    assert read_by_rosbags(Path(result.bag))["/owt/energy"]
    assert nodes_of(server) == {}
    assert operator.run(short_case(), tmp_path / "bag")[1].status == Status.SUCCEEDED


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_to_the_server_ends_its_goal(tmp_path: Path, domain: int, number: signal.Signals) -> None:
    with server_and_operator(tmp_path, domain, "/") as (server, operator):
        handle = operator.send(slow_case(), tmp_path / "bag")
        answer = handle.get_result_async()
        operator.spin_until(operator.moves)
        nodes, began = nodes_of(server), time.monotonic()
        server.signal(number)
        ended: list[float] = []
        watch = threading.Thread(target=lambda: server.wait(8.0) and ended.append(time.monotonic()))
        watch.start()
        result = operator.wait(answer)
        watch.join()
        assert (result.status, result.result.status) == (GoalStatus.STATUS_ABORTED, Status.CANCELLED)
        assert result.result.message == "the server was told to end"
        assert not any(Path(f"/proc/{pid}").exists() for pid in nodes.values())
        assert ended[0] - began < 4.0
    assert read_by_rosbags(partial_path(tmp_path / "bag"))["/owt/energy"]


def test_a_second_server_in_the_same_place_is_refused(place: tuple[Child, Operator]) -> None:
    _, operator = place
    environment = {**os.environ, "ROS_DOMAIN_ID": str(operator.domain)}
    command = [sys.executable, "-m", "owt_bringup.cli", "serve", "--namespace"]
    found = subprocess.run(
        [*command, "deck"], env=environment, capture_output=True, text=True, cwd=ROOT, timeout=60
    )
    assert found.returncode == 1
    last = found.stderr.splitlines()[-1]
    assert last.startswith("error: namespace = '/deck': has a server in ROS domain ")
    found = subprocess.run(
        [*command, "9 lives"], env=environment, capture_output=True, text=True, cwd=ROOT, timeout=60
    )
    assert (found.returncode, found.stderr.count("\n")) == (1, 1)
    assert found.stderr.startswith("error: namespace = '9 lives': is no ROS namespace")


def test_the_example_runs_against_the_server(place: tuple[Child, Operator], tmp_path: Path) -> None:
    _, operator = place
    command = [sys.executable, str(ROOT / "examples" / "run_sea_state.py"), str(tmp_path / "bag")]
    command += ["--ros-args", "-r", "__ns:=/deck"]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(operator.domain)}
    found = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert found.returncode == 0, found.stderr
    assert "times real time" in found.stdout
    assert f"in {tmp_path / 'bag'}" in found.stdout


def test_a_case_is_checked_without_running_it(place: tuple[Child, Operator]) -> None:
    _, operator = place

    def ask(text: str) -> Any:
        return operator.wait(operator.check.call_async(CheckCase.Request(case_json=text)))

    good = ask('{"sea_state": {"hs_m": 6.0, "tp_s": 9.45}}')
    assert (good.accepted, good.message) == (True, "")
    assert parse_case(json.loads(good.case_json)) == parse_case({"sea_state": {"hs_m": 6.0, "tp_s": 9.45}})
    assert json.loads(good.case_json)["stream"]["window"] == CaseConfig().stream.window
    steep = ask('{"sea_state": {"hs_m": 12.0, "tp_s": 8.5}, "wave": {"order": 1}}')
    assert steep.accepted
    assert (
        list(steep.warnings)
        == check_case('{"sea_state": {"hs_m": 12.0, "tp_s": 8.5}, "wave": {"order": 1}}')[1]
    )
    assert steep.warnings
    for text, message in (("[", "is not JSON"), ('{"water_depth_m": 45.0}', "water_depth_m = 45.0")):
        bad = ask(text)
        assert (bad.accepted, bad.case_json, list(bad.warnings)) == (False, "", [])
        assert message in bad.message


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (CancelledError("x"), Status.CANCELLED),
        (InputError("a", 1, "b", "c"), Status.INPUT_ERROR),
        (ComputationError("no convergence"), Status.NUMERICS_ERROR),
        (StreamError("gap"), Status.STREAM_ERROR),
        (NodeError("x", NodeStatus.INPUT), Status.INPUT_ERROR),
        (NodeError("x", NodeStatus.NUMERICS), Status.NUMERICS_ERROR),
        (NodeError("x", NodeStatus.STREAM), Status.STREAM_ERROR),
        (OwtError("else"), Status.STREAM_ERROR),
    ],
)
def test_every_error_has_its_status(error: OwtError, status: int) -> None:
    assert _status_of(error) == status


def test_speed_counts_from_the_first_sample_on() -> None:
    clock = iter([0.0, 100.0, 102.0, 104.0])
    speed = Speed(lambda: next(clock))
    assert [speed.at(t) for t in (0.0, 5.0, 25.0, 65.0)] == [0.0, 0.0, 10.0, 15.0]
