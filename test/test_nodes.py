"""The three nodes, real messages over DDS in one process: what they publish, and what they refuse."""

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from owt_msgs.msg import Credit, NodeStatus
from rclpy.parameter import Parameter

from local_graph import SUCCESS, LocalGraph, assert_messages_equal, expected_messages, short_case
from owt_campaign.pipeline import CaseBlocks, CaseRun, prepare_case, stream_case
from owt_model.config import CaseConfig
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_postproc.node import PostprocNode
from owt_ros import convert, topics
from owt_ros.qos import qos_for
from owt_ros.topics import POSTPROC, STRUCTURE, WAVE
from owt_structure_node.node import StructureNode
from owt_wave_node.node import WaveNode

pytestmark = [pytest.mark.graph, pytest.mark.timeout(120)]


@pytest.mark.parametrize("window", [1, 4])
def test_every_message_equals_the_run_in_one_process(
    domain: int, bag: Path, reference: tuple[CaseRun, list[CaseBlocks]], window: int
) -> None:
    with LocalGraph(domain, short_case(stream={"window": window}), bag) as graph:
        heard = graph.listen()
        graph.start()
        graph.spin_until(graph.is_done)
        graph.spin_for(0.3)
    for label, messages in expected_messages(*reference).items():
        assert len(heard[label]) == len(messages), label
        for one, two in zip(messages, heard[label], strict=True):
            assert_messages_equal(label, one, two)
    times = [clock.clock.sec for clock in heard["/clock"]]
    assert times == [0, 5, 10, 15]
    assert bag.is_dir()
    assert not bag.with_name(".bag.partial").exists()


def test_drag_damping_reaches_the_structure(domain: int, bag: Path) -> None:
    """The damping travels with the load basis: same numbers as in one process, and not those without it."""
    case = short_case(morison={"hydrodynamic_damping": True})
    run = prepare_case(case)
    expected = expected_messages(run, list(stream_case(run)))
    with LocalGraph(domain, case, bag) as graph:
        heard = graph.listen()
        graph.start()
        graph.spin_until(graph.is_done)
        graph.spin_for(0.3)
    for label, messages in expected.items():
        for one, two in zip(messages, heard[label], strict=True):
            assert_messages_equal(label, one, two)
    plain = prepare_case(short_case()).response.description.damping_ratio
    assert (run.response.description.damping_ratio > plain).all()


def test_the_comparison_would_notice_one_wrong_bit(reference: tuple[CaseRun, list[CaseBlocks]]) -> None:
    block = reference[1][1].stress
    wrong = dataclasses.replace(block, axial=np.nextafter(block.axial, np.inf))
    with pytest.raises(AssertionError, match="axial"):
        assert_messages_equal("stress", convert.stress_message(block), convert.stress_message(wrong))


def test_slow_acknowledgement_loses_nothing(domain: int, bag: Path) -> None:
    """A consumer that gives no credit holds the producer at its window; nothing is dropped."""
    case = short_case(stream={"window": 2, "block": 10})
    with LocalGraph(domain, case, bag, [WaveNode]) as graph:
        names = (STRUCTURE, POSTPROC)
        others = [_node(graph, name) for name in names]
        wanted = (topics.NODAL_LOADS, topics.SURFACE_ELEVATION)
        got: dict[str, list[int]] = {topic.label: [] for topic in wanted}
        for node in others:
            for topic in (*topics.RECORDED,):
                if node.get_name() in topic.consumers and topic.producer == WAVE:
                    keep = got[topic.label] if topic in wanted and node is others[1] else []
                    node.create_subscription(
                        topic.message, topic.name, lambda m, k=keep: k.append(getattr(m, "sequence", 0)),
                        qos_for(topic, window=2),
                    )  # fmt: skip
        credit = {
            n.get_name(): n.create_publisher(Credit, "owt/credit", qos_for(topics.CREDIT)) for n in others
        }
        graph.start()
        graph.spin_until(lambda: len(got["/owt/nodal_loads"]) == 2)
        graph.spin_for(0.5)
        assert got["/owt/nodal_loads"] == [0, 1], "no credit, no further block"
        for sequence in range(19):
            for name in names:
                for topic in wanted:
                    if name in topic.consumers:
                        credit[name].publish(Credit(consumer=name, topic=topic.label, sequence=sequence))
            expected = min(sequence + 3, 19)
            graph.spin_until(lambda n=expected: all(len(v) == n for v in got.values()))
        assert all(v == list(range(19)) for v in got.values())
        graph.spin_until(lambda: NodeStatus.DONE in graph.codes(WAVE))


