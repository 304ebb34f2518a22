"""``owt study``: a table or figure of the thesis, beside the print."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from owt_campaign.studies.registry import STUDIES
from owt_model.errors import InputError

if TYPE_CHECKING:
    from owt_campaign.studies.result import StudyResult

HELP = "tables and figures of the thesis, beside the print"

#: First line of the index of a folder of studies: only a file that begins with it is written over.
INDEX_TITLE = "# Studies: the thesis' tables and figures, beside the print"

#: What all pages have in common, and where they do not.
_INDEX_HEAD = """\
Written by `./owt study NAME --full -o docs/study`. Each page holds tables and figures beside the printed
values and ends with a verdict, the structure and the revision of the code; its JSON file holds print, result,
spread over the seeds, verdict and revision.

Numbers that hang on random phases are means over at least three seeds, with their range. Of one seed (1)
are: the load vectors of table B.1 and of figures B.4 and 6.1, figure 5.3, the curves over time in figures 5.4
and 5.7, the points of figures 6.2 and 6.3 (tables and rows beside them have three), the wind series of
figures 6.6 and 6.7, `cells` in wave-comparison.json and `cell_damage` in beyond.json. Regular waves and
NewWave groups (usfos, load-vectors) have no random phases.

What the thesis does not publish was chosen so that its tables B.1 to B.3 come out: tower and rotor-nacelle,
the masses of growth and water at the jacket's joints, alpha and beta of the Rayleigh damping, a second pair
of them for the frequency model, and the dashpot of the damping model (all on the page eigen). No other
number is tuned to a printed one."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("name", nargs="?", choices=STUDIES, metavar="NAME", help=", ".join(STUDIES))
    parser.add_argument("--list", action="store_true", help="print the names; with -o write the index of DIR")
    parser.add_argument(
        "--full", action="store_true", help="as in docs/study: all cases and seeds, minutes; else seconds"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="also write NAME.md, its figures and NAME.json into this folder",
    )


def run(options: argparse.Namespace) -> int:
    """Run the study and print it as a page, or as JSON."""
    from owt_bringup.output import ProgressBar, prepare_folder
    from owt_campaign.studies.registry import run_study
    from owt_model.versions import versions

    if options.list:
        width = max(map(len, STUDIES))
        print("\n".join(f"{study.name:{width}}  {study.help}" for study in STUDIES.values()))
        if options.output is not None:
            write_index(prepare_folder(options.output))
        return 0
    if options.name is None:
        raise InputError("study", None, "is not named", f"Choose one of {', '.join(STUDIES)}, or --list.")
    folder = None if options.output is None else prepare_folder(options.output)
    bar = ProgressBar(options.name, unit="runs")
    try:
        result = run_study(options.name, full=options.full, progress=bar.callback)
    finally:
        bar.close()
    made_by = versions()
    revision = made_by.get("revision", made_by["owt"])
    found, signed = result.as_json(revision), result.signed_page(revision)
    if folder is not None:
        write_study(folder, result, found, signed)
    print(json.dumps(found, allow_nan=False) if options.json else signed.rstrip())
    return 0


def write_study(folder: Path, result: StudyResult, found: dict[str, object], page: str) -> None:
    """Write page, figures and JSON of a study, and the index of the folder.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    from owt_bringup.output import atomic_path, write_json

    for key, draw in result.figures.items():
        from owt_campaign.studies.plotting import save

        with atomic_path(folder / result.picture(key)) as partial:
            save(draw(), partial)
    with atomic_path(folder / f"{result.name}.md") as partial:
        partial.write_text(page, encoding="utf-8")
    write_json(folder / f"{result.name}.json", found)
    write_index(folder)


def write_index(folder: Path) -> None:
    """Write the index of a folder of studies, unless a file of that name is somebody else's.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    from owt_bringup.output import atomic_path

    index = folder / "README.md"
    if not index.exists() or index.read_text(encoding="utf-8").startswith(INDEX_TITLE):
        with atomic_path(index) as partial:
            partial.write_text(index_page(folder), encoding="utf-8")


def index_page(folder: Path) -> str:
    """The index of a folder of studies, from their JSON files: one line and verdict each."""
    from owt_campaign.studies.result import table

    rows = []
    for name, study in STUDIES.items():
        path = folder / f"{name}.json"
        if not path.exists():
            continue
        found = json.loads(path.read_text(encoding="utf-8"))
        verdict = found["verdict"]
        outcome = {"partly": "partly reproduced", "not": "not reproduced"}.get(
            verdict["outcome"], verdict["outcome"]
        )
        reduced = "" if found["full"] else " (reduced version)"
        rows.append([f"[{name}]({name}.md)", study.help, f"**{outcome}**{reduced}: {verdict['why']}"])
    return f"{INDEX_TITLE}\n\n{_INDEX_HEAD}\n\n{table(['study', 'what', 'verdict'], rows)}\n"
