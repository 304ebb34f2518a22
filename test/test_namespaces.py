"""Several graphs side by side in one ROS domain: apart in namespaces, refused or broken without them."""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from owt_msgs.msg import NodeStatus
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from local_graph import assert_messages_equal, expected_messages, node_processes, read_by_rosbags, short_case
from owt_bringup import supervisor
from owt_bringup.domain import full_namespace, own_place
from owt_bringup.graph import run_graph
from owt_bringup.process import (
    Child,
    remove_shared_memory,
    shared_memory_of,
)
from owt_bringup.supervisor import NodeError, Supervisor
from owt_campaign.pipeline import prepare_case, stream_case
from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError
from owt_ros.qos import qos_for
from owt_ros.topics import CLOCK, CREDIT, DIAGNOSTICS, POSTPROC, RECORDED, STATUS, STRUCTURE, WAVE

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]

ROOT = Path(__file__).parents[1]
NORTH, SOUTH = "/north", "/sites/south"
#: Blocks per namespace, so that a credit tells where it belongs by its sequence.
BLOCK = {NORTH: 10, SOUTH: 50}


def case_of(namespace: str, **changes: Any) -> CaseConfig:
    seed = 1 if namespace == NORTH else 2
    sea = {"hs_m": 1.0, "tp_s": 8.0, "seed": seed}
    return short_case(sea_state=sea, stream={"block": BLOCK[namespace], "rate": 10.0}, **changes)


class Listener:
    """Hears the small topics of some namespaces."""

    def __init__(self, domain: int, namespaces: tuple[str, ...]) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = Node("listener", context=self._context, use_global_arguments=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.heard: dict[tuple[str, str], list[Any]] = {}
        for namespace in namespaces:
            for topic in (CREDIT, CLOCK, DIAGNOSTICS, STATUS):
                found = self.heard[namespace, topic.name] = []
                profile = qos_for(topic)
                profile.depth = 1000
                name = f"{namespace.rstrip('/')}/{topic.name}"
                self.node.create_subscription(topic.message, name, found.append, profile)

    def spin_while(self, threads: list[threading.Thread]) -> None:
        while any(thread.is_alive() for thread in threads):
            self._executor.spin_once(timeout_sec=0.05)

    def close(self) -> None:
        self._executor.shutdown(timeout_sec=1.0)
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)
        del self._executor, self.node, self._context


def test_two_graphs_in_one_domain_give_the_numbers_of_one_process_each(tmp_path: Path, domain: int) -> None:
    results: dict[str, Any] = {}
    everywhere: set[str] = set()

    def run(namespace: str) -> None:
        try:
            results[namespace] = run_graph(
                case_of(namespace),
                tmp_path / Path(namespace).name,
                record="all",
                domain_id=domain,
                namespace=namespace,
            )
        except OwtError as error:
            results[namespace] = error

    listener = Listener(domain, (NORTH, SOUTH, "/"))
    try:
        threads = [threading.Thread(target=run, args=(namespace,)) for namespace in (NORTH, SOUTH)]
        for thread in threads:
            thread.start()
        listener.spin_while(threads)
        everywhere = {name for name, _ in listener.node.get_topic_names_and_types()}
    finally:
        listener.close()
    for namespace in (NORTH, SOUTH):
        assert not isinstance(results[namespace], Exception), results[namespace]
        assert results[namespace].domain == domain
        run_of, recorded = prepare_case(case_of(namespace)), read_by_rosbags(results[namespace].bag)
        assert set(recorded) == {topic.label for topic in RECORDED}, "named as without a namespace"
        for label, messages in expected_messages(run_of, list(stream_case(run_of))).items():
            assert len(recorded[label]) == len(messages), label
            for one, two in zip(messages, recorded[label], strict=True):
                assert_messages_equal(label, one, two)
        heard = {name: found for (place, name), found in listener.heard.items() if place == namespace}
        blocks = len(recorded["/owt/energy"])
        assert {c.topic for c in heard[CREDIT.name]} >= {"/owt/nodal_loads", "/owt/energy"}, "as they are"
        assert max(c.sequence for c in heard[CREDIT.name]) == blocks - 1
        ticks, loads = heard[CLOCK.name], recorded["/owt/nodal_loads"]
        assert ticks, "all of them, from when the listener was found"
        for tick, load in zip(ticks, loads[-len(ticks) :], strict=True):
            assert (tick.clock.sec, tick.clock.nanosec) == (load.header.stamp.sec, load.header.stamp.nanosec)
        assert {m.node for m in heard[STATUS.name]} == {WAVE, STRUCTURE, POSTPROC}
        assert heard[DIAGNOSTICS.name]
    assert not any(found for (place, _), found in listener.heard.items() if place == "/")
    assert not {"/clock", "/diagnostics"} & {n for n in everywhere if n.startswith(("/north", "/sites"))}


