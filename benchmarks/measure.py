"""Timing, and the lines of the table."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
REPEATS = 7

Row = dict[str, Any]


@dataclass(frozen=True)
class Timing:
    """Wall and processor time in s, the smallest of several runs: what the machine needs when left alone."""

    wall: float
    cpu: float


def timing(work: Callable[[], Any], repeats: int = REPEATS) -> Timing:
    """Time `work` after one run that is not counted (none if it is run only once)."""
    if repeats > 1:
        work()
    wall, cpu = [], []
    for _ in range(repeats):
        start, used = time.perf_counter(), time.process_time()
        work()
        wall.append(time.perf_counter() - start)
        cpu.append(time.process_time() - used)
    return Timing(min(wall), min(cpu))


@dataclass(frozen=True)
class Process:
    """Times in s and peak memory in MiB of a whole process, its children included."""

    wall: float
    cpu: float
    memory: float


#: Starts a command from a small process: the system counts the memory of the one that starts it as its own.
STARTER = """
import json, resource, subprocess, sys, time
start = time.perf_counter()
status = subprocess.call(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
wall, used = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([wall, used.ru_utime + used.ru_stime, used.ru_maxrss, status]))
"""


def process(command: list[str], environment: Mapping[str, str] | None = None) -> Process:
    """Run a command of the workspace once, as a user does.

    Raises
    ------
    RuntimeError
        If it fails.
    """
    child = subprocess.run(
        [sys.executable, "-S", "-c", STARTER, *command], cwd=ROOT, env=os.environ | (environment or {}),
        stdout=subprocess.PIPE, check=True,
    )  # fmt: skip
    wall, cpu, memory, status = json.loads(child.stdout)
    if status != 0:
        raise RuntimeError(f"{' '.join(command)} exited {status}")
    return Process(wall, cpu, memory / 1024)


def matmul_seconds() -> float:
    """Wall time in s of a 1500 x 1500 matrix product."""
    a, b = np.random.default_rng(0).standard_normal((2, 1500, 1500))
    return timing(lambda: a @ b).wall


class Table:
    """Collects the figures and prints each as it comes."""

    def __init__(self, matmul: float) -> None:
        self.matmul = matmul
        self.rows: list[Row] = []

    def add(
        self,
        part: str,
        what: str,
        time: Timing | Process,
        beside: Mapping[str, float] | None = None,
        quoted: Mapping[str, float] | None = None,
    ) -> None:
        """Add a figure; `beside` holds times in s of other ways to do the same, measured in this run.

        `quoted` holds times in s that others give, not measured in this run; they are marked as such and set
        against processor time.
        """
        row: Row = {"part": part, "what": what, "wall_s": time.wall, "cpu_s": time.cpu}
        text = f"{what:<62} {time.wall:9.4f} s  {time.cpu:9.4f} s CPU"
        if isinstance(time, Process):
            row["memory_mib"] = time.memory
            text += f"  {time.memory:.0f} MiB"
        if beside:
            row["beside_s"] = dict(beside)
            text += "".join(f"; {name}: {s:.4g} s ({s / time.wall:.3g} x)" for name, s in beside.items())
        if quoted:
            row["quoted_s"] = dict(quoted)
            text += "".join(
                f"; quoted, not measured here: {name}: {s:.4g} s ({s / time.cpu:.3g} x our CPU)"
                for name, s in quoted.items()
            )
        self.rows.append(row)
        print(text, flush=True)

    def note(self, part: str, what: str, value: float, unit: str) -> None:
        """Add a figure that is no time."""
        self.rows.append({"part": part, "what": what, "value": value, "unit": unit})
        print(f"{what:<62} {value:9.3g} {unit}", flush=True)
