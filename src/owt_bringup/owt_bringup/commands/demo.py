"""``owt demo``: the whole graph, real processes, one sea state, a bag and its report."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from owt_model.errors import InputError

if TYPE_CHECKING:
    from owt_model.config import CaseConfig

HELP = "run the graph for one sea state; the bag folder holds the recording, summary.json and report.html"
DEFAULT_BAG = Path("bags/demo")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from owt_bringup.case_flags import add_case_flags

    add_case_flags(parser)
    parser.add_argument(
        "--bag", type=Path, default=DEFAULT_BAG, metavar="DIR",
        help=f"bag folder to write; only the default {DEFAULT_BAG} is replaced",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Run the graph, then read the bag back for the report."""
    import time

    from owt_bringup.analysis import analyse
    from owt_bringup.case_flags import case_from_flags
    from owt_bringup.graph import run_graph
    from owt_bringup.output import ProgressBar
    from owt_bringup.results import print_table
    from owt_bringup.sea_notes import print_warnings
    from owt_model.structure import case_structure
    from owt_postproc.report import head_figures

    start = time.perf_counter()
    case = case_from_flags(options)
    structure = case_structure(case.structure)
    structure.check_water_depth(case.water_depth_m)
    bar = ProgressBar("graph")
    try:
        result = run_graph(
            case,
            options.bag,
            overwrite=options.bag == DEFAULT_BAG,
            progress=bar.callback,
            domain_id=_domain_for_others(case),
        )
    finally:
        bar.close()
    graph_seconds = time.perf_counter() - start
    data, _, _ = analyse(result.bag)
    size = sum(path.stat().st_size for path in result.bag.iterdir() if path.suffix == ".mcap")
    elapsed = time.perf_counter() - start
    print_table(
        [
            *head_figures(data),
            ("elapsed", f"{elapsed:.1f} s, of which the graph {graph_seconds:.1f} s"),
            ("bag", f"{options.bag} ({size / 1e6:.0f} MB)"),
            ("report", str(options.bag / "report.html")),
        ]
    )
    for note in data.reduced.notes:
        print(f"note: {note}", file=sys.stderr)
    print_warnings(case, structure)
    return 0


def _domain_for_others(case: CaseConfig) -> int | None:
    """ROS domain where somebody publishes a load at the tower top; None for one of the graph's own."""
    if case.wind is None or case.wind.topic is None:
        return None
    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    if not domain.isdigit():
        raise InputError("ROS_DOMAIN_ID", domain, "must be a whole number", "Leave it out for domain 0.")
    print(f"note: waiting for /owt/tower_top_wrench in ROS domain {domain}", file=sys.stderr)
    return int(domain)
