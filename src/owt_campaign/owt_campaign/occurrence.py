"""Probability of each row of a load-case table: published with it, or by an assumed wave rose.

A table tells it in a column ``probability`` or ``occurrence``. Thesis table 4.5 does not; of its twelve
directions only 330 deg has a published scatter diagram (table 4.4). For such tables the share of each
direction comes from a wave rose in a file, and the heights within each direction are spread as in table 4.4,
over the rows that the table has: both are assumptions, and everything that rests on them says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from owt_campaign.load_cases import LoadCaseTable, read_csv, shipped_table
from owt_campaign.scatter import Scatter, read_scatter
from owt_model.errors import InputError

__all__ = ["ASSUMED_ROSE", "Occurrence", "WaveRose", "read_rose", "table_occurrence"]

ASSUMED_ROSE = "wave_rose_assumed.csv"
#: Sum of a column of probabilities that is taken for 1: cells have a few digits.
SUM_TOLERANCE = 1e-6


@dataclass(frozen=True)
class WaveRose:
    """Share of time of wave directions.

    Attributes
    ----------
    name : str
        File name.
    direction_deg, share : float arrays [sector]
        Centres of the sectors (from, clockwise from north), and their shares, which sum to 1.
    """

    name: str
    direction_deg: Float[np.ndarray, " sector"]
    share: Float[np.ndarray, " sector"]

    def sector(self, direction_deg: float) -> int:
        """The sector whose centre is nearest."""
        apart = np.abs((self.direction_deg - direction_deg + 180.0) % 360.0 - 180.0)
        return int(np.argmin(apart))


@dataclass(frozen=True)
class Occurrence:
    """Probability of each row of a table.

    Attributes
    ----------
    probability : float array [row]
        Share of time of each row; they sum to 1 at most.
    source : str
        One sentence that says where it comes from.
    assumed : bool
        Whether it rests on an assumption.
    """

    probability: Float[np.ndarray, " row"]
    source: str
    assumed: bool

    @property
    def without(self) -> list[int]:
        """Places of rows that count nothing."""
        return np.flatnonzero(self.probability == 0.0).tolist()


def read_rose(path: str | Path) -> WaveRose:
    """Read a wave rose: a CSV file with columns ``direction_deg`` and ``share``.

    Raises
    ------
    InputError
        If it is none: a column is missing, a share negative, or their sum not 1.
    """
    head, rows, _ = read_csv(path, what="wave rose")
    if sorted(head) != ["direction_deg", "share"]:
        raise InputError(
            "wave rose", ",".join(head), "must have columns direction_deg, share", "See docs/campaigns.md."
        )
    cells = np.array(
        [[_number(n, name, c) for name, c in zip(head, row, strict=True)] for n, row in enumerate(rows, 1)]
    )
    direction, share = (cells[:, head.index(name)] for name in ("direction_deg", "share"))
    for n, value in enumerate(direction.tolist()):
        if value > 360.0 or value % 360.0 in direction[:n] % 360.0:
            raise InputError(
                "wave rose, direction_deg", value, "must lie between 0 and 360, once each", "Join its shares."
            )
    if abs(share.sum() - 1.0) > SUM_TOLERANCE:
        raise InputError(
            "wave rose", float(share.sum()), "is the sum of its shares, and must be 1", "Scale them."
        )
    return WaveRose(Path(path).name, direction, share)


def _number(row: int, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not (np.isfinite(value) and value >= 0.0):
        raise InputError(f"row {row}, {name}", text, "must be a finite number, 0 or more", "Check the cell.")
    return value


def table_occurrence(table: LoadCaseTable, rose: WaveRose | None = None) -> Occurrence:
    """Probability of each row.

    Parameters
    ----------
    table : LoadCaseTable
        The table.
    rose : WaveRose, optional
        Shares of the directions, whatever the table says; where left out, a column ``probability`` or
        ``occurrence`` of the table counts, and without one the assumed rose that comes with this package.

    Raises
    ------
    InputError
        If a probability is no number, or they sum to more than 1.
    """
    if rose is None:
        for name in ("probability", "occurrence"):
            if name in table.columns:
                return _from_column(table, name)
        rose = read_rose(shipped_table(ASSUMED_ROSE))
    heights = read_scatter(shipped_table("scatter_330deg.csv"))
    probability = np.zeros(len(table.rows))
    for sector, share in enumerate(rose.share):
        places = [
            i
            for i, row in enumerate(table.rows)
            if row.problem is None and rose.sector(row.direction_deg) == sector
        ]
        probability[places] = share * _height_shares([table.rows[i].hs_m for i in places], heights)
    return Occurrence(
        probability,
        f"ASSUMED: shares of directions of {rose.name}; heights in each as in thesis table 4.4 (330 deg)",
        assumed=True,
    )


def _height_shares(heights: list[float], scatter: Scatter) -> Float[np.ndarray, " place"]:
    """Share of each height among those given; those of one bin of the diagram get equal parts."""
    shares = np.zeros(len(heights))
    low, high = scatter.height[:, 0], scatter.height[:, 1]
    bins = np.array(
        [int(np.argmax((low <= h) & (h < high))) if low.min() <= h < high.max() else -1 for h in heights]
    )
    for place, count in enumerate(scatter.occurrence.sum(axis=1)):
        here = bins == place
        if here.any():
            shares[here] = count / here.sum()
    total = shares.sum()
    return shares / total if total > 0.0 else shares


def _from_column(table: LoadCaseTable, name: str) -> Occurrence:
    values = np.array([_number(row.row, name, row.extra[name]) for row in table.rows])
    total = float(values.sum())
    if total <= 0.0:
        raise InputError(name, total, "is the sum of the column, and must be above 0", "Check the table.")
    if name == "occurrence":
        return Occurrence(values / total, "column occurrence of the table, over its sum", assumed=False)
    if total > 1.0 + SUM_TOLERANCE:
        raise InputError(name, total, "is the sum of the column, and must be 1 at most", "Scale it.")
    return Occurrence(values, f"column probability of the table, which sums to {total:.6g}", assumed=False)
