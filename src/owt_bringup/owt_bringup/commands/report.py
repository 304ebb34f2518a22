"""``owt report``: summary and report of a recorded bag."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "count the stress of a recorded bag again; summary.json and report.html"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("bag", type=Path, metavar="BAG", help="bag folder")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="folder to write into (default: the bag)"
    )


def run(options: argparse.Namespace) -> int:
    """Read the bag and write its results."""
    from owt_bringup.output import prepare_folder
    from owt_bringup.results import print_table, write_results
    from owt_postproc.bag_report import bag_report
    from owt_postproc.report import head_figures

    data = bag_report(options.bag)
    folder = prepare_folder(options.output or options.bag)
    write_results(data, folder)
    print_table([*head_figures(data), ("report", str(folder / "report.html"))])
    return 0
