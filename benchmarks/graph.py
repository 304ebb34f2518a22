"""The graph beside the run in one process: full speed, latency in real time, the cost of recording."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from benchmarks.measure import ROOT, Table, process
from owt_bringup.domain import own_domain
from owt_bringup.graph import run_graph
from owt_bringup.process import Child
from owt_model.config import CaseConfig, parse_case
from owt_ros import topics
from owt_ros.qos import qos_for

__all__ = ["bench_graph"]

#: Simulated s of a run in real time.
SECONDS = 20.0


class Probe:
    """Hears loads and stress of a running graph, and notes when each block was sent and came."""

    def __init__(self, domain: int) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = Node("probe", context=self._context, use_global_arguments=False)
        self.sent: dict[int, int] = {}
        self.came: dict[int, int] = {}
        for topic, handle in ((topics.NODAL_LOADS, self._on_load), (topics.MEMBER_STRESS, self._on_stress)):
            profile = qos_for(topic, window=1000)
            self._node.create_subscription(topic.message, topic.name, handle, profile)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def _spin(self) -> None:
        while not self._stop.is_set():
            self._executor.spin_once(timeout_sec=0.1)

    def _on_load(self, message: Any, info: Any) -> None:
        self.sent[message.sequence] = info["source_timestamp"]

    def _on_stress(self, message: Any, info: Any) -> None:
        self.came[message.sequence] = info["received_timestamp"]

    def latency_ms(self) -> np.ndarray:
        """From the publication of a load to the arrival of its stress, in ms, the first second left out."""
        both = sorted(set(self.sent) & set(self.came))
        return np.array([(self.came[i] - self.sent[i]) * 1e-6 for i in both[len(both) // 20 :]])

    def close(self) -> None:
        """Leave the graph."""
        self._stop.set()
        self._thread.join()
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def _cpu_seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _run(case: CaseConfig, folder: Path, *, probe: bool = False) -> dict[str, Any]:
    """Run a case; return times, CPU share of each node while it ran, and latencies."""
    children: dict[str, Child] = {}
    first: dict[str, tuple[float, float]] = {}
    last: dict[str, tuple[float, float]] = {}

    def look(*_: float) -> None:
        for name, child in children.items():
            if child.exit_code is None:
                last[name] = time.monotonic(), _cpu_seconds(child.pid)
                first.setdefault(name, last[name])

    with own_domain() as domain:
        heard = Probe(domain) if probe else None
        result = run_graph(case, folder, on_start=children.update, progress=look, domain_id=domain)
        if heard is not None:
            heard.close()
    share = {
        name: (last[name][1] - first[name][1]) / max(last[name][0] - first[name][0], 1e-9) for name in first
    }
    size = sum(path.stat().st_size for path in folder.glob("*.mcap"))
    found = {"seconds": result.seconds, "share": share, "bytes": size}
    return found if heard is None else {**found, "latency_ms": heard.latency_ms()}


def bench_graph(table: Table) -> None:
    """Full speed, two real-time rates, ten times real time."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "case.json").write_text("{}")
        alone = process([str(ROOT / "owt"), "simulate", str(folder / "case.json"), "-o", str(folder / "s")])
        run = min(
            (_run(parse_case({}), folder / f"full{i}") for i in range(2)), key=lambda r: r["seconds"]["run"]
        )
        table.note("graph", "./owt simulate, 600 s, second order", alone.wall, "s")
        table.note("graph", "graph from activation to the last block", run["seconds"]["run"], "s")
        table.note("graph", "graph over simulate", run["seconds"]["run"] / alone.wall, "x")
        table.note("graph", "its bag", run["bytes"] / 1e6, "MB")
        for dt in (0.1, 0.01):
            case = parse_case(
                {
                    "time": {"dt_s": dt, "n": round(SECONDS / dt)},
                    "structure": {"dt_s": min(dt, 0.02)},
                    "stream": {"block": 1, "rate": 1.0},
                }
            )
            found = _run(case, folder / f"live{dt}", probe=True)["latency_ms"]
            what = f"blocks of one sample at {1 / dt:g} Hz, load to stress"
            for share in (50, 99):
                table.note("graph", f"{what}, p{share}", float(np.percentile(found, share)), "ms")
            table.note("graph", f"{what}, samples", float(found.size), "")
        ten = _run(parse_case({"stream": {"rate": 10.0}, "time": {"n": 3000}}), folder / "ten")
        for node, share in ten["share"].items():
            table.note("graph", f"{node} at ten times real time, share of a core", 100 * share, "%")
