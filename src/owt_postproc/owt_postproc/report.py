"""The report: one HTML page that needs nothing but a browser, and the summary as plain numbers."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from owt_model.errors import InputError
from owt_postproc.core.statistics import statistics
from owt_postproc.core.summary import fatigue_summary
from owt_postproc.figures import all_figures
from owt_postproc.plot_style import Figure
from owt_postproc.report_case import report_facts
from owt_postproc.report_data import ReportData

__all__ = ["head_figures", "render", "summary", "write_report"]

TABLE_ROWS = 30
#: Figures that stand beside one another: two on the left, one on the right.
BESIDE = ("damage", "exceedance", "jacket")


def write_report(data: ReportData, path: str | Path) -> Path:
    """Write the report, whole or not at all; returns its path.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    path = Path(path)
    partial = path.with_name(f".{path.name}.partial")
    text = render(data)
    try:
        with partial.open("w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise InputError(
            "report",
            str(path),
            f"cannot be written ({error.strerror})",
            "Choose a folder with free space.",
        ) from None
    return path


def summary(data: ReportData) -> dict[str, Any]:
    """The results as plain finite numbers, units in the keys, ready for JSON."""
    reduced = data.reduced
    result: dict[str, Any] = {
        "case": dict(data.case),
        "sea_state": dict(data.sea_state),
        "versions": dict(data.versions),
        "model": {
            "name": reduced.model_name,
            "hash": reduced.model_hash,
            "reduction": reduced.reduction,
            "coordinates": len(reduced.coordinate_name),
            "frequency_hz": [float(v) for v in reduced.frequency_hz[:20]],
            "damping_ratio": [float(v) for v in reduced.damping_ratio[:20]],
            "notes": list(reduced.notes),
        },
        "statistics": {key: statistics(series).as_dict(unit) for key, _, series, unit, _, _ in _series(data)},
        "fatigue": fatigue_summary(data.fatigue, reduced, complete=data.complete),
    }
    return result


def _series(data: ReportData) -> list[tuple[str, str, np.ndarray, str, float, str]]:
    """Key, name, series, unit of the key, and scale and unit for people."""
    rows = [
        ("elevation_total", "Surface elevation", data.elevation_total, "m", 1.0, "m"),
        ("elevation_first_order", "Surface elevation, first order", data.elevation_first, "m", 1.0, "m"),
        ("wave_force_x", "Wave force, x", data.wave_force[:, 0], "n", 1e-6, "MN"),
        ("wave_force_y", "Wave force, y", data.wave_force[:, 1], "n", 1e-6, "MN"),
        ("normal_stress", f"Normal stress, {data.end_name}", data.stress_normal, "pa", 1e-6, "MPa"),
        (
            "von_mises_stress",
            f"Von Mises, {data.end_name}",
            data.stress_von_mises,
            "pa",
            1e-6,
            "MPa",
        ),
        ("potential_energy", "Potential energy", data.potential, "j", 1e-3, "kJ"),
        ("kinetic_energy", "Kinetic energy", data.kinetic, "j", 1e-3, "kJ"),
    ]
    if data.tower_top_load is not None:
        rows[4:4] = [
            ("tower_top_load_x", "Load at the tower top, x", data.tower_top_load[:, 0], "n", 1e-3, "kN"),
            ("tower_top_load_y", "Load at the tower top, y", data.tower_top_load[:, 1], "n", 1e-3, "kN"),
        ]
    for i, part in enumerate(data.reduced.substructure_name):
        rows += [
            (
                f"potential_energy_{part}",
                f"Potential energy, {part}",
                data.potential_substructure[:, i],
                "j",
                1e-3,
                "kJ",
            ),
            (
                f"kinetic_energy_{part}",
                f"Kinetic energy, {part}",
                data.kinetic_substructure[:, i],
                "j",
                1e-3,
                "kJ",
            ),
        ]
    if data.tower_top is not None:
        rows[4:4] = [
            ("tower_top_x", "Tower-top displacement, x", data.tower_top[:, 0], "m", 1.0, "m"),
            ("tower_top_y", "Tower-top displacement, y", data.tower_top[:, 1], "m", 1.0, "m"),
        ]
    return rows


