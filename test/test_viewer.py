"""The viewer beside a real graph: it sees the run, serves it, and leaves no trace in it."""

import json
import os
import signal
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from owt_msgs.msg import FatigueState, MemberStress
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from visualization_msgs.msg import Marker, MarkerArray

from local_graph import LocalGraph, assert_messages_equal, expected_messages, read_by_rosbags, short_case
from owt_bringup.cli import main
from owt_bringup.domain import own_domain
from owt_bringup.graph import run_graph
from owt_bringup.process import Child, find_executable, stop_all
from owt_bringup.viewer import viewer_arguments
from owt_campaign.pipeline import CaseRun, prepare_case, stream_case
from owt_ros import convert, schema, topics
from owt_ros.qos import qos_for
from owt_ros.topics import VIEWER
from owt_viewer.node import MARKERS, ViewerNode
from websocket_client import FoxgloveClient

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Watched(LocalGraph):
    """A graph in this process with a viewer, and somebody who looks at its markers."""

    def __init__(self, *arguments: Any, options: dict[str, Any] | None = None, **keywords: Any) -> None:
        super().__init__(*arguments, **keywords)
        given = [Parameter(name, value=value) for name, value in {"fps": 25.0, **(options or {})}.items()]
        self.viewer = ViewerNode(context=self.context, parameter_overrides=given, use_global_arguments=False)
        self.pictures: list[MarkerArray] = []
        profile = qos_for(MARKERS)
        profile.depth = 100
        self.watcher.create_subscription(MarkerArray, MARKERS.name, self.pictures.append, profile)
        self._executor.add_node(self.viewer)
        self._stack.callback(self.viewer.destroy_node)
        self._stack.callback(self.viewer.close)

    def texts(self) -> set[str]:
        return {marker.text for picture in self.pictures for marker in picture.markers} - {""}

    def complaints(self) -> list[str]:
        return [s.message for array in self.diagnostics for s in array.status if s.name == VIEWER]


def points_of(picture: MarkerArray, name: str) -> np.ndarray:
    chosen = [
        marker for marker in picture.markers if marker.ns == name and marker.type != Marker.TEXT_VIEW_FACING
    ]
    return np.array([[p.x, p.y, p.z] for marker in chosen for p in marker.points])


def test_the_picture_is_that_of_the_run_and_the_bag_is_as_without_it(domain: int, bag: Path) -> None:
    case = short_case(stream={"rate": 20.0, "block": 10})
    with Watched(domain, case, bag, options={"exaggeration": 100.0, "grid_points": 9}) as graph:
        graph.start()
        graph.spin_until(graph.is_done)
        graph.spin_until(lambda: any("t = 18.9 s" in text for text in graph.texts()))
        assert not graph.complaints()
    run = prepare_case(case)
    blocks = list(stream_case(run))
    recorded = read_by_rosbags(bag)
    for label, messages in expected_messages(run, blocks).items():
        for one, two in zip(messages, recorded[label], strict=True):
            assert_messages_equal(label, one, two)
    names = {status.name for entry in recorded["/diagnostics"] for status in entry.status}
    assert VIEWER not in names
    seen = {marker.header.stamp.sec for picture in graph.pictures for marker in picture.markers}
    assert len(seen) >= 3, "pictures came while the run went on"
    last = graph.pictures[-1]
    assert {"structure", "sea", "legend", "label"} <= {marker.ns for marker in last.markers}
    assert {marker.header.frame_id for marker in last.markers} == {"owt"}
    assert {"von Mises stress [MPa]", "displacement x 100"} <= graph.texts()
    expected = displaced(run, blocks[-1].modal.displacement[-1], 100.0)
    found = points_of(last, "structure")
    assert len(found) == 2 * run.mesh.n_elements
    distance = np.linalg.norm(found[:, None] - expected[None], axis=2).min(axis=1)
    assert distance.max() < 1e-9, "every end of a segment is a displaced node"
    undeformed = np.linalg.norm(found[:, None] - run.mesh.node_position[None], axis=2).min(axis=1)
    assert undeformed.max() > 1e-3, "and not where the node was"


