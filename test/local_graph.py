"""Nodes of a graph in one process, on one executor, in a domain of their own: what tests drive and watch."""

import gc
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from owt_msgs.msg import NodeStatus
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from owt_bringup.nodes import NODES as BRING_UP_NODES
from owt_bringup.process import Child, find_executable, stop_all
from owt_campaign.pipeline import CaseBlocks, CaseRun, prepare_case, stream_case
from owt_model.config import CaseConfig, parse_case
from owt_postproc.node import PostprocNode
from owt_ros import convert
from owt_ros.cdr import canonical
from owt_ros.fields import case_values
from owt_ros.lifecycle import StageNode
from owt_ros.parameters import parameter_yaml
from owt_ros.qos import qos_for
from owt_ros.selection import Selection
from owt_ros.topics import DIAGNOSTICS, RECORDED, STATUS, Topic, recorded
from owt_structure_node.node import StructureNode
from owt_wave_node.node import WaveNode

SUCCESS = TransitionCallbackReturn.SUCCESS
NODES: tuple[type[StageNode], ...] = (PostprocNode, StructureNode, WaveNode)


def short_case(**changes: Any) -> CaseConfig:
    """20 s of a small first-order sea, in four blocks, the last one shorter."""
    data: dict[str, Any] = {
        "sea_state": {"hs_m": 2.0, "tp_s": 8.0, "seed": 3},
        "wave": {"order": 1},
        "time": {"n": 190},
        "structure": {"reduction": "CB04M03"},
        "gauges_m": [[0.0, 0.0], [10.0, -5.0]],
    }
    return parse_case({**data, **changes})


