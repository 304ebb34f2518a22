"""A load at the tower top in the graph: a rotor's thrust, a file, and wrenches that somebody publishes."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from owt_msgs.msg import NodeStatus, TowerTopLoad
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Header

from local_graph import (
    NODES,
    SUCCESS,
    LocalGraph,
    assert_messages_equal,
    expected_messages,
    read_by_rosbags,
    short_case,
)
from owt_bringup.graph import run_graph
from owt_campaign.pipeline import prepare_case, run_case, stream_case
from owt_model.config import CaseConfig
from owt_model.errors import OwtError
from owt_postproc.bag_reader import read_bag
from owt_ros import convert
from owt_ros.lifecycle import StageNode
from owt_ros.qos import qos_for
from owt_ros.topics import POSTPROC, RECORDED, STATUS, STRUCTURE, TOWER_TOP_LOAD
from owt_structure_node.node import StructureNode

pytestmark = [pytest.mark.graph, pytest.mark.timeout(120)]

LABEL, INPUT = "/owt/tower_top_load", "/owt/tower_top_wrench"
THRUST = {
    "speed_m_s": 14.0,
    "direction_deg": -100.0,
    "turbulence_intensity": 0.13,
    "seed": 2**62 + 1,
    "rotor": {"hub_above_top_m": 2.5, "damping_n_s_m": 5.5e4},
}
SECOND = 1_000_000_000
#: Stamps in ns of somebody's rotor code: irregular, from 0 to past the last sample. The blocks of
#: :func:`case_of` need those up to the fifth, the last, and the last.
STAMPS = [
    0,
    30_000_001,
    400_000_000,
    1_999_999_999,
    2_400_000_000,
    2_650_000_000,
    4_700_000_000,
    6_123_456_789,
]
WRENCHES = np.random.default_rng(4).standard_normal((len(STAMPS), 6)) * [4e5, 4e5, 1e5, 2e6, 2e6, 5e5]


def case_of(wind: dict[str, Any], **changes: Any) -> CaseConfig:
    """6 s in three blocks, the last one shorter."""
    return short_case(wind=wind, **{"time": {"n": 60}, "stream": {"block": 25}, **changes})


def expected(case: CaseConfig) -> dict[str, list[Any]]:
    """What the graph of a case must publish, by the run in one process."""
    run = prepare_case(case)
    blocks = list(stream_case(run))
    tops = [convert.tower_top_load_message(b.tower_top) for b in blocks if b.tower_top is not None]
    return {**expected_messages(run, blocks), LABEL: tops}


def wrenches(messages: list[Any]) -> np.ndarray:
    return np.concatenate([np.reshape(message.wrench, (-1, 6)) for message in messages])


def assert_equal(found: dict[str, list[Any]], wanted: dict[str, list[Any]]) -> None:
    """Compare messages, number by number."""
    for label, messages in wanted.items():
        assert len(found[label]) == len(messages) > 0, label
        for one, two in zip(messages, found[label], strict=True):
            assert_messages_equal(label, one, two)


def assert_close(found: dict[str, list[Any]], wanted: dict[str, list[Any]]) -> None:
    """Compare streams: interpolation in ns differs from that in s by the rounding of the samples' times."""
    for label, names in (
        (LABEL, ("wrench",)),
        ("/owt/modal_state", ("displacement", "velocity", "acceleration")),
        ("/owt/member_stress", ("axial", "bending_y", "bending_z", "von_mises")),
        ("/owt/energy", ("potential", "kinetic", "potential_substructure")),
    ):
        assert [m.sequence for m in found[label]] == [m.sequence for m in wanted[label]] == [0, 1, 2]
        for name in names:
            one, two = (np.concatenate([getattr(m, name) for m in all_[label]]) for all_ in (found, wanted))
            assert np.abs(one - two).max() <= 1e-9 * np.abs(two).max(), f"{label}.{name}"


def series_of_messages(path: Path, interpolation: str) -> dict[str, Any]:
    """The messages as a file; a value that is held ends 1 ns before the next."""
    rows = []
    for i, stamp in enumerate(STAMPS):
        if interpolation == "hold" and i:
            rows.append((stamp - 1, WRENCHES[i - 1]))
        rows.append((stamp, WRENCHES[i]))
    lines = [
        ",".join([f"{stamp // SECOND}.{stamp % SECOND:09d}", *map(repr, wrench.tolist())])
        for stamp, wrench in rows
    ]
    path.write_text("\n".join(["time_s,fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm", *lines]) + "\n")
    return {"series": {"path": str(path)}}


