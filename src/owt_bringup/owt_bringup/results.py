"""What a run leaves behind besides its bag: summary.json, report.html and the short table on the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from owt_bringup.output import write_json
from owt_postproc.report import summary, write_report
from owt_postproc.report_data import ReportData

__all__ = ["print_table", "result_rows", "write_results"]


def write_results(data: ReportData, folder: Path) -> dict[str, Any]:
    """Write ``summary.json`` and ``report.html`` into `folder`; return the summary."""
    numbers = summary(data)
    write_report(data, folder / "report.html")
    write_json(folder / "summary.json", numbers)
    return numbers


def result_rows(data: ReportData) -> list[tuple[str, str]]:
    """The figures that a user wants to see first."""
    force = (data.wave_force[:, :2] ** 2).sum(axis=1).max() ** 0.5
    fatigue = data.fatigue
    worst = fatigue.worst_end
    rows = [
        ("largest elevation", f"{data.elevation_total.max():.2f} m"),
        ("largest wave force, horizontal", f"{force / 1e6:.2f} MN"),
    ]
    if data.tower_top is not None:
        top = (data.tower_top[:, :2] ** 2).sum(axis=1).max() ** 0.5
        rows.append(("largest tower-top displacement", f"{top * 1e3:.1f} mm"))
    rows += [
        ("largest stress range", f"{fatigue.max_range.max() / 1e6:.1f} MPa"),
        ("most damaged member end", data.end_name),
        (
            f"its damage in {fatigue.duration_s:.1f} s",
            f"{fatigue.damage[worst].max():.3g} ({fatigue.curve.name})",
        ),
    ]
    return rows


def print_table(rows: Iterable[tuple[str, str]]) -> None:
    """Print two aligned columns."""
    rows = list(rows)
    width = max(len(label) for label, _ in rows)
    for label, value in rows:
        print(f"{label:<{width}}  {value}")
