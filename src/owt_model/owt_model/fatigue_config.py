"""How stress becomes damage, as the case says it: S-N curves, hot spots, choices for single joints."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from owt_model.validation import Frozen

__all__ = ["Fatigue", "JointChoice", "JointFactors", "SideFactors"]

Factor = Annotated[float, Field(ge=0.0, le=100.0)]


class SideFactors(Frozen):
    """Stress concentration factors of one side of a connection; null for Efthymiou's."""

    axial_crown: Factor | None = Field(None, description="axial load of the brace, at the crowns")
    axial_saddle: Factor | None = Field(None, description="axial load of the brace, at the saddles")
    in_plane: Factor | None = Field(None, description="in-plane bending of the brace, at the crowns")
    out_of_plane: Factor | None = Field(None, description="out-of-plane bending of the brace, at the saddles")


class JointFactors(Frozen):
    """Stress concentration factors of a connection on nominal stress in the brace."""

    chord: SideFactors = Field(default_factory=SideFactors)
    brace: SideFactors = Field(default_factory=SideFactors)


class JointChoice(Frozen):
    """What is known of a joint, or of one brace end at it, and replaces what the geometry says."""

    chord: tuple[str, ...] | None = Field(
        None, min_length=1, max_length=2, description="members of the chord, one or two; for joints only"
    )
    chord_thickness_m: float | None = Field(
        None, gt=0.0, le=1.0, description="wall of the chord at the joint in m: the thickness of its can"
    )
    chord_length_m: float | None = Field(None, gt=0.0, le=1000.0, description="chord length L in m")
    gap_m: float | None = Field(
        None, ge=-10.0, le=10.0, description="gap in m between neighbouring braces of a plane, < 0: overlap"
    )
    scf: JointFactors | None = Field(
        None, description="own factors; the load of other braces then has no influence"
    )


class Fatigue(Frozen):
    """How stress becomes damage."""

    sn_curve: str = Field(
        "T_cathodic_protection",
        min_length=1,
        description="name of the S-N curve of the hot spots of tubular joints",
    )
    sn_file: str | None = Field(
        None, min_length=1, description="YAML file of S-N curves of your own; null for the package's alone"
    )
    wall_sn_curve: str | None = Field(
        None, min_length=1, description="S-N curve of the walls elsewhere; null for that of the joints"
    )
    thickness_effect: bool = Field(
        True, description="count walls thicker than the S-N curve's reference as weaker"
    )
    hot_spots: Literal["efthymiou", "nominal"] = Field(
        "efthymiou",
        description="stress that is counted: hot-spot stress of tubular joints, or nominal stress only",
    )
    scf: float = Field(
        1.0,
        ge=1.0,
        le=50.0,
        description="stress concentration factor on the nominal stress of walls away from tubular joints",
    )
    scf_range: Literal["report", "larger", "clamp", "refuse"] = Field(
        "report",
        description="geometry outside the range of the equations: taken and reported, the larger of it and "
        "the limits, the limits, or an error",
    )
    scf_minimum: float = Field(
        1.5, ge=0.0, le=10.0, description="least stress concentration factor by Efthymiou's equations"
    )
    chord_effect: Literal["frame", "length"] = Field(
        "frame",
        description="bending of the chord at the crowns: nominal stress of the chord, or by its length alpha",
    )
    chord_fixity: float = Field(
        0.7,
        ge=0.5,
        le=1.0,
        description="fixity C of the chord's ends, 0.5 fixed to 1 pinned, with its length",
    )
    design_life_years: float = Field(
        25.0, gt=0.0, le=1000.0, description="design life in years, for the utilisation that reports show"
    )
    design_fatigue_factor: float = Field(
        3.0, ge=1.0, le=100.0, description="factor on damage in the utilisation that reports show"
    )
    joints: dict[str, JointChoice] = Field(
        default_factory=dict,
        description="choices by joint (J21) or brace end (M056:J21), which goes before the joint",
    )
