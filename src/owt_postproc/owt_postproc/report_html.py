"""Pieces of a report's page: the shell that needs nothing but a browser, figures, tables."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import quote

from owt_model.errors import InputError
from owt_postproc.plot_style import Figure
from owt_postproc.report_measures import power

__all__ = ["Cell", "Link", "facts", "figure", "page", "power_cell", "table", "text", "tiles", "write_page"]

#: A row that is left out on paper.
_SCREEN = ' class="screen"'


@dataclass(frozen=True)
class Cell:
    """A number written in a way of its own."""

    text: str
    value: float


@dataclass(frozen=True)
class Link:
    """Text that leads to a page beside this one."""

    text: str
    target: str


def power_cell(value: float) -> Cell:
    """A number with its power of ten."""
    return Cell(power(value), value)


def page(title: str, subtitle: str, body: Iterable[str], figures: Sequence[Figure]) -> str:
    """The page as text, with style, script, plotting library and figures inside."""
    payload = json.dumps(
        [
            {"key": f.key, "data": f.data, "layout": {**f.layout, "height": f.height}, "extra": dict(f.extra)}
            for f in figures
        ],
        separators=(",", ":"),
        allow_nan=False,
    ).replace("</", "<\\/")
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{text(title)}</title>",
        f"<style>{_file('report.css')}</style>",
        f"<script>{_plotly()}</script>",
        "</head><body><main>",
        f"<header><h1>{text(title)}</h1><p>{text(subtitle)}</p></header>",
        *body,
        "</main>",
        f'<script id="figures" type="application/json">{payload}</script>',
        f"<script>{_file('report.js')}</script>",
        f"<script>{_file('tables.js')}</script>",
        "</body></html>",
    ]
    return "\n".join(part for part in parts if part)


def write_page(content: str, path: Path) -> Path:
    """Write a page, whole or not at all; returns its path.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    partial = path.with_name(f".{path.name}.partial")
    try:
        with partial.open("w", encoding="utf-8") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise InputError(
            "report",
            str(path),
            f"cannot be written ({error.strerror})",
            "Choose a folder with free space.",
        ) from None
    return path


def figure(shown: Figure) -> str:
    """Place of a figure and the words around it."""
    return (
        f'<figure id="figure-{shown.key}"><h3>{text(shown.title)}</h3>{shown.html}'
        f'<div class="plot" id="plot-{shown.key}" style="height:{shown.height}px"></div>'
        f"<figcaption>{text(shown.caption)}</figcaption></figure>"
    )


def tiles(figures: Iterable[tuple[str, str]]) -> str:
    """Labels and values in a row of boxes."""
    boxes = "".join(
        f'<div class="tile"><b>{text(value)}</b><span>{text(label)}</span></div>' for label, value in figures
    )
    return f'<div class="tiles">{boxes}</div>'


def facts(rows: Iterable[tuple[str, Any]]) -> str:
    """Keys and values as a table of two columns."""
    body = "".join(f'<tr><th scope="row">{text(k)}</th><td>{text(_shown(v))}</td></tr>' for k, v in rows)
    return f"<table><tbody>{body}</tbody></table>"


def table(
    name: str, head: Sequence[str], rows: Iterable[Sequence[Any]], *, caption: str, printed: int | None = None
) -> str:
    """A table whose headings sort it, with a button that saves it as CSV.

    Parameters
    ----------
    name : str
        Of the file that the button saves, without ending.
    head : sequence of str
        Headings, with units.
    rows : iterable of sequences
        Numbers, :class:`Cell` or text.
    caption : str
        What the table shows.
    printed : int, optional
        Rows that appear on paper; all by default. The table scrolls on the screen if there are more.
    """
    cells = [[_cell(value) for value in row] for row in rows]
    number = [bool(cells) and 'class="number"' in cells[0][i] for i in range(len(head))]
    columns = "".join(
        f'<th scope="col" class="{"number" if right else "word"}" aria-sort="none">'
        f'<button type="button">{text(h)}</button></th>'
        for h, right in zip(head, number, strict=True)
    )
    most = len(cells) if printed is None else printed
    body = "".join(f"<tr{_SCREEN if i >= most else ''}>{''.join(row)}</tr>" for i, row in enumerate(cells))
    kind = "long" if len(cells) > most else "short"
    return (
        f'<div class="table" data-name="{text(name)}" data-printed="{most}"><p class="note">{text(caption)} '
        f'<button type="button" class="download">Download CSV</button></p>'
        f'<div class="scroll {kind}" tabindex="0"><table class="sort {kind}">'
        f"<thead><tr>{columns}</tr></thead><tbody>{body}</tbody></table></div></div>"
    )


def _cell(value: Any) -> str:
    if isinstance(value, Cell):
        return f'<td class="number" data-value="{value.value!r}">{text(value.text)}</td>'
    if isinstance(value, Link):
        return f'<td><a href="{text(quote(value.target))}">{text(value.text)}</a></td>'
    if isinstance(value, float | int):
        return f'<td class="number" data-value="{value!r}">{text(_shown(value))}</td>'
    return f"<td>{text(value)}</td>"


def _shown(value: Any) -> str:
    return f"{value:.4g}".replace("-", "−") if isinstance(value, float) else str(value)


def text(value: Any) -> str:
    """Anything as text of a page."""
    return html.escape(str(value))


def _file(name: str) -> str:
    return (resources.files("owt_postproc") / "data" / name).read_text(encoding="utf-8")


@cache
def _plotly() -> str:
    """Plotly's own script, as its Python package ships it."""
    return (resources.files("plotly") / "package_data" / "plotly.min.js").read_text(encoding="utf-8")