def test_shared_memory_of_another_graph_is_left_alone(tmp_path: Path, domain: int) -> None:
    """A node maps the segments of all nodes in its domain; only those without an owner are removed."""
    code = "import rclpy; rclpy.init(); n = rclpy.create_node('x'); print('up', flush=True); rclpy.spin(n)"
    with subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"up\n"
        segments = shared_memory_of(other.pid)
        assert segments
        remove_shared_memory(segments)
        assert all(path.exists() for path in segments)
        other.kill()
    remove_shared_memory(segments)
    assert not any(path.exists() for path in segments)


def test_nodes_that_end_give_their_shared_memory_back(tmp_path: Path, domain: int) -> None:
    with node_processes(short_case(), tmp_path, {**os.environ, "ROS_DOMAIN_ID": str(domain)}) as nodes:
        deadline = time.monotonic() + 60.0
        while any(len(shared_memory_of(node.pid)) < 2 for node in nodes.values()):
            assert time.monotonic() < deadline, "they use no shared memory"
            time.sleep(0.05)
        segments = set().union(*(shared_memory_of(node.pid) for node in nodes.values()))
    assert {name: node.exit_code for name, node in nodes.items()} == dict.fromkeys(nodes, 0)
    assert not any(segment.exists() for segment in segments)


def test_a_second_graph_in_the_same_place_is_refused_and_the_first_goes_on(
    tmp_path: Path, domain: int
) -> None:
    refused: list[BaseException] = []

    def second(_: Any) -> None:
        for name in ("", "/"):
            with pytest.raises(InputError, match=r"namespace = '/': has a graph in ROS domain") as error:
                run_graph(short_case(), tmp_path / "second", domain_id=domain, namespace=name)
            refused.append(error.value)

    run_graph(short_case(), tmp_path / "first", domain_id=domain, on_start=second)
    assert len(refused) == 2
    assert not (tmp_path / "second").exists()
    with own_place("graph", domain, "/"), own_place("graph", domain, NORTH), own_place("server", domain, "/"):
        pass  # free again, and one place is not another


@contextmanager
def processes(
    folder: Path, domain: int, case: CaseConfig, namespace: str = "/"
) -> Iterator[dict[str, Child]]:
    """The nodes as anybody else may start them: without the bring-up."""
    folder.mkdir()
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    with node_processes(case, folder, environment, "-r", f"__ns:={namespace}") as children:
        yield children


