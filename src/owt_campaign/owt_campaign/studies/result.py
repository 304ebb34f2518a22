"""What a study gives: rows that put the print beside this code, a verdict, a page, figures, plain data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from owt_campaign.studies.cases import MODEL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "RULE",
    "Outcome",
    "Row",
    "StudyResult",
    "Verdict",
    "agreement",
    "number",
    "rows_table",
    "table",
]

Outcome = Literal["reproduced", "partly", "not"]
_SENTENCE = {"reproduced": "Reproduced.", "partly": "Partly reproduced.", "not": "Not reproduced."}

#: How numbers are judged where a page says nothing else.
RULE = "Numbers are *reproduced* within a quarter of the print, *partly* within a factor of two, else *not*."


@dataclass(frozen=True)
class Row:
    """One printed value or statement, and what this code finds.

    Attributes
    ----------
    name : str
        What it is.
    where : str
        Where in the thesis it stands.
    printed : float or str or None
        The print: a number, or the statement in its words; None where only a lost picture shows it.
    ours : float or str
        The same from this code; of several seeds the mean.
    unit : str
        Of both, empty for a plain number or a statement.
    spread : tuple of float, optional
        Lowest and highest over the seeds.
    verdict : str
        Of this row: reproduced, partly or not; empty where there is nothing to compare with.
    """

    name: str
    where: str
    printed: float | str | None
    ours: float | str
    unit: str = ""
    spread: tuple[float, float] | None = None
    verdict: Outcome | Literal[""] = ""

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.name,
            "where": self.where,
            "unit": self.unit,
            "print": _digits(self.printed),
            "ours": _digits(self.ours),
            "spread": None if self.spread is None else [_digits(value) for value in self.spread],
            "verdict": self.verdict or None,
        }


@dataclass(frozen=True)
class Verdict:
    """How a study ends: what came of the print, and why."""

    outcome: Outcome
    why: str


@dataclass(frozen=True)
class StudyResult:
    """What one study gives.

    Attributes
    ----------
    name, title : str
        Of the study and of its page.
    sections : sequence of str
        The page in Markdown, without title and verdict; figures are named by :meth:`picture`.
    rows : sequence of Row
        Print and this code side by side.
    verdict : Verdict
        How it ends.
    full : bool
        Whether it is the version that docs/study holds.
    figures : mapping
        Key of each figure -> what draws it; nothing is drawn before it is asked for.
    data : mapping
        More for the JSON object, beside ``study``, ``full``, ``revision``, ``structure``, ``verdict`` and
        ``rows``.
    structure : str
        What it was computed on, in words: the thesis' turbine where nothing else is named.
    """

    name: str
    title: str
    sections: Sequence[str]
    rows: Sequence[Row]
    verdict: Verdict
    full: bool = True
    figures: Mapping[str, Callable[[], Figure]] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    structure: str = f"model `{MODEL}`"

    def picture(self, key: str) -> str:
        """Name of the file of a figure."""
        return picture(self.name, key)

    @property
    def page(self) -> str:
        """The page in Markdown, whole."""
        parts = [f"# {self.title}"]
        if not self.full:
            parts.append(
                f"Reduced version, for a quick look and for the tests; `./owt study {self.name} --full` is "
                "the study."
            )
        verdict = f"## Verdict\n\n**{_SENTENCE[self.verdict.outcome]}** {self.verdict.why}"
        return "\n\n".join([*parts, *self.sections, verdict]) + "\n"

    def signed_page(self, revision: str) -> str:
        """The page, closed by a line with the structure and the revision of the code that made it."""
        return f"{self.page}\n*Structure: {self.structure}; revision {revision}.*\n"

    def as_json(self, revision: str) -> dict[str, Any]:
        """Plain data, with the revision of the code that made it."""
        return {
            "study": self.name,
            "full": self.full,
            "revision": revision,
            "structure": self.structure,
            "verdict": {"outcome": self.verdict.outcome, "why": self.verdict.why},
            "rows": [row.as_json() for row in self.rows],
            **self.data,
        }


def _digits(value: float | str | None) -> float | str | None:
    """Six digits of a number: what a diff of two revisions should show."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def picture(study: str, key: str) -> str:
    """Name of the file of a study's figure, beside its page."""
    return f"{study}-{key}.png"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def number(value: float | str | None) -> str:
    """A value as the tables show it: three digits, a dash for none."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def agreement(ours: float, low: float, high: float | None = None) -> Outcome:
    """Verdict of a number beside a printed one, or a printed range: :data:`RULE` in words."""
    high = low if high is None else high
    sign = -1.0 if low < 0.0 else 1.0
    ours, low, high = sign * ours, *sorted((sign * low, sign * high))
    if 0.75 * low <= ours <= 1.25 * high:
        return "reproduced"
    return "partly" if 0.5 * low <= ours <= 2.0 * high else "not"


def rows_table(rows: Sequence[Row]) -> str:
    """Rows as a table: print, here, lowest and highest of the seeds, verdict."""
    lines = []
    for row in rows:
        unit = f" [{row.unit}]" if row.unit else ""
        spread = "-" if row.spread is None else " to ".join(number(value) for value in row.spread)
        lines.append(
            [row.name + unit, row.where, number(row.printed), number(row.ours), spread, row.verdict or "-"]
        )
    return table(["what", "thesis", "print", "here", "lowest to highest seed", "verdict"], lines)