def render(data: ReportData) -> str:
    """The page as text."""
    figures = all_figures(data)
    payload = json.dumps(
        [{"key": f.key, "data": f.data, "layout": {**f.layout, "height": f.height}} for f in figures],
        separators=(",", ":"),
        allow_nan=False,
    ).replace("</", "<\\/")
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{_text(data.title)}</title>",
        f"<style>{_file('report.css')}</style>",
        f"<script>{_plotly()}</script>",
        "</head><body><main>",
        f"<header><h1>{_text(data.title)}</h1><p>{_text(_subtitle(data))}</p></header>",
        _tiles(data),
        '<section class="columns">',
        *(f"<div><h2>{_text(title)}</h2>{_facts(rows)}</div>" for title, rows in report_facts(data)),
        "</section>",
        "<h2>Results</h2>",
        *(_figure(figure) for figure in figures if figure.key not in BESIDE),
        '<section class="beside"><div>',
        *(_figure(figure) for figure in figures if figure.key in BESIDE[:2]),
        "</div><div>",
        *(_figure(figure) for figure in figures if figure.key in BESIDE[2:]),
        "</div></section>",
        "<h2>Statistics</h2>",
        _statistics_table(data),
        "<h2>Member ends</h2>",
        _ends_table(data),
        "<h2>Natural frequencies of the reduced model</h2>",
        _frequency_table(data),
        "<h2>Method and limits</h2>",
        f'<p class="note">{_text(_method(data))}</p>',
        "<details><summary>Case</summary>",
        f"<pre>{_text(json.dumps(dict(data.case), indent=1))}</pre></details>",
        "</main>",
        f'<script id="figures" type="application/json">{payload}</script>',
        f"<script>{_file('report.js')}</script>",
        "</body></html>",
    ]
    return "\n".join(parts)


def _figure(figure: Figure) -> str:
    return (
        f'<figure><h3>{_text(figure.title)}</h3><div class="plot" id="plot-{figure.key}" '
        f'style="height:{figure.height}px"></div><figcaption>{_text(figure.caption)}</figcaption></figure>'
    )


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


def head_figures(data: ReportData) -> list[tuple[str, str]]:
    """Label and value of the figures that a user wants to see first."""
    shear = 1e-6 * np.hypot(data.wave_force[:, 0], data.wave_force[:, 1]).max()
    figures = [
        ("highest crest", f"{data.elevation_total.max():.2f} m"),
        ("largest base shear of the waves", f"{shear:.2f} MN"),
    ]
    if data.tower_top is not None:
        top = np.hypot(*data.tower_top[:, :2].T).max()
        figures.append(("largest tower-top displacement", f"{top:.3f} m"))
    fatigue = data.fatigue
    return [
        *figures,
        ("largest stress range", f"{1e-6 * fatigue.max_range.max():.1f} MPa"),
        ("most damaged member end", data.end_name),
        (
            f"its damage in {fatigue.duration_s:.0f} s, at {data.spot_name.split(' ', 1)[1]}°",
            _power(float(fatigue.damage.max())),
        ),
    ]


def _tiles(data: ReportData) -> str:
    return (
        '<div class="tiles">'
        + "".join(
            f'<div class="tile"><b>{_text(value)}</b><span>{_text(label)}</span></div>'
            for label, value in head_figures(data)
        )
        + "</div>"
    )


def _facts(rows: Iterable[tuple[str, Any]]) -> str:
    body = "".join(f"<tr><th>{_text(k)}</th><td>{_text(_shown(v))}</td></tr>" for k, v in rows)
    return f"<table><tbody>{body}</tbody></table>"


@dataclass(frozen=True)
class _Cell:
    """A number written in a way of its own."""

    text: str
    value: float


