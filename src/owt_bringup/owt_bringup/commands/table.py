"""``owt table``: a load-case table of a scatter diagram."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from owt_model.errors import InputError

HELP = "a load-case table of a scatter diagram"
METHODS = ("weighted-tp", "weighted-hs", "full")
#: Width in m of the heights of thesis table 4.5.
THESIS_BIN = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "scatter", type=Path, metavar="SCATTER.csv", help="scatter diagram (docs/campaigns.md)"
    )
    parser.add_argument(
        "--method", choices=METHODS, default="weighted-tp",
        help="one sea state per height with its mean period, per period with its mean height, or per cell "
        "(default weighted-tp, as thesis table 4.5)",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, metavar="OUT.csv", help="file to write (default: print it)"
    )
    parser.add_argument(
        "--direction", type=float, metavar="DEG",
        help="where the waves come from, from north (default: as a comment of the file says)",
    )  # fmt: skip
    parser.add_argument(
        "--hs-bin", type=float, metavar="M",
        help=f"with weighted-tp: width of the heights, 0 for those of the diagram (default {THESIS_BIN:g})",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Make the table and write it."""
    from owt_bringup.output import atomic_path
    from owt_campaign.scatter import build_table, read_scatter, table_text

    if options.output is not None and options.output.resolve() == options.scatter.resolve():
        raise InputError(
            "output", str(options.output), "is the scatter diagram itself", "Choose another name."
        )
    width = options.hs_bin
    if width is None and options.method == "weighted-tp":
        width = THESIS_BIN
    scatter = read_scatter(options.scatter, direction_deg=options.direction)
    table = build_table(scatter, options.method, height_bin_m=width or None)
    text = table_text(table)
    if options.output is None:
        print(text, end="")
        return 0
    with atomic_path(options.output) as partial:
        partial.write_text(text, encoding="utf-8")
    print(f"{options.output}: {len(table.rows)} sea states", file=sys.stderr)
    return 0
