"""Somebody who listens to what a replay publishes, and what it should be."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from local_graph import short_case
from owt_bringup.transport import PROFILE_VARIABLE
from owt_model.config import CaseConfig
from owt_postproc.bag_source import BagSource, RawMessage
from owt_ros.topics import Kind, recorded


def case() -> CaseConfig:
    """6 s in twelve blocks, with a load at the tower top."""
    return short_case(wind={"thrust": {}}, time={"n": 60}, stream={"block": 5})


def messages_of(bag: Path, keep: Callable[[RawMessage], bool] = lambda _: True) -> dict[str, list[bytes]]:
    """Bytes of a bag by topic."""
    found: dict[str, list[bytes]] = {}
    with BagSource(bag) as source:
        for message in source.messages():
            if keep(message):
                padding = bytes(-len(message.data) % 4)  # DDS carries whole words
                found.setdefault(message.topic, []).append(message.data + padding)
    return found


class Listener:
    """Somebody who subscribes to all topics of a bag, and starts the command."""

    def __init__(self, domain: int, prefix: str = "", *, latched: bool = True) -> None:
        self.domain, self.environment = domain, dict[str, str]()
        self.heard: dict[str, list[bytes]] = {}
        self.at: dict[str, list[float]] = {}
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = Node("listener", context=self._context, use_global_arguments=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        for topic in recorded(case()):
            keeps = topic.kind is Kind.LATCHED and latched
            profile = QoSProfile(
                depth=1,
                history=HistoryPolicy.KEEP_ALL,
                reliability=ReliabilityPolicy.RELIABLE,
                durability=DurabilityPolicy.TRANSIENT_LOCAL if keeps else DurabilityPolicy.VOLATILE,
            )
            take = self._take(topic.label)
            self._node.create_subscription(topic.message, prefix + topic.label, take, profile, raw=True)

    def _take(self, label: str) -> Callable[[bytes], None]:
        def take(data: bytes) -> None:
            self.heard.setdefault(label, []).append(bytes(data))
            self.at.setdefault(label, []).append(time.monotonic())

        return take

    @property
    def count(self) -> int:
        return sum(map(len, self.heard.values()))

    def start(self, bag: Path, *arguments: str) -> "subprocess.Popen[str]":
        command = [sys.executable, "-m", "owt_bringup.cli", "replay", str(bag), *arguments]
        command += ["--domain", str(self.domain), "--wait", "60"]
        own = {name: value for name, value in os.environ.items() if name != PROFILE_VARIABLE}
        return subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**own, **self.environment},
        )

    def spin_until(self, ready: Callable[[], bool], seconds: float = 90.0) -> None:
        deadline = time.monotonic() + seconds
        while not ready():
            assert time.monotonic() < deadline, {label: len(found) for label, found in self.heard.items()}
            self._executor.spin_once(timeout_sec=0.02)

    def replay(self, bag: Path, *arguments: str) -> str:
        """Replay to the end, take all that has arrived by then, and return what was printed."""
        process = self.start(bag, *arguments)
        self.spin_until(lambda: process.poll() is not None)
        out, err = process.communicate()
        assert (process.returncode, err) == (0, "")
        self.spin_until(lambda: self.count >= int(out.split()[0]), 5.0)
        return out

    def close(self) -> None:
        self._executor.shutdown(timeout_sec=1.0)
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)
