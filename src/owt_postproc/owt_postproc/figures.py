"""Figures of the report: pure functions of :class:`ReportData`."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_postproc.core.statistics import spectrum
from owt_postproc.figures_fatigue import damage_bars, exceedance, jacket
from owt_postproc.plot_style import (
    BLUE,
    FAINT,
    INK,
    ORANGE,
    TEAL,
    Figure,
    axis,
    envelope,
    layout,
    log_axis,
    numbers,
)
from owt_postproc.report_data import ReportData

__all__ = ["all_figures"]

#: Half length of the close-up in s.
CLOSE_UP_S = 30.0
#: Spectra are shown up to this frequency in Hz.
TOP_HZ = 5.0
#: Natural frequencies marked in a spectrum.
MODES_MARKED = 12
#: Lowest density drawn, as a share of the highest.
LOWEST_SHOWN = 1e-8

Line = tuple[str, np.ndarray, np.ndarray, str]


def all_figures(data: ReportData) -> list[Figure]:
    """The figures of the report, in their order."""
    figures = [_elevation(data), _shear(data)]
    if data.tower_top_load is not None:
        figures.append(_tower_top_load(data, data.tower_top_load))
    if data.tower_top is not None:
        figures.append(_tower_top(data))
    shown = (_stress(data), _spectrum(data), _energy(data), damage_bars(data), exceedance(data))
    figures += [figure for figure in shown if figure is not None]
    if data.geometry is not None:
        figures.append(jacket(data, data.geometry))
    return figures


def _elevation(data: ReportData) -> Figure:
    lines = [
        ("first order", data.wave_time, data.elevation_first, ORANGE),
        ("total", data.wave_time, data.elevation_total, BLUE),
    ]
    return _record("elevation", "Surface elevation", "m", data, lines, "At the first gauge.")


def _directions(data: ReportData) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal unit vectors along and across the waves."""
    b = np.deg2rad(float(data.sea_state.get("direction_deg", 0.0)))
    return np.array([np.cos(b), np.sin(b)]), np.array([-np.sin(b), np.cos(b)])


def _shear(data: ReportData) -> Figure:
    along, across = _directions(data)
    force = 1e-6 * data.wave_force[:, :2]
    lines = [
        ("across", data.wave_time, force @ across, FAINT),
        ("along the waves", data.wave_time, force @ along, BLUE),
    ]
    caption = "Sum of the horizontal wave loads on all nodes."
    return _record("shear", "Base shear of the waves", "MN", data, lines, caption)


def _tower_top_load(data: ReportData, load: np.ndarray) -> Figure:
    along, across = _directions(data)
    force = 1e-3 * load[:, :2]
    lines = [
        ("across", data.wave_time, force @ across, FAINT),
        ("along the waves", data.wave_time, force @ along, BLUE),
    ]
    return _record("tower_top_load", "Load at the tower top", "kN", data, lines, "Horizontal force.")


def _tower_top(data: ReportData) -> Figure:
    assert data.tower_top is not None
    along, across = _directions(data)
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
    interval = 1
    for name, t, y, colour in lines:
        x_thin, y_thin, every = envelope(t, y)
        interval = max(interval, every)
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
        caption += f" Left: lowest and highest of every {interval} samples. Right: all samples."
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
    return Figure(key, title, caption, traces, look_of_all)


def _spectrum(data: ReportData) -> Figure | None:
    """None of a record so short that it has no frequency in the range shown."""
    result = spectrum(1e-6 * data.stress_normal, float(data.time[1] - data.time[0]))
    shown = result.frequency <= TOP_HZ
    if np.count_nonzero(shown) < 2:
        return None
    f, density = result.frequency[shown], result.density[shown]
    high = float(density.max()) or 1.0
    density = np.maximum(density, 1e-30 * high)
    shapes, notes = _marks(data, float(f[0]), float(f[-1]))
    trace = {
        "type": "scatter",
        "mode": "lines",
        "x": numbers(f),
        "y": numbers(density),
        "showlegend": False,
        "line": {"color": BLUE, "width": 1.4},
        "hovertemplate": "%{y:.3g} MPa²/Hz<extra></extra>",
    }
    look = layout(
        xaxis=log_axis("frequency in Hz", float(f[0]), float(f[-1]), labels=(1, 2, 5)),
        yaxis=log_axis("MPa²/Hz", LOWEST_SHOWN * high, 2.0 * high),
        shapes=shapes,
        annotations=notes,
    )
    caption = (
        "Of the signed normal stress above, by Welch's method with Hann windows; resolution "
        f"{result.resolution:.2g} Hz. Dotted: natural frequencies, and the peak of the sea."
    )
    title = f"Spectrum of the stress at {data.end_name}"
    return Figure("spectrum", title, caption, [trace], look, height=360)


def _marks(data: ReportData, low: float, high: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Lines and labels at the natural frequencies and the peak of the sea; near ones share a label."""
    marks = [(float(v), f"f{i + 1}", TEAL) for i, v in enumerate(data.reduced.frequency_hz[:MODES_MARKED])]
    tp = float(data.sea_state.get("tp_s") or 0.0)
    if tp > 0.0:
        marks.append((1.0 / tp, "1/Tp", ORANGE))
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    room = 0.03 * np.log10(high / low)
    for value, label, colour in sorted(mark for mark in marks if low <= mark[0] <= high):
        line = {"color": colour, "width": 1, "dash": "dot"}
        place = {"x0": value, "x1": value, "y0": 0, "y1": 1, "yref": "paper"}
        shapes.append({"type": "line", **place, "line": line, "layer": "below"})
        x = float(np.log10(value))
        if notes and x - notes[-1]["x"] < room:
            first = notes[-1]["text"].split("–")[0]
            notes[-1]["text"] = f"{first}–{label.removeprefix('f')}" if first.startswith("f") else first
            continue
        notes.append(
            {
                "x": x,
                "y": 1,
                "yref": "paper",
                "yanchor": "bottom",
                "text": label,
                "showarrow": False,
                "font": {"color": colour, "size": 11},
            }
        )
    return shapes, notes
