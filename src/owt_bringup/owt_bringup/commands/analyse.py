"""``owt analyse``: summary and report of recorded bags."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "count the stress of a bag again, complete or not, or of a folder of bags; report, tables, summary"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="bag folder, finished or being written; or a folder of bags"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR",
        help="folder to write into (default: the bag; NAME.partial beside one that is not finished)",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Read the bag or the bags and write their results."""
    from owt_bringup.analysis import run_analysis

    return run_analysis(options.bag, options.output)
