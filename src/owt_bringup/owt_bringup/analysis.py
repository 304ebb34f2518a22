"""What `analyse` and `report` do: summary and report of one bag, complete or not, or of a folder of bags."""

from __future__ import annotations

import sys
from pathlib import Path

from owt_bringup.output import prepare_folder
from owt_bringup.recompute import Recomputation, block_source
from owt_bringup.results import print_table, write_records, write_results
from owt_model.errors import InputError, OwtError
from owt_postproc.bag_report import bag_report
from owt_postproc.bag_source import BagSource
from owt_postproc.fatigue_check import FatigueCheck
from owt_postproc.report import head_figures
from owt_postproc.report_data import ReportData
from owt_postproc.report_records import Records

__all__ = ["analyse", "analyse_all", "bags_in", "run_analysis"]


def analyse(bag: Path, output: Path | None = None) -> tuple[ReportData, Path, list[str]]:
    """Write ``summary.json``, ``report.html`` and the tables of one bag.

    Parameters
    ----------
    bag : Path
        Bag folder or MCAP file, complete or not; a NAME that only exists as ``.NAME.partial`` is found.
    output : Path, optional
        Folder to write into; by default the bag, or NAME.partial beside one that is not complete.

    Returns
    -------
    data : ReportData
    folder : Path
        Where the files lie.
    notes : list of str
        What a user of the results must know, one line each.

    Raises
    ------
    OwtError
        If the bag cannot be read, has a gap, or holds other numbers than its own loads and stress give.
    """
    with BagSource(bag) as source:
        blocks = block_source(source)
        again = blocks if isinstance(blocks, Recomputation) else None
        check = FatigueCheck(None if again is None else again.deviation)
        data = bag_report(source, blocks=blocks, check=check)
        folder = prepare_folder(output or _place(source))
        write_results(data, folder)
        notes = [] if source.finished and data.complete else [_how_far(bag, data)]
        notes += [f"left out: {' '.join(line.split())}" for line in source.damaged]
    if again is not None:
        turned = ", but for the modes' own coordinates, which another machine turns" if again.turned else ""
        found = f"response computed again from the recorded loads: equals what was recorded {again.deviation}"
        notes += [*again.notes, found + turned]
    if check.blocks:
        notes.append(f"cycles counted again: equal the recorded fatigue {check.deviation}")
    notes += data.fatigue.hot_spots.warnings
    return data, folder, notes


def _how_far(bag: Path, data: ReportData) -> str:
    duration = data.case["time"]["n"] * data.case["time"]["dt_s"]
    return f"{bag} is not complete: it goes to {data.time[-1]:.1f} s of {duration:g} s"


def _place(bag: BagSource) -> Path:
    """Folder of a complete bag; one beside it otherwise, as a recording may still be going on."""
    if bag.path.is_file():
        return bag.path.absolute().with_suffix("")
    folder = bag.folder.absolute()
    if folder.name.startswith(".") and ".partial" in folder.name:
        return folder.with_name(folder.name.removeprefix("."))
    return folder if bag.finished else folder.with_name(f"{folder.name}.partial")


def bags_in(folder: Path) -> list[Path]:
    """Bags that lie in `folder`, partial ones too; empty if it is a bag itself, or holds none."""
    if not folder.is_dir() or any(folder.glob("*.mcap")):
        return []
    return sorted(path for path in folder.iterdir() if path.is_dir() and any(path.glob("*.mcap")))


def analyse_all(bags: list[Path], output: Path | None) -> int:
    """Analyse each bag into a folder of its own, and all together; a line each; return how many failed.

    Parameters
    ----------
    bags : list of Path
        Bag folders that lie in one folder.
    output : Path, optional
        Folder for theirs and for what they give together; by default each has its usual place, and
        what they give together lies beside them.
    """
    records = Records()
    for bag in bags:
        name = bag.name
        try:
            data, folder, notes = analyse(bag, None if output is None else output / name.removeprefix("."))
        except OwtError as error:
            print(f"error: {name}: {' '.join(str(error).split())}", file=sys.stderr)
            records.fail(name, " ".join(str(error).split()))
            continue
        records.add(name, data, folder / "report.html")
        result = f"largest damage {data.fatigue.damage.max():.3g} at {data.end_name}"
        print(f"{name}: {result} in {data.fatigue.duration_s:g} s, {folder}")
        for note in notes:
            print(f"note: {name}: {note}", file=sys.stderr)
    for page in write_records(records, prepare_folder(output or bags[0].parent)):
        print(f"all together: {page}")
    failed = records.failed
    if failed:
        print(f"error: {len(failed)} of {len(bags)} bags failed: {', '.join(failed)}", file=sys.stderr)
    return len(failed)


def run_analysis(bag: Path, output: Path | None) -> int:
    """Analyse a bag or a folder of bags, print what was found, and return the exit code."""
    bags = bags_in(bag)
    if bags:
        return 1 if analyse_all(bags, output) else 0
    if bag.is_dir() and not any(bag.glob("*.mcap")):
        raise InputError("bag", str(bag), "holds no MCAP file", "Give a bag folder, or a folder of bags.")
    data, folder, notes = analyse(bag, output)
    print_table([*head_figures(data), ("report", str(folder / "report.html"))])
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return 0
