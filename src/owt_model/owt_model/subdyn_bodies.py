"""Concentrated masses of a SubDyn deck, the masses of its rigid links, and its spring members."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.subdyn_deck import Deck, Points, Row

__all__ = ["add_link_masses", "add_soil_masses", "concentrated_masses", "joint_springs"]


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


def add_soil_masses(soil: dict[str, list[float]], masses: dict[str, Any]) -> None:
    """Add mass and moments of inertia of the soil files to the bodies at their joints."""
    for joint, (mass, *inertia) in soil.items():
        if mass > 0.0 or any(inertia):
            masses[joint] = _joined(masses.get(joint), mass, np.diag(inertia), np.zeros(3))


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
    centre = sum((m * r for m, _, r in parts), np.zeros(3)) / (total or 1.0)
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


def joint_springs(
    deck: Deck, tables: dict[str, list[Row]], rows: dict[str, Row], joints: Points
) -> dict[str, dict[str, Any]]:
    """Springs between joints from the rows of their members."""
    names = tuple(f"k{i + 1}{j + 1}" for i in range(6) for j in range(i, 6))
    properties: dict[str, list[float]] = {}
    for row in tables.get("springs", []):
        properties[deck.identifier(row, "PropSetID", "P")] = deck.columns(row, names)
    springs = {}
    for name, row in rows.items():
        ends = [deck.identifier(row, f"MJointID{i}", "J", i) for i in (1, 2)]
        section = deck.identifier(row, "MPropSetID1", "P", 3)
        if section not in properties:
            raise deck.refuse(
                "MPropSetID1", section[1:], "is no spring property", "Check the file.", row.line
            )
        if joints[ends[0]] != joints[ends[1]]:
            raise deck.refuse(
                "MJointID2", ends[1][1:], "is not on the place of joint 1", "Add a rigid link.", row.line
            )
        matrix = np.zeros((6, 6))
        matrix[np.triu_indices(6)] = properties[section]
        matrix = matrix + np.triu(matrix, 1).T
        turn = np.tile(_signs(deck, tables.get("cosines", []), row), 2)
        springs[name] = {"joints": ends, "stiffness": (turn[:, None] * matrix * turn).tolist()}
    return springs


def _signs(deck: Deck, cosines: list[Row], row: Row) -> Float[np.ndarray, " 3"]:
    """Signs of a spring's axes against the global ones; others directions than those are refused."""
    which = deck.identifier(row, "COSMID", "C", 6) if len(row.tokens) > 6 else "C-1"
    if which == "C-1":
        return np.ones(3)
    names = tuple(f"COSM{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
    for line in cosines:
        if deck.identifier(line, "COSMID", "C") == which:
            matrix = np.array(deck.columns(line, names)).reshape(3, 3)
            if np.abs(np.abs(matrix) - np.eye(3)).max() > 1e-9:
                raise deck.refuse(
                    "COSMID",
                    which[1:],
                    "turns a spring out of the global axes, which is not supported",
                    "Give its stiffness in global axes.",
                    row.line,
                )
            return np.asarray(np.sign(np.diag(matrix)))
    raise deck.refuse("COSMID", which[1:], "is no cosine matrix of this file", "Check the file.", row.line)
