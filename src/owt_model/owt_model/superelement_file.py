"""Reads superelement files: FlexASCII and GuyanASCII of OpenFAST up to 4, and the two files of OpenFAST 5.

Keywords follow an exclamation mark at the start of a line, in any case; a mark followed by a blank starts a
comment. What ExtPtfm would skip or cut without a word (a matrix of another size, lines behind the stated
length) is refused here.
"""

from __future__ import annotations

import math
import re
from array import array
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_model.superelement import INTERFACE, Superelement

__all__ = ["parse_superelement"]

#: Keywords of sections and their names; the longer ones first.
_SECTIONS = {
    "weight constant": "weight constant",
    "weight stiffness": "weight stiffness",
    "mass": "mass matrix",
    "stiffness": "stiffness matrix",
    "damping": "damping matrix",
    "loading": "loads",
    "forcing": "loads",
}
_HEADER = {
    "dimension": "dimension",
    "time increment": "time increment",
    "total simulation time": "total simulation time",
    "nsteps": "number of steps",
}
_FORCE_COLUMNS = re.compile(r"(\d+)\s+force column")
_HINT = "Is this a superelement file of Flex5 or ExtPtfm?"


@dataclass
class _Section:
    """Rows of a section so far, end to end."""

    name: str
    source: str
    line: int
    values: array[float] = field(default_factory=lambda: array("d"))
    width: int = 0

    @property
    def rows(self) -> Float[np.ndarray, "row column"]:
        """The rows; a copy, so that none of it is shared with the array that grows."""
        return np.array(self.values).reshape(-1, max(self.width, 1))


def parse_superelement(text: str, *, source: str, forces: tuple[str, str] | None = None) -> Superelement:
    """Return the superelement that a file describes; its kind is recognised.

    Matrices that are symmetric but for the last digits are made so by their mean. A file without loads gives
    one sample of zero.

    Parameters
    ----------
    text : str
        The file's content.
    source : str
        Its name, for messages.
    forces : tuple of str, optional
        Content and name of the file of loads that OpenFAST 5 has apart.

    Raises
    ------
    InputError
        If the file is malformed; names source, line or section, value, rule and remedy.
    """
    lines = text.splitlines()
    if len(lines) > 1 and lines[1].strip().lower().startswith("#mass"):
        return _guyan(lines, source)
    reader = _Reader()
    reader.read(lines, source)
    if forces is not None:
        reader.read(forces[0].splitlines(), forces[1])
    return reader.finish(source)


def _refuse(source: str, line: int | None, name: str, value: object, limit: str, remedy: str) -> InputError:
    """Build the error for a value of a file."""
    return InputError(f"{source}{'' if line is None else f', line {line}'}: {name}", value, limit, remedy)


def _numbers(text: str, source: str, line: int, name: str) -> list[float]:
    """Return the finite numbers of a line, with Fortran's D for an exponent too."""
    tokens = text.replace(",", " ").split()
    try:
        values = [float(token) for token in tokens]
        if "_" in text:  # Python takes it between digits
            raise ValueError
    except ValueError:
        values = [_number(token, source, line, name) for token in tokens]
    if not math.isfinite(sum(map(abs, values))):
        wrong = next((v for v in values if not math.isfinite(v)), math.inf)
        raise _refuse(source, line, name, wrong, "must be finite", "Check what wrote the file.")
    return values


def _number(token: str, source: str, line: int, name: str) -> float:
    try:
        return float(token.lower().replace("d", "e").replace("_", "x"))
    except ValueError:
        raise _refuse(source, line, name, token, "is not a number", "Check the line.") from None


def _is_number(token: str) -> bool:
    try:
        float(token.strip(",").lower().replace("d", "e"))
    except ValueError:
        return False
    return True


