"""Spectra of the sea and of what it does, one above the other, natural frequencies marked."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_postproc.core.statistics import spectrum
from owt_postproc.plot_style import BLUE, INK, ORANGE, TEAL, Figure, layout, log_axis, numbers
from owt_postproc.report_data import ReportData

__all__ = ["spectra"]

#: Spectra are shown up to this frequency in Hz.
TOP_HZ = 5.0
#: Natural frequencies marked in a spectrum.
MODES_MARKED = 12
#: Lowest density drawn, as a share of the highest.
LOWEST_SHOWN = 1e-8
#: Room between two panels, as a share of the height.
GAP = 0.05
#: Height of a panel in pixels.
PANEL = 190

Panel = tuple[str, str, np.ndarray, float, str]


def _panels(data: ReportData) -> list[Panel]:
    """Name, unit, series, sampling interval and colour of what is shown, top to bottom."""
    wave_dt, dt = (float(t[1] - t[0]) if len(t) > 1 else 1.0 for t in (data.wave_time, data.time))
    along, _ = data.directions
    panels = [
        ("surface elevation", "m²/Hz", data.elevation_total, wave_dt, TEAL),
        ("base shear along the waves", "MN²/Hz", 1e-6 * data.wave_force[:, :2] @ along, wave_dt, ORANGE),
        (f"normal stress, {data.end_name}", "MPa²/Hz", 1e-6 * data.stress_normal, dt, BLUE),
    ]
    if data.tower_top is not None:
        top = data.tower_top[:, :2] @ along
        panels.insert(2, ("tower top along the waves", "m²/Hz", top, dt, INK))
    return panels


def spectra(data: ReportData) -> Figure | None:
    """Spectra, one panel each; None of a record so short that it has no frequency in the range shown."""
    panels = [p for p in _panels(data) if len(p[2]) >= 4]
    found = [(p, spectrum(p[2], p[3])) for p in panels]
    found = [(p, s) for p, s in found if np.count_nonzero(s.frequency <= TOP_HZ) >= 2]
    if not found:
        return None
    low = min(float(s.frequency[0]) for _, s in found)
    room = (1.0 + GAP) / len(found)
    traces, axes, notes = [], {}, []
    for i, ((name, unit, _, _, colour), result) in enumerate(found):
        shown = result.frequency <= TOP_HZ
        density = result.density[shown]
        high = float(density.max()) or 1.0
        number = "" if i == 0 else str(i + 1)
        top = 1.0 - i * room
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": name,
                "x": numbers(result.frequency[shown]),
                "y": numbers(np.maximum(density, 1e-30 * high)),
                "yaxis": f"y{number}",
                "showlegend": False,
                "line": {"color": colour, "width": 1.5},
                "hovertemplate": f"%{{y:.3g}} {unit}",
            }
        )
        domain = [max(0.0, top - room + GAP), top]
        axes[f"yaxis{number}"] = {**log_axis(unit, LOWEST_SHOWN * high, 4.0 * high), "domain": domain}
        notes.append(
            {
                "x": 0.995, "xref": "paper", "xanchor": "right",
                "y": top - 0.008, "yref": "paper", "yanchor": "top",
                "text": f"<b>{name}</b>", "showarrow": False, "font": {"color": colour, "size": 13},
                "bgcolor": "rgba(255,255,255,0.8)",
            }
        )  # fmt: skip
    shapes, marks = _marks(data, low, TOP_HZ)
    last = "" if len(found) == 1 else str(len(found))
    look = layout(
        xaxis={**log_axis("frequency in Hz", low, TOP_HZ, labels=(1, 2, 5)), "anchor": f"y{last}"},
        **axes,
        shapes=shapes,
        annotations=[*marks, *notes],
        hoversubplots="axis",
    )
    resolution = ", ".join(sorted({f"{s.resolution:.2g}" for _, s in found}))
    caption = (
        f"By Welch's method with Hann windows, resolution {resolution} Hz; each panel spans eight "
        "decades. Dotted: "
        "natural frequencies of the reduced model (f1, f2, ...), and the peak of the sea (1/Tp)."
    )
    title = "Spectra of the waves and of the response"
    return Figure("spectrum", title, caption, traces, look, height=90 + PANEL * len(found))


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
                "font": {"color": colour, "size": 12},
            }
        )
    return shapes, notes
