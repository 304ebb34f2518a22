"""The report of one run: one HTML page that needs nothing but a browser."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from owt_postproc.core.statistics import statistics
from owt_postproc.figures import all_figures
from owt_postproc.plot_style import Figure
from owt_postproc.report_case import report_facts
from owt_postproc.report_data import ReportData
from owt_postproc.report_html import facts, figure, page, power_cell, table, text, tiles, write_page
from owt_postproc.report_measures import DesignLife, design_life
from owt_postproc.report_methods import methods
from owt_postproc.report_summary import head_figures, series_of, summary
from owt_postproc.report_usage import Usage, usage_of

__all__ = ["ends_table", "head_figures", "methods_table", "pairs", "render", "summary", "write_report"]

#: Rows of a long table that appear on paper.
PRINTED_ROWS = 40
#: Figures that stand beside one another.
FIRST, SECOND = ("jacket", "damage"), ("exceedance", "matrix")


def write_report(data: ReportData, path: str | Path) -> Path:
    """Write the report, whole or not at all; returns its path.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    return write_page(render(data), Path(path))


def render(data: ReportData) -> str:
    """The page as text."""
    figures = all_figures(data)
    usage = usage_of(data.fatigue, data.reduced.end_name)
    body = [
        tiles(head_figures(data)),
        "<h2>Fatigue</h2>",
        pairs(figures),
        "<h3>Member ends</h3>",
        ends_table(usage, design_life(data.case)),
        "<h2>Sea, loads and response</h2>",
        *(figure(f) for f in figures if f.key not in (*FIRST, *SECOND)),
        "<h3>Statistics</h3>",
        _statistics_table(data),
        "<h3>Natural frequencies of the reduced model</h3>",
        _frequency_table(data),
        "<h2>Where this comes from</h2>",
        '<section class="columns">',
        *(f"<div><h3>{text(title)}</h3>{facts(rows)}</div>" for title, rows in report_facts(data)),
        "</section>",
        "<h3>Methods and their sources</h3>",
        methods_table(methods(data)),
        "<details><summary>Case as computed</summary>",
        f"<pre>{text(json.dumps(dict(data.case), indent=1))}</pre></details>",
    ]
    return page(data.title, _subtitle(data), body, figures)


def pairs(figures: Iterable[Figure]) -> str:
    """The figures of the fatigue results, two beside each other where both are there."""
    shown = {f.key: f for f in figures}
    rows = []
    for kind, keys in (("pair first", FIRST), ("pair", SECOND)):
        there = [figure(shown[key]) for key in keys if key in shown]
        rows.append(
            f'<section class="{kind}">{"".join(there)}</section>' if len(there) > 1 else "".join(there)
        )
    return "".join(rows)


def _subtitle(data: ReportData) -> str:
    sea, regular = data.sea_state, data.case.get("regular")
    parts = [f"{data.reduced.model_name}, {data.reduced.reduction}"]
    if sea.get("hs_m"):
        parts.append(f"Hs {sea['hs_m']:g} m, Tp {sea['tp_s']:g} s, towards {sea['direction_deg']:g}°")
    elif regular:
        size = f"T {regular['period_s']:g} s" if regular.get("period_s") else f"L {regular['length_m']:g} m"
        parts.append(f"regular wave ({regular['theory']}), H {regular['height_m']:g} m, {size}")
    parts.append(f"{data.fatigue.duration_s:.0f} s")
    if not data.complete:
        parts.append("INCOMPLETE: the recording broke off before its last block")
    return " · ".join(parts)


def ends_table(usage: Usage, design: DesignLife | None) -> str:
    """All member ends, each by its worst spot, the most damaged first."""
    damage, spot, largest = usage.end_damage, usage.worst_spot, usage.end_max_range
    factor = usage.spot_factor
    used = None if design is None else design.utilisation(damage, usage.duration_s)
    rows: list[list[Any]] = []
    for e in np.argsort(-damage, kind="stable"):
        s = int(spot[e])
        rows.append(
            [
                usage.end_name[e],
                power_cell(float(damage[e])),
                *([] if used is None else [power_cell(float(used[e]))]),
                usage.end_kind[e] or "-",
                usage.spot_side[s],
                float(usage.spot_angle_deg[s]),
                float(factor[s]),
                float(usage.cycles[s]),
                1e-6 * float(largest[e]),
                1e-6 * float(usage.total_stress[e]),
            ]
        )
    head = [
        "member end", "damage", *([] if design is None else ["utilisation"]), "joint", "worst spot on",
        "at angle, °", "largest factor", "cycles", "largest range, MPa", "total stress, MPa",
    ]  # fmt: skip
    caption = (
        f"All {len(rows)} member ends, each by its worst spot; click a heading to sort. Largest factor: "
        "of its stress concentration factors. Total stress: the measure of the thesis, no damage."
    )
    return table("member_ends", head, rows, caption=caption, printed=PRINTED_ROWS)


def _statistics_table(data: ReportData) -> str:
    rows = []
    for _, name, series, _, scale, unit in series_of(data):
        s = statistics(series * scale)
        mean = s.mean if abs(s.mean) > 1e-12 * s.std else 0.0  # round-off is no mean
        rows.append([name, unit, mean, s.std, s.minimum, s.maximum, s.skewness, s.zero_up_crossings])
    head = ["series", "unit", "mean", "standard deviation", "minimum", "maximum", "skewness", "up-crossings"]
    return table("statistics", head, rows, caption="Over the whole record.")


def _frequency_table(data: ReportData) -> str:
    frequency, ratio = data.reduced.frequency_hz[:12], data.reduced.damping_ratio[:12]
    rows = [
        [f"f{i + 1}", float(f), 100.0 * float(z)]
        for i, (f, z) in enumerate(zip(frequency, ratio, strict=True))
    ]
    head = ["mode", "frequency, Hz", "damping, % of critical"]
    return table("frequencies", head, rows, caption="Undamped frequencies, the lowest first.")


def methods_table(rows: Iterable[tuple[str, str, str]]) -> str:
    """What was done, and where it comes from."""
    return table("methods", ["step", "method", "source"], rows, caption="In the order of the chain.")