class _Reader:
    """Header and sections of a file with keywords, line by line."""

    def __init__(self) -> None:
        self.header: dict[str, tuple[float, int]] = {}
        self.sections: dict[str, _Section] = {}
        self.comments: list[str] = []
        self._open: _Section | None = None
        self._source = ""

    @property
    def n(self) -> int:
        """Dimension; the header has it before the first section."""
        return int(self.header["dimension"][0])

    def read(self, lines: list[str], source: str) -> None:
        """Add the content of one file."""
        self._source, self._open = source, None
        for i, line in enumerate(lines, 1):
            text = line.strip()
            if text.startswith("!"):
                self._marked(text[1:], i)
            elif text:
                self._row(text, i)

    def finish(self, source: str) -> Superelement:
        """Check that everything is there, and put it together."""
        for name in ("mass matrix", "stiffness matrix", "damping matrix"):
            if name not in self.sections:
                raise _refuse(source, None, name, "nothing", "is missing", _HINT)
        mass, stiffness, damping = (
            self._matrix(f"{name} matrix", self.n) for name in ("mass", "stiffness", "damping")
        )
        dt, loads, elevation = self._loads()
        if "weight constant" in self.sections:
            loads = loads + self._matrix("weight constant", 1)
        if "weight stiffness" in self.sections and self._matrix("weight stiffness", self.n).any():
            place = self.sections["weight stiffness"]
            raise _refuse(
                place.source,
                place.line,
                place.name,
                "not zero",
                "is not supported",
                "Use zeros in its place.",
            )
        return _element(source, mass, stiffness, damping, dt, loads, elevation, tuple(self.comments))

    def _marked(self, text: str, line: int) -> None:
        """A keyword, or a comment."""
        title = text.lower()
        for keyword, name in _SECTIONS.items():
            if title.startswith(keyword):
                return self._start(name, line)
        for keyword, name in _HEADER.items():
            if title.startswith(keyword):
                return self._value(name, text[len(keyword) :], line)
        if not self.sections and "flex 5 format" not in title and text.strip():
            self.comments.append(text.strip())
        return None

    def _start(self, name: str, line: int) -> None:
        if name in self.sections:
            first = self.sections[name].line
            raise _refuse(
                self._source, line, name, "again", f"is in line {first} already", "Keep one of the two."
            )
        if "dimension" not in self.header:
            raise _refuse(self._source, line, "dimension", "nothing", f"is missing before the {name}", _HINT)
        self._open = self.sections[name] = _Section(name, self._source, line)

    def _value(self, name: str, text: str, line: int) -> None:
        columns = _FORCE_COLUMNS.search(text.lower())
        shown = columns[1] if columns else text.split(":", 1)[-1].strip()
        value = (_numbers(shown, self._source, line, name) or [math.nan])[0]
        if name == "dimension":
            known = self.header.get(name)
            if known is not None:
                if value != known[0]:
                    raise _refuse(
                        self._source, line, name, shown, f"is {known[0]:g} in line {known[1]}", "Check both."
                    )
                return
            if not (value.is_integer() and INTERFACE <= value <= 10_000):
                rule = "must be a whole number, 6 to 10000: the interface has six"
                raise _refuse(self._source, line, name, shown, rule, _HINT)
        elif not (value > 0.0 or (value == 0.0 and name == "total simulation time")):
            raise _refuse(self._source, line, name, shown, "must be a number > 0", "Check the header.")
        self.header[name] = (value, line)

    def _row(self, text: str, line: int) -> None:
        """Numbers of a section; words before the first of them, and outside sections, are comments."""
        section = self._open
        if section is None:
            if _is_number(text.split()[0]):
                raise _refuse(self._source, line, "numbers", text, "belong to no section", _HINT)
            return
        if not section.values and text[0].isalpha() and not _is_number(text.split()[0]):
            return
        values = _numbers(text.split("!")[0], self._source, line, section.name)
        n = self.n
        allowed = (n + 1, n + 2) if section.name == "loads" else (n,)
        if len(values) not in allowed or section.width not in (0, len(values)):
            rule = f"must be {section.width or ' or '.join(map(str, allowed))} in a line"
            raise _refuse(
                self._source, line, f"{section.name}, numbers", len(values), rule, "Check dimension and line."
            )
        section.width = len(values)
        section.values.extend(values)

    def _matrix(self, name: str, rows: int) -> Float[np.ndarray, "row column"]:
        section = self.sections[name]
        matrix = section.rows if section.values else np.zeros((0, self.n))
        if len(matrix) != rows:
            raise _refuse(
                section.source,
                section.line,
                f"{name}, lines",
                len(matrix),
                f"must be {rows}",
                "Check dimension and section.",
            )
        return matrix

    def _loads(self) -> tuple[float, Float[np.ndarray, "sample dof"], Float[np.ndarray, " sample"] | None]:
        """Time step, loads and elevation; one zero sample where there are none."""
        n, section = self.n, self.sections.get("loads")
        if section is None:
            return 1.0, np.zeros((1, n)), None
        table = section.rows
        if "number of steps" in self.header:
            expected, rule = round(self.header["number of steps"][0]), "number of steps"
            dt = _step(table[:, 0])
        else:
            for name in ("time increment", "total simulation time"):
                if name not in self.header:
                    raise _refuse(section.source, None, name, "nothing", "is missing in the header", _HINT)
            dt = self.header["time increment"][0]
            expected, rule = round(self.header["total simulation time"][0] / dt) + 1, "total time / step + 1"
        if len(table) != expected or not section.values:
            raise _refuse(
                section.source,
                section.line,
                "loads, lines",
                len(table) if section.values else 0,
                f"must be {expected}, the {rule}",
                "Check the header, or whether the file is complete.",
            )
        _check_time(table[:, 0], dt, section)
        elevation = np.ascontiguousarray(table[:, n + 1]) if table.shape[1] == n + 2 else None
        return dt, np.ascontiguousarray(table[:, 1 : n + 1]), elevation


