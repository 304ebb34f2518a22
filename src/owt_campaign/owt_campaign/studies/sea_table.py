"""The load-case table of the case study (thesis table 4.5), as cases of the studies."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import study_case
from owt_model.config import CaseConfig

__all__ = ["WEIGHTS", "Cell", "cell_case", "few_cells", "load_case_table", "occurrence"]

#: Occurrences per 1 m of Hs of direction 330 deg, the only ones published (thesis table 4.4).
PUBLISHED_DEG = 330.0
PUBLISHED = (8226, 14005, 5918, 2141, 918, 399, 107, 19, 11, 5, 0)
#: Ways to weigh the cells: by the assumed wave rose, by what is published, or each the same.
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
        return (180.0 - self.from_deg) % 360.0


@cache
def load_case_table() -> tuple[Cell, ...]:
    """The 169 sea states, by rising wave height."""
    text = (resources.files("owt_campaign") / "data" / "load_cases.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    return tuple(Cell(float(r["hs_m"]), float(r["direction_deg"]), float(r["tp_s"])) for r in rows)


def few_cells() -> list[Cell]:
    """What reduced versions of the studies run: four heights of direction 330 deg, and one from 240 deg."""
    chosen = {(1.25, 330.0), (3.25, 330.0), (5.25, 330.0), (8.25, 330.0), (5.25, 240.0)}
    return [cell for cell in load_case_table() if (cell.hs_m, cell.from_deg) in chosen]


def cell_case(cell: Cell, *, seed: int = 1, samples: int = 6000, **changes: Any) -> CaseConfig:
    """Case of a sea state; the rest as :func:`~owt_campaign.studies.cases.study_case`."""
    return study_case(
        cell.hs_m, cell.tp_s, seed=seed, direction_deg=cell.to_deg, duration_s=0.1 * samples, **changes
    )


def occurrence(cells: Sequence[Cell], weights: str = "assumed") -> Float[np.ndarray, " cell"]:
    """Probability of each cell among the given ones.

    Parameters
    ----------
    cells : sequence of Cell
        Sea states.
    weights : str
        One of :data:`WEIGHTS`.
    """
    if weights == "alike":
        share = np.ones(len(cells))
    else:
        # Half of a 1 m bin each; the highest bin, empty in direction 330, counts as one occurrence.
        share = np.array([max(PUBLISHED[int(cell.hs_m)], 1) / 2.0 for cell in cells])
        if weights == "published":
            share[[cell.from_deg != PUBLISHED_DEG for cell in cells]] = 0.0
    return np.asarray(share / share.sum())
