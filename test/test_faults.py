"""What must not break a graph silently: killed nodes, full disks, garbage, second producers, restarts."""

import os
import resource
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from owt_msgs.msg import Credit, NodeStatus
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock

from fault_trials import PHASES, run_trial, trial_case
from local_graph import LocalGraph, expected_messages, node_processes, read_by_rosbags, short_case, start_node
from owt_bringup.graph import node_environment, run_graph
from owt_bringup.process import Child
from owt_bringup.supervisor import Supervisor
from owt_campaign.pipeline import CaseBlocks, CaseRun, prepare_case, stream_case
from owt_model.errors import OwtError
from owt_postproc.bag_recovery import recover_report
from owt_postproc.node import PostprocNode
from owt_ros import convert, topics
from owt_ros.convert import stamp
from owt_ros.qos import qos_for
from owt_ros.topics import POSTPROC, STRUCTURE, WAVE, Topic
from owt_structure_node.node import StructureNode
from owt_wave_node.node import WaveNode

pytestmark = [pytest.mark.graph, pytest.mark.timeout(240)]


@pytest.mark.parametrize(("number", "victim", "phase"), [(100, WAVE, "run"), (101, POSTPROC, "closing")])
def test_a_killed_node_is_noticed_and_what_was_recorded_is_exact(
    tmp_path: Path, number: int, victim: str, phase: str
) -> None:
    """Two of the trials of docs/reliability.md; ``fault_trials.py`` runs all of them."""
    assert phase in PHASES
    trial = run_trial(number, victim, phase, tmp_path)
    assert trial.survived, trial
    assert trial.exact
    assert trial.bring_up <= 2.0
    assert trial.noticed <= 8.0, "by the nodes themselves, where one was killed before it was discovered"


def test_a_disk_that_fills_ends_the_run_and_keeps_what_fitted(tmp_path: Path) -> None:
    """The kernel refuses the recording node's writes from 2 MB on; what was written can be recovered."""
    children: dict[str, Child] = {}

    def limit(processes: dict[str, Child]) -> None:
        children.update(processes)
        resource.prlimit(processes[POSTPROC].pid, resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))

    bag = tmp_path / "bag"
    with pytest.raises(OwtError, match=r"^postproc_node: bag .*bag: .*; what was recorded is kept in"):
        run_graph(short_case(time={"n": 1000}), bag, on_start=limit)
    assert not bag.exists()
    assert all(child.exit_code is not None for child in children.values())
    found = recover_report(tmp_path / ".bag.partial", tmp_path / "new")
    assert found.messages > 10
    assert not found.intact
    assert (tmp_path / ".bag.partial" / "bag_0.mcap").stat().st_size <= 2_000_000


class StandIn:
    """A node of the graph's name that does what a test wants."""

    def __init__(self, graph: LocalGraph, name: str) -> None:
        self.node = Node(name, context=graph.context, use_global_arguments=False)
        graph._executor.add_node(self.node)
        graph._stack.callback(self.node.destroy_node)
        self._publishers: dict[Topic, Any] = {}
        self._graph = graph

    def hear(self, producer: str) -> None:
        """Subscribe to what a producer sends to this node, and never acknowledge it."""
        for topic in topics.RECORDED:
            if topic.producer == producer and self.node.get_name() in topic.consumers:
                profile = qos_for(topic, window=10)
                self.node.create_subscription(topic.message, topic.name, lambda _: None, profile)

    def open(self, *wanted: Topic) -> None:
        """Get ready to publish."""
        for topic in wanted:
            profile = qos_for(topic, window=10)
            self._publishers[topic] = self.node.create_publisher(topic.message, topic.name, profile)
        self._graph.spin_until(lambda: all(p.get_subscription_count() for p in self._publishers.values()))

    def send(self, topic: Topic, message: Any) -> None:
        self._publishers[topic].publish(message)


def test_a_consumer_that_never_acknowledges_is_named(domain: int, tmp_path: Path) -> None:
    options = {WAVE: {"stall_s": 1.5}}
    with LocalGraph(domain, short_case(), tmp_path / "bag", [WaveNode], options) as graph:
        for name in (STRUCTURE, POSTPROC):
            StandIn(graph, name).hear(WAVE)
        graph.start()
        message = graph.error_of(WAVE)
    assert "has not acknowledged block 0 of /owt/" in message
    assert "stall_s" in message


