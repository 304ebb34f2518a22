"""``owt recover``: what can be saved of an unfinished bag."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

HELP = "restore every complete chunk of an unfinished bag into a new one; an intact bag is copied"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("bag", type=Path, metavar="BAG", help="bag folder, finished or partial")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="NEW", help="bag folder to write")


def run(options: argparse.Namespace) -> int:
    """Recover the bag, warn of what was lost, and print what was restored."""
    from owt_postproc.bag_recovery import recover_report

    report = recover_report(options.bag, options.output)
    for loss in report.damaged:
        print(f"warning: {' '.join(loss.split())}", file=sys.stderr)
    print(f"{report.messages} messages restored to {options.output}")
    return 0
