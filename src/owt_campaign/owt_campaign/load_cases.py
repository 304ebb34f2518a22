"""Load-case tables: one sea state per row, read from CSV, as cases of the configuration.

Needed are the columns ``hs_m``, ``direction_deg`` and ``tp_s``; all others are carried along. The direction
is that of metocean tables: where the waves come from, clockwise from north. Lines that begin with ``#`` are
comments. A row that cannot be a case does not stop the others: it says what is wrong with it.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError

__all__ = [
    "COLUMNS",
    "LoadCase",
    "LoadCaseTable",
    "case_of",
    "german_bight",
    "own_seed",
    "read_csv",
    "read_load_cases",
    "shipped_table",
    "towards_deg",
]

COLUMNS = ("hs_m", "direction_deg", "tp_s")


@dataclass(frozen=True)
class LoadCase:
    """One row of a load-case table.

    Attributes
    ----------
    row : int
        Number of the row, from 1, comments and heading not counted.
    hs_m, direction_deg, tp_s : float
        Sea state, its direction as metocean tables give it; NaN where the cell is no number.
    extra : mapping
        The other columns, as text.
    problem : InputError, optional
        What is wrong with the row.
    """

    row: int
    hs_m: float
    direction_deg: float
    tp_s: float
    extra: Mapping[str, str] = field(default_factory=dict)
    problem: InputError | None = None

    def own_seed(self, seed: int) -> int:
        """Seed of the random numbers of its `seed`-th realisation, see :func:`own_seed`."""
        return own_seed(self.hs_m, self.tp_s, self.direction_deg, seed)

    @property
    def label(self) -> str:
        """Name for people."""
        return f"row {self.row} (Hs {self.hs_m:g} m, Tp {self.tp_s:g} s, from {self.direction_deg:g} deg)"


@dataclass(frozen=True)
class LoadCaseTable:
    """A load-case table.

    Attributes
    ----------
    name : str
        Where it comes from.
    rows : tuple of LoadCase
    comments : tuple of str
        Comment lines of the file, without their ``#``.
    """

    name: str
    rows: tuple[LoadCase, ...]
    comments: tuple[str, ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The other columns."""
        return tuple(self.rows[0].extra)


def towards_deg(metocean_deg: float) -> float:
    """Direction that waves travel to, from +x (north) towards +y (west), of a metocean direction, in degrees.

    b = (180 - direction) mod 360: 330 becomes 210.
    """
    return (180.0 - metocean_deg) % 360.0


def read_csv(path: str | Path, *, what: str) -> tuple[list[str], list[list[str]], tuple[str, ...]]:
    """Heading, rows and comments of a CSV file; each row has as many cells as the heading.

    Raises
    ------
    InputError
        If the file cannot be read, has no heading or no row, a column twice, or a row of another length.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not UTF-8 text"
        raise InputError(what, str(path), f"cannot be read ({reason})", "Give a readable CSV file.") from None
    lines = text.splitlines()
    comments = tuple(line.lstrip("# ").rstrip() for line in lines if line.lstrip().startswith("#"))
    body = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    try:
        table = [
            [cell.strip() for cell in row] for row in csv.reader(io.StringIO("\n".join(body)), strict=True)
        ]
    except csv.Error as error:
        raise InputError(what, str(path), f"is not CSV ({error})", "Check its quotes and commas.") from None
    if len(table) < 2:
        raise InputError(what, str(path), "has no row below its heading", "Give one row or more.")
    head = table[0]
    for name in head:
        if head.count(name) > 1:
            raise InputError(what, name, "names two columns of its heading", "Keep one of them.")
    for number, row in enumerate(table[1:], 1):
        if len(row) != len(head):
            raise InputError(
                f"{what}, row {number}",
                len(row),
                f"must have {len(head)} cells, as the heading",
                "Check its commas.",
            )
    return head, table[1:], comments


def read_load_cases(path: str | Path) -> LoadCaseTable:
    """Read a load-case table.

    Raises
    ------
    InputError
        As :func:`read_csv`; if a needed column is missing. A cell that is no number only spoils its row.
    """
    head, rows, comments = read_csv(path, what="load-case table")
    for name in COLUMNS:
        if name not in head:
            raise InputError(
                "load-case table",
                ",".join(head),
                f"has no column {name}",
                f"Name columns {', '.join(COLUMNS)}.",
            )
    found = tuple(_row(number, dict(zip(head, row, strict=True))) for number, row in enumerate(rows, 1))
    return LoadCaseTable(str(path), found, comments)


def shipped_table(name: str) -> Path:
    """Path of a table that comes with this package."""
    return Path(str(resources.files("owt_campaign") / "data" / name))


def german_bight() -> LoadCaseTable:
    """Thesis table 4.5."""
    return read_load_cases(shipped_table("load_cases_german_bight.csv"))


def _row(number: int, cells: dict[str, str]) -> LoadCase:
    values, problem = [], None
    for name in COLUMNS:
        text = cells.pop(name)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            value = math.nan
            refused = InputError(f"row {number}, {name}", text, "must be a finite number", "Check the cell.")
            problem = problem or refused
        values.append(value)
    hs, direction, tp = values
    return LoadCase(number, hs, direction, tp, extra=cells, problem=problem)


def own_seed(hs_m: float, tp_s: float, direction_deg: float, seed: int) -> int:
    """Seed of the random numbers of one sea state, of its `seed`-th realisation.

    Sea states of a table need phases of their own. With the same ones in each, records of all sea states are
    large or small together, and the damage of a table scatters as that of a single record does. The number
    follows from the sea state alone: it is the same in every table, wherever its row stands.

    Parameters
    ----------
    hs_m, tp_s, direction_deg : float
        The sea state, as its table gives it.
    seed : int
        Number of the realisation.

    Returns
    -------
    int
        The first 32 bits of a SHA-256.
    """
    text = f"{float(hs_m)!r} {float(tp_s)!r} {float(direction_deg)!r} {seed}"
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4])


def case_of(
    row: LoadCase, base: Mapping[str, Any] | None = None, *, seed: int, order: int | None = None
) -> CaseConfig:
    """The case of a row.

    Parameters
    ----------
    row : LoadCase
        The row.
    base : mapping, optional
        All else of the case, as a case file holds it.
    seed : int
        Of its sea, and of the wind of ``wind.thrust``. Realisations of a table take
        :meth:`LoadCase.own_seed`.
    order : int, optional
        Wave order, in the place of that of `base`.

    Raises
    ------
    InputError
        If the row is spoiled, or the configuration refuses the case.
    """
    if row.problem is not None:
        raise row.problem
    data: dict[str, Any] = json.loads(json.dumps(dict(base or {})))
    if not 0.0 <= row.direction_deg <= 360.0:
        raise InputError(
            "direction_deg",
            row.direction_deg,
            "must lie between 0 and 360",
            "Give degrees clockwise from north.",
        )
    data["sea_state"] = {
        **(data.get("sea_state") or {}),
        "hs_m": row.hs_m,
        "tp_s": row.tp_s,
        "direction_deg": towards_deg(row.direction_deg),
        "seed": seed,
    }
    thrust = (data.get("wind") or {}).get("thrust")
    if thrust is not None:
        thrust["seed"] = seed
    if order is not None:
        data["wave"] = {**(data.get("wave") or {}), "order": order}
    return parse_case(data)