def test_credits_that_make_no_sense_change_nothing(domain: int, tmp_path: Path) -> None:
    """From nobody, for other topics, for blocks that were never sent: the run gives the same numbers."""
    with LocalGraph(domain, short_case(stream={"block": 10}), tmp_path / "bag") as graph:
        heard = graph.listen([topics.MEMBER_STRESS])
        noise = graph.watcher.create_publisher(Credit, "owt/credit", qos_for(topics.CREDIT))
        graph.start()
        for consumer in ("", "nobody", STRUCTURE):
            for topic in ("", "/owt/nodal_loads", "/clock"):
                noise.publish(Credit(consumer=consumer, topic=topic, sequence=2**63))
        graph.spin_until(graph.is_done)
        graph.spin_until(lambda: len(heard["/owt/member_stress"]) == 19)
    blocks = list(stream_case(prepare_case(short_case(stream={"block": 10}))))
    for message, block in zip(heard["/owt/member_stress"], blocks, strict=True):
        np.testing.assert_array_equal(message.axial, block.stress.axial.ravel())


#: What comes to each node, and how it can be wrong: topic, field, value (None: one number less), the error.
GARBAGE = [
    (STRUCTURE, topics.MODEL, "model_hash", "", "/owt/model belongs to model"),
    (STRUCTURE, topics.LOAD_BASIS, "vectors", np.nan, "load_basis.vectors"),
    (STRUCTURE, topics.LOAD_BASIS, "vectors", None, "LoadBasis: vectors has"),
    (STRUCTURE, topics.NODAL_LOADS, "fixed_end", np.inf, "NaN or inf"),
    (STRUCTURE, topics.NODAL_LOADS, "fixed_end", None, "NodalLoads 0: fixed_end has"),
    (STRUCTURE, topics.NODAL_LOADS, "dt", np.nan, "is no block of a stream"),
    (STRUCTURE, topics.NODAL_LOADS, "samples", 0, "is no block of a stream"),
    (POSTPROC, topics.MODEL, "node_position_m", np.nan, "/owt/model: node_position_m holds NaN or inf"),
    (POSTPROC, topics.SEA_STATE, "amplitude_m", np.nan, "/owt/sea_state: amplitude_m holds NaN or inf"),
    (POSTPROC, topics.LOAD_BASIS, "mean", np.inf, "/owt/load_basis: mean holds NaN or inf"),
    (
        POSTPROC,
        topics.REDUCED_MODEL,
        "model_hash",
        "f" * 64,
        "/owt/reduced_model belongs to model ffff",
    ),
    (POSTPROC, topics.REDUCED_MODEL, "frequency_hz", np.nan, "/owt/reduced_model: frequency_hz holds NaN"),
    (POSTPROC, topics.SURFACE_ELEVATION, "total", np.nan, "/owt/surface_elevation block 0: total holds NaN"),
    (POSTPROC, topics.NODAL_LOADS, "nodal", None, "NodalLoads 0: nodal has"),
    (POSTPROC, topics.MODAL_STATE, "velocity", np.nan, "/owt/modal_state block 0: velocity holds NaN"),
    (POSTPROC, topics.MEMBER_STRESS, "von_mises", np.nan, "/owt/member_stress block 0: von_mises holds NaN"),
    (POSTPROC, topics.MEMBER_STRESS, "axial", None, "MemberStress 0: "),
    (
        POSTPROC,
        topics.ENERGY,
        "kinetic_substructure",
        -np.inf,
        "block 0: kinetic_substructure holds",
    ),
]


