"""The table of proofs in docs/verification.md."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from proofs.registry import Proof, found

__all__ = ["HEADER", "PAGE", "cells", "committed_rows", "lines", "write"]

PAGE = Path(__file__).parents[2] / "docs" / "verification.md"
BEGIN, END = "<!-- proofs: written by python -m proofs -->", "<!-- end of proofs -->"
HEADER = ["claim", "against", "found", "allowed", "wrong variant", "its value"]


def number(value: float) -> str:
    """Two digits at most."""
    return f"{value:.2g}" if value else "0"


def cells(proof: Proof) -> list[list[str]]:
    """Rows of a proof: one per wrong variant, what they share in the first only."""
    values = found(proof)
    shared = [proof.claim, proof.against, number(values.right), number(proof.allowed)]
    return [
        [*(shared if i == 0 else [""] * len(shared)), name, number(value)]
        for i, (name, value) in enumerate(values.wrong.items())
    ]


def lines(rows: Iterable[list[str]]) -> list[str]:
    """Markdown of a table."""
    table = [HEADER, ["---"] * len(HEADER), *rows]
    return ["| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in table]


def split() -> tuple[str, str, str]:
    """The page before its table, the table, and the page after it."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    table, after = rest.split(END)
    return before, table, after


def committed_rows() -> list[list[str]]:
    """Cells of the table as it stands in the page, header left out."""
    rows = [line for line in split()[1].splitlines() if line.startswith("|")][2:]
    return [
        [cell.strip().replace("\0", "|") for cell in row.replace(r"\|", "\0").strip("|").split("|")]
        for row in rows
    ]


def write(proofs: Iterable[Proof]) -> None:
    """Write the table of `proofs` into the page."""
    before, _, after = split()
    table = "\n".join(lines(row for proof in proofs for row in cells(proof)))
    PAGE.write_text(f"{before}{BEGIN}\n\n{table}\n\n{END}{after}", encoding="utf-8")