def _step(time: Float[np.ndarray, " sample"]) -> float:
    """Mean step in s, of the nine digits that times have where those give the last one; 1 for one sample."""
    if len(time) < 2:
        return 1.0
    last, steps = float(time[-1]), len(time) - 1
    short = float(f"{last / steps:.9g}")
    return short if abs(short * steps - last) <= 1e-9 * abs(last) else last / steps


def _check_time(time: Float[np.ndarray, " sample"], dt: float, section: _Section) -> None:
    """Refuse times that are not k dt, but for the few digits that files give them."""
    exact = dt * np.arange(len(time))
    wrong = np.abs(time - exact) > 0.02 * dt + 1e-7 * exact
    if wrong.any():
        i = int(wrong.argmax())
        raise _refuse(
            section.source,
            section.line,
            f"loads, time of sample {i + 1}",
            float(time[i]),
            f"must be {exact[i]:g} s: even steps of {dt:g} s from zero",
            "Interpolate the loads, or shift their times.",
        )


def _element(
    source: str,
    mass: Float[np.ndarray, "dof dof"],
    stiffness: Float[np.ndarray, "dof dof"],
    damping: Float[np.ndarray, "dof dof"],
    dt: float,
    loads: Float[np.ndarray, "sample dof"],
    elevation: Float[np.ndarray, " sample"] | None,
    comments: tuple[str, ...],
) -> Superelement:
    """Build the superelement, its matrices symmetric to the last digit; errors name the file."""
    try:
        Superelement(mass, stiffness, damping, dt, loads, elevation)
    except InputError as error:
        raise _refuse(source, None, error.field, error.value, error.limit, error.remedy) from None
    mass, stiffness, damping = (0.5 * (matrix + matrix.T) for matrix in (mass, stiffness, damping))
    return Superelement(mass, stiffness, damping, dt, loads, elevation, comments)


def _guyan(lines: list[str], source: str) -> Superelement:
    """Read the file of six degrees of freedom, whose lines have fixed places."""
    matrices = []
    for first, name in ((2, "mass"), (9, "damping"), (16, "stiffness")):
        title = lines[first - 1] if len(lines) >= first else ""
        if name not in title.lower():
            raise _refuse(source, first, f"{name} matrix", title, f"must be titled #{name}", _HINT)
        rows = [
            _guyan_row(lines, source, first + 1 + i, f"{name} matrix", INTERFACE) for i in range(INTERFACE)
        ]
        matrices.append(np.array(rows))
    mass, damping, stiffness = matrices
    section = _Section("loads", source, 26, width=INTERFACE + 1)
    end = len(lines)
    while end and not lines[end - 1].strip():
        end -= 1
    for line in range(26, end + 1):
        section.values.extend(_guyan_row(lines, source, line, "loads", INTERFACE + 1))
    table = section.rows if section.values else np.zeros((1, INTERFACE + 1))
    dt = _step(table[:, 0])
    _check_time(table[:, 0], dt, section)
    loads = np.ascontiguousarray(table[:, 1:])
    return _element(source, mass, stiffness, damping, dt, loads, None, (lines[0].strip(),))


def _guyan_row(lines: list[str], source: str, line: int, name: str, width: int) -> list[float]:
    text = lines[line - 1] if line <= len(lines) else ""
    values = _numbers(text, source, line, name)
    if len(values) != width:
        raise _refuse(
            source, line, f"{name}, numbers", len(values), f"must be {width} in a line", "Check the line."
        )
    return values
