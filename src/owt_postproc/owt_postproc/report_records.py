"""Several records together: damage of each spot added up before the largest is looked for."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from owt_postproc.figures_fatigue import damage_bars, exceedance
from owt_postproc.figures_jacket import jacket
from owt_postproc.plot_style import Figure
from owt_postproc.report import ends_table, methods_table, pairs
from owt_postproc.report_data import Geometry, ReportData
from owt_postproc.report_html import Link, page, power_cell, table, text, tiles
from owt_postproc.report_measures import YEAR_S, DesignLife, design_life, power
from owt_postproc.report_methods import fatigue_methods
from owt_postproc.report_tables import Table, case_hash
from owt_postproc.report_usage import Usage, add_up, same_spots, usage_of

__all__ = ["Group", "Record", "Records", "records_table"]

#: Facts of a sea state in the table of records: key, heading and name of a column.
SEA = (
    ("hs_m", "Hs, m"),
    ("tp_s", "Tp, s"),
    ("direction_deg", "direction, °"),
    ("seed", "seed"),
)


@dataclass(frozen=True)
class Record:
    """What is kept of one record.

    Attributes
    ----------
    name : str
    page : Path
        Its own report.
    sea : dict
        Facts of its sea state.
    case_sha256 : str
    complete : bool
    duration_s : float
    damage : float array [spot]
    most_used : int
        Its own spot of largest damage.
    max_range : float
        Its largest range in Pa.
    """

    name: str
    page: Path
    sea: dict[str, Any]
    case_sha256: str
    complete: bool
    duration_s: float
    damage: np.ndarray
    most_used: int
    max_range: float


@dataclass
class Group:
    """Records of the same spots, which add up."""

    model_name: str
    model_hash: str
    usage: Usage
    geometry: Geometry | None
    design: DesignLife | None
    records: list[Record]


@dataclass
class Records:
    """Collects records, one after another, and what became of those that failed."""

    groups: list[Group] = field(default_factory=list)
    failed: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, data: ReportData, report: Path) -> None:
        """Take the results of a record whose own page is `report`."""
        usage, reduced = usage_of(data.fatigue, data.reduced.end_name), data.reduced
        record = Record(
            name=name,
            page=report,
            sea={key: data.sea_state.get(key) for key, _ in SEA},
            case_sha256=case_hash(data.case),
            complete=data.complete,
            duration_s=usage.duration_s,
            damage=usage.damage,
            most_used=usage.most_used,
            max_range=float(usage.max_range.max()),
        )
        design = design_life(data.case)
        for group in self.groups:
            same = group.model_hash == reduced.model_hash and group.design == design
            if same and same_spots(group.usage, usage):
                group.usage = add_up(group.usage, usage)
                group.records.append(record)
                return
        self.groups.append(
            Group(reduced.model_name, reduced.model_hash, usage, data.geometry, design, [record])
        )

    def fail(self, name: str, message: str) -> None:
        """Note a record that could not be analysed."""
        self.failed[name] = message

    def summary(self) -> dict[str, Any]:
        """Plain numbers, units in the keys, ready for JSON."""
        return {"groups": [_plain(group) for group in self.groups], "failed": dict(self.failed)}

    def render(self, group: Group, folder: Path) -> str:
        """Page of a group, to lie in `folder`."""
        usage = group.usage
        figures: list[Figure] = []
        if group.geometry is not None:
            figures.append(jacket(usage, group.geometry, group.design))
        figures += [damage_bars(usage), exceedance(usage)]
        n = len(group.records)
        hours = usage.duration_s / 3600.0
        body = [
            self._warnings(group),
            tiles(_head(group)),
            "<h2>Damage of all records together</h2>",
            '<p class="note">The damage of each spot is added up over the records before the largest is '
            "looked for; each record counts once, with the time that it lasts.</p>",
            pairs(figures),
            "<h3>Member ends</h3>",
            ends_table(usage, group.design),
            "<h2>Records</h2>",
            _records_table(group, folder),
            "<h2>Methods and their sources</h2>",
            methods_table(fatigue_methods(usage)),
        ]
        subtitle = f"{group.model_name}, {n} records, {hours:.4g} h · structure {group.model_hash[:16]}"
        return page(f"Fatigue over {n} records", subtitle, body, figures)

    def _warnings(self, group: Group) -> str:
        lines = [f"{text(name)} failed and is not counted: {text(why)}" for name, why in self.failed.items()]
        lines += [
            f"{text(r.name)} is not complete: only {r.duration_s:g} s of it are counted"
            for r in group.records
            if not r.complete
        ]
        if len(self.groups) > 1:
            lines.append(
                f"{len(self.groups)} groups of records, by structure and fatigue options, which do "
                "not add up: this "
                f"page is that of {len(group.records)} of them"
            )
        if not lines:
            return ""
        items = "".join(f"<li>{line}</li>" for line in lines)
        return f'<div class="warning" role="alert"><ul>{items}</ul></div>'


def _head(group: Group) -> list[tuple[str, str]]:
    usage = group.usage
    worst = int(np.argmax(usage.end_damage))
    damage = float(usage.end_damage[worst])
    figures = [
        ("records", str(len(group.records))),
        ("counted together", f"{usage.duration_s / 3600.0:.4g} h"),
        ("largest stress range", f"{1e-6 * usage.max_range.max():.1f} MPa"),
        ("most damaged member end", usage.end_name[worst]),
        ("its damage, added up", power(damage)),
        ("its damage in a year of these records", power(damage * YEAR_S / max(usage.duration_s, 1e-300))),
    ]
    return figures


def _records_table(group: Group, folder: Path) -> str:
    usage = group.usage
    spot = usage.most_used
    whole = float(usage.damage[spot])
    rows: list[list[Any]] = []
    for r in group.records:
        at = usage.end_name[int(usage.spot_end[r.most_used])]
        share = 100.0 * float(r.damage[spot]) / whole if whole else 0.0
        rows.append(
            [
                Link(r.name, Path(os.path.relpath(r.page, folder)).as_posix()),
                *("" if r.sea[key] is None else r.sea[key] for key, _ in SEA),
                r.duration_s,
                "yes" if r.complete else "NO",
                power_cell(float(r.damage[r.most_used])),
                at,
                1e-6 * r.max_range,
                share,
            ]
        )
    head = [
        "record", *(label for _, label in SEA), "duration, s", "complete", "largest damage", "at",
        "largest range, MPa", "share of the damage added up, %",
    ]  # fmt: skip
    caption = (
        f"All {len(rows)} records; the share is that of the damage added up at the most used spot, "
        f"{usage.spot_name[spot]}."
    )
    return table("records", head, rows, caption=caption)


def records_table(group: Group) -> Table:
    """One line per record, as a file."""
    usage = group.usage
    records = group.records
    columns: dict[str, Any] = {
        "record": [r.name for r in records],
        "case_sha256": [r.case_sha256 for r in records],
        **{
            key: np.array([np.nan if r.sea[key] is None else r.sea[key] for r in records], float)
            for key, _ in SEA
        },
        "duration_s": np.array([r.duration_s for r in records]),
        "complete": np.array([r.complete for r in records]),
        "max_damage": np.array([r.damage[r.most_used] for r in records]),
        "max_damage_spot": [usage.spot_name[r.most_used] for r in records],
        "max_range_pa": np.array([r.max_range for r in records]),
        "damage_at_most_used_spot": np.array([r.damage[usage.most_used] for r in records]),
    }
    return Table("records", columns)


def _plain(group: Group) -> dict[str, Any]:
    usage = group.usage
    spot = usage.most_used
    return {
        "model": {"name": group.model_name, "hash": group.model_hash},
        "sn_curve": usage.curve.name,
        "duration_s": usage.duration_s,
        "max_damage": float(usage.damage[spot]),
        "max_damage_spot": usage.spot_name[spot],
        "max_range_pa": float(usage.max_range.max()),
        "records": [
            {
                "name": r.name,
                "case_sha256": r.case_sha256,
                "complete": r.complete,
                "duration_s": r.duration_s,
                "max_damage": float(r.damage[r.most_used]),
                "max_damage_spot": usage.spot_name[r.most_used],
                "damage_at_most_used_spot": float(r.damage[spot]),
            }
            for r in group.records
        ],
    }
