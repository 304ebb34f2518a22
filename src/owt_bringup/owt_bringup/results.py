"""What a run leaves behind besides its bag: summary.json, report.html and the short table on the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from owt_bringup.output import write_json
from owt_postproc.report import summary, write_report
from owt_postproc.report_data import ReportData

__all__ = ["print_table", "write_results"]


def write_results(data: ReportData, folder: Path) -> dict[str, Any]:
    """Write ``summary.json`` and ``report.html`` into `folder`; return the summary."""
    numbers = summary(data)
    write_report(data, folder / "report.html")
    write_json(folder / "summary.json", numbers)
    return numbers


def print_table(rows: Iterable[tuple[str, str]]) -> None:
    """Print two aligned columns."""
    rows = list(rows)
    width = max(len(label) for label, _ in rows)
    for label, value in rows:
        print(f"{label:<{width}}  {value}")
