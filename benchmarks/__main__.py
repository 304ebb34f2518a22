"""``./owt bench [PART...]``: times of the stages and of whole commands, beside named alternatives.

Equality with the alternative is checked before anything is timed. Times are the smallest of several runs.
``-o FILE`` writes the figures as JSON, from which ``python -m benchmarks.page FILE`` makes the table of
docs/performance.md.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from pathlib import Path

from benchmarks.campaign import bench_campaign
from benchmarks.chain import bench_rainflow, bench_structure
from benchmarks.engine import bench_engine
from benchmarks.fatigue import bench_fatigue
from benchmarks.graph import bench_graph
from benchmarks.measure import Table, matmul_seconds
from benchmarks.processes import bench_commands, bench_demo
from benchmarks.waves import bench_long, bench_waves

PARTS = {
    "waves": bench_waves,
    "long": bench_long,
    "structure": bench_structure,
    "rainflow": bench_rainflow,
    "engine": bench_engine,
    "fatigue": bench_fatigue,
    "commands": bench_commands,
    "graph": bench_graph,
    "campaign": bench_campaign,
    "demo": bench_demo,
}

#: Parts that run only if they are named.
ON_REQUEST = ("graph", "campaign", "demo")


def main() -> int:
    """Run the parts asked for; all but those on request if none is."""
    parser = argparse.ArgumentParser(prog="owt bench", description=__doc__)
    parser.add_argument(
        "part",
        nargs="*",
        metavar="PART",
        help=f"of {', '.join(PARTS)}; all but {', '.join(ON_REQUEST)} if none",
    )
    parser.add_argument("--demo", action="store_true", help="also time the graph")
    parser.add_argument("-o", "--output", type=Path, help="JSON file to write")
    options = parser.parse_args()
    unknown = [part for part in options.part if part not in PARTS]
    if unknown:
        parser.error(f"no part {unknown[0]!r}; parts are {', '.join(PARTS)}")
    chosen = options.part or [part for part in PARTS if part not in ON_REQUEST]
    if options.demo and "demo" not in chosen:
        chosen.append("demo")
    table = Table(matmul_seconds())
    machine = f"{len(os.sched_getaffinity(0))} processors, {platform.machine()}"
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "all")
    print(f"{machine}, BLAS threads: {threads}; matrix product 1500 x 1500: {table.matmul:.3f} s")
    for part in chosen:
        PARTS[part](table)
    if options.output:
        result = {"machine": machine, "matmul_1500_s": table.matmul, "rows": table.rows}
        options.output.write_text(json.dumps(result, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
