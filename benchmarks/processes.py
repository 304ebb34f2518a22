"""Whole commands as a user runs them."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from benchmarks.measure import ROOT, Process, Table, process

OWT = str(ROOT / "owt")


def _best(command: list[str], repeats: int, environment: dict[str, str] | None = None) -> Process:
    """Smallest times and largest memory of several runs."""
    runs = [process(command, environment) for _ in range(repeats)]
    return Process(min(r.wall for r in runs), min(r.cpu for r in runs), max(r.memory for r in runs))


def bench_commands(table: Table) -> None:
    """Loads and the whole chain; the first run on a machine without compiled kernels."""
    with tempfile.TemporaryDirectory() as folder:
        case = {}
        for order in (1, 2):
            case[order] = Path(folder) / f"{order}.json"
            case[order].write_text(json.dumps({"wave": {"order": order}}))
        process([OWT, "loads", "--help"])  # sets up what is missing, uncounted
        table.add("commands", "./owt loads --help", _best([OWT, "loads", "--help"], 3))
        loads = {n: [OWT, "loads", str(path), "-o", f"{folder}/loads.npz"] for n, path in case.items()}
        for order, command in loads.items():
            name = "first" if order == 1 else "second"
            table.add("commands", f"./owt loads, 600 s, {name} order", _best(command, 5))
        cache = {"NUMBA_CACHE_DIR": f"{folder}/kernels"}
        table.add("commands", "./owt loads, second order, nothing compiled yet", process(loads[2], cache))
        table.add("commands", "./owt loads, second order, the run after it", process(loads[2], cache))
        simulate = [OWT, "simulate", str(case[2]), "-o", folder]
        table.add("commands", "./owt simulate, 600 s, second order, CB10M10", _best(simulate, 2))


def bench_demo(table: Table) -> None:
    """The graph, real processes."""
    with tempfile.TemporaryDirectory() as folder:
        table.add(
            "demo", "./owt demo, 600 s, second order", process([OWT, "demo", "--bag", f"{folder}/demo"])
        )
