"""Totals of a campaign over its cases, weighted by the probability of their sea states.

Damage is added up for each hot spot before the largest is looked for: spots that are worst in different seas
do not add. The mean over the seeds of a row counts; a row without any finished seed counts nothing, and
the probability that is covered says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.engine import CaseOutcome

__all__ = ["YEAR_S", "OrderTotals", "TotalsBuilder"]

#: Julian year.
YEAR_S = 365.25 * 86400.0


@dataclass(frozen=True)
class OrderTotals:
    """Totals of one wave order.

    Attributes
    ----------
    covered : float
        Probability of the rows that count.
    damage_per_year : float array [spot]
    damage_error_per_year : float array [spot]
        Standard error of `damage_per_year` by the scatter of the seeds, which are independent from row to
        row; NaN where a row that counts has one seed.
    total_stress_per_year : float array [end]
        Sum of range x count in Pa of the von Mises stress.
    cycles_per_year : float array [spot, bin]
    row_damage_per_year : float array [row, spot]
        Share of each row in `damage_per_year`.
    von_mises_cycles_per_year : float array [end]
    max_range : float array [spot]
        Largest range in Pa of all cases.
    """

    covered: float
    damage_per_year: Float[np.ndarray, " spot"]
    damage_error_per_year: Float[np.ndarray, " spot"]
    total_stress_per_year: Float[np.ndarray, " end"]
    cycles_per_year: Float[np.ndarray, "spot bin"]
    row_damage_per_year: Float[np.ndarray, "row spot"]
    von_mises_cycles_per_year: Float[np.ndarray, " end"]
    max_range: Float[np.ndarray, " spot"]

    def relative_error(self, spot: int) -> float:
        """Standard error of the damage of a hot spot by the scatter of the seeds, over the damage."""
        damage = float(self.damage_per_year[spot])
        return float(self.damage_error_per_year[spot]) / damage if damage > 0.0 else float("nan")

    def life_years(self, design_fatigue_factor: float) -> Float[np.ndarray, " spot"]:
        """Years until the damage times the design fatigue factor is 1; inf without damage."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / (design_fatigue_factor * self.damage_per_year))


class TotalsBuilder:
    """Adds up outcomes of one wave order, row by row.

    Parameters
    ----------
    probability : float array [row]
        Of the rows.
    """

    def __init__(self, probability: Float[np.ndarray, " row"]) -> None:
        self._probability = probability
        self._damage: np.ndarray | None = None
        self._covered = 0.0

    def add_row(self, row: int, outcomes: list[CaseOutcome]) -> None:
        """Add the finished seeds of a row, once."""
        if not outcomes:
            return
        per_year = [YEAR_S / _record_s(outcome) for outcome in outcomes]
        weight = self._probability[row] / len(outcomes)
        damage, stress, cycles, unsigned = (
            weight
            * np.sum([f * getattr(o.fatigue, name) for f, o in zip(per_year, outcomes, strict=True)], axis=0)
            for name in ("damage", "total_stress", "histogram", "von_mises_cycles")
        )
        if self._damage is None:
            self._damage = np.zeros((len(self._probability), len(damage)))
            self._variance = np.zeros(len(damage))
            self._stress, self._cycles = np.zeros_like(stress), np.zeros_like(cycles)
            self._unsigned, self._largest = np.zeros_like(unsigned), np.zeros_like(damage)
        self._damage[row] = damage
        if weight > 0.0:
            each = [f * o.fatigue.damage for f, o in zip(per_year, outcomes, strict=True)]
            n = len(outcomes)
            self._variance += weight**2 * n * np.var(each, axis=0, ddof=1) if n > 1 else np.nan
        self._stress += stress
        self._cycles += cycles
        self._unsigned += unsigned
        for outcome in outcomes:
            self._largest = np.maximum(self._largest, outcome.fatigue.max_range)
        self._covered += float(self._probability[row])

    def totals(self) -> OrderTotals | None:
        """The totals; None if no row was added."""
        if self._damage is None:
            return None
        whole = self._damage.sum(axis=0)
        return OrderTotals(
            covered=self._covered,
            damage_per_year=whole,
            damage_error_per_year=np.sqrt(self._variance),
            total_stress_per_year=self._stress,
            cycles_per_year=self._cycles,
            row_damage_per_year=self._damage,
            von_mises_cycles_per_year=self._unsigned,
            max_range=self._largest,
        )


def _record_s(outcome: CaseOutcome) -> float:
    """Length of the record that was counted, in s."""
    return outcome.case.time.duration_s
