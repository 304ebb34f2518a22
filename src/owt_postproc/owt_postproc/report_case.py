"""Facts of a run for its report: the case, as far as it differs from the defaults, model, modes, fatigue."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from owt_model.config import SEA_SOURCES, CaseConfig
from owt_model.wind_config import RotorConfig
from owt_postproc.report_data import ReportData

__all__ = ["case_facts", "report_facts"]

#: Parts of a case that other tables of the report show, or that do not change a result.
ELSEWHERE = ("points_m", "stream")
#: Numbers of a list that are still written out.
SHORT = 6


def _flat(prefix: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Dotted names and values."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(f"{prefix}.{key}" if prefix else str(key), inner)
    else:
        yield prefix, value


def _numbers(value: Any) -> int:
    return sum(map(_numbers, value)) if isinstance(value, list | tuple) else 1


def _shown(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return str(value) if _numbers(value) <= SHORT else f"{len(value)} entries"
    return "on" if value is True else "off" if value is False else value


def case_facts(case: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Key and value of everything in `case` that is not the default, and of all that gives its sea.

    Parameters
    ----------
    case : mapping
        A case file as plain data; keys that it lacks have their defaults.
    """
    default = dict(_flat("", CaseConfig().model_dump(mode="json")))
    default |= dict(_flat("wind.thrust.rotor", RotorConfig().model_dump(mode="json")))
    source = [name for name in SEA_SOURCES if case.get(name) is not None]
    return [
        (name, _shown(value))
        for name, value in _flat("", {key: part for key, part in case.items() if key not in ELSEWHERE})
        if value is not None
        and (value != default.get(name) or (source and name.split(".")[0] == source[0] != "sea_state"))
    ]


def report_facts(data: ReportData) -> list[tuple[str, Iterable[tuple[str, Any]]]]:
    """Titles, keys and values of what the report says in tables of two columns."""
    curve, wall, reduced = data.fatigue.curve, data.fatigue.wall_curve, data.reduced
    labels = {
        "hs_m": "significant wave height, m", "tp_s": "peak period, s", "gamma": "peak enhancement",
        "direction_deg": "direction the waves travel to, °", "seed": "seed", "order": "wave order",
        "stretching": "above still water", "cutoff_rad_s": "highest component, rad/s",
        "water_depth_m": "water depth, m", "duration_s": "duration, s",
    }  # fmt: skip
    structure: Mapping[str, Any] = data.case.get("structure", {})
    return [
        ("Sea state", [(labels.get(key, key), v) for key, v in data.sea_state.items() if v is not None]),
        (
            "Structure",
            [
                ("model", reduced.model_name),
                ("content hash", reduced.model_hash[:16]),
                ("reduction", reduced.reduction),
                ("generalised coordinates", len(reduced.coordinate_name)),
                ("integration step, s", structure.get("dt_s", "-")),
                *(("note", note) for note in reduced.notes),
            ],
        ),
        (
            "Fatigue",
            [
                ("S-N curve of joints", f"{curve.name} ({curve.description})"),
                ("S-N curve of walls", f"{wall.name} ({wall.description})"),
                ("stress concentration factor of walls", data.fatigue.scf),
                ("member ends, hot spots", f"{len(reduced.end_name)}, {data.fatigue.hot_spots.n_spots}"),
                ("samples per hot spot", data.fatigue.samples),
                *(("note", note) for note in data.fatigue.hot_spots.notes),
            ],
        ),
        ("Case, where it is not the default", case_facts(data.case) or [("all defaults", "-")]),
        ("Versions", list(data.versions.items()) or [("not recorded", "-")]),
    ]
