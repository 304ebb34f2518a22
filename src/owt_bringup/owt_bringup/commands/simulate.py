"""``owt simulate``: the whole chain in one process."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from owt_model.errors import InputError

if TYPE_CHECKING:
    from owt_bringup.bag_case import RecordedRun
    from owt_model.config import CaseConfig

HELP = "the whole chain in one process: report, tables, summary.json and series.npz"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("case", type=Path, metavar="CASE.json", nargs="?", help="case file")
    parser.add_argument(
        "--from-bag", type=Path, metavar="BAG",
        help="instead of a case file: the case in a bag, with the load at the tower top that it recorded",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="folder to write into"
    )
    parser.add_argument(
        "--full", action="store_true", help="also full.npz: every channel of every stream (0.6 GB for 600 s)"
    )


def _case(options: argparse.Namespace) -> tuple[CaseConfig, RecordedRun | None]:
    """Case of a file; or of a bag, with what it recorded."""
    if (options.case is None) == (options.from_bag is None):
        raise InputError(
            "CASE.json",
            None if options.case is None else str(options.case),
            "must be given, or a bag by --from-bag, and not both",
            "Give one of them.",
        )
    if options.from_bag is None:
        from owt_bringup.sea_notes import load_resolved_case

        return load_resolved_case(options.case), None
    from owt_bringup.bag_case import recorded_run
    from owt_postproc.bag_source import BagSource

    with BagSource(options.from_bag) as bag:
        recorded = recorded_run(bag)
    return recorded.case, recorded


def run(options: argparse.Namespace) -> int:
    """Run the case and write its results."""
    import time

    from owt_bringup.output import ProgressBar, prepare_folder, write_npz
    from owt_bringup.results import print_table, write_results
    from owt_bringup.sea_notes import print_notes, print_warnings
    from owt_campaign.pipeline import run_case
    from owt_model.versions import versions
    from owt_postproc.report import head_figures

    start = time.perf_counter()
    case, recorded = _case(options)
    folder = prepare_folder(options.output)
    bar = ProgressBar("simulate")
    result = run_case(
        case,
        keep_series=options.full,
        versions=versions(),
        progress=bar.callback,
        tower_top=None if recorded is None else recorded.tower_top,
        measured=None if recorded is None else recorded.measured,
        structure=None if recorded is None else recorded.structure,
    )
    bar.close()
    data = result.report
    series = {
        "wave_time": data.wave_time,
        "elevation_first": data.elevation_first,
        "elevation_total": data.elevation_total,
        "wave_force": data.wave_force,
        "time": data.time,
        "potential": data.potential,
        "kinetic": data.kinetic,
        "potential_substructure": data.potential_substructure,
        "kinetic_substructure": data.kinetic_substructure,
        "stress_normal": data.stress_normal,
        "stress_von_mises": data.stress_von_mises,
        "damage": data.fatigue.damage,
    }
    if data.tower_top is not None:
        series["tower_top"] = data.tower_top
    if data.tower_top_load is not None:
        series["tower_top_load"] = data.tower_top_load
    write_npz(folder / "series.npz", series)
    if options.full:
        write_npz(folder / "full.npz", result.series)
    write_results(data, folder)
    elapsed = time.perf_counter() - start
    speed = f"{elapsed:.1f} s, {case.time.duration_s / elapsed:.0f} times real time"
    print_table([*head_figures(data), ("elapsed", speed), ("results", str(folder))])
    for note in (
        *(() if recorded is None else recorded.notes),
        *data.reduced.notes,
        *data.fatigue.hot_spots.warnings,
    ):
        print(f"note: {note}", file=sys.stderr)
    if recorded is None:
        print_notes(case, "simulate", result.mesh)
    else:  # the case of a bag names every option, set or not
        print_warnings(case, result.mesh.structure)
    return 0
