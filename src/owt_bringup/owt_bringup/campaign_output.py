"""What a campaign tells while it runs and when it is done."""

from __future__ import annotations

import re
import sys
import time
from pathlib import Path
from typing import Any, Self

import numpy as np

from owt_bringup.results import print_table
from owt_bringup.sea_notes import case_warnings
from owt_campaign.campaign import CampaignResult
from owt_campaign.runner import CaseRecord

__all__ = ["CampaignProgress", "print_outcome", "summary", "warning_lines"]

#: Seconds between two lines where there is no terminal.
INTERVAL = 10.0
#: Failed cases that are printed; summary.json names all.
SHOWN = 20


class CampaignProgress:
    """Cases done, rate, time left and failures: one line on a terminal, or a line now and then elsewhere.

    Parameters
    ----------
    cases : int
        Cases in all.
    """

    def __init__(self, cases: int) -> None:
        self._cases, self._done, self._reused, self._failed = cases, 0, 0, 0
        self._begin = self._computing = time.perf_counter()
        self._shown = 0.0
        self._terminal = sys.stderr.isatty()

    def __enter__(self) -> Self:
        """Begin to count the time."""
        return self

    def __exit__(self, *details: object) -> None:
        """Leave the terminal on a clean line."""
        if self._terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    @property
    def elapsed(self) -> float:
        """Seconds since the begin."""
        return time.perf_counter() - self._begin

    def started(self, place: str) -> None:
        """Say where the work is done."""
        self._computing = time.perf_counter()
        print(
            f"campaign: {self._cases - self._done} cases to compute, {self._done} there; {place}",
            file=sys.stderr,
        )

    def done(self, record: CaseRecord) -> None:
        """Count a case."""
        self._done += 1
        self._reused += record.reused
        self._failed += record.status == "failed"
        now = time.perf_counter()
        every = 0.1 if self._terminal else INTERVAL
        if record.reused or (now - self._shown < every and self._done < self._cases):
            return
        self._shown = now
        end, line = ("", f"\r\033[K{self._line(now)}") if self._terminal else ("\n", self._line(now))
        print(line, end=end, file=sys.stderr, flush=True)

    def _line(self, now: float) -> str:
        computed = self._done - self._reused
        rate = computed / max(now - self._computing, 1e-9)
        left = (self._cases - self._done) / max(rate, 1e-9)
        return (
            f"campaign: {self._done} of {self._cases} cases, {60.0 * rate:.1f} a minute, "
            f"{_duration(left)} left, {self._failed} failed"
        )


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def summary(result: CampaignResult, elapsed: float) -> dict[str, Any]:
    """The campaign as plain numbers."""
    plan = result.plan
    rows = plan.table.rows
    numbers: dict[str, Any] = {
        "cases": len(plan.cases) + len(plan.refused),
        "computed": result.computed,
        "reused": result.reused,
        "failed": [
            {
                "row": rows[place.row].row, "seed": place.seed, "order": place.order, "full": place.full,
                "name": plan.name(place), "message": message,
            }
            for place, message in sorted(result.failed.items(), key=lambda item: _place_order(item[0]))
        ],
        "distrusted": result.distrusted,
        "elapsed_s": elapsed,
        "table": plan.table.name,
        "occurrence": plan.occurrence.source,
        "occurrence_assumed": plan.occurrence.assumed,
        "warnings": _warnings(result),
        "totals": {},
    }  # fmt: skip
    if result.seconds:
        numbers["seconds_per_case"] = {
            "mean": float(np.mean(result.seconds)), "largest": float(np.max(result.seconds))
        }  # fmt: skip
        numbers["worker_peak_memory_mib"] = float(np.max(result.peak_memory_mib))
    if result.sample is not None:
        factor = result.sample.case.fatigue.design_fatigue_factor
        numbers["design_fatigue_factor"] = factor
        spots = result.sample.fatigue.hot_spots
        for order, totals in result.totals.items():
            worst = int(np.argmax(totals.damage_per_year))
            life, error = float(totals.life_years(factor)[worst]), totals.relative_error(worst)
            numbers["totals"][str(order)] = {
                "probability_covered": totals.covered,
                "worst_spot": spots.name[worst],
                "damage_per_year": float(totals.damage_per_year[worst]),
                "relative_standard_error": error if np.isfinite(error) else None,
                "life_years": life if np.isfinite(life) else None,
                "total_stress_per_year_pa": float(totals.total_stress_per_year.sum()),
            }
    return numbers