def displaced(run: CaseRun, coordinate: np.ndarray, exaggeration: float) -> np.ndarray:
    motion = run.response.node_basis[:, :3] @ coordinate
    return np.asarray(run.mesh.node_position + exaggeration * motion)


def test_damage_can_colour_the_members(domain: int, bag: Path) -> None:
    with Watched(domain, short_case(stream={"rate": 20.0}), bag, options={"colour": "damage"}) as graph:
        graph.start()
        graph.spin_until(graph.is_done)
        graph.spin_until(lambda: "damage so far" in graph.texts())
        assert not graph.complaints()


def test_garbage_and_another_model_become_diagnostics(domain: int, bag: Path) -> None:
    """No message stops the viewer: it says what is wrong, once, and shows what it can."""
    run = prepare_case(short_case())
    with Watched(domain, short_case(), bag, []) as graph:
        publish = {
            topic: graph.watcher.create_publisher(topic.message, topic.name, qos_for(topic, window=8))
            for topic in (
                topics.MODEL,
                topics.LOAD_BASIS,
                topics.REDUCED_MODEL,
                topics.MEMBER_STRESS,
                topics.FATIGUE,
            )
        }
        graph.spin_until(lambda: all(p.get_subscription_count() for p in publish.values()))
        publish[topics.MEMBER_STRESS].publish(MemberStress(dt=-1.0, samples=3))
        graph.spin_until(lambda: any("no block of a stream" in text for text in graph.complaints()))
        model = convert.model_message(run.mesh)
        model.model_hash = "0" * 64
        publish[topics.MODEL].publish(model)
        graph.spin_until(lambda: any("is not known" in text for text in graph.complaints()))
        graph.spin_until(lambda: "not deformed" in graph.texts())
        model.element_node[5] = 10_000
        publish[topics.MODEL].publish(model)
        graph.spin_until(
            lambda: any("name a node that it does not have" in text for text in graph.complaints())
        )
        publish[topics.MODEL].publish(convert.model_message(run.mesh))
        reduced = convert.reduced_model_message(run.response.description)
        reduced.model_hash = "f" * 64
        publish[topics.REDUCED_MODEL].publish(reduced)
        publish[topics.LOAD_BASIS].publish(convert.load_basis_message(run.load_basis))
        graph.spin_until(lambda: any("belongs to model ffffffffffff" in text for text in graph.complaints()))
        before = len(graph.complaints())
        publish[topics.FATIGUE].publish(FatigueState(damage=[1.0], cycles=[]))
        graph.spin_until(lambda: len(graph.complaints()) > before)
        shown = len(graph.pictures)
        graph.spin_until(lambda: len(graph.pictures) > shown + 1)


def view(case: Any, domain: int, folder: Path, **options: Any) -> Child:
    arguments = viewer_arguments(case, options, folder)
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    program = find_executable("owt_viewer", VIEWER)
    return Child(VIEWER, [str(program), *arguments], folder / "viewer.log", environment)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_viewer_that_dies_or_hangs_changes_nothing(tmp_path: Path, number: signal.Signals) -> None:
    case, bag, progress = short_case(stream={"rate": 4.0, "block": 10}), tmp_path / "bag", []  # type: ignore[var-annotated]
    hit: list[float] = []
    with own_domain() as domain:
        viewer = view(case, domain, tmp_path, port=(port := free_port()))
        try:
            with connected(port) as client:
                reader = threading.Thread(target=read_until_closed, args=(client,), daemon=True)
                reader.start()
                strike = after(progress, 5.0, lambda: (viewer.signal(number), hit.append(progress[-1])))
                began = time.monotonic()
                result = run_graph(
                    case, bag, record="all", domain_id=domain, progress=lambda t, _: progress.append(t)
                )
                strike.join()
            elapsed = time.monotonic() - began
        finally:
            viewer.signal(signal.SIGCONT)
            stop_all([viewer])
    assert hit
    assert 5.0 <= hit[0] < 15.0
    assert elapsed < 60.0
    assert result.statistics["stress_samples"] == 5 * 189 + 1
    run, recorded = prepare_case(case), read_by_rosbags(bag)
    for label, messages in expected_messages(run, list(stream_case(run))).items():
        for one, two in zip(messages, recorded[label], strict=True):
            assert_messages_equal(label, one, two)


