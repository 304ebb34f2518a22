"""Which cases a campaign runs: every row of its table, with every seed and wave order."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from owt_campaign.load_cases import LoadCaseTable, case_of
from owt_campaign.occurrence import Occurrence
from owt_model.config import CaseConfig
from owt_model.errors import InputError

__all__ = ["FULL", "CampaignPlan", "Place", "make_plan"]

#: Reduction whose results the others' errors are measured against.
FULL = "full"


@dataclass(frozen=True)
class Place:
    """Where a case stands in the results; `full` for those that only errors are measured against.

    `seed` counts the realisations of a sea state; its case holds the :meth:`LoadCase.own_seed` of it.
    """

    row: int
    seed: int
    order: int
    full: bool = False


@dataclass(frozen=True)
class CampaignPlan:
    """Cases of a campaign.

    Attributes
    ----------
    table : LoadCaseTable
    occurrence : Occurrence
    seeds, orders : tuple of int
        Seeds and wave orders of every row.
    places : tuple of Place
        Of the cases, in their order.
    cases : tuple of CaseConfig
    refused : dict of Place to str
        Cases that the configuration refuses, and why.
    """

    table: LoadCaseTable
    occurrence: Occurrence
    seeds: tuple[int, ...]
    orders: tuple[int, ...]
    places: tuple[Place, ...]
    cases: tuple[CaseConfig, ...]
    refused: dict[Place, str]

    def name(self, place: Place) -> str:
        """A case for people."""
        full = ", full model" if place.full else ""
        return f"{self.table.rows[place.row].label}, seed {place.seed}, order {place.order}{full}"


def make_plan(
    table: LoadCaseTable,
    occurrence: Occurrence,
    base: Mapping[str, Any],
    *,
    seeds: int,
    orders: Sequence[int],
    against_full: bool = False,
) -> CampaignPlan:
    """Lay out the cases of a campaign.

    Parameters
    ----------
    table : LoadCaseTable
        One sea state per row.
    occurrence : Occurrence
        Probability of each row.
    base : mapping
        All else of the cases, as a case file holds it.
    seeds : int
        Seeds of each row: the one of `base` (1 if it has none) and those after it.
    orders : sequence of int
        Wave orders of each row.
    against_full : bool
        Also run every case on the unreduced model.

    Raises
    ------
    InputError
        If a count is refused.
    """
    if seeds < 1:
        raise InputError("seeds", seeds, "must be 1 or more", "Thesis table 4.5 goes with 3.")
    sea = base.get("sea_state") or {}
    first = sea.get("seed", 1)
    numbers = tuple(range(int(first), int(first) + seeds))
    unreduced = _with_reduction(base, FULL)
    places, cases, refused = [], [], {}
    for row, load_case in enumerate(table.rows):
        for order in orders:
            for seed in numbers:
                for full in (False, True) if against_full else (False,):
                    place = Place(row, seed, order, full)
                    given = unreduced if full else base
                    try:
                        case = case_of(load_case, given, seed=load_case.own_seed(seed), order=order)
                    except InputError as error:
                        refused[place] = " ".join(str(error).split())
                        continue
                    places.append(place)
                    cases.append(case)
    return CampaignPlan(table, occurrence, numbers, tuple(orders), tuple(places), tuple(cases), refused)


def _with_reduction(base: Mapping[str, Any], reduction: str) -> dict[str, Any]:
    changed = copy.deepcopy(dict(base))
    changed["structure"] = {**(changed.get("structure") or {}), "reduction": reduction}
    return changed
