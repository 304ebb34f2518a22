"""Parts of a structure as data: sections, members and their releases, springs, masses, tower, water.

What they make together is :class:`owt_model.structure.Structure`.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from owt_model.errors import InputError
from owt_model.validation import Frozen

__all__ = [
    "AddedMass",
    "Dashpot",
    "Fixity",
    "Flooding",
    "Interface",
    "JointSpring",
    "MarineGrowth",
    "Member",
    "Point",
    "PointMass",
    "Positive",
    "Release",
    "RigidLink",
    "RotorNacelle",
    "Section",
    "Spring",
    "SpringMatrix",
    "StaticState",
    "SupportSpring",
    "Tower",
]

Coordinate = Annotated[float, Field(ge=-1e5, le=1e5)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Fixity = tuple[bool, bool, bool, bool, bool, bool]


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


class Release(Frozen):
    """Rotations in which a member's end is free of its joint."""

    about: Literal["x", "y", "z", "xy", "xz", "yz", "xyz"] = Field(
        "xyz",
        description="axes of the member about which its end turns freely, x along it: xyz is a ball joint, "
        "yz a bar of a truss, which still takes torsion",
    )
    hinge: Point | None = Field(
        None, description="one global direction about which the end turns freely, instead of `about`"
    )
    stiffness_nm_rad: NonNegative = Field(
        0.0, description="rotational spring in N m/rad between joint and end, about each free axis"
    )

    @model_validator(mode="after")
    def _one_kind(self) -> Release:
        if self.hinge is not None:
            if "about" in self.model_fields_set:
                raise InputError("release.about", self.about, "excludes `hinge`", "Give one of the two.")
            if not any(self.hinge):
                raise InputError("release.hinge", self.hinge, "must have a direction", "Give [0, 1, 0].")
        return self


class Member(Frozen):
    """A straight tube from its first to its second joint."""

    joints: tuple[str, str]
    section: str
    section_last: str | None = Field(
        None, description="section at the second joint of a tapered member; diameter and wall vary linearly"
    )
    flooded: bool = Field(False, description="filled with water up to the free surface of `flooding`")
    release_first: Release | None = Field(None, description="release at the first joint")
    release_last: Release | None = Field(None, description="release at the second joint")

    @property
    def releases(self) -> tuple[Release | None, Release | None]:
        """Releases at the first and at the second joint."""
        return self.release_first, self.release_last


class RigidLink(Frozen):
    """Joints that move as one rigid body."""

    joints: tuple[str, ...] = Field(min_length=2)


#: Beyond it a spring is a support, and sums lose their digits.
Coefficient = Annotated[float, Field(ge=-1e20, le=1e20)]
SpringRow = Annotated[tuple[Coefficient, ...], Field(min_length=6, max_length=6)]
SpringMatrix = Annotated[tuple[SpringRow, ...], Field(min_length=6, max_length=6)]
#: Beyond it a dashpot holds like a support, and weaker ones lose their digits beside it.
Damper = Annotated[float, Field(ge=-1e15, le=1e15)]
DashpotRow = Annotated[tuple[Damper, ...], Field(min_length=6, max_length=6)]
DashpotMatrix = Annotated[tuple[DashpotRow, ...], Field(min_length=6, max_length=6)]


def _six_by_six(given: SpringRow | SpringMatrix) -> SpringMatrix:
    """Six coefficients as a diagonal matrix; a matrix as it is."""
    rows = [row for row in given if isinstance(row, tuple)]
    if rows:
        return tuple(rows)
    diagonal = [value for value in given if not isinstance(value, tuple)]
    return tuple(tuple(k if i == j else 0.0 for j in range(6)) for i, k in enumerate(diagonal))


def _check_passive(field: str, given: SpringMatrix) -> None:
    """Refuse a matrix that is not symmetric, or gives energy in some direction."""
    matrix = np.array(given)
    if not np.array_equal(matrix, matrix.T):
        raise InputError(field, "a matrix", "must be symmetric", "Check its entries.")
    # Scaled to a unit diagonal: translations and rotations have different units.
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), 1e-300))
    lowest = float(np.linalg.eigvalsh(matrix / scale[:, None] / scale)[0])
    if not lowest >= -1e-9:
        raise InputError(
            field,
            lowest,
            "must not be negative in any direction (lowest eigenvalue, scaled)",
            "Check signs and units.",
        )


class Spring(Frozen):
    """Linear spring in six directions."""

    stiffness: SpringRow | SpringMatrix = Field(
        description="six stiffnesses (x, y, z in N/m, about x, y, z in N m/rad) or a symmetric 6 x 6 matrix"
    )

    @model_validator(mode="after")
    def _passive(self) -> Spring:
        _check_passive("springs.*.stiffness", self.matrix)
        return self

    @property
    def matrix(self) -> SpringMatrix:
        """The 6 x 6 stiffness."""
        return _six_by_six(self.stiffness)


class Dashpot(Frozen):
    """Viscous damper in six directions, global axes: from one place to the ground, or between two.

    Between two it resists their relative motion, at the second.
    """

    joints: Annotated[tuple[str, ...], Field(min_length=1, max_length=2)] = Field(
        description="one or two joints, or tower_top"
    )
    damping: DashpotRow | DashpotMatrix = Field(
        description="six coefficients (x, y, z in N s/m, about x, y, z in N m s/rad) or a symmetric 6 x 6 "
        "matrix"
    )

    @model_validator(mode="after")
    def _passive(self) -> Dashpot:
        _check_passive("dashpots.*.damping", self.matrix)
        if len(set(self.joints)) < len(self.joints):
            raise InputError(
                "dashpots.*.joints", self.joints, "must be two places", "Name one for the ground."
            )
        return self

    @property
    def matrix(self) -> SpringMatrix:
        """The 6 x 6 damping."""
        return _six_by_six(self.damping)


class SupportSpring(Spring):
    """Elastic support of a joint, global axes; it acts in the directions that `supports` leaves free."""


class JointSpring(Spring):
    """Spring between two joints, at the second: it resists their relative motion, in global axes."""

    joints: tuple[str, str]


class StaticState(Frozen):
    """Weights at rest, and what the axial forces that they cause do to the stiffness."""

    gravity_m_s2: Positive = Field(9.81, description="gravity in m/s2")
    buoyancy: bool = Field(True, description="displaced water of `added_mass` carries the wet members")
    p_delta: bool = Field(True, description="geometric stiffness of the axial forces")


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
