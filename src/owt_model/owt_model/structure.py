"""A structure as data: joints, members, sections, supports, interface, tower, masses and zones.

Read from a YAML file (shipped: ``oc4``, ``oc4-thesis``) or imported from a SubDyn deck
(:mod:`owt_model.subdyn`). Positions are in m, x, y horizontal, z up from still water.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import Field, ValidationError, model_validator

from owt_model.errors import InputError
from owt_model.validation import Frozen, input_error

__all__ = [
    "AddedMass",
    "Flooding",
    "Interface",
    "MarineGrowth",
    "Member",
    "PointMass",
    "RotorNacelle",
    "Section",
    "Structure",
    "Tower",
    "load_structure",
    "parse_structure",
    "shipped_structures",
]

Coordinate = Annotated[float, Field(ge=-1e5, le=1e5)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Fixity = tuple[bool, bool, bool, bool, bool, bool]
CLAMPED: Fixity = (True, True, True, True, True, True)


class Section(Frozen):
    """Circular hollow section of one material."""

    diameter_m: Positive = Field(description="outer diameter in m")
    thickness_m: Positive = Field(description="wall thickness in m")
    youngs_modulus_pa: Positive = Field(description="Young's modulus in Pa")
    shear_modulus_pa: Positive = Field(description="shear modulus in Pa")
    density_kg_m3: NonNegative = Field(description="density of the wall in kg/m3")

    @model_validator(mode="after")
    def _tube(self) -> Section:
        if 2.0 * self.thickness_m > self.diameter_m:
            raise InputError(
                "sections.*.thickness_m",
                self.thickness_m,
                f"must be at most half of the diameter {self.diameter_m} m",
                "Check the section table.",
            )
        return self


class Member(Frozen):
    """A straight tube from its first to its second joint."""

    joints: tuple[str, str]
    section: str
    flooded: bool = Field(False, description="filled with water up to the free surface of `flooding`")


class Interface(Frozen):
    """Joints tied rigidly to one six-degree-of-freedom node, the transition piece."""

    joints: tuple[str, ...] = Field(min_length=1)
    reference_m: Point = Field(description="position of the transition-piece node in m")


class PointMass(Frozen):
    """Mass and inertia about the node; `offset_m` is the centre of gravity seen from the node."""

    mass_kg: NonNegative = 0.0
    inertia_kg_m2: Annotated[tuple[float, ...], Field(min_length=6, max_length=6)] = Field(
        (0.0,) * 6, description="Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of gravity, in kg m2"
    )
    offset_m: Point = (0.0, 0.0, 0.0)


class Tower(Frozen):
    """Tower of linearly tapering diameter and parabolic wall thickness, from the transition piece up."""

    height_m: Positive
    elements: Annotated[int, Field(ge=1, le=1000)] = 17
    diameter_base_m: Positive
    diameter_top_m: Positive
    thickness_base_m: Positive
    thickness_mid_m: Positive
    thickness_top_m: Positive
    youngs_modulus_pa: Positive
    shear_modulus_pa: Positive
    density_kg_m3: Positive

    @model_validator(mode="after")
    def _wall(self) -> Tower:
        for s in np.linspace(0.0, 1.0, 101):
            wall, diameter = self.thickness_at(float(s)), self.diameter_at(float(s))
            if not 0.0 < 2.0 * wall <= diameter or wall < 0.2 * min(
                self.thickness_base_m, self.thickness_top_m
            ):
                raise InputError(
                    "tower.thickness_mid_m",
                    self.thickness_mid_m,
                    f"makes the parabolic wall {wall:.3g} m thick at {s:.0%} of the height",
                    "Choose a middle thickness between those of base and top.",
                )
        return self

    def diameter_at(self, s: float) -> float:
        """Outer diameter in m at the share `s` of the height."""
        return self.diameter_base_m + (self.diameter_top_m - self.diameter_base_m) * s

    def thickness_at(self, s: float) -> float:
        """Wall thickness in m at the share `s` of the height: a parabola through base, mid and top."""
        base, mid, top = self.thickness_base_m, self.thickness_mid_m, self.thickness_top_m
        return base * (1 - s) * (1 - 2 * s) + 4 * mid * s * (1 - s) + top * s * (2 * s - 1)


class RotorNacelle(PointMass):
    """Rotor-nacelle assembly, lumped at the tower top."""


class MarineGrowth(Frozen):
    """Marine growth of constant thickness between two levels."""

    thickness_m: Positive
    density_kg_m3: Positive
    z_bottom_m: float
    z_top_m: float

    @model_validator(mode="after")
    def _upright(self) -> MarineGrowth:
        if self.z_bottom_m >= self.z_top_m:
            raise InputError(
                "marine_growth.z_bottom_m",
                self.z_bottom_m,
                f"must lie below z_top_m = {self.z_top_m} m",
                "z is up from still water.",
            )
        return self


class Flooding(Frozen):
    """Water inside the flooded members, up to its free surface."""

    density_kg_m3: Positive
    free_surface_z_m: float = 0.0


class AddedMass(Frozen):
    """Added mass of the displaced water, growth included."""

    coefficient: NonNegative = 1.0
    density_kg_m3: Positive
    free_surface_z_m: float = 0.0


class Structure(Frozen):
    """A bottom-fixed support structure with an optional tower and rotor-nacelle mass."""

    name: str = Field(min_length=1)
    description: str = ""
    sources: tuple[str, ...] = ()
    beam: Literal["euler-bernoulli", "timoshenko"] = "euler-bernoulli"
    rotary_inertia: bool = Field(False, description="rotary inertia in the consistent mass of the members")
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
    supports: dict[str, Fixity] = Field(description="joint: six flags, true for a fixed degree of freedom")
    interface: Interface
    point_masses: dict[str, PointMass] = Field(default_factory=dict, description="at joints")
    transition_piece: PointMass = Field(default_factory=PointMass)
    tower: Tower | None = None
    rotor_nacelle: RotorNacelle | None = None
    marine_growth: MarineGrowth | None = None
    flooding: Flooding | None = None
    added_mass: AddedMass | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Structure:
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
            for joint in member.joints:
                known(f"members.{name}.joints", joint, self.joints, "joint")
            if member.flooded and self.flooding is None:
                raise InputError(
                    f"members.{name}.flooded", True, "needs `flooding`", "Give density and level."
                )
        for field, names in (
            ("supports", self.supports),
            ("interface.joints", self.interface.joints),
            ("point_masses", self.point_masses),
        ):
            for joint in names:
                known(field, joint, self.joints, "joint")
        if not self.supports:
            raise InputError(
                "supports", {}, "must name at least one joint", "A free structure is a mechanism."
            )

    def _check_geometry(self) -> None:
        places = Counter(self.joints.values())
        for name, place in self.joints.items():
            if places[place] > 1:
                raise InputError(f"joints.{name}", place, "lies on another joint", "Merge the two joints.")
        used = {joint for member in self.members.values() for joint in member.joints}
        for name in self.joints:
            if name not in used:
                raise InputError(f"joints.{name}", name, "is connected to no member", "Remove or connect it.")
        pairs: set[frozenset[str]] = set()
        for name, member in self.members.items():
            pair = frozenset(member.joints)
            if len(pair) == 1:
                raise InputError(f"members.{name}", member.joints, "starts where it ends", "Name two joints.")
            if pair in pairs:
                raise InputError(f"members.{name}", member.joints, "duplicates another member", "Remove one.")
            pairs.add(pair)
        repeated = [name for name, n in Counter(self.interface.joints).items() if n > 1]
        if repeated:
            raise InputError("interface.joints", repeated, "are listed twice", "List each joint once.")
        overlap = set(self.interface.joints) & set(self.supports)
        if overlap:
            raise InputError(
                "interface.joints", sorted(overlap), "are also supports", "Choose one of the two."
            )

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
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise InputError(
            "structure.model", model, "cannot be read as text", "Give a YAML or SubDyn file."
        ) from None
    if path.suffix.lower() in (".yaml", ".yml"):
        return parse_structure(_yaml(text, model), source=model)
    from owt_model.subdyn import parse_subdyn  # imported here: subdyn builds on this module

    return parse_subdyn(text, source=model)


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


def _yaml(text: str, source: str) -> Any:
    try:
        return yaml.load(text, Loader=_UniqueKeys)
    except InputError:
        raise
    # PyYAML lets the errors of its constructors through: dates, numbers and tags that cannot be.
    except (yaml.YAMLError, ValueError, KeyError, AttributeError, TypeError, RecursionError) as error:
        problem = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError("structure.model", source, f"is not YAML ({problem})", "Check its syntax.") from None