def spoiled(message: Any, field: str, value: Any) -> Any:
    """Put a wrong value into a message: into one entry of an array, or drop its last one."""
    old = getattr(message, field)
    if not hasattr(old, "__len__") or isinstance(old, str):
        setattr(message, field, value)
    elif value is None:
        setattr(message, field, old[:-1])
    else:
        old[len(old) // 2] = value
    return message


@pytest.mark.parametrize(("node", "topic", "field", "value", "words"), GARBAGE)
def test_garbage_in_each_message_is_an_error(
    domain: int,
    tmp_path: Path,
    reference: tuple[CaseRun, list[CaseBlocks]],
    node: str,
    topic: Topic,
    field: str,
    value: Any,
    words: str,
) -> None:
    kinds = [PostprocNode] if node == POSTPROC else [StructureNode]
    if field == "fixed_end":  # found when it is integrated, which needs somebody to send the response to
        kinds = [PostprocNode, StructureNode]
    sent = expected_messages(*reference)
    with LocalGraph(domain, short_case(), tmp_path / "bag", kinds) as graph:
        producer = StandIn(graph, topic.producer)
        graph.start()
        before = [t for t in topics.RECORDED if t.kind is topics.Kind.LATCHED and node in t.consumers]
        wanted = [t for t in dict.fromkeys([*before, topic]) if t.label in sent]
        producer.open(*wanted)
        copies = {t: graph_copy(t, sent[t.label][0]) for t in wanted}
        spoiled(copies[topic], field, value)
        for t in wanted:
            producer.send(t, copies[t])
        assert words in graph.error_of(node)
    assert not (tmp_path / "bag").exists()


def graph_copy(topic: Topic, message: Any) -> Any:
    """Copy a message through its bytes."""
    return deserialize_message(bytes(serialize_message(message)), topic.message)


def test_two_producers_on_a_topic_are_an_error(
    domain: int, tmp_path: Path, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    """A second wave node would mix two seas: neither consumer goes on."""
    case = short_case(stream={"rate": 5.0})
    with LocalGraph(domain, case, tmp_path / "bag") as graph:
        second = StandIn(graph, "another_wave_node")
        graph.start()
        second.open(topics.NODAL_LOADS)
        graph.spin_until(lambda: max((m.time_s for m in graph.status if m.node == POSTPROC), default=0) > 1.0)
        second.send(topics.NODAL_LOADS, convert.nodal_loads_message(reference[1][1].load))
        for name in (STRUCTURE, POSTPROC):
            assert "/owt/nodal_loads: block" in graph.error_of(name)
    assert not (tmp_path / "bag").exists()


def test_a_clock_that_jumps_back_is_an_error(domain: int, tmp_path: Path) -> None:
    with LocalGraph(domain, short_case(stream={"rate": 5.0}), tmp_path / "bag") as graph:
        second = StandIn(graph, "another_clock")
        graph.start()
        second.open(topics.CLOCK)
        graph.spin_until(lambda: max((m.time_s for m in graph.status if m.node == POSTPROC), default=0) > 6.0)
        second.send(topics.CLOCK, Clock(clock=stamp(1_000_000_000)))
        assert "/clock went from " in graph.error_of(POSTPROC)
    assert not (tmp_path / "bag").exists()


def test_a_node_restarts_while_the_others_live(tmp_path: Path, domain: int) -> None:
    """Killed mid-run and started anew: after cleanup and configure the graph runs, with the right numbers."""
    case = trial_case(5)
    change = Transition()
    environment = node_environment(domain, tmp_path)
    with node_processes(case, tmp_path, environment) as children:
        watched = dict(children)
        with Supervisor(domain, watched, lambda: None) as graph:
            graph.await_services(60.0)
            names = list(children)
            bring_up(graph, names)
            graph.spin_until(lambda: graph.status[POSTPROC].time_s > 2.0, 60.0, "no start")
            watched.clear()
            os.kill(children[STRUCTURE].pid, signal.SIGKILL)
            children[STRUCTURE].wait(5.0)
            others = [WAVE, POSTPROC]
            graph.spin_until(
                lambda: all(graph.status[n].code == NodeStatus.ERROR for n in others), 10.0, "nobody noticed"
            )
            children[STRUCTURE] = start_node(STRUCTURE, tmp_path, environment)
            graph.status.clear()
            watched.update(children)  # the new process is awaited by its token: the dead one is still known
            graph.await_services(60.0)
            graph.change_states(others, change.TRANSITION_CLEANUP, 30.0)
            graph.status.clear()
            bring_up(graph, names)
            graph.spin_until(
                lambda: POSTPROC in graph.status and graph.status[POSTPROC].code == NodeStatus.DONE,
                60.0,
                "no end",
            )
    found = read_by_rosbags(tmp_path / "bag")
    blocks = list(stream_case(prepare_case(case)))
    assert len(found["/owt/modal_state"]) == len(blocks)
    for message, block in zip(found["/owt/modal_state"], blocks, strict=True):
        np.testing.assert_array_equal(message.displacement, block.modal.displacement.ravel())


def bring_up(graph: Supervisor, names: list[str]) -> None:
    graph.change_states(names, Transition.TRANSITION_CONFIGURE, 60.0)
    for name in names:
        graph.change_states([name], Transition.TRANSITION_ACTIVATE, 60.0)