def _table(head: list[str], rows: Iterable[list[Any]], *, sort: bool = False) -> str:
    def cell(value: Any) -> str:
        if isinstance(value, _Cell):
            return f'<td class="number" data-value="{value.value!r}">{_text(value.text)}</td>'
        if isinstance(value, float | int):
            return f'<td class="number" data-value="{value!r}">{_text(_shown(value))}</td>'
        return f"<td>{_text(value)}</td>"

    columns = "".join(
        f'<th class="number">{_text(h)}</th>' if i else f"<th>{_text(h)}</th>" for i, h in enumerate(head)
    )
    body = "".join(f"<tr>{''.join(map(cell, row))}</tr>" for row in rows)
    kind = "sort" if sort else "short"
    return f'<table class="{kind}"><thead><tr>{columns}</tr></thead><tbody>{body}</tbody></table>'


def _statistics_table(data: ReportData) -> str:
    rows = []
    for _, name, series, _, scale, unit in _series(data):
        s = statistics(series * scale)
        mean = s.mean if abs(s.mean) > 1e-12 * s.std else 0.0  # round-off is no mean
        rows.append([f"{name}, {unit}", mean, s.std, s.minimum, s.maximum, s.skewness, s.zero_up_crossings])
    return _table(["", "mean", "standard deviation", "minimum", "maximum", "skewness", "up-crossings"], rows)


def _ends_table(data: ReportData) -> str:
    fatigue = data.fatigue
    spots, spot, damage = fatigue.hot_spots, fatigue.worst_spot, fatigue.end_damage
    order = np.argsort(-damage, kind="stable")[:TABLE_ROWS]
    rows = [
        [
            data.reduced.end_name[e],
            _Cell(_power(float(damage[e])), float(damage[e])),
            f"{spots.side[spot[e]]} {spots.angle_deg[spot[e]]:g}",
            float(fatigue.cycles[spot[e]]),
            1e-6 * float(fatigue.max_range[spot[e]]),
            1e-6 * float(fatigue.total_stress[e]),
        ]
        for e in order
    ]
    head = ["member end", "damage", "hot spot, at °", "cycles", "largest range, MPa", "total stress, MPa"]
    note = (
        f'<p class="note">The {len(rows)} most damaged of {len(damage)} member ends; click a heading to '
        "sort. Total stress: sum of range × count of the unsigned von Mises stress, the measure of the "
        "thesis and not a damage.</p>"
    )
    return _table(head, rows, sort=True) + note


def _frequency_table(data: ReportData) -> str:
    frequency, ratio = data.reduced.frequency_hz[:12], data.reduced.damping_ratio[:12]
    rows = [
        [f"f{i + 1}", float(f), 100.0 * float(z)]
        for i, (f, z) in enumerate(zip(frequency, ratio, strict=True))
    ]
    return _table(["mode", "frequency, Hz", "damping, % of critical"], rows)


def _method(data: ReportData) -> str:
    curve = data.fatigue.curve
    return (
        "Rainflow counting after ASTM E1049-85 with the residue as half cycles, every integration step "
        "included; Palmgren-Miner sum of the signed stress at eight hot spots on the chord side and on the "
        "brace side of each brace end, with Efthymiou's stress concentration factors and influence "
        "functions, and at eight points of the wall of all other ends, as far as the case does not say "
        "otherwise. No mean-stress correction. "
        f"S-N curve: {curve.edition} {curve.source} Series "
        "are drawn thinned out where the captions say so, and in single precision; the numbers in the tables "
        "come from all samples."
    )


def _shown(value: Any) -> str:
    return f"{value:.4g}".replace("-", "−") if isinstance(value, float) else str(value)


def _power(value: float) -> str:
    """Three digits and a power of ten."""
    digits, exponent = f"{value:.2e}".split("e")
    return f"{digits}×10{str(int(exponent)).translate(_SUPERSCRIPT)}" if value else "0"


_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _text(value: Any) -> str:
    return html.escape(str(value))


def _file(name: str) -> str:
    return (resources.files("owt_postproc") / "data" / name).read_text(encoding="utf-8")


@cache
def _plotly() -> str:
    """Plotly's own script, as its Python package ships it."""
    return (resources.files("plotly") / "package_data" / "plotly.min.js").read_text(encoding="utf-8")
