"""Import of OpenFAST SubDyn input files: what a frame of circular tubes needs, and nothing silently.

The reader goes by the keyword behind each value, not by line numbers, so that it takes the variants of the
format: with and without the rigid-body position block, joints of 4 to 10 columns, reaction and interface rows
of the joint alone, with six flags, with the number of the transition piece first or last, concentrated masses
of 5 or 11 columns, tables without a line of units, comments from ``!`` or ``#`` on, tabs, commas, Fortran's
``1.0d3``. Only the element model and NDiv may lack their keywords.

Imported: joints (cantilever, revolute and spherical ones with their stiffness), reaction joints with their
flags, soil springs and masses (SSI files), interface joints, members of circular section, tapered ones too,
rigid links with their mass, spring members between joints on one place, element model (FEMMod 1 or 3),
elements per member (NDiv), concentrated masses. Anything else that would change the structure is refused by
name; what only concerns a simulation, and how the file was read where it leaves a choice, is in the
structure's ``notes``. SubDyn's element has rotary inertia, its deck no growth, water or added mass. A deck
does not say where the transition-piece node is: it is put at the horizontal centroid of the interface joints,
at the level of the highest.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable
from typing import Any

from owt_model.structure import Structure, parse_structure
from owt_model.subdyn_bodies import (
    add_link_masses,
    add_soil_masses,
    concentrated_masses,
    joint_springs,
)
from owt_model.subdyn_deck import Deck, Points, Row
from owt_model.subdyn_soil import read_soil

__all__ = ["parse_subdyn"]

_BEAM = {1: "euler-bernoulli", 3: "timoshenko"}
_OTHER_MEMBERS = {
    "1r": "a rectangular beam",
    "2": "a cable",
    "4": "a beam of arbitrary section",
}


def _no_files(name: str) -> str | None:
    """Read no other file."""
    return None


def parse_subdyn(text: str, *, source: str, read: Callable[[str], str | None] = _no_files) -> Structure:
    """Return the structure that a SubDyn input file describes.

    Parameters
    ----------
    text : str
        The file's content.
    source : str
        Its name, for messages and as the structure's name.
    read : callable
        Content of a file that this one names, None where it cannot be read.

    Raises
    ------
    InputError
        If the file is not a SubDyn deck, or holds something that is not supported; names field and line.
    """
    deck = Deck(text, source)
    tables = deck.tables()
    for keyword, table in (("NJoints", "joints"), ("NMembers", "members")):
        if not tables.get(table):
            raise deck.refuse(
                keyword,
                "nothing" if table not in tables else 0,
                "must be at least 1",
                "Is this a SubDyn input file of tubes?",
            )
    joints, free = _joints(deck, tables["joints"])
    sections = _sections(deck, tables.get("sections", []))
    beams, links, spring_rows = _members(deck, tables["members"], joints, sections)
    if not beams:
        count = len(tables["members"])
        raise deck.refuse("NMembers", count, "are all rigid links or springs", "A structure needs a beam.")
    _release(deck, beams, links, free)
    supports, springs, soil = _reactions(deck, tables.get("reactions", []), joints, read)
    interface = _interface(deck, tables.get("interface", []), joints)
    places = [joints[name] for name in interface]
    reference = [sum(p[i] for p in places) / len(places) for i in (0, 1)] + [max(p[2] for p in places)]
    masses = concentrated_masses(deck, tables.get("masses", []), joints)
    add_link_masses(deck, tables.get("rigid", []), links, joints, masses)
    add_soil_masses(soil, masses)
    return parse_structure(
        {
            "name": source,
            "description": "Imported from a SubDyn input file",
            "sources": [source],
            "notes": _notes(deck, tables["members"], reference, free=not (supports or springs)),
            "beam": _element_model(deck),
            "rotary_inertia": True,
            "elements_per_member": _subdivision(deck),
            "mudline_z_m": min(joints[name][2] for name in ({**supports, **springs} or joints)),
            "sections": {
                name: sections[name]
                for name in dict.fromkeys(s for beam in beams.values() for s in _sections_of(beam))
            },
            "joints": joints,
            "members": beams,
            "supports": supports,
            "free": not (supports or springs),
            "support_springs": springs,
            "joint_springs": joint_springs(deck, tables, spring_rows, joints),
            "rigid_links": {name: {"joints": ends} for name, (ends, _) in links.items()},
            "interface": {"joints": interface, "reference_m": reference},
            "point_masses": masses,
        },
        source=source,
    )


def _sections_of(beam: dict[str, Any]) -> list[str]:
    return [beam[key] for key in ("section", "section_last") if key in beam]


def _notes(deck: Deck, members: list[Row], reference: list[float], *, free: bool) -> list[str]:
    """What the deck holds that is no part of the structure, or that it leaves open."""
    place = ", ".join(f"{x:g}" for x in reference)
    notes = [f"position of the transition piece, which a deck does not hold: taken as ({place}) m"]
    if free:
        notes.append("NReact holds no joint: only modes with the interface held")
    if "mdivsize" in deck.header(members) and any(len(row.tokens) > 7 for row in members):
        notes.append("MDivSize (size of elements): every member has NDiv elements")
    for keyword, what in (
        ("JDampings", "damping ratios of its modes"),
        ("GuyanDampMod", "damping of its static modes"),
    ):
        for row in deck.rows:  # several damping ratios may stand before their keyword
            names = [token.lower() for token in row.tokens]
            if keyword.lower() in names and row.tokens[0].strip("\"'").lower() not in ("0", "0.0"):
                notes.append(f"{keyword} ({what}): damping is that of the case")
                break
    return notes


def _element_model(deck: Deck) -> str:
    row = deck.keyword("FEMMod") or deck.below("FEA", 1)
    if row is None:
        raise deck.refuse("FEMMod", "nothing", "is missing", "Is this a SubDyn input file?")
    model = deck.integer(row.tokens[0], "FEMMod", row.line)
    if model not in _BEAM:
        raise deck.refuse(
            "FEMMod",
            model,
            "must be 1 (Euler-Bernoulli) or 3 (Timoshenko)",
            "Tapered elements are not supported.",
            row.line,
        )
    return _BEAM[model]


def _subdivision(deck: Deck) -> int:
    row = deck.keyword("NDiv") or deck.below("FEA", 2)
    if row is None:
        raise deck.refuse("NDiv", "nothing", "is missing", "Is this a SubDyn input file?")
    count = deck.integer(row.tokens[0], "NDiv", row.line)
    if not 1 <= count <= 100:
        raise deck.refuse("NDiv", count, "must be 1 to 100", "Subdivide less.", row.line)
    return count


def _joints(deck: Deck, rows: list[Row]) -> tuple[Points, dict[str, dict[str, Any]]]:
    """Positions, and the release of the joints that are not cantilever joints."""
    joints: Points = {}
    free: dict[str, dict[str, Any]] = {}
    for row in rows:
        name = deck.identifier(row, "JointID", "J")
        deck.new(name, joints, "JointID", row.line)
        joints[name] = deck.columns(row, ("JointXss", "JointYss", "JointZss"))
        if len(row.tokens) <= 4:
            continue
        kind = deck.integer(row.tokens[4], "JointType", row.line)
        if kind not in (1, 3, 4):
            raise deck.refuse(
                "JointType",
                kind,
                "must be 1 (cantilever), 3 (revolute) or 4 (spherical)",
                "Universal joints are not supported.",
                row.line,
            )
        if kind == 1:
            continue
        given = ("JointDirX", "JointDirY", "JointDirZ", "JointStiff")
        *direction, stiffness = deck.columns(row, given, first=5)
        if stiffness < 0.0:
            raise deck.refuse("JointStiff", stiffness, "must be at least 0", "Check the file.", row.line)
        free[name] = {"stiffness_nm_rad": stiffness}
        if kind == 3:
            if not any(direction):
                raise deck.refuse("JointDirX", 0, "is no direction", "Give the hinge's.", row.line)
            free[name]["hinge"] = direction
    return joints, free


def _release(
    deck: Deck, beams: dict[str, Any], links: dict[str, Any], free: dict[str, dict[str, Any]]
) -> None:
    """Release all beams but one at each revolute or spherical joint, all where a rigid link ends there."""
    for joint, release in free.items():
        ends = [(beam, side) for beam in beams.values() for side in (0, 1) if beam["joints"][side] == joint]
        rigid = sum(joint in joints for joints, _ in links.values())
        if rigid > 1 or (release["stiffness_nm_rad"] > 0.0 and len(ends) + rigid > 2):
            raise deck.refuse(
                f"JointType of joint {joint[1:]}",
                len(ends) + rigid,
                "members meet there: more than one rigid link, or more than two on a sprung joint",
                "Divide the joint.",
            )
        for beam, side in ends[0 if rigid else 1 :]:
            beam[("release_first", "release_last")[side]] = release


def _sections(deck: Deck, rows: list[Row]) -> dict[str, dict[str, float]]:
    sections: dict[str, dict[str, float]] = {}
    for row in rows:
        name = deck.identifier(row, "PropSetID", "P")
        deck.new(name, sections, "PropSetID", row.line)
        young, shear, density, diameter, thickness = deck.columns(
            row, ("YoungE", "ShearG", "MatDens", "XsecD", "XsecT")
        )
        sections[name] = {
            "diameter_m": diameter,
            "thickness_m": thickness if thickness != 0.0 else 0.5 * diameter,  # 0 is a solid bar
            "youngs_modulus_pa": young,
            "shear_modulus_pa": shear,
            "density_kg_m3": density,
        }
    return sections


def _members(
    deck: Deck, rows: list[Row], joints: Points, sections: dict[str, dict[str, float]]
) -> tuple[dict[str, Any], dict[str, tuple[list[str], tuple[str, int]]], dict[str, Row]]:
    """Beams, rigid links with their joints, property set and line, and the rows of springs."""
    beams: dict[str, Any] = {}
    springs: dict[str, Row] = {}
    links: dict[str, tuple[list[str], tuple[str, int]]] = {}
    header = deck.header(rows)
    typed = "mtype" in header or len(header) > 6  # older files have COSMID there, and beams only
    for row in rows:
        name = deck.identifier(row, "MemberID", "M")
        deck.new(name, ChainMap[str, Any](beams, links, springs), "MemberID", row.line)
        ends = [deck.identifier(row, f"MJointID{i}", "J", i) for i in (1, 2)]
        for i, joint in enumerate(ends):
            deck.known(joint, joints, f"MJointID{i + 1}", row.line)
        pair = [deck.identifier(row, f"MPropSetID{i}", "P", i + 2) for i in (1, 2)]
        kind = row.tokens[5].lower() if typed and len(row.tokens) > 5 else "1"
        if kind == "3":
            links[name] = (ends, (pair[0], row.line))
            continue
        if kind == "5":
            springs[name] = row
            continue
        if kind not in ("1", "1c"):
            raise deck.refuse(
                "MType",
                kind,
                f"is {_OTHER_MEMBERS.get(kind, 'unknown')}; only circular beams (1, 1c), rigid links "
                "(3) and springs (5) are supported",
                "Replace the member.",
                row.line,
            )
        for i, section in enumerate(pair):
            if section not in sections:
                raise deck.refuse(
                    f"MPropSetID{i + 1}",
                    section[1:],
                    "is not a circular property set of this file",
                    "Rectangular and arbitrary sections and cables are not supported.",
                    row.line,
                )
        beams[name] = {"joints": ends, "section": pair[0]}
        if sections[pair[0]] != sections[pair[1]]:
            beams[name]["section_last"] = pair[1]
    return beams, links, springs


def _reactions(
    deck: Deck, rows: list[Row], joints: Points, read: Callable[[str], str | None]
) -> tuple[dict[str, list[bool]], dict[str, Any], dict[str, list[float]]]:
    """Fixed directions, soil springs, and masses of the soil; a joint without any is held by nothing."""
    names = ("RctTDXss", "RctTDYss", "RctTDZss", "RctRDXss", "RctRDYss", "RctRDZss")
    supports: dict[str, list[bool]] = {}
    springs: dict[str, Any] = {}
    masses: dict[str, list[float]] = {}
    seen: set[str] = set()
    for row in rows:
        name = deck.identifier(row, "RJointID", "J")
        deck.new(name, seen, "RJointID", row.line)
        deck.known(name, joints, "RJointID", row.line)
        seen.add(name)
        flags = deck.flags(row, names) if len(row.tokens) > 1 else [True] * 6  # SubDyn: the joint alone
        if len(flags) < 6:
            raise deck.refuse(names[len(flags)], "nothing", "is missing", "Give six flags.", row.line)
        file = row.tokens[7].strip("\"' ") if len(row.tokens) > 7 else ""
        if file.lower() not in ("", "none", "unused") and not all(flags):  # SubDyn: not read when all fixed
            stiffness, masses[name] = read_soil(deck, file, row.line, read)
            springs[name] = {"stiffness": stiffness}
        if any(flags):
            supports[name] = flags
    return supports, springs, masses


def _interface(deck: Deck, rows: list[Row], joints: Points) -> list[str]:
    if not rows:
        raise deck.refuse("NInterf", 0, "must be at least 1", "Name the joints of the transition piece.")
    names = ("ItfTDXss", "ItfTDYss", "ItfTDZss", "ItfRDXss", "ItfRDYss", "ItfRDZss")
    interface: dict[str, str | None] = {}
    second = deck.header(rows)[1:2] == ["tpid"]  # newer files name the transition piece before the flags
    for row in rows:
        name = deck.identifier(row, "IJointID", "J")
        deck.new(name, interface, "IJointID", row.line)
        deck.known(name, joints, "IJointID", row.line)
        n = len(row.tokens)
        flagged = n >= 7
        first = 2 if second and n >= 8 else 1
        if flagged and not all(deck.flags(row, names, first)):
            raise deck.refuse(
                "ItfTDXss",
                row.tokens[first : first + 6],
                "must be locked in all six directions",
                "A partly free interface is not supported.",
                row.line,
            )
        numbered = n == 2 or n >= 8
        interface[name] = row.tokens[1 if n == 2 or first == 2 else 7] if numbered else None
    pieces = sorted({piece for piece in interface.values() if piece is not None})
    if len(pieces) > 1 and "0" in pieces:  # the point that a floating structure's motion refers to
        pieces.remove("0")
        interface = {name: piece for name, piece in interface.items() if piece != "0"}
    if len(pieces) > 1:
        raise deck.refuse("TPID", pieces, "must be one transition piece", "Import one at a time.")
    return list(interface)
