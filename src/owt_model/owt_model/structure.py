"""A structure as data: joints, members, sections, supports, interface, tower, masses and zones.

Read from a YAML file (shipped: ``oc4``, ``oc4-thesis``) or imported from a SubDyn deck
(:mod:`owt_model.subdyn`). Positions are in m, x, y horizontal, z up from still water.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import Field, ValidationError, model_validator

from owt_model.errors import InputError
from owt_model.parts import (
    AddedMass,
    Dashpot,
    Fixity,
    Flooding,
    Interface,
    JointSpring,
    MarineGrowth,
    Member,
    Point,
    PointMass,
    Positive,
    Release,
    RigidLink,
    RotorNacelle,
    Section,
    StaticState,
    SupportSpring,
    Tower,
)
from owt_model.structure_config import StructureConfig
from owt_model.structure_names import TOWER_TOP, check_names
from owt_model.validation import Frozen, input_error

__all__ = [
    "AddedMass",
    "Dashpot",
    "Flooding",
    "Interface",
    "JointSpring",
    "MarineGrowth",
    "Member",
    "PointMass",
    "Release",
    "RigidLink",
    "RotorNacelle",
    "Section",
    "StaticState",
    "Structure",
    "SupportSpring",
    "Tower",
    "case_structure",
    "load_structure",
    "parse_structure",
    "shipped_structures",
    "with_weights",
]


class Structure(Frozen):
    """A bottom-fixed support structure with an optional tower and rotor-nacelle mass."""

    name: str = Field(min_length=1)
    description: str = ""
    sources: tuple[str, ...] = ()
    beam: Literal["euler-bernoulli", "timoshenko"] = "euler-bernoulli"
    mass: Literal["consistent", "lumped"] = Field(
        "consistent",
        description="mass of the elements: consistent, or halves at the nodes with the rotary terms of the "
        "scaled diagonal (HRZ)",
    )
    rotary_inertia: bool = Field(False, description="rotary inertia of the members' sections in bending")
    elements_per_member: Annotated[int, Field(ge=1, le=100)] = 4
    extra_mass: Literal["distributed", "joints"] = Field(
        "distributed",
        description="growth, flood water and added mass: distributed along the members, or isotropic masses "
        "at the joints with the zone decided by the member's midpoint (thesis)",
    )
    mudline_z_m: float
    sections: dict[str, Section]
    joints: dict[str, Point]
    members: dict[str, Member]
    supports: dict[str, Fixity] = Field(
        default_factory=dict, description="joint: six flags, true for a fixed degree of freedom"
    )
    free: bool = Field(
        False, description="no supports needed: only the modes with the interface held are of interest"
    )
    support_springs: dict[str, SupportSpring] = Field(default_factory=dict, description="elastic supports")
    joint_springs: dict[str, JointSpring] = Field(
        default_factory=dict, description="springs between two joints, which may lie on the same place"
    )
    rigid_links: dict[str, RigidLink] = Field(default_factory=dict)
    interface: Interface
    point_masses: dict[str, PointMass] = Field(default_factory=dict, description="at joints")
    transition_piece: PointMass = Field(default_factory=PointMass)
    tower: Tower | None = None
    rotor_nacelle: RotorNacelle | None = None
    marine_growth: MarineGrowth | None = None
    flooding: Flooding | None = None
    added_mass: AddedMass | None = None
    static_state: StaticState | None = Field(
        None, description="count the weights' geometric stiffness in every analysis"
    )
    dashpots: dict[str, Dashpot] = Field(
        default_factory=dict, description="viscous dampers of joints and tower top"
    )
    jacket_stiffness_factor: Positive = Field(
        1.0, description="factor on the stiffness of the members, not of the tower: for sensitivity studies"
    )
    notes: tuple[str, ...] = Field((), description="what an import left out")

    @model_validator(mode="after")
    def _consistent(self) -> Structure:
        check_names(self.joints, self.members, self.elements_per_member, self.tower)
        self._check_references()
        self._check_geometry()
        if self.rotor_nacelle is not None and self.tower is None:
            raise InputError("rotor_nacelle", "given", "needs a tower to stand on", "Add a tower.")
        return self

    def _check_references(self) -> None:
        def known(field: str, name: str, table: dict[str, Any], what: str) -> None:
            if name not in table:
                raise InputError(field, name, f"is not a {what} of the structure", f"Add it to `{what}s`.")

        for name, member in self.members.items():
            known(f"members.{name}.section", member.section, self.sections, "section")
            if member.section_last is not None:
                known(f"members.{name}.section_last", member.section_last, self.sections, "section")
                self._check_taper(name, member)
            for joint in member.joints:
                known(f"members.{name}.joints", joint, self.joints, "joint")
            if member.flooded and self.flooding is None:
                raise InputError(
                    f"members.{name}.flooded", True, "needs `flooding`", "Give density and level."
                )
        for field, names in (
            ("supports", self.supports),
            ("support_springs", self.support_springs),
            ("interface.joints", self.interface.joints),
            ("point_masses", self.point_masses),
        ):
            for joint in names:
                known(field, joint, self.joints, "joint")
        for table, parts in (("rigid_links", self.rigid_links), ("joint_springs", self.joint_springs)):
            for name, part in parts.items():
                for joint in part.joints:
                    known(f"{table}.{name}.joints", joint, self.joints, "joint")
        for name, dashpot in self.dashpots.items():
            for joint in set(dashpot.joints) - {TOWER_TOP}:
                known(f"dashpots.{name}.joints", joint, self.joints, "joint")
        if not (self.supports or self.support_springs or self.free):
            raise InputError(
                "supports", {}, "must name at least one joint", "A free structure is a mechanism."
            )

    def _check_taper(self, name: str, member: Member) -> None:
        """Only the tube may change along a member, not its material."""
        first, last = self.sections[member.section], self.sections[member.section_last or ""]
        for key in ("youngs_modulus_pa", "shear_modulus_pa", "density_kg_m3"):
            if getattr(first, key) != getattr(last, key):
                raise InputError(
                    f"members.{name}.section_last",
                    member.section_last,
                    f"has another {key} than {member.section}",
                    "Divide the member where the material changes.",
                )

    def _check_geometry(self) -> None:
        at: dict[Point, str] = {}
        for name, place in self.joints.items():
            x, y, z = place
            other = at.setdefault((round(x, 6), round(y, 6), round(z, 6)), name)
            sprung = {frozenset(spring.joints) for spring in self.joint_springs.values()}
            if other != name and frozenset((other, name)) not in sprung:
                raise InputError(
                    f"joints.{other}", place, f"lies on another joint, {name} (within 1e-6 m)", "Merge them."
                )
        used = {joint for part in self._connections() for joint in part}
        for name in self.joints:
            if name not in used:
                raise InputError(f"joints.{name}", name, "is connected to no member", "Remove or connect it.")
        pairs: set[frozenset[str]] = set()
        for name, member in self.members.items():
            pair = frozenset(member.joints)
            if len(pair) == 1:
                raise InputError(
                    f"members.{name}",
                    member.joints,
                    "starts where it ends: no length",
                    "Name two joints.",
                )
            if pair in pairs:
                raise InputError(f"members.{name}", member.joints, "duplicates another member", "Remove one.")
            pairs.add(pair)
        repeated = [name for name, n in Counter(self.interface.joints).items() if n > 1]
        if repeated:
            raise InputError("interface.joints", repeated, "are listed twice", "List each joint once.")
        overlap = set(self.interface.joints) & (set(self.supports) | set(self.support_springs))
        if overlap:
            raise InputError(
                "interface.joints", sorted(overlap), "are also supports", "Choose one of the two."
            )
        self.rigid_groups()

    def _connections(self) -> list[tuple[str, ...]]:
        """Joints of each member, rigid link and spring."""
        members = [member.joints for member in self.members.values()]
        links = [link.joints for link in self.rigid_links.values()]
        return [*members, *links, *(spring.joints for spring in self.joint_springs.values())]

    def rigid_groups(self) -> dict[str, str]:
        """Joint that each joint of a rigid link follows: its group's interface joint, support, or first.

        Raises
        ------
        InputError
            If one rigid body holds two supported joints, or a supported one and one of the interface.
        """
        leader: dict[str, str] = {}
        for link in self.rigid_links.values():
            merged = {leader.get(joint, joint) for joint in link.joints}
            group = {j for j, of in leader.items() if of in merged} | set(link.joints)
            tied = [joint for joint in self.interface.joints if joint in group]
            held = [joint for joint in self.joints if joint in group and joint in self.supports]
            if len(held) > 1 or (held and tied):
                raise InputError(
                    "rigid_links",
                    [*held, *tied],
                    "are held twice: one rigid body may have one supported joint, or be on the interface",
                    "Support one of its joints, or use members.",
                )
            first = [joint for joint in self.joints if joint in group]
            leader |= dict.fromkeys(group, [*tied, *held, *first][0])
        return leader

    @property
    def content_hash(self) -> str:
        """SHA-256 of the canonical content: two structures with the same hash give the same numbers."""
        canonical = json.dumps(self.model_dump(mode="json"), sort_keys=True)
        return hashlib.sha256(canonical.encode()).hexdigest()

    def check_water_depth(self, water_depth_m: float) -> None:
        """Refuse a water depth more than 1 m from the model's mudline.

        Raises
        ------
        InputError
            If it is.
        """
        if abs(water_depth_m + self.mudline_z_m) > 1.0:
            raise InputError(
                "water_depth_m",
                water_depth_m,
                f"lies more than 1 m from the mudline of {self.name} at z = {self.mudline_z_m} m",
                f"Use {-self.mudline_z_m:g} m or another structure.",
            )


def shipped_structures() -> list[str]:
    """Names of the structures that come with the package."""
    folder = resources.files("owt_model") / "structures"
    return sorted(
        entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml")
    )


def parse_structure(data: Any, *, source: str) -> Structure:
    """Validate a structure given as plain data (what YAML holds).

    Raises
    ------
    InputError
        Naming the first offending field, its value, the limit and the remedy.
    """
    if not isinstance(data, dict):
        raise InputError(source, data, "must be a mapping", "See the shipped structures for an example.")
    try:
        return Structure.model_validate_json(json.dumps(data))
    except ValidationError as error:
        raise input_error(error, Structure, remedy=f"See {source}.") from None
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(
            source, "data", f"holds something that is not plain data ({error})", "Quote it."
        ) from None


def load_structure(model: str) -> Structure:
    """Load a shipped structure by name, or a YAML file or SubDyn deck (``.dat``) by path.

    Raises
    ------
    InputError
        If there is no such structure, or it is not a valid one.
    """
    if model in shipped_structures():
        text = (resources.files("owt_model") / "structures" / f"{model}.yaml").read_text(encoding="utf-8")
        return parse_structure(_yaml(text, model), source=f"{model}.yaml")
    path = Path(model)
    if not path.is_file():
        raise InputError(
            "structure.model",
            model,
            "is neither a shipped structure nor a file",
            f"Shipped are: {', '.join(shipped_structures())}.",
        )
    is_yaml = path.suffix.lower() in (".yaml", ".yml")
    given = _text(path, legacy=not is_yaml)
    if given is None:
        raise InputError("structure.model", model, "cannot be read as text", "Give a YAML or SubDyn file.")
    if is_yaml:
        return parse_structure(_yaml(given, model), source=model)
    from owt_model.subdyn import parse_subdyn  # imported here: subdyn builds on this module

    def beside(name: str) -> str | None:
        return _text(path.parent / name.replace("\\", "/"), legacy=True)

    return parse_subdyn(given, source=model, read=beside)


def _text(path: Path, *, legacy: bool) -> str | None:
    """Text of a file, None where there is none; `legacy` takes comments of any one-byte encoding."""
    try:
        data = path.read_bytes()
        if legacy and b"\0" not in data:
            try:
                return data.decode("utf-8-sig")
            except UnicodeDecodeError:
                return data.decode("latin-1")
        return data.decode("utf-8")
    except (OSError, ValueError):
        return None


def case_structure(config: StructureConfig, given: Structure | None = None) -> Structure:
    """Load the structure of a case, or take the one given, with what the case changes in it.

    Raises
    ------
    InputError
        As :func:`load_structure`.
    """
    names = ("jacket_stiffness_factor", "static_state")
    changes = {name: getattr(config, name) for name in names if getattr(config, name) is not None}
    return (given or load_structure(config.model)).model_copy(update=changes)


def with_weights(structure: Structure) -> Structure:
    """Count the geometric stiffness of the weights: as the structure says, of all where it says nothing."""
    if structure.static_state is not None:
        return structure
    return structure.model_copy(update={"static_state": StaticState()})


class _UniqueKeys(yaml.SafeLoader):
    """A SafeLoader that refuses a mapping which names a key twice: one of the two would be lost."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Build a mapping from unique keys."""
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for key, n in Counter(map(str, keys)).items():
            if n > 1:
                line = node.start_mark.line + 1
                raise InputError(
                    key, "", f"is given twice in the mapping of line {line}", "Keep one of the two."
                )
        return super().construct_mapping(node, deep=deep)


# YAML 1.1 takes 1e8 and 6.1e4 for text, everybody else for numbers.
_UniqueKeys.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def _yaml(text: str, source: str) -> Any:
    try:
        return yaml.load(text, Loader=_UniqueKeys)
    except InputError:
        raise
    # PyYAML lets the errors of its constructors through: dates, numbers and tags that cannot be.
    except (yaml.YAMLError, ValueError, KeyError, AttributeError, TypeError, RecursionError) as error:
        problem = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError("structure.model", source, f"is not YAML ({problem})", "Check its syntax.") from None