class RotorCode:
    """Stands in for a program that computes the load at the tower top and knows nothing of this project."""

    def __init__(self, graph: LocalGraph, topic: str = INPUT) -> None:
        self.node = Node("rotor_code", context=graph.context, use_global_arguments=False)
        graph._executor.add_node(self.node)
        graph._stack.callback(self.node.destroy_node)
        profile = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
        self._publisher = self.node.create_publisher(WrenchStamped, topic, profile)
        self._graph, self._sent = graph, 0

    @property
    def readers(self) -> int:
        return int(self._publisher.get_subscription_count())

    def burst(self, count: int) -> None:
        """Publish the next `count` wrenches at once."""
        for i in range(self._sent, self._sent + count):
            self.send(STAMPS[i], WRENCHES[i])
        self._sent += count

    def send(self, stamp: int, wrench: Any) -> None:
        """Publish one wrench."""
        force, torque = (
            Vector3(x=float(a), y=float(b), z=float(c)) for a, b, c in np.reshape(wrench, (2, 3))
        )
        header = Header(stamp=convert.stamp(stamp))
        self._publisher.publish(WrenchStamped(header=header, wrench=Wrench(force=force, torque=torque)))


def started(graph: LocalGraph) -> RotorCode:
    """Start the graph, and a rotor code that it hears."""
    rotor = RotorCode(graph)
    graph.start()
    graph.spin_until(lambda: rotor.readers == 1)
    return rotor


def test_thrust_in_three_processes_equals_the_run_in_one(bag: Path) -> None:
    """Every number, through a parameter file and DDS into the bag, which holds the load itself."""
    ramped = {"reduction": "CB04M03", "ramp_s": 2.0}
    case = case_of({"thrust": THRUST}, structure=ramped)
    result = run_graph(case, bag, record="all")
    wanted = expected(case)
    assert_equal(read_by_rosbags(bag), wanted)
    assert result.statistics["messages"][LABEL] == 3
    stream = read_bag(bag).streams[LABEL]
    np.testing.assert_array_equal(stream["wrench"], wrenches(wanted[LABEL]))
    np.testing.assert_allclose(stream["time"], 0.1 * np.arange(60), atol=1e-12)
    np.testing.assert_array_equal(
        run_case(case, keep_series=True).series["tower_top.wrench"], stream["wrench"]
    )
    other = expected(case_of({"thrust": {**THRUST, "seed": 2**62}}, structure=ramped))
    with pytest.raises(AssertionError, match=r"tower_top_load\.wrench"):
        assert_equal({LABEL: other[LABEL]}, {LABEL: wanted[LABEL]})


@pytest.mark.parametrize("interpolation", ["linear", "hold"])
def test_messages_give_what_a_file_of_them_gives(
    domain: int, bag: Path, tmp_path: Path, interpolation: str
) -> None:
    """Sent in bursts before, during and after activation; a block waits for the wrench that it needs."""
    with LocalGraph(domain, case_of({"topic": {"interpolation": interpolation}}), bag) as graph:
        heard = graph.listen((*RECORDED, TOWER_TOP_LOAD))
        rotor, structure = RotorCode(graph), graph.nodes[STRUCTURE]
        for node in graph.nodes.values():
            assert node.trigger_configure() == SUCCESS, graph.status
        graph.spin_until(lambda: rotor.readers == 1)
        rotor.burst(2)
        graph.spin_until(lambda: len(structure._backlog) == 2)
        for node in graph.nodes.values():
            assert node.trigger_activate() == SUCCESS, graph.status
        rotor.burst(3)  # up to the last sample of the first block
        graph.spin_until(lambda: len(heard[LABEL]) == 1)
        rotor.burst(2)  # not as far as the next block
        graph.spin_for(0.5)
        assert len(heard[LABEL]) == len(heard["/owt/member_stress"]) == 1
        rotor.burst(1)
        graph.spin_until(graph.is_done)
        graph.spin_until(lambda: all(len(heard[label]) == 3 for label in (LABEL, "/owt/energy")))
    wanted = {
        name: expected(case_of(series_of_messages(tmp_path / name, name))) for name in ("linear", "hold")
    }
    assert_close(heard, wanted.pop(interpolation))
    for other in wanted.values():
        with pytest.raises(AssertionError, match=r"tower_top_load\.wrench"):
            assert_close(heard, other)
    np.testing.assert_array_equal(read_bag(bag).streams[LABEL]["wrench"], wrenches(heard[LABEL]))


