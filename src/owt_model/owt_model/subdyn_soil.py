"""Soil files of a SubDyn deck (SSI): stiffness, and lumped mass, at a reaction joint."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from owt_model.subdyn_deck import Deck

__all__ = ["read_soil"]

#: Names of the entries of an SSI file: the upper triangle, column by column.
_AXES = ("x", "y", "z", "tx", "ty", "tz")
_ENTRY = {_AXES[i] + _AXES[j]: (i, j) for j in range(6) for i in range(j + 1)}


def read_soil(
    deck: Deck, file: str, line: int, read: Callable[[str], str | None]
) -> tuple[list[list[float]], list[float]]:
    """Return a soil file's stiffness matrix, and its mass in kg with the moments of inertia in kg m2.

    Lines of value and name, symmetric, zero where nothing is given.
    """
    text = read(file)
    if text is None:
        raise deck.refuse("SSIfile", file, "cannot be read", "Put it beside the deck.", line)
    soil = Deck(text, file)
    matrices = {"k": np.zeros((6, 6)), "m": np.zeros((6, 6))}
    given = set()
    for row in soil.rows:
        name = row.tokens[1].lower() if len(row.tokens) > 1 else ""
        if name[:1] in matrices and name[1:] in _ENTRY:
            i, j = _ENTRY[name[1:]]
            matrix = matrices[name[0]]
            matrix[i, j] = matrix[j, i] = soil.number(row.tokens[0], row.tokens[1], row.line)
            given.add(name[0])
    if "k" not in given:
        raise deck.refuse("SSIfile", file, "holds no stiffness", "Give lines like `1e9 Kxx`.", line)
    mass = matrices["m"]
    body = np.diag(mass)
    if np.any(mass != np.diag(body)) or body[0] != body[1] or body[1] != body[2] or body.min() < 0.0:
        raise soil.refuse(
            "Mxx, Myy, Mzz",
            body[:3].tolist(),
            "must be one mass, at least 0, without couplings",
            "Use a concentrated mass with an offset.",
        )
    stiffness: list[list[float]] = matrices["k"].tolist()
    return stiffness, body[2:].tolist()
