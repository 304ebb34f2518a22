"""The load-case table of the case study (thesis table 4.5), as cases of the studies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Float

from owt_campaign.load_cases import german_bight, own_seed, towards_deg
from owt_campaign.occurrence import table_occurrence
from owt_campaign.studies.cases import study_case
from owt_model.config import CaseConfig

__all__ = [
    "WEIGHTS",
    "Cell",
    "cell_case",
    "few_cells",
    "load_case_table",
    "occurrence",
]

#: Direction of the only published scatter diagram (thesis table 4.4).
PUBLISHED_DEG = 330.0
#: Ways to weigh the cells: the assumed wave rose, what is published (direction 330 deg), each the same.
WEIGHTS = ("assumed", "published", "alike")


@dataclass(frozen=True)
class Cell:
    """One sea state of the table: Hs in m, Tp in s, and where the waves come from, clockwise from north."""

    hs_m: float
    from_deg: float
    tp_s: float

    @property
    def to_deg(self) -> float:
        """Direction the waves travel to, from +x (north) towards +y (west)."""
        return towards_deg(self.from_deg)


@cache
def load_case_table() -> tuple[Cell, ...]:
    """The 169 sea states, by rising wave height."""
    return tuple(Cell(row.hs_m, row.direction_deg, row.tp_s) for row in german_bight().rows)


@cache
def _probability() -> dict[Cell, float]:
    """Probability of each sea state of the table by the assumed wave rose."""
    return dict(zip(load_case_table(), table_occurrence(german_bight()).probability.tolist(), strict=True))


def few_cells() -> list[Cell]:
    """What reduced versions of the studies run: two heights of direction 330 deg, and one from 240 deg."""
    chosen = {(1.25, 330.0), (5.25, 330.0), (5.25, 240.0)}
    return [cell for cell in load_case_table() if (cell.hs_m, cell.from_deg) in chosen]


def cell_case(
    cell: Cell, *, seed: int = 1, samples: int = 6000, shared_phases: bool = False, **changes: Any
) -> CaseConfig:
    """Case of a sea state; the rest as :func:`~owt_campaign.studies.cases.study_case`.

    Each sea state has phases of its own, unless `shared_phases` gives all of them those of the seed.
    """
    if not shared_phases:
        seed = own_seed(cell.hs_m, cell.tp_s, cell.from_deg, seed)
    return study_case(
        cell.hs_m, cell.tp_s, seed=seed, direction_deg=cell.to_deg, duration_s=0.1 * samples, **changes
    )


def occurrence(cells: Sequence[Cell], weights: str = "assumed") -> Float[np.ndarray, " cell"]:
    """Probability of each cell among the given ones, which stand for the table.

    Parameters
    ----------
    cells : sequence of Cell
        Sea states.
    weights : str
        One of :data:`WEIGHTS`.
    """
    if weights == "alike":
        return np.full(len(cells), 1.0 / len(cells))
    known = _probability()
    share = np.array([known[cell] for cell in cells])
    published = np.array([cell.from_deg == PUBLISHED_DEG for cell in cells])
    for here, whole in ((published, True), (~published, False)):
        # All of the published direction may be run, and only some of the others: each keeps its share.
        if share[here].any():
            share[here] *= sum(p for c, p in known.items() if (c.from_deg == PUBLISHED_DEG) is whole)
            share[here] /= sum(known[cell] for cell, mine in zip(cells, here, strict=True) if mine)
    if weights == "published":
        share[~published] = 0.0
    return np.asarray(share / share.sum())