def test_nodes_of_somebody_else_in_the_same_place_are_noticed(
    tmp_path: Path, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(supervisor, "_FORGET_S", 1.0)
    with processes(tmp_path / "else", domain, short_case()) as others:
        with Supervisor(domain, others, lambda: None) as graph:
            graph.await_services(60.0)
        with pytest.raises(OwtError, match=rf"two nodes are named .* in ROS domain {domain}, namespace /: "):
            run_graph(short_case(), tmp_path / "bag", domain_id=domain)
        # and in a namespace of its own it runs
        run_graph(short_case(), tmp_path / "bag", domain_id=domain, namespace="apart")


def run_through(graph: Supervisor, names: list[str]) -> None:
    graph.change_states(names, Transition.TRANSITION_CONFIGURE, 60.0)
    for name in names:
        graph.change_states([name], Transition.TRANSITION_ACTIVATE, 60.0)
    graph.watch(None, 20.0, 30.0)


def test_two_graphs_without_namespaces_and_without_a_bring_up_end_in_an_error(
    tmp_path: Path, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Negative control of all above: every node hears two producers, and none counts mixed numbers."""
    monkeypatch.setattr(Supervisor, "_doubles", lambda _: [])
    with ExitStack() as stack:
        both = [
            stack.enter_context(processes(tmp_path / str(seed), domain, short_case(
                sea_state={"hs_m": 1.0, "tp_s": 8.0, "seed": seed}, stream={"rate": 10.0}
            )))
            for seed in (1, 2)
        ]  # fmt: skip
        graph = stack.enter_context(Supervisor(domain, dict(both[0]), lambda: None))
        graph.spin_until(
            lambda: all(graph._node.get_node_names().count(name) == 2 for name in both[0]), 60.0, "no start"
        )
        with pytest.raises(NodeError) as error:
            run_through(graph, list(both[0]))
        assert error.value.kind == NodeStatus.STREAM
    assert not list(tmp_path.glob("*/bag")), "no bag is complete"


@pytest.mark.parametrize(
    ("given", "full"), [("", "/"), ("/", "/"), ("north", "/north"), ("/north/", "/north"), ("a/b", "/a/b")]
)
def test_a_namespace_is_written_in_full(given: str, full: str) -> None:
    assert full_namespace(given) == full


@pytest.mark.parametrize("given", ["9north", "a b", "north-sea", "a//b", "~x", "{x}", "a" * 300])
def test_what_is_no_namespace_is_refused(given: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no ROS namespace"):
        run_graph(short_case(), tmp_path / "bag", namespace=given)
    assert not list(tmp_path.iterdir())


def test_the_demo_in_a_namespace(tmp_path: Path, domain: int) -> None:
    """As a user runs it; a Ctrl-C in the middle leaves nothing behind."""
    command = [sys.executable, "-m", "owt_bringup.cli", "demo", "--namespace", "north", "--duration", "20"]
    command += ["--order", "1", "--reduction", "CB04M03", "--bag", str(tmp_path / "bag")]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    with Listening(domain) as heard:
        found = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert found.returncode == 0, found.stderr
    assert f"note: topics are /north/owt/... in ROS domain {domain}" in found.stderr
    assert {m.node for m in heard["/north", STATUS.name]} == {WAVE, STRUCTURE, POSTPROC}
    assert (tmp_path / "bag" / "report.html").is_file()


class Listening:
    """A listener that spins in a thread while the block lasts."""

    def __init__(self, domain: int) -> None:
        self._listener = Listener(domain, ("/north",))
        self._done = threading.Event()
        self._waiter = threading.Thread(target=self._done.wait)
        self._spinner = threading.Thread(target=lambda: self._listener.spin_while([self._waiter]))

    def __enter__(self) -> dict[tuple[str, str], list[Any]]:
        self._waiter.start()
        self._spinner.start()
        return self._listener.heard

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._spinner.join()
        self._listener.close()


@pytest.mark.parametrize("variable", [None, "SUBNET"])
def test_processes_of_a_graph_stay_on_this_machine_unless_told_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str | None
) -> None:
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE")
    if variable is not None:
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", variable)

    def look(children: dict[str, Child]) -> None:
        for child in children.values():
            seen = Path(f"/proc/{child.pid}/environ").read_bytes().split(b"\0")
            assert f"ROS_AUTOMATIC_DISCOVERY_RANGE={variable or 'LOCALHOST'}".encode() in seen
        raise LookedError

    class LookedError(Exception):
        pass

    with pytest.raises(LookedError):
        run_graph(short_case(), tmp_path / "bag", on_start=look)


def test_owt_run_stays_on_this_machine_unless_told_otherwise() -> None:
    """The environment that ./owt gives to what it runs."""
    script = 'set -eu; ROOT=$1; source "$ROOT/tools/env.sh"; MODE=wheels; use_environment; '
    script += 'echo "$ROS_AUTOMATIC_DISCOVERY_RANGE"'
    clean = {k: v for k, v in os.environ.items() if not k.startswith("ROS_")}
    for given, wanted in (({}, "LOCALHOST"), ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, "SUBNET")):
        command = ["bash", "-c", script, "bash", str(ROOT)]
        found = subprocess.run(command, env={**clean, **given}, capture_output=True, text=True, check=True)
        assert found.stdout == f"{wanted}\n"
    text = (ROOT / "owt").read_text(encoding="utf-8")
    assert "run) ensure_set_up; run_executable" in text, "which calls use_environment"
