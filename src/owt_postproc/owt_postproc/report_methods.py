"""What computed a run, method by method, each with its source."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from owt_postproc.report_data import ReportData
from owt_postproc.report_usage import Usage, usage_of

__all__ = ["fatigue_methods", "methods"]


def methods(data: ReportData) -> list[tuple[str, str, str]]:
    """Step, method and source of a run's results, in the order of the chain."""
    return [
        *_sea(data.case),
        *_structure(data.case, data.reduced.reduction),
        *fatigue_methods(usage_of(data.fatigue, data.reduced.end_name)),
    ]


def _sea(case: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    wave, regular = case.get("wave") or {}, case.get("regular")
    if regular:
        waves = (f"regular wave, {regular.get('theory', 'stream')}", "docs/theory.md")
    elif wave.get("order", 2) == 2:
        waves = ("irregular waves of second order, sum and difference terms", "Sharma and Dean 1981")
    else:
        waves = ("linear irregular waves", "docs/theory.md")
    return [
        ("waves", *waves),
        ("above still water", f"{wave.get('stretching', 'taylor')} extrapolation", "docs/theory.md"),
        ("wave loads", "Morison's equation, normal to the member", "Morison et al. 1950"),
    ]


def _structure(case: Mapping[str, Any], reduction: str) -> list[tuple[str, str, str]]:
    structure = case.get("structure") or {}
    integrator = str(structure.get("integrator", "newmark"))
    return [
        (
            "reduction",
            f"{reduction}: fixed-interface modes (CB) and modal truncation vectors (M) of the loads",
            "Craig and Bampton 1968; Dickens et al. 1997",
        ),
        ("time integration", integrator, "Newmark 1959" if "newmark" in integrator else "docs/theory.md"),
        ("stress", "section forces of the member ends, fixed-end forces included", "docs/theory.md"),
    ]


def fatigue_methods(usage: Usage) -> list[tuple[str, str, str]]:
    """Step, method and source of what turns stress into damage."""
    joints, walls = usage.curve, usage.wall_curve
    rows = []
    if any(usage.end_kind):
        rows.append(
            (
                "hot spots",
                "eight points on the chord side and on the brace side of each brace end, Efthymiou's stress "
                "concentration factors and influence functions, superposition",
                "Efthymiou 1988; DNV-RP-C203, 3.3 and appendix B",
            )
        )
    rows += [
        (
            "other ends",
            f"signed normal stress at eight points of the wall, one factor {usage.wall_scf:g}",
            "docs/theory.md",
        ),
        (
            "cycles",
            "rainflow of every integration step, residue as half cycles",
            "ASTM E1049-85 (2017)",
        ),
        ("S-N curve", f"{joints.name}: {joints.description}", f"{joints.edition} {joints.source}"),
    ]
    if walls != joints:
        rows.append(
            ("S-N curve of walls", f"{walls.name}: {walls.description}", f"{walls.edition} {walls.source}")
        )
    return [
        *rows,
        ("damage", "sum of n/N, no mean-stress correction", "Palmgren 1924; Miner 1945"),
        (
            "total stress",
            "sum of range × count of the unsigned von Mises stress, no damage",
            "thesis, chapter 5",
        ),
        (
            "figures",
            "series thinned out where a caption says so, in single precision; tables from all samples",
            "this report",
        ),
    ]
