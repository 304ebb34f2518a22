"""Scatter diagrams, and the load-case tables that are made of them (thesis 4.4.1, 7.3.1).

A scatter diagram is a CSV file: one row per bin of the significant wave height, columns ``hm0_min_m`` and
``hm0_max_m`` with its limits, and one column ``tp_9.5s`` per bin of the peak period, named by its centre,
with the number of occurrences.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float

from owt_campaign.load_cases import LoadCase, LoadCaseTable, read_csv
from owt_model.errors import InputError

__all__ = ["METHODS", "Method", "Scatter", "build_table", "is_scatter", "read_scatter", "table_text"]

Method = Literal["weighted-tp", "weighted-hs", "full"]
METHODS: tuple[Method, ...] = ("weighted-tp", "weighted-hs", "full")
LIMITS = ("hm0_min_m", "hm0_max_m")
_PERIOD = re.compile(r"^tp_([0-9.]+)s?$")
_DIRECTION = re.compile(r"direction\s+([-+0-9.]+)\s*deg", re.IGNORECASE)
#: Narrowest heights in m that a table is split into.
NARROWEST = 0.01


@dataclass(frozen=True)
class Scatter:
    """Occurrences of sea states from one direction.

    Attributes
    ----------
    name : str
        Where it comes from.
    height : float array [height, 2]
        Limits of the bins of the significant wave height in m.
    period : float array [period]
        Centres of the bins of the peak period in s.
    occurrence : float array [height, period]
        Number of occurrences.
    direction_deg : float
        Where the waves come from, clockwise from north.
    """

    name: str
    height: Float[np.ndarray, "height 2"]
    period: Float[np.ndarray, " period"]
    occurrence: Float[np.ndarray, "height period"]
    direction_deg: float

    @property
    def centre(self) -> Float[np.ndarray, " height"]:
        """Centres of the bins of the significant wave height in m."""
        return np.asarray(self.height.mean(axis=1))


def is_scatter(path: str | Path) -> bool:
    """Whether a CSV file has the heading of a scatter diagram.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    head, _, _ = read_csv(path, what="table")
    return all(name in head for name in LIMITS)


def read_scatter(path: str | Path, *, direction_deg: float | None = None) -> Scatter:
    """Read a scatter diagram.

    Parameters
    ----------
    path : path
        The file.
    direction_deg : float, optional
        Its direction; else a comment of the file says it, as in "wave direction 330 deg".

    Raises
    ------
    InputError
        If the file is no scatter diagram, or its direction is not known.
    """
    head, rows, comments = read_csv(path, what="scatter diagram")
    for name in LIMITS:
        if name not in head:
            raise InputError(
                "scatter diagram", ",".join(head), f"has no column {name}", "See docs/campaigns.md."
            )
    places = {name: match for i, name in enumerate(head) if (match := _PERIOD.match(name)) and i >= 0}
    unknown = [name for name in head if name not in places and name not in LIMITS]
    if unknown or not places:
        raise InputError(
            "scatter diagram", unknown[0] if unknown else ",".join(head),
            "names no column of a scatter diagram" if unknown else "has no column of a peak period",
            "Name columns hm0_min_m, hm0_max_m and tp_9.5s, one per period.",
        )  # fmt: skip
    cells = np.array(
        [[_count(n, name, c) for name, c in zip(head, row, strict=True)] for n, row in enumerate(rows, 1)]
    )
    limits = cells[:, [head.index(name) for name in LIMITS]]
    if not ((limits[:, 1] > limits[:, 0]) & (limits[:, 0] >= 0.0)).all():
        raise InputError(
            "hm0_min_m", limits[:, 0].tolist(), "must be 0 or more and below hm0_max_m", "Check the bins."
        )
    lowest = limits[np.argsort(limits[:, 0])]
    if (lowest[1:, 0] < lowest[:-1, 1] - 1e-9).any():
        raise InputError("hm0_min_m", limits[:, 0].tolist(), "has bins that overlap", "Check the bins.")
    occurrence = cells[:, [head.index(name) for name in places]]
    if occurrence.sum() <= 0.0:
        raise InputError("scatter diagram", str(path), "has no occurrence", "Check its cells.")
    period = np.array([_number("tp", match.group(1)) for match in places.values()])
    if (period <= 0.0).any() or len(set(period.tolist())) < len(period):
        raise InputError(
            "scatter diagram", period.tolist(), "has a period twice, or one that is not above 0 s",
            "Check the heading.",
        )  # fmt: skip
    return Scatter(str(path), limits, period, occurrence, _direction(path, comments, direction_deg))


def _direction(path: str | Path, comments: Sequence[str], given: float | None) -> float:
    told = next((m.group(1) for line in comments if (m := _DIRECTION.search(line))), None)
    if given is None and told is None:
        raise InputError(
            "direction",
            None,
            f"is not told by a comment of {path}",
            "Write a comment '# direction 330 deg' into it, or give `owt table` --direction.",
        )
    direction = _number("direction", told) if given is None and told is not None else float(given or 0.0)
    if not 0.0 <= direction <= 360.0:
        raise InputError(
            "direction", direction, "must lie between 0 and 360", "Give degrees clockwise from north."
        )
    return direction


