"""``owt view``: the live picture of a graph that runs, for Foxglove, Lichtblick and RViz2."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

HELP = "show a graph that runs: markers on /owt/markers and a WebSocket for Foxglove and Lichtblick"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from owt_bringup.viewer import DEFAULT_PORT

    add = parser.add_argument
    add("--domain", type=int, default=None, help="ROS domain of the graph (default ROS_DOMAIN_ID, else 0)")
    add("--namespace", default="", help="namespace of the graph's nodes")
    add(
        "--case",
        type=Path,
        default=None,
        metavar="CASE.json",
        help="case of the run, for a structure of one's own",
    )
    add(
        "--host",
        default="127.0.0.1",
        help="address to serve on; 0.0.0.0 for other machines too (default %(default)s)",
    )
    add("--port", type=int, default=DEFAULT_PORT, help="TCP port; 0 for markers only (default %(default)s)")
    add(
        "--colour",
        choices=("stress", "damage"),
        default="stress",
        help="what colours the members (default %(default)s)",
    )
    add(
        "--exaggeration",
        type=float,
        default=200.0,
        help="what displacements are multiplied by (default %(default)s)",
    )
    add("--fps", type=float, default=8.0, help="pictures per second of wall time (default %(default)s)")


def run(options: argparse.Namespace) -> int:
    """Become the viewer node until Ctrl-C."""
    from owt_bringup.domain import own_domain
    from owt_bringup.viewer import VIEWER_OPTIONS, describe_connection, viewer_arguments
    from owt_model.config import CaseConfig, load_case
    from owt_viewer.node import main

    case = CaseConfig() if options.case is None else load_case(options.case)
    values = {name: getattr(options, name) for name in VIEWER_OPTIONS}
    if options.domain is not None:
        with own_domain(options.domain) as domain:
            os.environ["ROS_DOMAIN_ID"] = str(domain)
    with tempfile.TemporaryDirectory(prefix="owt-view-") as folder:
        arguments = viewer_arguments(case, values, Path(folder), namespace=options.namespace)
        print(describe_connection(options.host, options.port), file=sys.stderr)
        return main(["owt", *arguments])