def test_a_publisher_that_stops_is_an_error_that_names_the_topic(domain: int, bag: Path) -> None:
    limit = 0.8
    with LocalGraph(domain, case_of({"topic": {"timeout_s": limit}}), bag) as graph:
        heard = graph.listen([TOWER_TOP_LOAD])
        started(graph).burst(5)
        graph.spin_until(lambda: len(heard[LABEL]) == 1)
        began = time.monotonic()
        message = graph.error_of(STRUCTURE)
        assert time.monotonic() - began < limit + 5.0, "it looks four times in that time"
    assert message.startswith(f"no message on {INPUT} reaches the end of block 1 within 0.8 s: publish it")
    assert "wind.topic.timeout_s" in message
    assert not bag.exists()


def test_a_graph_that_nobody_publishes_to_ends_with_the_reason(bag: Path) -> None:
    with pytest.raises(OwtError, match=rf"^structure_node: no message on {INPUT} reaches the end of block 0"):
        run_graph(case_of({"topic": {"timeout_s": 0.5}}), bag)
    assert not bag.exists()


def test_a_publisher_slower_than_the_limit_per_block_is_no_error(domain: int, bag: Path) -> None:
    """One message every 0.1 s of wall time is not missing, however long all those of a block take."""
    case = case_of({"topic": {"timeout_s": 1.2}}, stream={"block": 60})
    with LocalGraph(domain, case, bag) as graph:
        rotor, stamps = started(graph), iter(range(0, 100 * SECOND, SECOND // 4))
        rotor.node.create_timer(0.1, lambda: rotor.send(next(stamps), WRENCHES[0]))
        graph.spin_until(graph.is_done)


@pytest.mark.parametrize(
    ("stamps", "value", "message"),
    [
        ([0, SECOND], np.nan, "tower-top wrench at 1 s holds NaN or inf"),
        ([0, SECOND], -np.inf, "tower-top wrench at 1 s holds NaN or inf"),
        # A stamp below the one before is sorted in, so no error any more (test_live_graph.py); two values of
        # one time still are.
        ([0, SECOND, SECOND], 1.0, "tower-top wrench at 1 s comes twice, with different values"),
        ([SECOND, 9 * SECOND], 1.0, "known is 1 s to 9 s; its first message must be stamped 0"),
    ],
)
def test_wrenches_that_cannot_be_are_errors(
    domain: int, bag: Path, stamps: list[int], value: float, message: str
) -> None:
    kinds = NODES if "first" in message else [StructureNode]  # the others are found without loads
    with LocalGraph(domain, case_of({"topic": {}}), bag, kinds) as graph:
        rotor = started(graph)
        for i, stamp in enumerate(stamps):
            rotor.send(stamp, np.full(6, i * value if stamp else 0.0))
        assert message in graph.error_of(STRUCTURE)
        graph.spin_until(lambda: any(s.level == b"\x02" for d in graph.diagnostics for s in d.status))


def test_a_file_that_is_refused_makes_configure_fail(domain: int, bag: Path, tmp_path: Path) -> None:
    case = case_of({"series": {"path": str(tmp_path / "none.csv")}})
    with LocalGraph(domain, case, bag, [StructureNode]) as graph:
        assert graph.nodes[STRUCTURE].trigger_configure() != SUCCESS
        assert graph.error_of(STRUCTURE).startswith(
            f"wind.series.path = '{tmp_path / 'none.csv'}': cannot be"
        )


def in_namespace(kind: type[StageNode]) -> type[StageNode]:
    """The same node in the namespace /north."""
    make = {"__init__": lambda self, **options: kind.__init__(self, namespace="north", **options)}
    return type(kind.__name__, (kind,), make)


def test_the_topics_live_in_the_namespace_of_the_graph(domain: int, bag: Path) -> None:
    kinds, given = [in_namespace(kind) for kind in NODES], {POSTPROC: {"bag": str(bag)}}
    with LocalGraph(domain, case_of({"topic": {}}), bag, kinds, given) as graph:
        profile, heard = qos_for(STATUS), list[TowerTopLoad]()
        profile.depth = 200
        graph.watcher.create_subscription(NodeStatus, "/north/owt/status", graph.status.append, profile)
        graph.watcher.create_subscription(
            TowerTopLoad, f"/north{LABEL}", heard.append, qos_for(TOWER_TOP_LOAD, window=10)
        )
        other, rotor = RotorCode(graph), RotorCode(graph, f"/north{INPUT}")
        graph.start()
        graph.spin_until(lambda: rotor.readers == 1)
        other.send(9 * SECOND, np.full(6, np.nan))  # nobody listens in the root namespace
        assert other.readers == 0
        rotor.burst(len(STAMPS))
        graph.spin_until(graph.is_done)
    assert np.abs(wrenches(heard)[0] - WRENCHES[0]).max() == 0.0
    np.testing.assert_array_equal(read_bag(bag).streams[LABEL]["wrench"], wrenches(heard))