def _number(field: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise InputError(field, text, "must be a finite number", "Check the cell.")
    return value


def _count(row: int, name: str, text: str) -> float:
    value = _number(f"row {row}, {name}", text)
    if value < 0.0:
        raise InputError(f"row {row}, {name}", text, "must be 0 or more", "Check the cell.")
    return value


def build_table(scatter: Scatter, method: Method, *, height_bin_m: float | None = None) -> LoadCaseTable:
    """Make a load-case table of a scatter diagram.

    Parameters
    ----------
    scatter : Scatter
        The diagram.
    method : str
        ``weighted-tp``: one sea state per height, its period the mean weighted by occurrence (thesis 4.4.1).
        ``weighted-hs``: one per period, its height the weighted mean (7.3.1). ``full``: one per cell.
    height_bin_m : float, optional
        With weighted-tp, cut bins of the height into bins of this width, which get equal parts of the
        occurrences and the period of the bin: thesis table 4.5 has 0.5 m.

    Raises
    ------
    InputError
        If the method is not known, or the bins cannot be cut so.
    """
    if method not in METHODS:
        raise InputError("method", method, f"must be one of {', '.join(METHODS)}", "Use weighted-tp.")
    if height_bin_m is not None and method != "weighted-tp":
        raise InputError("hs-bin", height_bin_m, "goes with the method weighted-tp only", "Leave it out.")
    if height_bin_m is not None and not NARROWEST <= height_bin_m < np.inf:
        raise InputError("hs-bin", height_bin_m, f"must be {NARROWEST:g} m or more", "Use 0.5.")
    rows = {"weighted-tp": _by_height, "weighted-hs": _by_period, "full": _by_cell}[method](
        scatter, height_bin_m
    )
    total = scatter.occurrence.sum()
    cases = tuple(
        LoadCase(
            number, hs, scatter.direction_deg, tp,
            {"hs_min_m": f"{low:g}", "hs_max_m": f"{high:g}", "occurrence": f"{count:.10g}",
             "probability": f"{count / total:.10g}"},
        )
        for number, (low, high, hs, tp, count) in enumerate(rows, 1)
    )  # fmt: skip
    return LoadCaseTable(
        f"{Path(scatter.name).name}, {method}",
        cases,
        (
            f"Load-case table, {method}, of {Path(scatter.name).name}: {len(cases)} sea states, "
            f"{total:g} occurrences, direction {scatter.direction_deg:g} deg (from, clockwise from north).",
            "probability is that within this direction.",
        ),
    )


Row = tuple[float, float, float, float, float]


def _by_height(scatter: Scatter, height_bin_m: float | None) -> list[Row]:
    rows = []
    for (low, high), counts in zip(scatter.height, scatter.occurrence, strict=True):
        if not counts.sum():
            continue
        parts = 1 if height_bin_m is None else round((high - low) / height_bin_m)
        if parts < 1 or (height_bin_m is not None and abs(parts * height_bin_m - (high - low)) > 1e-9):
            raise InputError(
                "hs-bin",
                height_bin_m,
                f"does not divide the bin from {low:g} to {high:g} m",
                "Use one that divides all bins, or 0 for those of the diagram.",
            )
        period = float(counts @ scatter.period / counts.sum())
        edges = np.linspace(low, high, parts + 1)
        rows += [
            (float(a), float(b), float(0.5 * (a + b)), period, float(counts.sum() / parts))
            for a, b in itertools.pairwise(edges)
        ]
    return rows


def _by_period(scatter: Scatter, _: float | None) -> list[Row]:
    rows = []
    for period, counts in zip(scatter.period, scatter.occurrence.T, strict=True):
        if counts.sum():
            used = scatter.height[counts > 0.0]
            height = float(counts @ scatter.centre / counts.sum())
            rows.append((float(used.min()), float(used.max()), height, float(period), float(counts.sum())))
    return rows


def _by_cell(scatter: Scatter, _: float | None) -> list[Row]:
    return [
        (float(low), float(high), float(centre), float(period), float(count))
        for (low, high), centre, counts in zip(
            scatter.height, scatter.centre, scatter.occurrence, strict=True
        )
        for period, count in zip(scatter.period, counts, strict=True)
        if count > 0.0
    ]


def table_text(table: LoadCaseTable) -> str:
    """The table as the text of a CSV file."""
    lines = [f"# {comment}" for comment in table.comments]
    lines.append(",".join((*table.columns[:2], "hs_m", "direction_deg", "tp_s", *table.columns[2:])))
    for row in table.rows:
        extra = list(row.extra.values())
        numbers = [f"{value:.8g}" for value in (row.hs_m, row.direction_deg, row.tp_s)]
        lines.append(",".join((*extra[:2], *numbers, *extra[2:])))
    return "\n".join(lines) + "\n"
