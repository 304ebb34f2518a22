"""The results of a run as plain numbers: for a summary file, a terminal, a report's tables."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_postproc.core.statistics import statistics
from owt_postproc.core.summary import fatigue_summary
from owt_postproc.report_data import ReportData
from owt_postproc.report_measures import power

__all__ = ["head_figures", "series_of", "summary"]


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
        "statistics": {
            key: statistics(series).as_dict(unit) for key, _, series, unit, _, _ in series_of(data)
        },
        "fatigue": fatigue_summary(data.fatigue, reduced, complete=data.complete),
    }
    return result


def series_of(data: ReportData) -> list[tuple[str, str, np.ndarray, str, float, str]]:
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
            power(float(fatigue.damage.max())),
        ),
    ]