def _error(total: dict[str, Any]) -> str:
    error = total["relative_standard_error"]
    return "" if error is None else f" +- {error:.1%} (standard error, by the seeds)"


def _coverage(result: CampaignResult, numbers: dict[str, Any]) -> list[str]:
    """What of the table counts nothing, in words."""
    rows, lines = result.plan.table.rows, []
    without = [str(rows[place].row) for place in result.plan.occurrence.without if not rows[place].problem]
    if without:
        more = f" and {len(without) - SHOWN} more" if len(without) > SHOWN else ""
        lines.append(
            f"without probability, so that they count nothing: row {', '.join(without[:SHOWN])}{more}"
        )
    for order, total in numbers["totals"].items():
        if total["probability_covered"] < 1.0 - 1e-6:
            lines.append(
                f"order {order}: the sea states that count have a probability of "
                f"{total['probability_covered']:.4g} together, not 1"
            )
    return lines


def _warnings(result: CampaignResult) -> list[dict[str, Any]]:
    """Models used outside their range: the rows and one of their sentences, by kind of warning."""
    structure = None if result.mesh is None else result.mesh.structure
    plan = result.plan
    found: dict[str, list[tuple[int, str]]] = {}
    seed, order = plan.seeds[0], max(plan.orders)
    for place, case in zip(plan.places, plan.cases, strict=True):
        if place.full or (place.seed, place.order) != (seed, order) or place in result.failed:
            continue
        for sentence in case_warnings(case, structure):
            kind = re.sub(r"[-+]?[0-9][0-9.e+-]*", "#", sentence)
            found.setdefault(kind, []).append((plan.table.rows[place.row].row, sentence))
    return [{"rows": [row for row, _ in some], "example": some[0][1]} for some in found.values()]


def warning_lines(numbers: dict[str, Any]) -> list[str]:
    """The warnings of :func:`summary` in words."""
    return [
        f"in {len(warning['rows'])} of the rows, row {warning['rows'][0]} for one: {warning['example']}"
        for warning in numbers["warnings"]
    ]


def _place_order(place: Any) -> tuple[int, int, int, bool]:
    return (place.row, place.order, place.seed, place.full)


def print_outcome(result: CampaignResult, numbers: dict[str, Any], folder: Path) -> None:
    """Print the short table, what is assumed, and the cases that failed."""
    rows = [
        ("cases", f"{result.computed} computed, {result.reused} reused, {len(result.failed)} failed"),
        ("elapsed", _duration(numbers["elapsed_s"])),
    ]
    for order, total in numbers["totals"].items():
        life = "unlimited" if total["life_years"] is None else f"{total['life_years']:.3g} years"
        rows.append(
            (
                f"order {order}",
                f"damage {total['damage_per_year']:.3e}{_error(total)} a year, life {life}, "
                f"at {total['worst_spot']}",
            )
        )
    rows.append(("results", str(folder)))
    print_table(rows)
    print(f"note: probability of the sea states: {numbers['occurrence']}", file=sys.stderr)
    for line in _coverage(result, numbers):
        print(f"note: {line}", file=sys.stderr)
    for line in warning_lines(numbers):
        print(f"warning: {line}", file=sys.stderr)
    if result.distrusted:
        print(
            f"note: {result.distrusted} results did not fit their checksum; computed again", file=sys.stderr
        )
    for failed in numbers["failed"][:SHOWN]:
        print(f"failed: {failed['name']}: {failed['message']}", file=sys.stderr)
    if len(numbers["failed"]) > SHOWN:
        print(f"failed: {len(numbers['failed']) - SHOWN} more, see summary.json", file=sys.stderr)
