"""Figures of the report: pure functions of :class:`ReportData`."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_postproc.figures_fatigue import damage_bars, exceedance, rainflow_matrix
from owt_postproc.figures_jacket import jacket
from owt_postproc.figures_spectra import spectra
from owt_postproc.plot_style import (
    BLUE,
    FAINT,
    INK,
    MOST_POINTS,
    MOST_SAMPLES,
    ORANGE,
    TEAL,
    Figure,
    axis,
    envelope,
    layout,
    numbers,
)
from owt_postproc.report_data import ReportData
from owt_postproc.report_measures import design_life
from owt_postproc.report_usage import usage_of

__all__ = ["all_figures"]

#: Half length of the close-up in s.
CLOSE_UP_S = 30.0

Line = tuple[str, np.ndarray, np.ndarray, str]


def all_figures(data: ReportData) -> list[Figure]:
    """The figures of the report, in their order."""
    usage = usage_of(data.fatigue, data.reduced.end_name)
    figures: list[Figure | None] = []
    if data.geometry is not None:
        figures.append(jacket(usage, data.geometry, design_life(data.case)))
    figures += [damage_bars(usage), exceedance(usage)]
    figures.append(rainflow_matrix(data.stress_normal, usage.spot_name[usage.most_used]))
    figures += [_stress(data), _elevation(data), _shear(data)]
    if data.tower_top_load is not None:
        figures.append(_tower_top_load(data, data.tower_top_load))
    if data.tower_top is not None:
        figures.append(_tower_top(data))
    figures += [_energy(data), spectra(data)]
    return [figure for figure in figures if figure is not None]


def _elevation(data: ReportData) -> Figure:
    lines = [
        ("first order", data.wave_time, data.elevation_first, ORANGE),
        ("total", data.wave_time, data.elevation_total, BLUE),
    ]
    return _record("elevation", "Surface elevation", "m", data, lines, "At the first gauge.")


def _shear(data: ReportData) -> Figure:
    along, across = data.directions
    force = 1e-6 * data.wave_force[:, :2]
    lines = [
        ("across", data.wave_time, force @ across, FAINT),
        ("along the waves", data.wave_time, force @ along, BLUE),
    ]
    caption = "Sum of the horizontal wave loads on all nodes."
    return _record("shear", "Base shear of the waves", "MN", data, lines, caption)


def _tower_top_load(data: ReportData, load: np.ndarray) -> Figure:
    along, across = data.directions
    force = 1e-3 * load[:, :2]
    lines = [
        ("across", data.wave_time, force @ across, FAINT),
        ("along the waves", data.wave_time, force @ along, BLUE),
    ]
    return _record("tower_top_load", "Load at the tower top", "kN", data, lines, "Horizontal force.")


def _tower_top(data: ReportData) -> Figure:
    assert data.tower_top is not None
    along, across = data.directions
    top = data.tower_top[:, :2]
    lines = [
        ("across", data.time, top @ across, FAINT),
        ("along the waves", data.time, top @ along, BLUE),
    ]
    caption = "Horizontal, from the undeformed position."
    return _record("tower_top", "Tower-top displacement", "m", data, lines, caption)


def _stress(data: ReportData) -> Figure:
    lines = [
        ("von Mises", data.time, 1e-6 * data.stress_von_mises, ORANGE),
        ("normal stress", data.time, 1e-6 * data.stress_normal, BLUE),
    ]
    caption = f"Signed hot-spot stress at {data.spot_name}°, and nominal, unsigned von Mises stress."
    title = f"Stress at the most damaged member end, {data.end_name}"
    return _record("stress", title, "MPa", data, lines, caption)


def _energy(data: ReportData) -> Figure:
    lines = [
        ("kinetic", data.time, 1e-3 * data.kinetic, ORANGE),
        ("potential", data.time, 1e-3 * data.potential, BLUE),
    ]
    for i, (part, colour) in enumerate(zip(data.reduced.substructure_name, (TEAL, FAINT), strict=False)):
        lines.insert(0, (f"potential, {part}", data.time, 1e-3 * data.potential_substructure[:, i], colour))
    caption = "Of the reduced model; the transition piece counts to the tower."
    return _record("energy", "Energies of the structure", "kJ", data, lines, caption)


def _record(key: str, title: str, unit: str, data: ReportData, lines: list[Line], caption: str) -> Figure:
    """The whole record on the left, the time round the highest crest on the right."""
    crest = float(data.wave_time[np.argmax(data.elevation_total)])
    end = float(lines[0][1][-1])
    start = max(0.0, min(crest - CLOSE_UP_S, end - 2 * CLOSE_UP_S))
    stop = min(end, start + 2 * CLOSE_UP_S)
    traces: list[dict[str, Any]] = []
    samples: list[dict[str, Any]] = []
    interval, whole_inside = 1, True
    for name, t, y, colour in lines:
        x_thin, y_thin, every = envelope(t, y)
        interval = max(interval, every)
        if every > 1 and len(t) <= MOST_SAMPLES:
            step = float(t[1] - t[0])
            samples.append({"trace": len(traces), "x0": float(t[0]), "dx": step, "y": numbers(y)})
        whole_inside = whole_inside and (every == 1 or len(t) <= MOST_SAMPLES)
        near = (t >= start) & (t <= stop)
        look = {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "legendgroup": name,
            "hovertemplate": f"%{{y:.4g}} {unit}",
        }
        whole = {"x": numbers(x_thin), "y": numbers(y_thin), "line": {"color": colour, "width": 1}}
        close = {"x": numbers(t[near]), "y": numbers(y[near]), "line": {"color": colour, "width": 1.6}}
        traces.append({**look, **whole})
        traces.append({**look, **close, "showlegend": False, "xaxis": "x2", "yaxis": "y2"})
    if interval > 1:
        caption += f" Left: first, last, lowest and highest of every {interval} samples"
        caption += (
            ", all of them when zoomed in. Right: all samples." if whole_inside else ". Right: all samples."
        )
    window = {
        "type": "rect",
        "xref": "x",
        "yref": "y domain",
        "x0": start,
        "x1": stop,
        "y0": 0,
        "y1": 1,
        "fillcolor": INK,
        "opacity": 0.07,
        "line": {"width": 0},
        "layer": "below",
    }
    look_of_all = layout(
        xaxis=axis("time in s", domain=[0.0, 0.64], range=[0.0, end]),
        yaxis=axis(unit),
        xaxis2=axis("time in s, highest crest", domain=[0.69, 1.0], anchor="y2", range=[start, stop]),
        yaxis2=axis("", anchor="x2", matches="y", showticklabels=False),
        shapes=[window],
    )
    extra = {"samples": samples, "most": 2 * MOST_POINTS} if samples else {}
    return Figure(key, title, caption, traces, look_of_all, extra=extra)
