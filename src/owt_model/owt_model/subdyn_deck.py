"""Lines, keywords, tables and numbers of a SubDyn input file, and errors that name field and line."""

from __future__ import annotations

import math
import re
from collections.abc import Container
from dataclasses import dataclass
from typing import Any

from owt_model.errors import InputError

__all__ = ["Deck", "Points", "Row"]

Points = dict[str, list[float]]

_TOKEN = re.compile(r"\"[^\"]*\"|'[^']*'|[^\s,;]+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
#: Count keywords (lower case) and the name of the table that follows.
_TABLES = {
    "njoints": "joints",
    "nreact": "reactions",
    "ninterf": "interface",
    "nmembers": "members",
    "npropsets": "sections",
    "npropsetscyl": "sections",
    "ncmass": "masses",
    "nrigidpropsets": "rigid",
    "nspringpropsets": "springs",
    "ncosms": "cosines",
}


@dataclass(frozen=True)
class Row:
    """Tokens of one line, and where it stands."""

    tokens: list[str]
    line: int


class Deck:
    """Lines of a deck with their keywords and tables."""

    def __init__(self, text: str, source: str) -> None:
        self.source = source
        self.rows = [
            Row(_TOKEN.findall(re.split("[!#]", line)[0]), i + 1) for i, line in enumerate(text.splitlines())
        ]
        self.titles = [line.strip().upper() for line in text.splitlines()]

    def refuse(self, field: str, value: Any, limit: str, remedy: str, line: int | None = None) -> InputError:
        """Build the error for a value of this deck."""
        where = f"{self.source}, line {line}: {field}" if line else f"{self.source}: {field}"
        return InputError(where, value, limit, remedy)

    def keyword(self, name: str) -> Row | None:
        """Return the row ``value name`` of a keyword, not looking at the two lines of the title."""
        for row in self.rows[2:]:
            if len(row.tokens) > 1 and row.tokens[1].lower() == name.lower():
                return row
        return None

    def integer(self, text: str, field: str, line: int) -> int:
        """Read a whole number."""
        number = self.number(text, field, line)
        if number != int(number):
            raise self.refuse(field, text, "must be a whole number", "Check the file.", line)
        return int(number)

    def number(self, text: str, field: str, line: int) -> float:
        """Read a finite number, Fortran's exponents included."""
        if not _NUMBER.fullmatch(text):
            raise self.refuse(field, text, "must be a number", "Check the columns of this line.", line)
        value = float(re.sub("[dD]", "e", text))
        if not math.isfinite(value):
            raise self.refuse(field, text, "must be a finite number", "Check the file.", line)
        return value

    def tables(self) -> dict[str, list[Row]]:
        """Return the rows of every table that is imported."""
        found: dict[str, list[Row]] = {}
        title = ""
        for i, row in enumerate(self.rows):
            if self.titles[i].startswith("---"):
                title = self.titles[i]
            name = _TABLES.get(row.tokens[1].lower()) if i > 1 and len(row.tokens) > 1 else None
            if name is None or (name == "sections" and "RECT" in title) or name in found:
                continue
            if not _NUMBER.fullmatch(row.tokens[0]):
                continue  # a keyword in running text
            count = self.integer(row.tokens[0], row.tokens[1], row.line)
            if count < 0:
                raise self.refuse(row.tokens[1], count, "must be at least 0", "Check the file.", row.line)
            first = i + 2 if self._numeric(i + 2) else i + 3  # the oldest files have no line of units
            if first + count > len(self.rows):
                raise self.refuse(
                    row.tokens[1], count, "is more rows than the file has", "Check the file.", row.line
                )
            found[name] = self.rows[first : first + count]
        return found

    def _numeric(self, index: int) -> bool:
        """Whether the line of this index starts with a number."""
        tokens = self.rows[index].tokens if index < len(self.rows) else []
        return bool(tokens) and _NUMBER.fullmatch(tokens[0]) is not None

    def below(self, title: str, place: int) -> Row | None:
        """Return the row at this place below the section with `title`, if it starts with a number."""
        for i, line in enumerate(self.titles[2:], start=2):
            if line.startswith("---") and title in line:
                return self.rows[i + place] if self._numeric(i + place) else None
        return None

    def identifier(self, row: Row, field: str, prefix: str, column: int = 0) -> str:
        """Read a whole number and name it: a joint J1, a member M1."""
        if len(row.tokens) <= column:
            raise self.refuse(
                field, "nothing", "is missing", "Check the number of rows of the table.", row.line
            )
        return f"{prefix}{self.integer(row.tokens[column], field, row.line)}"

    def columns(self, row: Row, names: tuple[str, ...], first: int = 1) -> list[float]:
        """Read the columns `names` of a row."""
        if len(row.tokens) < first + len(names):
            missing = names[max(len(row.tokens) - first, 0)]
            raise self.refuse(missing, "nothing", "is missing", "Check the columns of this line.", row.line)
        return [self.number(row.tokens[first + i], name, row.line) for i, name in enumerate(names)]

    def new(self, name: str, table: Container[str], field: str, line: int) -> None:
        """Refuse a number that is given twice."""
        if name in table:
            raise self.refuse(field, name[1:], "is given twice", "Number them uniquely.", line)

    def known(self, name: str, joints: Container[str], field: str, line: int) -> None:
        """Refuse a joint that the file does not have."""
        if name not in joints:
            raise self.refuse(field, name[1:], "is not a joint of this file", "Check the joint table.", line)

    def flags(self, row: Row, names: tuple[str, ...], first: int = 1) -> list[bool]:
        """Read the flags `names`, as many as there are."""
        flags = []
        for name, text in zip(names, row.tokens[first : first + len(names)], strict=False):
            if text.lower() not in ("0", "1", "t", "f", "true", "false"):
                raise self.refuse(name, text, "must be 0 or 1", "Check the columns of this line.", row.line)
            flags.append(text.lower() in ("1", "t", "true"))
        return flags

    def header(self, rows: list[Row]) -> list[str]:
        """Column names of a table, in lower case."""
        above = rows[0].line - 3
        row = self.rows[above + 1 if self._numeric(above) else above]  # the count stands there
        return [token.lower() for token in row.tokens]
