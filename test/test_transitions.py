"""Transitions of the managed nodes: in any order, refused with a reason, paused and resumed."""

import random
import threading
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from owt_msgs.msg import NodeStatus
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from local_graph import (
    NODES,
    SUCCESS,
    LocalGraph,
    assert_messages_equal,
    expected_messages,
    read_by_rosbags,
    short_case,
)
from owt_bringup import supervisor
from owt_bringup.graph import Timeouts, run_graph
from owt_campaign.pipeline import CaseBlocks, CaseRun, prepare_case, stream_case
from owt_model.config import CaseConfig
from owt_model.errors import OwtError
from owt_ros.lifecycle import ACTIVE, PAUSED, StageNode
from owt_ros.topics import POSTPROC, STRUCTURE, WAVE

pytestmark = [pytest.mark.graph, pytest.mark.timeout(120)]

CURVE = CaseConfig().fatigue.sn_curve
NAMES = ("configure", "cleanup", "activate", "deactivate")
#: What each transition leads from and to; all else is refused.
LEGAL = {
    ("unconfigured", "configure"): "inactive",
    ("inactive", "cleanup"): "unconfigured",
    ("inactive", "activate"): "active",
    ("active", "deactivate"): "inactive",
}


def state_of(node: StageNode) -> str:
    return str(node._state_machine.current_state[1])


def ask(node: StageNode, name: str) -> bool:
    change: Callable[[], Any] = getattr(node, f"trigger_{name}")
    return bool(change() == SUCCESS)


def reset(graph: LocalGraph) -> None:
    """All nodes back to the beginning, whatever they do."""
    for node in graph.nodes.values():
        if state_of(node) == "active":
            assert ask(node, "deactivate")
    for node in graph.nodes.values():
        if state_of(node) == "inactive":
            assert ask(node, "cleanup")


def assert_bag_equal(bag: Path, expected: dict[str, list[Any]]) -> None:
    recorded = read_by_rosbags(bag)
    for label, messages in expected.items():
        assert len(recorded[label]) == len(messages), label
        for one, two in zip(messages, recorded[label], strict=True):
            assert_messages_equal(label, one, two)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_run_after_a_random_walk_gives_the_right_numbers(
    domain: int, bag: Path, reference: tuple[CaseRun, list[CaseBlocks]], seed: int
) -> None:
    """Forty transitions of all nodes, legal or not, the graph working in between; then a whole run."""
    walk = random.Random(seed)
    with LocalGraph(domain, short_case(), bag, NODES, {POSTPROC: {"overwrite": True}}) as graph:
        refused = 0
        for _ in range(40):
            node, name = walk.choice(list(graph.nodes.values())), walk.choice(NAMES)
            before, broken = state_of(node), bool(node._broken)
            allowed = (before, name) in LEGAL and not (name == "activate" and broken)
            assert ask(node, name) == allowed, (node.ROLE, before, name, graph.status[-1:])
            assert state_of(node) == (LEGAL[before, name] if allowed else before)
            refused += not allowed
            if walk.random() < 0.3:
                graph.spin_for(0.05)
        assert refused > 5
        reset(graph)
        graph.spin_for(0.2)
        graph.status.clear()
        graph.start()
        graph.spin_until(graph.is_done)
    assert_bag_equal(bag, expected_messages(*reference))


