"""What a run leaves behind besides its bag: summary, report, tables, and the short table on the terminal."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from owt_bringup.output import write_json
from owt_postproc.report import summary, write_report
from owt_postproc.report_data import ReportData
from owt_postproc.report_html import write_page
from owt_postproc.report_measures import design_life
from owt_postproc.report_records import Records, records_table
from owt_postproc.report_tables import case_hash, usage_tables, write_tables
from owt_postproc.report_usage import usage_of

__all__ = ["print_table", "write_records", "write_results"]


def write_results(data: ReportData, folder: Path) -> dict[str, Any]:
    """Write ``summary.json``, ``report.html`` and the tables into `folder`; return the summary."""
    numbers = summary(data)
    write_report(data, folder / "report.html")
    usage = usage_of(data.fatigue, data.reduced.end_name)
    metadata = {
        "case_sha256": case_hash(data.case),
        "case": json.dumps(dict(data.case)),
        "model_name": data.reduced.model_name,
        "model_hash": data.reduced.model_hash,
        "reduction": data.reduced.reduction,
        "sn_curve": usage.curve.name,
        "duration_s": repr(usage.duration_s),
        "complete": str(data.complete),
        "versions": json.dumps(dict(data.versions)),
    }
    write_tables(usage_tables(usage, design_life(data.case)), folder, metadata)
    write_json(folder / "summary.json", numbers)
    return numbers


def write_records(records: Records, folder: Path) -> list[Path]:
    """Write summary, pages and tables of several records together; return the pages.

    Records that do not add up get a page and tables each, numbered.
    """
    pages = []
    for i, group in enumerate(records.groups, 1):
        number = f"_{i}" if len(records.groups) > 1 else ""
        pages.append(write_page(records.render(group, folder), folder / f"report{number}.html"))
        metadata = {
            "case_sha256": json.dumps([r.case_sha256 for r in group.records]),
            "records": json.dumps([r.name for r in group.records]),
            "failed": json.dumps(records.failed),
            "model_name": group.model_name,
            "model_hash": group.model_hash,
            "sn_curve": group.usage.curve.name,
            "duration_s": repr(group.usage.duration_s),
        }
        tables = [records_table(group), *usage_tables(group.usage, group.design)]
        named = [replace(table, name=f"{table.name}{number}") for table in tables]
        write_tables(named, folder, metadata)
    write_json(folder / "summary.json", records.summary())
    return pages


def print_table(rows: Iterable[tuple[str, str]]) -> None:
    """Print two aligned columns."""
    rows = list(rows)
    width = max(len(label) for label, _ in rows)
    for label, value in rows:
        print(f"{label:<{width}}  {value}")