def _node(graph: LocalGraph, name: str) -> Any:
    from rclpy.node import Node

    node = Node(name, context=graph.context, use_global_arguments=False)
    graph._executor.add_node(node)
    graph._stack.callback(node.destroy_node)
    return node


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        (
            "sea_state.hs_m",
            -2.0,
            "sea_state.hs_m = -2.0: must be greater than 0. It is the significant",
        ),
        ("sea_state.tp_s", 0.0, "sea_state.tp_s = 0.0: must be greater than 0"),
        ("wave.ordre", 1, "wave.ordre = 1: is not a known parameter. Did you mean: wave.order"),
        ("water_depth_m", 47.0, "water_depth_m = 47.0: lies more than 1 m from the mudline"),
        (
            "structure.model",
            "no_such",
            "structure.model = 'no_such': is neither a shipped structure",
        ),
        ("lease_s", -1.0, "lease_s = -1.0: must be greater than or equal to 0"),
    ],
)
def test_a_bad_parameter_makes_configure_fail(
    domain: int, bag: Path, name: str, value: Any, message: str
) -> None:
    with LocalGraph(domain, short_case(), bag, [WaveNode], {WAVE: {name: value}}) as graph:
        assert graph.nodes[WAVE].trigger_configure() != SUCCESS
        assert message in graph.error_of(WAVE)
        assert graph.nodes[WAVE].trigger_activate() != SUCCESS


def test_a_bad_value_is_refused_when_it_is_set(domain: int, bag: Path) -> None:
    with LocalGraph(domain, short_case(), bag, [WaveNode], {WAVE: {"sea_state.hs_m": -2.0}}) as graph:
        node = graph.nodes[WAVE]
        assert node.trigger_configure() != SUCCESS
        for name, value in (
            ("sea_state.hs_m", -1.0),
            ("sea_state.tp_s", 1.0),
            ("time.n", 2.5),
            ("structure.reduction", "CB"),
        ):
            (result,) = node.set_parameters([Parameter(name, value=value)])
            assert not result.successful, name
            assert result.reason
        (result,) = node.set_parameters([Parameter("sea_state.hs_m", value=1.0)])
        assert result.successful
        assert node.trigger_configure() == SUCCESS


def test_a_missing_bag_parameter_is_named(domain: int, bag: Path) -> None:
    with LocalGraph(domain, short_case(), bag, [PostprocNode], {POSTPROC: {"bag": ""}}) as graph:
        assert graph.nodes[POSTPROC].trigger_configure() != SUCCESS
        assert graph.error_of(POSTPROC).startswith("bag = '': is missing")


def test_transitions_twice_and_in_any_order(domain: int, bag: Path) -> None:
    with LocalGraph(domain, short_case(), bag, [StructureNode]) as graph:
        node = graph.nodes[STRUCTURE]
        assert node.trigger_activate() != SUCCESS
        assert node.trigger_configure() == SUCCESS
        assert node.trigger_configure() != SUCCESS
        for _ in range(2):
            assert node.trigger_activate() == SUCCESS
            assert node.trigger_deactivate() == SUCCESS
        assert node.trigger_cleanup() == SUCCESS
        assert node.trigger_configure() == SUCCESS
        assert node.trigger_shutdown() == SUCCESS


class Feeder:
    """Stands in for the wave node: sends what a test wants the structure node to get."""

    def __init__(self, graph: LocalGraph, run: CaseRun, loads: list[Any]) -> None:
        node = _node(graph, WAVE)
        self._publishers = {
            topic: node.create_publisher(topic.message, topic.name, qos_for(topic, window=10))
            for topic in (topics.MODEL, topics.LOAD_BASIS, topics.NODAL_LOADS)
        }
        graph.start()
        graph.spin_until(lambda: all(p.get_subscription_count() for p in self._publishers.values()))
        self._publishers[topics.MODEL].publish(convert.model_message(run.mesh))
        self._publishers[topics.LOAD_BASIS].publish(convert.load_basis_message(run.load_basis))
        for message in loads:
            self._publishers[topics.NODAL_LOADS].publish(message)


@pytest.fixture
def structure(domain: int, bag: Path) -> Iterator[LocalGraph]:
    with LocalGraph(domain, short_case(), bag, [StructureNode]) as graph:
        yield graph


def _loads(blocks: list[CaseBlocks], *order: int, **changes: Any) -> list[Any]:
    return [convert.nodal_loads_message(dataclasses.replace(blocks[i].load, **changes)) for i in order]


