"""Import of OpenFAST SubDyn input files: what a clamped frame of circular tubes needs, and nothing silently.

The reader goes by the keyword behind each value, not by line numbers, so that it takes the variants of the
format: with and without the rigid-body position block, joints of 4 to 10 columns, interface rows of the
joint alone, with six flags, with the number of the transition piece, or both, concentrated masses of 5 or
11 columns, comments from ``!`` on, tabs, commas, Fortran's ``1.0d3``.

Imported: joints, reaction joints with their flags, interface joints, members of circular section,
element model (FEMMod 1 or 3), elements per member (NDiv), concentrated masses. Anything else that would
change the structure is refused by name. SubDyn's element has rotary inertia, its deck no growth, water or
added mass. A deck does not say where the transition-piece node is: it is put at the horizontal
centroid of the interface joints, at the level of the highest.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from owt_model.errors import InputError
from owt_model.structure import Structure, parse_structure

__all__ = ["parse_subdyn"]

_TOKEN = re.compile(r"\"[^\"]*\"|'[^']*'|[^\s,;]+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
_BEAM = {1: "euler-bernoulli", 3: "timoshenko"}
#: Count keywords (lower case) and the name of the table that follows.
_TABLES = {
    "njoints": "joints",
    "nreact": "reactions",
    "ninterf": "interface",
    "nmembers": "members",
    "npropsets": "sections",
    "npropsetscyl": "sections",
    "ncmass": "masses",
}
_OTHER_MEMBERS = {
    "1r": "a rectangular beam",
    "2": "a cable",
    "3": "a rigid link",
    "4": "a beam of arbitrary section",
    "5": "a spring",
}


@dataclass(frozen=True)
class _Row:
    """Tokens of one line, and where it stands."""

    tokens: list[str]
    line: int


class _Deck:
    """Lines of a deck with their keywords and tables."""

    def __init__(self, text: str, source: str) -> None:
        self.source = source
        self.rows = [
            _Row(_TOKEN.findall(line.split("!")[0]), i + 1) for i, line in enumerate(text.splitlines())
        ]
        self.titles = [line.strip().upper() for line in text.splitlines()]

    def refuse(self, field: str, value: Any, limit: str, remedy: str, line: int | None = None) -> InputError:
        """Build the error for a value of this deck."""
        where = f"{self.source}, line {line}: {field}" if line else f"{self.source}: {field}"
        return InputError(where, value, limit, remedy)

    def keyword(self, name: str) -> _Row | None:
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

    def tables(self) -> dict[str, list[_Row]]:
        """Return the rows of every table that is imported."""
        found: dict[str, list[_Row]] = {}
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
            first = i + 3  # two lines of column names and units
            if first + count > len(self.rows):
                raise self.refuse(
                    row.tokens[1], count, "is more rows than the file has", "Check the file.", row.line
                )
            found[name] = self.rows[first : first + count]
        return found


def parse_subdyn(text: str, *, source: str) -> Structure:
    """Return the structure that a SubDyn input file describes.

    Parameters
    ----------
    text : str
        The file's content.
    source : str
        Its name, for messages and as the structure's name.

    Raises
    ------
    InputError
        If the file is not a SubDyn deck, or holds something that is not supported; names field and line.
    """
    deck = _Deck(text, source)
    tables = deck.tables()
    for keyword, table in (("NJoints", "joints"), ("NMembers", "members"), ("NPropSets", "sections")):
        if not tables.get(table):
            raise deck.refuse(
                keyword,
                "nothing" if table not in tables else 0,
                "must be at least 1",
                "Is this a SubDyn input file?",
            )
    joints = _joints(deck, tables["joints"])
    sections = _sections(deck, tables["sections"])
    members, used = _members(deck, tables["members"], joints, sections)
    supports = _reactions(deck, tables.get("reactions", []), joints)
    interface = _interface(deck, tables.get("interface", []), joints)
    places = [joints[name] for name in interface]
    reference = [sum(p[i] for p in places) / len(places) for i in (0, 1)] + [max(p[2] for p in places)]
    return parse_structure(
        {
            "name": source,
            "description": "Imported from a SubDyn input file",
            "sources": [source],
            "beam": _element_model(deck),
            "rotary_inertia": True,
            "elements_per_member": _subdivision(deck),
            "mudline_z_m": min(joints[name][2] for name in supports),
            "sections": {name: sections[name] for name in used},
            "joints": joints,
            "members": members,
            "supports": supports,
            "interface": {"joints": interface, "reference_m": reference},
            "point_masses": _masses(deck, tables.get("masses", []), joints),
        },
        source=source,
    )


def _element_model(deck: _Deck) -> str:
    row = deck.keyword("FEMMod")
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


def _subdivision(deck: _Deck) -> int:
    row = deck.keyword("NDiv")
    if row is None:
        raise deck.refuse("NDiv", "nothing", "is missing", "Is this a SubDyn input file?")
    count = deck.integer(row.tokens[0], "NDiv", row.line)
    if not 1 <= count <= 100:
        raise deck.refuse("NDiv", count, "must be 1 to 100", "Subdivide less.", row.line)
    return count


def _identifier(deck: _Deck, row: _Row, field: str, prefix: str, column: int = 0) -> str:
    if len(row.tokens) <= column:
        raise deck.refuse(field, "nothing", "is missing", "Check the number of rows of the table.", row.line)
    return f"{prefix}{deck.integer(row.tokens[column], field, row.line)}"


def _columns(deck: _Deck, row: _Row, names: tuple[str, ...], first: int = 1) -> list[float]:
    """Read the columns `names` of a row."""
    if len(row.tokens) < first + len(names):
        missing = names[max(len(row.tokens) - first, 0)]
        raise deck.refuse(missing, "nothing", "is missing", "Check the columns of this line.", row.line)
    return [deck.number(row.tokens[first + i], name, row.line) for i, name in enumerate(names)]


def _new(deck: _Deck, name: str, table: dict[str, Any], field: str, line: int) -> None:
    if name in table:
        raise deck.refuse(field, name[1:], "is given twice", "Number them uniquely.", line)


def _known(deck: _Deck, name: str, joints: dict[str, list[float]], field: str, line: int) -> None:
    if name not in joints:
        raise deck.refuse(field, name[1:], "is not a joint of this file", "Check the joint table.", line)


def _joints(deck: _Deck, rows: list[_Row]) -> dict[str, list[float]]:
    joints: dict[str, list[float]] = {}
    for row in rows:
        name = _identifier(deck, row, "JointID", "J")
        _new(deck, name, joints, "JointID", row.line)
        joints[name] = _columns(deck, row, ("JointXss", "JointYss", "JointZss"))
        if len(row.tokens) > 4:
            kind = deck.integer(row.tokens[4], "JointType", row.line)
            if kind != 1:
                raise deck.refuse(
                    "JointType",
                    kind,
                    "must be 1 (cantilever)",
                    "Universal, pin and ball joints are not supported.",
                    row.line,
                )
    return joints


def _sections(deck: _Deck, rows: list[_Row]) -> dict[str, dict[str, float]]:
    sections: dict[str, dict[str, float]] = {}
    for row in rows:
        name = _identifier(deck, row, "PropSetID", "P")
        _new(deck, name, sections, "PropSetID", row.line)
        young, shear, density, diameter, thickness = _columns(
            deck, row, ("YoungE", "ShearG", "MatDens", "XsecD", "XsecT")
        )
        sections[name] = {
            "diameter_m": diameter,
            "thickness_m": thickness,
            "youngs_modulus_pa": young,
            "shear_modulus_pa": shear,
            "density_kg_m3": density,
        }
    return sections


def _members(
    deck: _Deck,
    rows: list[_Row],
    joints: dict[str, list[float]],
    sections: dict[str, dict[str, float]],
) -> tuple[dict[str, Any], list[str]]:
    """Members, and the sections that they use."""
    members: dict[str, Any] = {}
    used: dict[str, None] = {}
    header = [token.lower() for token in deck.rows[rows[0].line - 3].tokens]
    typed = "mtype" in header or len(header) > 6  # older files have COSMID there, and beams only
    for row in rows:
        name = _identifier(deck, row, "MemberID", "M")
        _new(deck, name, members, "MemberID", row.line)
        kind = row.tokens[5].lower() if typed and len(row.tokens) > 5 else "1c"
        if kind not in ("1", "1c"):
            what = _OTHER_MEMBERS.get(kind, "of an unknown kind")
            raise deck.refuse(
                "MType", kind, f"is {what}: only circular beams are supported", "Use 1c.", row.line
            )
        ends = [_identifier(deck, row, f"MJointID{i}", "J", i) for i in (1, 2)]
        for i, joint in enumerate(ends):
            _known(deck, joint, joints, f"MJointID{i + 1}", row.line)
        pair = [_identifier(deck, row, f"MPropSetID{i}", "P", i + 2) for i in (1, 2)]
        for i, section in enumerate(pair):
            if section not in sections:
                raise deck.refuse(
                    f"MPropSetID{i + 1}",
                    section[1:],
                    "is not a circular property set of this file",
                    "Rectangular and arbitrary sections, cables, rigid links and springs are not supported.",
                    row.line,
                )
        if sections[pair[0]] != sections[pair[1]]:
            raise deck.refuse(
                "MPropSetID2",
                pair[1][1:],
                f"differs from set {pair[0][1:]} at the other end",
                "Tapered members are not supported: divide the member into steps.",
                row.line,
            )
        members[name] = {"joints": ends, "section": pair[0]}
        used[pair[0]] = None
    return members, list(used)


def _flags(deck: _Deck, row: _Row, names: tuple[str, ...]) -> list[bool]:
    flags = []
    for name, text in zip(names, row.tokens[1:7], strict=False):
        if text.lower() not in ("0", "1", "t", "f", "true", "false"):
            raise deck.refuse(name, text, "must be 0 or 1", "Check the columns of this line.", row.line)
        flags.append(text.lower() in ("1", "t", "true"))
    return flags


def _reactions(deck: _Deck, rows: list[_Row], joints: dict[str, list[float]]) -> dict[str, list[bool]]:
    if not rows:
        raise deck.refuse("NReact", 0, "must be at least 1", "A structure without supports is a mechanism.")
    names = ("RctTDXss", "RctTDYss", "RctTDZss", "RctRDXss", "RctRDYss", "RctRDZss")
    supports: dict[str, list[bool]] = {}
    for row in rows:
        name = _identifier(deck, row, "RJointID", "J")
        _new(deck, name, supports, "RJointID", row.line)
        _known(deck, name, joints, "RJointID", row.line)
        flags = _flags(deck, row, names)
        if len(flags) < 6:
            raise deck.refuse(names[len(flags)], "nothing", "is missing", "Give six flags.", row.line)
        if len(row.tokens) > 7 and row.tokens[7].strip("\"' ").lower() not in ("", "none", "unused"):
            raise deck.refuse(
                "SSIfile",
                row.tokens[7],
                "is not supported",
                "Clamp the joint, or model the soil as members.",
                row.line,
            )
        if not any(flags):
            raise deck.refuse("RctTDXss", 0, "leaves the joint free in all directions", "Fix some.", row.line)
        supports[name] = flags
    return supports


def _interface(deck: _Deck, rows: list[_Row], joints: dict[str, list[float]]) -> list[str]:
    if not rows:
        raise deck.refuse("NInterf", 0, "must be at least 1", "Name the joints of the transition piece.")
    names = ("ItfTDXss", "ItfTDYss", "ItfTDZss", "ItfRDXss", "ItfRDYss", "ItfRDZss")
    interface: dict[str, None] = {}
    pieces = set()
    for row in rows:
        name = _identifier(deck, row, "IJointID", "J")
        _new(deck, name, interface, "IJointID", row.line)
        _known(deck, name, joints, "IJointID", row.line)
        n = len(row.tokens)
        flagged = n >= 7
        if flagged and not all(_flags(deck, row, names)):
            raise deck.refuse(
                "ItfTDXss",
                row.tokens[1:7],
                "must be locked in all six directions",
                "A partly free interface is not supported.",
                row.line,
            )
        if n == 2 or n >= 8:
            pieces.add(row.tokens[7] if flagged else row.tokens[1])
        interface[name] = None
    if len(pieces) > 1:
        raise deck.refuse("TPID", sorted(pieces), "must be one transition piece", "Import one at a time.")
    return list(interface)


def _masses(deck: _Deck, rows: list[_Row], joints: dict[str, list[float]]) -> dict[str, Any]:
    masses: dict[str, Any] = {}
    diagonal = ("JMass", "JMXX", "JMYY", "JMZZ")
    others = ("JMXY", "JMXZ", "JMYZ", "MCGX", "MCGY", "MCGZ")
    for row in rows:
        name = _identifier(deck, row, "CMJointID", "J")
        _new(deck, name, masses, "CMJointID", row.line)
        _known(deck, name, joints, "CMJointID", row.line)
        mass, *inertia = _columns(deck, row, diagonal)
        more = _columns(deck, row, others, first=5) if len(row.tokens) > 5 else [0.0] * 6
        if mass < 0.0:
            raise deck.refuse("JMass", mass, "must be at least 0 kg", "Check the file.", row.line)
        masses[name] = {"mass_kg": mass, "inertia_kg_m2": inertia + more[:3], "offset_m": more[3:]}
    return masses