def after(progress: list[float], reached: float, act: Callable[[], Any]) -> threading.Thread:
    """Call `act` when the run has come as far as `reached` s."""

    def wait() -> None:
        deadline = time.monotonic() + 60.0
        while not (progress and progress[-1] >= reached) and time.monotonic() < deadline:
            time.sleep(0.02)
        act()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


def connected(port: int) -> FoxgloveClient:
    """A client of a server that may still be starting."""
    deadline = time.monotonic() + 60.0
    while True:
        try:
            return FoxgloveClient(port)
        except OSError:
            assert time.monotonic() < deadline, "nothing listens"
            time.sleep(0.05)


def read_until_closed(client: FoxgloveClient) -> None:
    try:
        while True:
            client.message()
    except (OSError, ValueError):
        return


def test_a_websocket_client_gets_the_ros_message_and_the_numbers(tmp_path: Path) -> None:
    case, found = short_case(stream={"rate": 4.0, "block": 10}), {}  # type: ignore[var-annotated]
    with own_domain() as domain:
        viewer = view(case, domain, tmp_path, port=(port := free_port()))
        run = threading.Thread(target=run_graph, args=(case, tmp_path / "bag"), kwargs={"domain_id": domain})
        try:
            with connected(port) as client:
                run.start()
                numbers: dict[str, float] = {}
                while not {"elevation_m", "largest_stress_mpa", "largest_damage"} <= numbers.keys():
                    topic, time_ns, payload = client.message()
                    found[topic] = time_ns, payload
                    numbers = json.loads(found.get("/owt/live", (0, b"{}"))[1])
                while client.message()[0] != "/owt/markers":
                    pass
            run.join()
        finally:
            stop_all([viewer])
    offered = {channel["topic"]: channel for channel in client.channels.values()}
    markers = offered["/owt/markers"]
    assert (markers["encoding"], markers["schemaEncoding"]) == ("cdr", "ros2msg")
    assert markers["schemaName"] == "visualization_msgs/msg/MarkerArray"
    assert markers["schema"] == schema.definition("visualization_msgs/msg/MarkerArray")
    time_ns, payload = found["/owt/markers"]
    picture = deserialize_message(payload, MarkerArray)
    stamp = picture.markers[0].header.stamp
    assert stamp.sec * 1_000_000_000 + stamp.nanosec == time_ns < 20e9
    assert {"structure", "sea"} <= {marker.ns for marker in picture.markers}
    assert 0.0 < numbers["largest_stress_mpa"] < 1e3
    assert abs(numbers["elevation_m"]) < 4.0


def test_nobody_outside_this_machine_is_served(domain: int, tmp_path: Path) -> None:
    viewer = view(short_case(), domain, tmp_path, port=(port := free_port()))
    try:
        connected(port).__exit__()
        table = Path("/proc/net/tcp").read_text().splitlines()[1:]
        listening = [row.split()[1] for row in table if row.split()[3] == "0A"]
        assert [place for place in listening if place.endswith(f":{port:04X}")] == [f"0100007F:{port:04X}"]
        assert viewer.exit_code is None
        (tmp_path / "second").mkdir()
        second = view(short_case(), domain, tmp_path / "second", port=port)
        assert second.wait(60.0)
        assert second.exit_code == 1
        assert "cannot be served on 127.0.0.1" in second.last_line
    finally:
        stop_all([viewer])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--namespace", "a b"], "is no ROS namespace"),
        (["--domain", "500"], "must lie in 0 to 101"),
        (["--exaggeration", "-1"], "exaggeration"),
        (["--case", "no_such.json"], "no_such.json"),
    ],
)
def test_what_view_refuses(arguments: list[str], message: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "--port", "0", *arguments]) != 0
    assert message in capfd.readouterr().err