def test_a_wrong_model_hash_is_an_error(
    structure: LocalGraph, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    run, blocks = reference
    Feeder(structure, run, _loads(blocks, 0, model_hash="0" * 64))
    message = structure.error_of(STRUCTURE)
    assert message.startswith("/owt/nodal_loads belongs to model 000000000000, this node has ")
    assert "give all nodes the same structure.model" in message


def test_a_model_of_another_structure_is_an_error(
    structure: LocalGraph, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    other = dataclasses.replace(reference[0], mesh=build_mesh(load_structure("oc4-thesis")))
    Feeder(structure, other, [])
    assert structure.error_of(STRUCTURE).startswith("/owt/model belongs to model ")


@pytest.mark.parametrize(
    ("order", "message"),
    [
        ((0, 2), "/owt/nodal_loads: block 2 arrived, 1 was expected: gap of 1"),
        ((0, 1, 1), "duplicate or out of order"),
        ((1, 0), "block 1 arrived, 0 was expected: gap of 1"),
    ],
)
def test_gap_duplicate_and_reordering_are_errors(
    structure: LocalGraph, reference: tuple[CaseRun, list[CaseBlocks]], order: tuple[int, ...], message: str
) -> None:
    Feeder(structure, reference[0], _loads(reference[1], *order))
    assert message in structure.error_of(STRUCTURE)
    structure.spin_until(lambda: any(s.level == b"\x02" for d in structure.diagnostics for s in d.status))
    worst = [s for d in structure.diagnostics for s in d.status if s.level == b"\x02"]
    assert message in worst[0].message
    assert worst[0].name == STRUCTURE


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_load_that_is_no_number_is_an_error(
    domain: int, bag: Path, reference: tuple[CaseRun, list[CaseBlocks]], value: float
) -> None:
    run, blocks = reference
    nodal = blocks[0].load.nodal.copy()
    nodal[13, 2, 1] = value
    with LocalGraph(domain, short_case(), bag, [PostprocNode, StructureNode]) as graph:
        Feeder(graph, run, _loads(blocks, 0, nodal=nodal))
        message = graph.error_of(STRUCTURE)
    assert "NaN or inf" in message
    assert "sample 13" in message


def test_a_message_with_too_few_numbers_is_an_error(
    structure: LocalGraph, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    (message,) = _loads(reference[1], 0)
    message.nodal = message.nodal[:-1]
    Feeder(structure, reference[0], [message])
    assert "NodalLoads 0: nodal has " in structure.error_of(STRUCTURE)


def test_the_gap_is_marked_in_the_bag(
    domain: int, bag: Path, reference: tuple[CaseRun, list[CaseBlocks]]
) -> None:
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    blocks = reference[1]
    with LocalGraph(domain, short_case(), bag, [PostprocNode]) as graph:
        feeder = _node(graph, WAVE)
        publisher = feeder.create_publisher(
            topics.NODAL_LOADS.message, topics.NODAL_LOADS.name, qos_for(topics.NODAL_LOADS, window=9)
        )
        graph.start()
        graph.spin_until(lambda: publisher.get_subscription_count() > 0)
        for message in _loads(blocks, 0, 2):
            publisher.publish(message)
        assert "gap of 1" in graph.error_of(POSTPROC)
    assert not bag.exists()
    partial = bag.with_name(".bag.partial")
    store = get_typestore(Stores.ROS2_KILTED)
    with Reader(partial) as reader:
        marks = [
            status.message
            for connection, _, raw in reader.messages()
            if connection.topic == "/diagnostics"
            for status in store.deserialize_cdr(raw, connection.msgtype).status
        ]
    assert any("gap of 1" in mark for mark in marks)


def test_a_full_disk_is_an_error_and_leaves_no_bag(
    domain: int, bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import errno
    import os

    from owt_postproc import bag as module

    written, write = 0, os.write

    def limited(fd: int, data: memoryview) -> int:
        nonlocal written
        if written > 3_000_000:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written += len(data)
        return write(fd, data)

    with LocalGraph(domain, short_case(), bag) as graph:
        graph.start()
        monkeypatch.setattr(module.os, "write", limited)
        message = graph.error_of(POSTPROC)
        monkeypatch.undo()
    assert "the disk is full" in message
    assert str(bag.with_name(".bag.partial")) in message
    assert not bag.exists()


def test_nodes_that_are_missing_are_named(domain: int, bag: Path) -> None:
    with LocalGraph(domain, short_case(), bag, [WaveNode], {WAVE: {"wait_s": 0.5}}) as graph:
        graph.start()
        message = graph.error_of(WAVE)
    assert "no subscription of" in message
    assert STRUCTURE in message
    assert POSTPROC in message


def test_result_of_the_run(domain: int, bag: Path) -> None:
    with LocalGraph(domain, short_case(), bag) as graph:
        graph.start()
        graph.spin_until(graph.is_done)
        result = json.loads(
            next(m.result for m in graph.status if m.node == POSTPROC and m.code == NodeStatus.DONE)
        )
    assert result["bag"] == str(bag)
    assert result["stress_samples"] == 5 * 189 + 1
    assert result["messages"]["/owt/energy"] == 4
    assert result["largest_damage"] > 0.0


def test_rate_ties_the_stream_to_wall_time(domain: int, bag: Path) -> None:
    import time

    case: CaseConfig = short_case(stream={"rate": 10.0, "block": 10})
    with LocalGraph(domain, case, bag) as graph:
        heard = graph.listen()
        graph.start()
        graph.spin_until(lambda: len(heard["/owt/energy"]) > 0)  # everything is built, time runs
        began = time.monotonic()
        graph.spin_until(graph.is_done)
        assert 1.6 <= time.monotonic() - began < 10.0, "18 s of simulated time at ten times real time"
