"""``owt study``: a table or figure of the thesis, beside the print."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

HELP = "tables and figures of the thesis, beside the print"

#: Studies that there are.
STUDIES = ("eigen",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "name", choices=STUDIES, metavar="NAME", help="eigen: frequencies and damping, tables B.1, B.2, B.3"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="also write the page NAME.md into this folder"
    )


def run(options: argparse.Namespace) -> int:
    """Run the study and print it as a page, or as JSON."""
    from owt_bringup.output import atomic_path, prepare_folder
    from owt_campaign.studies.eigen import eigen_study, thesis_tables
    from owt_campaign.studies.eigen_page import eigen_page

    folder = None if options.output is None else prepare_folder(options.output)
    study = eigen_study()
    page = eigen_page(study, thesis_tables())
    if folder is not None:
        with atomic_path(folder / f"{options.name}.md") as partial:
            partial.write_text(page, encoding="utf-8")
    print(json.dumps(study.as_json(), allow_nan=False) if options.json else page.rstrip())
    return 0
