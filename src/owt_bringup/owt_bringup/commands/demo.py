"""``owt demo``: the whole graph, real processes, one sea state, a bag and its report."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import AbstractContextManager, nullcontext
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
    from owt_bringup.viewer import DEFAULT_PORT

    add_case_flags(parser)
    parser.add_argument(
        "--bag", type=Path, default=DEFAULT_BAG, metavar="DIR",
        help=f"bag folder to write; only the default {DEFAULT_BAG} is replaced",
    )  # fmt: skip
    parser.add_argument(
        "--record", choices=("default", "all"), default="default",
        help="what the bag keeps: what the rest is computed from (0.2 MB/s), or everything (0.8 MB/s)",
    )  # fmt: skip
    parser.add_argument(
        "--namespace", default="", metavar="NAME",
        help="namespace of all nodes and topics, in ROS domain ROS_DOMAIN_ID (0); without it the graph has a "
        "domain of its own",
    )  # fmt: skip
    parser.add_argument(
        "--view", type=int, nargs="?", const=DEFAULT_PORT, default=None, metavar="PORT",
        help=f"serve the live picture for Foxglove and Lichtblick ({DEFAULT_PORT}); best with --rate 1",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Run the graph, then read the bag back for the report."""
    import time

    from owt_bringup.analysis import analyse
    from owt_bringup.case_flags import case_from_flags
    from owt_bringup.domain import own_domain
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
        namespace = options.namespace
        with (
            own_domain(_domain_for_others(case, namespace)) as domain,
            _viewer(case, options.view, domain, namespace),
        ):
            result = run_graph(
                case,
                options.bag,
                overwrite=options.bag == DEFAULT_BAG,
                record=options.record,
                progress=bar.callback,
                domain_id=domain,
                namespace=namespace,
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
    for note in (*data.reduced.notes, *data.fatigue.hot_spots.warnings):
        print(f"note: {note}", file=sys.stderr)
    print_warnings(case, structure)
    return 0


def _viewer(case: CaseConfig, port: int | None, domain: int, namespace: str) -> AbstractContextManager[None]:
    """A viewer beside the graph, where one was asked for."""
    from owt_bringup.viewer import viewer_beside

    return nullcontext() if port is None else viewer_beside(case, port, domain, namespace)


def _domain_for_others(case: CaseConfig, namespace: str) -> int | None:
    """ROS domain of a graph that others take part in or see; None for one of its own."""
    awaited = [] if case.live is None else ["owt/measured_elevation"]
    if case.wind is not None and case.wind.topic is not None:
        awaited.append("owt/tower_top_wrench")
    if not (awaited or namespace):
        return None
    from owt_bringup.domain import full_namespace

    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    if not domain.isdigit():
        raise InputError("ROS_DOMAIN_ID", domain, "must be a whole number", "Leave it out for domain 0.")
    prefix = full_namespace(namespace).rstrip("/")
    listened = " and ".join(f"{prefix}/{topic}" for topic in awaited)
    what = f"waiting for {listened}" if awaited else f"topics are {prefix}/owt/..."
    print(f"note: {what} in ROS domain {domain}", file=sys.stderr)
    return int(domain)