class LocalGraph:
    """Some nodes of a graph and a watcher; a context manager.

    Nodes and watcher share a process, where Fast DDS reports idle publishers as dead: watching peers is off.
    """

    def __init__(
        self,
        domain: int,
        case: CaseConfig,
        bag: Path,
        kinds: Iterable[type[StageNode]] = NODES,
        overrides: dict[str, dict[str, Any]] | None = None,
    ) -> None:
        self.case, self.bag = case, bag
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self._stack = ExitStack()
        self._executor = SingleThreadedExecutor(context=self.context)
        self.watcher = Node("watcher", context=self.context, use_global_arguments=False)
        self._executor.add_node(self.watcher)
        self.status: list[NodeStatus] = []
        self.diagnostics: list[Any] = []
        profile = qos_for(STATUS)
        profile.depth = 200
        self.watcher.create_subscription(NodeStatus, STATUS.name, self.status.append, profile)
        self.watcher.create_subscription(
            DIAGNOSTICS.message, DIAGNOSTICS.name, self.diagnostics.append, qos_for(DIAGNOSTICS)
        )
        self.nodes: dict[str, StageNode] = {}
        for kind in kinds:
            values = {**case_values(case), "lease_s": 0.0, **(overrides or {}).get(kind.ROLE, {})}
            if kind is PostprocNode:
                values = {"bag": str(bag), "record": "all", **values}
            given = [Parameter(name, value=value) for name, value in values.items()]
            node = kind(context=self.context, parameter_overrides=given, use_global_arguments=False)
            self.nodes[kind.ROLE] = node
            self._executor.add_node(node)

    def listen(self, topics: Iterable[Topic] = RECORDED) -> dict[str, list[Any]]:
        """Collect every message of `topics`."""
        found: dict[str, list[Any]] = {topic.label: [] for topic in topics}
        for topic in topics:
            profile = qos_for(topic, window=10_000)
            self.watcher.create_subscription(topic.message, topic.name, found[topic.label].append, profile)
        return found

    def start(self) -> None:
        """Configure and activate all nodes, consumers first."""
        for node in self.nodes.values():
            assert node.trigger_configure() == SUCCESS, self.status
        for node in self.nodes.values():
            assert node.trigger_activate() == SUCCESS, self.status

    def spin_until(self, ready: Callable[[], bool], seconds: float = 60.0) -> None:
        """Spin until `ready()`, at most `seconds`."""
        deadline = time.monotonic() + seconds
        while not ready():
            assert time.monotonic() < deadline, self.status[-5:]
            self._executor.spin_once(timeout_sec=0.05)

    def spin_for(self, seconds: float) -> None:
        """Spin for a while: only to show that nothing happens."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)

    def codes(self, name: str) -> list[int]:
        """Status codes that node `name` has published."""
        return [message.code for message in self.status if message.node == name]

    def is_done(self) -> bool:
        """Tell whether the bag is complete, or something failed."""
        assert NodeStatus.ERROR not in [message.code for message in self.status], self.status[-1]
        return NodeStatus.DONE in self.codes(PostprocNode.ROLE)

    def error_of(self, name: str) -> str:
        """Wait for the error status of node `name` and return its message."""
        self.spin_until(lambda: NodeStatus.ERROR in self.codes(name))
        return next(m.message for m in self.status if m.node == name and m.code == NodeStatus.ERROR)

    def __enter__(self) -> "LocalGraph":
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        for node in self.nodes.values():
            node.close()
            node.destroy_node()
        self._executor.shutdown(timeout_sec=1.0)
        self.watcher.destroy_node()
        rclpy.shutdown(context=self.context)
        del self._executor, self.watcher, self.context  # rclpy leaves the domain when the last reference goes
        self.nodes.clear()
        gc.collect()


def assert_messages_equal(name: str, one: Any, two: Any) -> None:
    """Compare two messages of any make, rclpy or rosbags, field by field, number by number."""
    fields = [field for field in one.get_fields_and_field_types()]
    for field in fields:
        a, b = getattr(one, field), getattr(two, field)
        if hasattr(a, "get_fields_and_field_types"):
            assert_messages_equal(f"{name}.{field}", a, b)
        elif hasattr(a, "__len__") and not isinstance(a, str) and not (len(a) and isinstance(a[0], str)):
            np.testing.assert_array_equal(np.asarray(a), np.asarray(b), err_msg=f"{name}.{field}")
        else:
            assert (list(a) == list(b)) if isinstance(a, list) else (a == b), f"{name}.{field}"


def expected_messages(run: CaseRun, blocks: list[CaseBlocks]) -> dict[str, list[Any]]:
    """What the graph must publish, by topic."""
    return {
        "/owt/model": [convert.model_message(run.mesh)],
        "/owt/sea_state": [convert.sea_state_message(run.wave.sea_state)],
        "/owt/load_basis": [convert.load_basis_message(run.load_basis)],
        "/owt/reduced_model": [convert.reduced_model_message(run.response.description)],
        "/owt/surface_elevation": [convert.elevation_message(b.elevation) for b in blocks],
        "/owt/nodal_loads": [convert.nodal_loads_message(b.load) for b in blocks],
        "/owt/modal_state": [convert.modal_message(b.modal) for b in blocks],
        "/owt/member_stress": [convert.stress_message(b.stress) for b in blocks],
        "/owt/energy": [convert.energy_message(b.energy) for b in blocks],
        "/owt/fatigue": [convert.fatigue_message(b.fatigue) for b in blocks],
    }


def expected_bytes(case: CaseConfig, *, everything: bool = False) -> dict[str, list[bytes]]:
    """What the bag of a case must hold, byte for byte, by topic."""
    run = prepare_case(case)
    selection, topics = Selection(everything=everything, ends=8), {t.label: t for t in recorded(case)}
    selection.learn(run.response.description)

    def kept(label: str, message: Any) -> bytes:
        cdr = bytes(serialize_message(message))
        return canonical(type(message), selection.of(topics[label], cdr, message))

    expected = expected_messages(run, list(stream_case(run)))
    return {label: [kept(label, message) for message in found] for label, found in expected.items()}


def start_node(name: str, folder: Path, environment: dict[str, str], *arguments: str) -> Child:
    """Start a node whose parameter file lies in `folder`."""
    package = next(node.package for node in BRING_UP_NODES if node.name == name)
    ros = ["--ros-args", "--params-file", str(folder / "parameters.yaml"), *arguments]
    command = [str(find_executable(package, name)), *ros]
    return Child(name, command, folder / f"{name}.log", environment)


@contextmanager
def node_processes(
    case: CaseConfig, folder: Path, environment: dict[str, str], *arguments: str
) -> Iterator[dict[str, Child]]:
    """The nodes as anybody may start them, without the bring-up; they record into the folder ``bag``."""
    parameters = parameter_yaml(case, {PostprocNode.ROLE: {"bag": str(folder / "bag")}})
    (folder / "parameters.yaml").write_text(parameters)
    children: dict[str, Child] = {}
    try:
        for node in BRING_UP_NODES:
            children[node.name] = start_node(node.name, folder, environment, *arguments)
        yield children
    finally:
        stop_all(children.values())


def read_by_rosbags(bag: Path) -> dict[str, list[Any]]:
    """All messages of a bag by topic, read with the definitions in the bag."""
    found: dict[str, list[Any]] = {}
    with Reader(bag) as reader:
        store = get_typestore(Stores.EMPTY)
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            found[connection.topic] = []
        for connection, _, raw in reader.messages():
            found[connection.topic].append(store.deserialize_cdr(raw, connection.msgtype))
    return found
