"""Flow control: a slow consumer at full speed, a late one in real time."""

import json
import os
import re
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from owt_msgs.msg import Credit, NodeStatus
from rclpy.node import Node

from local_graph import LocalGraph, expected_messages, read_by_rosbags, short_case
from owt_bringup import graph as bring_up
from owt_bringup.graph import run_graph
from owt_bringup.process import Child, find_executable
from owt_campaign.pipeline import prepare_case, stream_case
from owt_ros import topics
from owt_ros.qos import qos_for
from owt_ros.topics import POSTPROC, STRUCTURE, WAVE
from owt_wave_node.node import WaveNode

pytestmark = [pytest.mark.graph, pytest.mark.timeout(240)]

#: A postproc node that takes a hundred times as long for each message; it says what it would have taken.
SLOW = """#!{python}
import sys, time
from owt_postproc import node
handle, busy = node.PostprocNode._on_data, 0.0
def slow(self, topic, head, cdr):
    global busy
    began = time.thread_time()
    handle(self, topic, head, cdr)
    took = time.thread_time() - began
    busy += took
    print(f"busy {{busy}} s", file=sys.stderr, flush=True)
    time.sleep(99.0 * took)
node.PostprocNode._on_data = slow
sys.exit(node.main())
"""


def peak_memory(child: Child) -> float:
    """Largest memory in MiB that a process has used so far; 0 once it has ended."""
    try:
        text = Path(f"/proc/{child.pid}/status").read_text()
    except OSError:
        return 0.0
    found = re.search(r"VmHWM:\s+(\d+) kB", text)
    return int(found[1]) / 1024 if found else 0.0


class Watch:
    """Peak memory of the nodes of a run, looked at as it goes on."""

    def __init__(self) -> None:
        self.children: dict[str, Child] = {}
        self.memory: dict[str, float] = {}

    def started(self, children: dict[str, Child]) -> None:
        self.children.update(children)

    def look(self, *_: Any) -> None:
        for name, child in self.children.items():
            self.memory[name] = max(self.memory.get(name, 0.0), peak_memory(child))


def test_a_consumer_a_hundred_times_slower_loses_nothing_and_costs_no_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """12 blocks of 1 MB of loads: without a bound the wave node would hold 10 MB more."""
    case = short_case(time={"n": 300}, stream={"block": 25, "window": 2})
    usual, slowed = Watch(), Watch()
    run_graph(case, tmp_path / "usual", on_start=usual.started, progress=usual.look)
    script = tmp_path / "slow_node"
    script.write_text(SLOW.format(python=sys.executable))
    script.chmod(0o755)
    monkeypatch.setattr(
        bring_up, "find_executable", lambda p, n: script if n == POSTPROC else find_executable(p, n)
    )
    run_graph(case, tmp_path / "slow", on_start=slowed.started, progress=slowed.look)
    log = (tmp_path / "slow" / "log" / f"{POSTPROC}.log").read_text()
    assert float(log.split("busy ")[1].split()[0]) > 0.0, "the slow one ran"
    one, two = (read_by_rosbags(tmp_path / name) for name in ("usual", "slow"))
    for label in one:
        assert len(one[label]) == len(two[label]), label
    assert [m.sequence for m in two["/owt/nodal_loads"]] == list(range(12))
    np.testing.assert_array_equal(
        np.concatenate([m.axial for m in one["/owt/member_stress"]]),
        np.concatenate([m.axial for m in two["/owt/member_stress"]]),
    )
    for name in (WAVE, STRUCTURE, POSTPROC):
        assert slowed.memory[name] < usual.memory[name] + 5.0, (usual.memory, slowed.memory)


def consumers(graph: LocalGraph) -> tuple[dict[str, Any], dict[str, list[Any]]]:
    """Stand-ins of both consumers of the wave node: their credit publishers, and what one of them gets."""
    credit, got = {}, {"/owt/nodal_loads": []}  # type: ignore[var-annotated]
    for name in (STRUCTURE, POSTPROC):
        node = Node(name, context=graph.context, use_global_arguments=False)
        graph._executor.add_node(node)
        graph._stack.callback(node.destroy_node)
        for topic in topics.RECORDED:
            if topic.producer == WAVE and name in topic.consumers:
                keep = got.setdefault(topic.label, []) if name == POSTPROC else []
                node.create_subscription(topic.message, topic.name, keep.append, qos_for(topic, window=200))
        credit[name] = node.create_publisher(Credit, "owt/credit", qos_for(topics.CREDIT))
    return credit, got


def lateness(graph: LocalGraph) -> list[str]:
    return [
        status.message
        for entry in graph.diagnostics
        for status in entry.status
        if status.level == DiagnosticStatus.WARN and status.message.startswith("late: ")
    ]


def test_in_real_time_a_late_consumer_is_reported_and_holds_nobody(domain: int, tmp_path: Path) -> None:
    """19 s at ten times real time, consumers that acknowledge the first block and no other."""
    case = short_case(stream={"rate": 10.0, "block": 5, "window": 2, "late_s": 1.0})
    with LocalGraph(domain, case, tmp_path / "bag", [WaveNode]) as graph:
        credit, got = consumers(graph)
        graph.start()
        graph.spin_until(lambda: len(got["/owt/nodal_loads"]) > 0)
        for topic in (topics.NODAL_LOADS, topics.SURFACE_ELEVATION):
            for name in topic.consumers:
                credit[name].publish(Credit(consumer=name, topic=topic.label, sequence=0))
        began = time.monotonic()
        graph.spin_until(lambda: NodeStatus.DONE in graph.codes(WAVE))
        took = time.monotonic() - began
        graph.spin_until(lambda: len(got["/owt/nodal_loads"]) == 38)
        graph.spin_until(lambda: "lost" in "".join(lateness(graph)[-1:]))
    assert 1.6 < took < 6.0, "1.85 s of wall time, and what a busy machine adds"
    said = lateness(graph)
    assert said
    assert re.search(r"node has \d+ blocks of /owt/nodal_loads to process", said[0])
    # The history holds the window and one second of wall time, 2 + 20 of the 38 blocks.
    assert "of which are lost" in said[-1]


