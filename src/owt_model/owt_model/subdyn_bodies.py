"""Concentrated masses of a SubDyn deck, and the masses of its rigid links."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.subdyn_deck import Deck, Points, Row

__all__ = ["add_link_masses", "concentrated_masses"]


def concentrated_masses(deck: Deck, rows: list[Row], joints: Points) -> dict[str, Any]:
    """Read the bodies at joints."""
    masses: dict[str, Any] = {}
    diagonal = ("JMass", "JMXX", "JMYY", "JMZZ")
    others = ("JMXY", "JMXZ", "JMYZ", "MCGX", "MCGY", "MCGZ")
    for row in rows:
        name = deck.identifier(row, "CMJointID", "J")
        deck.new(name, masses, "CMJointID", row.line)
        deck.known(name, joints, "CMJointID", row.line)
        mass, *inertia = deck.columns(row, diagonal)
        more = deck.columns(row, others, first=5) if len(row.tokens) > 5 else [0.0] * 6
        if mass < 0.0:
            raise deck.refuse("JMass", mass, "must be at least 0 kg", "Check the file.", row.line)
        masses[name] = {"mass_kg": mass, "inertia_kg_m2": inertia + more[:3], "offset_m": more[3:]}
    return masses


def add_link_masses(
    deck: Deck,
    rows: list[Row],
    links: dict[str, tuple[list[str], tuple[str, int]]],
    joints: Points,
    masses: dict[str, Any],
) -> None:
    """Add the mass of each rigid link, a thin rod, to the body at its first joint."""
    density = {deck.identifier(row, "PropSetID", "P"): deck.columns(row, ("MatDens",))[0] for row in rows}
    for ends, (section, line) in links.values():
        if section not in density:
            raise deck.refuse(
                "MPropSetID1", section[1:], "is no rigid link property", "Check the file.", line
            )
        first, last = (np.array(joints[joint]) for joint in ends)
        along = last - first
        mass = density[section] * float(np.linalg.norm(along))
        if mass < 0.0:
            raise deck.refuse("MatDens", density[section], "must be at least 0 kg/m", "Check the file.", line)
        if mass > 0.0:
            rod = mass / 12.0 * (along @ along * np.eye(3) - np.outer(along, along))
            masses[ends[0]] = _joined(masses.get(ends[0]), mass, rod, 0.5 * along)


def _joined(
    body: dict[str, Any] | None,
    mass: float,
    inertia: Float[np.ndarray, "3 3"],
    offset: Float[np.ndarray, " 3"],
) -> dict[str, Any]:
    """Body at a joint together with another of given inertia about its centre of gravity at `offset`."""
    parts = [(mass, inertia, offset)]
    if body is not None:
        xx, yy, zz, xy, xz, yz = body["inertia_kg_m2"]
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        parts.append((body["mass_kg"], own, np.array(body["offset_m"])))
    total = sum(m for m, _, _ in parts)
    centre = sum((m * r for m, _, r in parts), np.zeros(3)) / total
    whole = np.zeros((3, 3))
    for m, own, r in parts:
        d = r - centre
        whole += own + m * (d @ d * np.eye(3) - np.outer(d, d))
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return {
        "mass_kg": total,
        "inertia_kg_m2": [float(whole[i]) for i in order],
        "offset_m": centre.tolist(),
    }
