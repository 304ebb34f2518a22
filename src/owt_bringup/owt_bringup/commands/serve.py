"""``owt serve``: the action RunSeaState and the case check, until Ctrl-C."""

from __future__ import annotations

import argparse

HELP = "serve the action owt/run_sea_state and the service owt/check_case to operators, until Ctrl-C"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "--namespace",
        default="",
        metavar="NAME",
        help="namespace of the server and of the graphs that it runs",
    )


def run(options: argparse.Namespace) -> int:
    """Serve in the ROS domain ROS_DOMAIN_ID (0)."""
    from owt_bringup.domain import full_namespace
    from owt_bringup.server import serve

    namespace = full_namespace(options.namespace)
    remap = [] if namespace == "/" else ["--ros-args", "--remap", f"__ns:={namespace}"]
    return serve(["owt", *remap])