def test_in_real_time_consumers_in_time_are_not_called_late(domain: int, tmp_path: Path) -> None:
    """Late would be more than a window of four blocks, 2 s of wall time."""
    with LocalGraph(domain, short_case(stream={"rate": 2.0, "block": 10}), tmp_path / "bag") as graph:
        graph.start()
        graph.spin_until(lambda: max((m.time_s for m in graph.status if m.node == POSTPROC), default=0) > 6.0)
    assert not lateness(graph)


def test_a_node_that_pauses_in_real_time_catches_up(tmp_path: Path) -> None:
    """Stopped for 0.55 s, less than the lease: what fits the history comes later."""
    case = short_case(time={"n": 400}, stream={"rate": 10.0, "block": 2, "window": 2, "late_s": 20.0})
    children: dict[str, Child] = {}
    paused = threading.Event()

    def pause(reached: float, _: float) -> None:
        if reached > 5.0 and not paused.is_set():
            paused.set()
            os.kill(children[STRUCTURE].pid, signal.SIGSTOP)
            threading.Timer(0.55, lambda: os.kill(children[STRUCTURE].pid, signal.SIGCONT)).start()

    bag = tmp_path / "bag"
    run_graph(case, bag, record="all", on_start=children.update, progress=pause)
    assert paused.is_set()
    run, found = prepare_case(case), read_by_rosbags(bag)
    wanted = expected_messages(run, list(stream_case(run)))
    for label in ("/owt/nodal_loads", "/owt/member_stress"):
        assert [m.sequence for m in found[label]] == list(range(200))
    np.testing.assert_array_equal(
        np.concatenate([m.axial for m in found["/owt/member_stress"]]),
        np.concatenate([m.axial for m in wanted["/owt/member_stress"]]),
    )


@pytest.mark.parametrize(("missed", "complete"), [(10, True), (90, False)])
def test_what_does_not_fit_the_history_is_a_gap(
    domain: int, tmp_path: Path, missed: int, complete: bool
) -> None:
    """The structure node is not called while the producer sends blocks; its history holds 70 of them."""
    case = short_case(time={"n": 400}, stream={"rate": 10.0, "block": 2, "window": 2, "late_s": 1.0})
    bag = tmp_path / "bag"
    with LocalGraph(domain, case, bag) as graph:
        graph.start()
        sent = next(o.credit for o in graph.nodes[WAVE]._outlets if o.topic is topics.NODAL_LOADS)
        graph.spin_until(lambda: graph.nodes[POSTPROC].time_ns > 2e9)
        graph._executor.remove_node(graph.nodes[STRUCTURE])
        first = sent.sent
        graph.spin_until(lambda: sent.sent >= first + missed)
        graph._executor.add_node(graph.nodes[STRUCTURE])
        if complete:
            graph.spin_until(graph.is_done)
            return
        message = graph.error_of(STRUCTURE)
        assert re.search(r"^/owt/nodal_loads: block \d+ arrived, .*gap of", message)
        graph.spin_until(
            lambda: any(s.level == DiagnosticStatus.ERROR for d in graph.diagnostics for s in d.status)
        )
        graph.spin_for(0.3)  # the mark is on its way to the bag, too
    marks = [s.message for d in read_by_rosbags(tmp_path / ".bag.partial")["/diagnostics"] for s in d.status]
    assert any("gap of" in mark for mark in marks)


def call(graph: LocalGraph, kind: Any, name: str) -> Any:
    """Call a service of the graph."""
    client = graph.watcher.create_client(kind, name)
    graph.spin_until(client.service_is_ready)
    future = client.call_async(kind.Request())
    graph.spin_until(future.done)
    return future.result()


def test_an_operator_asks_for_the_fatigue_so_far_and_for_a_readable_bag(domain: int, tmp_path: Path) -> None:
    from owt_msgs.srv import FatigueSummary, Flush

    from owt_postproc.mcap_file import scan

    bag = tmp_path / "bag"
    with LocalGraph(domain, short_case(stream={"rate": 5.0, "block": 10}), bag) as graph:
        graph.start()
        graph.spin_until(lambda: max((m.time_s for m in graph.status if m.node == POSTPROC), default=0) > 3.0)
        half = json.loads(call(graph, FatigueSummary, "owt/fatigue_summary").summary_json)
        flushed = call(graph, Flush, "owt/flush")
        assert flushed.success
        assert flushed.bag == str(tmp_path / ".bag.partial")
        with (tmp_path / ".bag.partial" / "bag_0.mcap").open("rb") as stream:
            seen = [r for r in scan(stream, damaged=[]) if type(r).__name__ == "Message"]
        assert len(seen) >= flushed.messages > 20
        graph.spin_until(graph.is_done)
        whole = json.loads(call(graph, FatigueSummary, "owt/fatigue_summary").summary_json)
        after = call(graph, Flush, "owt/flush")
        assert (after.success, after.message) == (False, "nothing is being recorded")
    assert not half["complete"]
    assert whole["complete"]
    assert 100 < half["samples"] < whole["samples"] == 5 * 189 + 1
    run = prepare_case(short_case(stream={"block": 10}))
    *_, last = stream_case(run)
    assert whole["max_damage"] == float(last.fatigue.damage.max())
    assert half["max_damage"] < whole["max_damage"]