@pytest.mark.parametrize("kind", NODES, ids=lambda kind: kind.ROLE)
def test_every_transition_from_every_state_works_or_says_why_not(
    domain: int, bag: Path, kind: type[StageNode]
) -> None:
    way: list[tuple[str, ...]] = [(), ("configure",), ("configure", "activate"), ("shutdown",)]
    with LocalGraph(domain, short_case(), bag, [kind], {POSTPROC: {"overwrite": True}}) as graph:
        node = graph.nodes[kind.ROLE]
        for path in way:
            reset(graph)
            assert all(ask(node, name) for name in path)
            state = state_of(node)
            for name in (*NAMES, "shutdown"):
                if (state, name) in LEGAL or (name == "shutdown" and state != "finalized"):
                    continue
                graph.diagnostics.clear()
                for _ in range(2):
                    assert not ask(node, name)
                    assert state_of(node) == state
                wanted = f"{kind.ROLE} is {state}: {name} is not possible, but "

                def told(text: str = wanted) -> bool:
                    return any(s.message.startswith(text) for d in graph.diagnostics for s in d.status)

                graph.spin_until(told, 10.0)
                assert node._last_status.message.startswith(wanted)
                assert node._last_status.code != NodeStatus.ERROR


def test_the_service_says_why_it_refuses(domain: int, bag: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with LocalGraph(domain, short_case(), bag, [NODES[1]]) as graph:
        client = graph.watcher.create_client(ChangeState, f"{STRUCTURE}/change_state")
        graph.spin_until(client.service_is_ready)

        def call(**transition: Any) -> bool:
            future = client.call_async(ChangeState.Request(transition=Transition(**transition)))
            graph.spin_until(future.done)
            return bool(future.result().success)

        for transition, name in (
            ({"id": Transition.TRANSITION_ACTIVATE}, "activate"),
            ({"id": Transition.TRANSITION_INACTIVE_SHUTDOWN}, "shutdown from inactive"),
            ({"label": "deactivate"}, "deactivate"),
            ({"label": "dance"}, "dance"),
            ({"id": 77}, "transition 77"),
        ):
            assert not call(**transition)
            wanted = f"structure_node is unconfigured: {name} is not possible, but configure, shutdown"
            graph.spin_until(lambda text=wanted: any(m.message == text for m in graph.status), 10.0)
            assert wanted in capfd.readouterr().err
        assert call(label="configure")
        assert call(id=Transition.TRANSITION_ACTIVATE)
        assert call(label="shutdown")
        assert not call(label="shutdown")


def test_a_refused_transition_does_not_disturb_a_run(
    domain: int, bag: Path, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    with LocalGraph(domain, short_case(), bag) as graph:
        graph.start()
        for node in graph.nodes.values():
            assert not ask(node, "configure")
        graph.spin_until(graph.is_done)
        result = graph.nodes[POSTPROC]._last_status.result
        assert not ask(graph.nodes[POSTPROC], "activate")
        assert graph.nodes[POSTPROC]._last_status.code == NodeStatus.DONE
        assert graph.nodes[POSTPROC]._last_status.result == result, "what was done stays done"
    assert_bag_equal(bag, expected_messages(*reference))


@pytest.mark.parametrize("paused", [WAVE, STRUCTURE, POSTPROC])
def test_a_paused_and_resumed_run_gives_the_same_bag(
    domain: int, bag: Path, paused: str, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    """Twice, by deactivate and activate, while blocks are under way."""
    case = short_case(stream={"rate": 4.0, "block": 5, "window": 2})
    run = prepare_case(case)
    with LocalGraph(domain, case, bag) as graph:
        graph.start()
        node = graph.nodes[paused]
        for reached in (3.0, 9.0):
            graph.spin_until(lambda t=reached: graph.nodes[POSTPROC].time_ns > t * 1e9)
            assert ask(node, "deactivate")
            assert node._last_status.message == PAUSED
            graph.spin_for(0.3)
            stands = graph.nodes[POSTPROC].time_ns
            graph.spin_for(0.5)  # two seconds of simulated time at this rate
            assert graph.nodes[POSTPROC].time_ns == stands, "nothing moves"
            assert ask(node, "activate")
            assert node._last_status.message == ACTIVE
        graph.spin_until(graph.is_done)
    assert_bag_equal(bag, expected_messages(run, list(stream_case(run))))
    with pytest.raises(AssertionError):  # negative control: a bag with other blocks is noticed
        assert_bag_equal(bag, expected_messages(*reference))


class Pause:
    """Deactivates the wave node of a graph of processes for longer than the limit without progress."""

    def __init__(self, domain: int, seconds: float) -> None:
        self._domain, self._seconds = domain, seconds
        self._reached = threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.answers: list[bool] = []

    def on_progress(self, reached: float, _: float) -> None:
        if reached > 2.0:
            self._reached.set()

    def _run(self) -> None:
        context = Context()
        rclpy.init(context=context, domain_id=self._domain)
        node = Node("operator", context=context, use_global_arguments=False)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        client = node.create_client(ChangeState, f"{WAVE}/change_state")
        client.wait_for_service(60.0)
        self._reached.wait(60.0)
        for label in ("deactivate", "activate"):
            future = client.call_async(ChangeState.Request(transition=Transition(label=label)))
            executor.spin_until_future_complete(future, 10.0)
            self.answers.append(bool(future.done() and future.result().success))
            time.sleep(self._seconds if label == "deactivate" else 0.0)
        executor.shutdown(timeout_sec=1.0)
        node.destroy_node()
        rclpy.shutdown(context=context)


@pytest.mark.parametrize("noticed", [True, False])
def test_a_pause_is_no_stall(domain: int, bag: Path, monkeypatch: pytest.MonkeyPatch, noticed: bool) -> None:
    case = short_case(stream={"rate": 10.0, "block": 5})
    if not noticed:  # negative control
        monkeypatch.setattr(supervisor, "PAUSED", "nobody says so")
    pause = Pause(domain, 5.0)
    pause.thread.start()
    with nullcontext() if noticed else pytest.raises(OwtError, match=r"no progress for 2\.\d* s"):
        run_graph(
            case,
            bag,
            record="all",
            domain_id=domain,
            timeouts=Timeouts(stall=2.0),
            progress=pause.on_progress,
        )
    pause.thread.join()
    if noticed:
        assert pause.answers == [True, True]
        run = prepare_case(case)
        assert_bag_equal(bag, expected_messages(run, list(stream_case(run))))


def test_a_node_that_failed_while_it_worked_starts_only_after_a_cleanup(domain: int, bag: Path) -> None:
    """What was lost with the error would be missing without a word."""
    with LocalGraph(domain, short_case(), bag, [NODES[1]]) as graph:
        node = graph.nodes[STRUCTURE]
        graph.start()
        node.fail("a gap")
        assert state_of(node) == "inactive"
        for _ in range(2):
            assert not ask(node, "activate")
            assert "the run broke off (a gap): clean up and configure" in node._last_status.message
        assert ask(node, "cleanup")
        assert ask(node, "configure")
        assert ask(node, "activate")


@pytest.mark.parametrize(
    ("name", "bad", "good"),
    [("structure.model", "no_such", "oc4"), ("water_depth_m", 47.0, 50.0), ("fatigue.sn_curve", "Q", CURVE)],
)
def test_configure_fails_cleanly_and_works_after_the_parameter_is_set(
    domain: int, bag: Path, reference: tuple[CaseRun, list[CaseBlocks]], name: str, bad: Any, good: Any
) -> None:
    overrides = {kind.ROLE: {name: bad} for kind in NODES}
    with LocalGraph(domain, short_case(), bag, NODES, overrides) as graph:
        failed = [node for node in graph.nodes.values() if not ask(node, "configure")]
        assert failed
        for node in failed:
            assert state_of(node) == "unconfigured"
            assert name in node._last_status.message
            assert (node._outlets, node._inlets, node._credit_in, node._peers) == ([], [], None, None)
            assert not ask(node, "activate")
        for node in graph.nodes.values():
            (result,) = node.set_parameters([Parameter(name, value=good)])
            assert result.successful, result.reason
        reset(graph)
        graph.spin_for(0.2)
        graph.status.clear()
        graph.start()
        graph.spin_until(graph.is_done)
    assert_bag_equal(bag, expected_messages(*reference))
