"""The one configuration object: a load case, validated, frozen, units in the field names.

The case file, the ROS parameters, the launch arguments and the command-line flags are all derived
from :class:`CaseConfig`; ``docs/case.schema.json`` is its JSON schema. Defaults are those of thesis
table 4.3.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from owt_model.errors import InputError
from owt_model.fatigue_config import Fatigue
from owt_model.live_config import LiveElevation
from owt_model.sea_config import (
    Components,
    Coordinate,
    Current,
    Focus,
    Measured,
    RegularWave,
    SeaStateConfig,
    SpectrumFile,
)
from owt_model.structure_config import Damping, StructureConfig
from owt_model.validation import Frozen, input_error
from owt_model.wind_config import WindConfig

__all__ = [
    "SEA_SOURCES",
    "CaseConfig",
    "Components",
    "Current",
    "Damping",
    "Fatigue",
    "Focus",
    "LiveElevation",
    "Measured",
    "Morison",
    "RegularWave",
    "SeaStateConfig",
    "SpectrumFile",
    "Stream",
    "StructureConfig",
    "Time",
    "Wave",
    "WindConfig",
    "load_case",
    "parse_case",
    "parse_case_text",
]

#: Steepness 2 pi Hs / (g Tp^2) above which a sea state cannot exist (limit of a single deep-water wave).
MAX_STEEPNESS = 1.0 / 7.0
#: Hs over water depth above which a sea state cannot exist (depth-limited breaking).
MAX_HEIGHT_OVER_DEPTH = 0.6

#: Ways to give the sea of a case; exactly one is set.
SEA_SOURCES = ("sea_state", "components", "spectrum_file", "measured", "regular")


class Wave(Frozen):
    """Wave theory and what is done above still water."""

    order: Literal[1, 2] = Field(2, description="perturbation order")
    stretching: Literal["taylor", "wheeler", "constant", "none"] = Field(
        "taylor", description="kinematics above still water"
    )
    route: Literal["auto", "exact", "compressed", "direct"] = Field(
        "auto", description="how pairs are summed: exact (single summation), compressed, or direct sums"
    )
    window: int | None = Field(
        None, ge=64, le=10_000_000, description="samples of loads held at a time; null chooses"
    )

    @model_validator(mode="after")
    def _wheeler_is_first_order(self) -> Wave:
        if self.order == 2 and self.stretching == "wheeler":
            raise InputError(
                "wave.stretching",
                "wheeler",
                "stretches the first order only and is refused at order 2",
                "Use taylor at order 2, or order 1.",
            )
        return self


class Time(Frozen):
    """Sampling of waves and loads."""

    dt_s: float = Field(0.1, gt=0.0, le=60.0, description="time step of waves and loads in s")
    n: int = Field(6000, ge=2, le=10_000_000, description="number of samples")

    @property
    def duration_s(self) -> float:
        """Length n dt of the record in s."""
        return self.n * self.dt_s


#: A coefficient, or a table of levels z in m and values, linear between them and constant beyond.
Coefficient = (
    Annotated[float, Field(ge=0.0, le=10.0)]
    | tuple[tuple[Coordinate, Annotated[float, Field(ge=0.0, le=10.0)]], ...]
)


class Morison(Frozen):
    """Morison loads (thesis 4.2.3)."""

    cd: Coefficient = Field(1.0, description="drag coefficient, or a table of [z, Cd]")
    cm: Coefficient = Field(2.0, description="inertia coefficient, or a table of [z, Cm]")
    marine_growth: bool = Field(False, description="loads on the diameter with marine growth")
    distribution: Literal["constant", "linear", "quadratic"] = Field(
        "linear", description="sectional force between hydrodynamic nodes"
    )
    discretisation_m: float = Field(1.0, ge=0.01, le=50.0, description="longest hydrodynamic element in m")
    surface: Literal["moving", "midpoint"] = Field(
        "moving", description="last wet node moves with the surface, or elements load by their midpoint"
    )
    points: Literal["stations", "gauss"] = Field(
        "stations", description="kinematics at every station, or at few Gauss points of submerged elements"
    )
    axial_cd: float = Field(0.0, ge=0.0, le=10.0, description="drag coefficient along the member, on D/2")
    axial_ca: float = Field(0.0, ge=0.0, le=10.0, description="added mass coefficient along the member")
    end_cd: float = Field(0.0, ge=0.0, le=10.0, description="drag coefficient of a member's end disc")
    end_ca: float = Field(0.0, ge=0.0, le=10.0, description="added mass coefficient of a member's end")
    buoyancy: bool = Field(False, description="hydrostatic load on the members, as a load of its own")
    diffraction: Literal["none", "maccamy-fuchs"] = Field(
        "none", description="inertia force corrected for the diffraction of short waves"
    )
    hydrodynamic_damping: bool = Field(
        False, description="drag on the relative velocity, linearised as damping of the structure"
    )

    @model_validator(mode="after")
    def _tables_are_functions(self) -> Morison:
        for name, value in (("cd", self.cd), ("cm", self.cm)):
            levels = [z for z, _ in value] if isinstance(value, tuple) else [0.0]
            if not levels or len(set(levels)) != len(levels):
                raise InputError(
                    f"morison.{name}",
                    levels,
                    "needs one or more levels, each once",
                    "List [z, value] by level.",
                )
        return self


class Stream(Frozen):
    """How the graph and the in-process run cut time into blocks."""

    block: int = Field(50, ge=1, le=10_000, description="load samples per block")
    window: int = Field(4, ge=1, le=64, description="blocks in flight before a producer waits for credit")
    rate: float = Field(0.0, ge=0.0, le=100.0, description="simulated s per s; 0 as fast as the slowest node")
    late_s: float = Field(
        10.0,
        ge=0.0,
        le=600.0,
        description="wall time in s that a consumer may be late, at a rate, before it loses blocks",
    )


class CaseConfig(Frozen):
    """One load case, from the sea to the damage."""

    water_depth_m: float = Field(50.0, ge=0.1, le=5000.0, description="water depth in m")
    gravity_m_s2: float = Field(9.81, ge=0.1, le=30.0, description="gravity in m/s2")
    density_kg_m3: float = Field(1025.0, gt=0.0, le=3000.0, description="water density in kg/m3")
    sea_state: SeaStateConfig | None = Field(default_factory=SeaStateConfig)
    components: Components | None = None
    spectrum_file: SpectrumFile | None = None
    measured: Measured | None = None
    regular: RegularWave | None = None
    live: LiveElevation | None = Field(
        None, description="elevation measured while the graph runs; null for the waves of sea_state"
    )
    current: Current | None = None
    wave: Wave = Field(default_factory=Wave)
    time: Time = Field(default_factory=Time)
    points_m: tuple[tuple[Coordinate, Coordinate, Coordinate], ...] | None = Field(
        None, min_length=1, description="points [x, y, z] of `waves`, z up from still water"
    )
    gauges_m: tuple[tuple[Coordinate, Coordinate], ...] = Field(
        ((0.0, 0.0),), min_length=1, description="gauge points [x, y] of the surface elevation"
    )
    morison: Morison = Field(default_factory=Morison)
    structure: StructureConfig = Field(default_factory=StructureConfig)
    fatigue: Fatigue = Field(default_factory=Fatigue)
    stream: Stream = Field(default_factory=Stream)
    wind: WindConfig | None = Field(None, description="load at the tower top; null for none")

    @model_validator(mode="after")
    def _possible(self) -> CaseConfig:
        given = [name for name in SEA_SOURCES if getattr(self, name) is not None]
        if len(given) != 1:
            raise InputError(
                given[1] if given else "sea_state",
                "given" if given else None,
                f"the sea must be given once, by one of {', '.join(SEA_SOURCES)}",
                "Set all of them but one to null.",
            )
        if self.sea_state is not None:
            self._check_sea_state(self.sea_state)
        if self.live is not None:
            self._check_live(self.live)
        for i, (_, _, z) in enumerate(self.points_m or ()):
            if z < -self.water_depth_m:
                raise InputError(
                    f"points_m[{i}]",
                    z,
                    f"lies below the sea bed at z = {-self.water_depth_m} m",
                    "Give z up from still water, in m.",
                )
        return self

    def _check_sea_state(self, sea: SeaStateConfig) -> None:
        limit_height = MAX_HEIGHT_OVER_DEPTH * self.water_depth_m
        if sea.hs_m > limit_height:
            raise InputError(
                "sea_state.hs_m",
                sea.hs_m,
                f"must be at most {MAX_HEIGHT_OVER_DEPTH} of the water depth, {limit_height:g} m",
                "Waves this high break in this depth.",
            )
        steepness = 2.0 * math.pi * sea.hs_m / (self.gravity_m_s2 * sea.tp_s**2)
        if steepness > MAX_STEEPNESS:
            shortest = math.sqrt(2.0 * math.pi * sea.hs_m / (self.gravity_m_s2 * MAX_STEEPNESS))
            raise InputError(
                "sea_state.tp_s",
                sea.tp_s,
                f"makes the steepness 2 pi Hs/(g Tp^2) {steepness:.3g}, above 1/7",
                f"Use at least {shortest:.2f} s with Hs {sea.hs_m:g} m.",
            )
        sea.component_numbers(duration=self.time.duration_s, gravity=self.gravity_m_s2)
        if sea.focus is not None:
            self._check_focus(sea.focus)

    def _check_live(self, live: LiveElevation) -> None:
        if self.sea_state is None or self.sea_state.spreading is not None:
            raise InputError(
                "live",
                "given",
                "needs sea_state, the expected sea, with long crests: one gauge sees no directions",
                "Give sea_state without spreading.",
            )
        live.samples(self.time.dt_s)
        highest, nyquist = self.sea_state.cutoff_hz(self.gravity_m_s2), 0.45 / self.time.dt_s
        if highest >= nyquist:
            raise InputError(
                "time.dt_s",
                self.time.dt_s,
                f"samples the elevation too rarely for the sea's cut-off at {highest:.3g} Hz",
                f"Use at most {0.45 / highest:.3g} s.",
            )

    def _check_focus(self, focus: Focus) -> None:
        end = (self.time.n - 1) * self.time.dt_s
        if focus.time_s > end * (1.0 + 1e-12):
            raise InputError(
                "sea_state.focus.time_s",
                focus.time_s,
                f"lies after the last sample of the record, {end:g} s",
                "Focus within the record, or lengthen it.",
            )
        limit_height = MAX_HEIGHT_OVER_DEPTH * self.water_depth_m
        if focus.crest_m > limit_height:
            raise InputError(
                "sea_state.focus.crest_m",
                focus.crest_m,
                f"must be at most {MAX_HEIGHT_OVER_DEPTH} of the water depth, {limit_height:g} m",
                "Waves this high break in this depth.",
            )

    @property
    def outside_wait_s(self) -> float:
        """Longest wall time in s that a run may wait for messages from outside."""
        topic = None if self.wind is None else self.wind.topic
        wait = 0.0 if topic is None else topic.timeout_s
        if self.live is not None:  # the first loads need a record as long as the lag, in real time or slower
            block = self.stream.block * self.time.dt_s
            wait += self.live.timeout_s + self.live.lag_s + 2.0 * self.live.hop_s + block
        return wait

    @property
    def substeps(self) -> int:
        """Integration steps per load step.

        Raises
        ------
        InputError
            If the integration step does not divide the load step. Waves and loads alone do not ask.
        """
        ratio = self.time.dt_s / self.structure.dt_s
        if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9 * ratio:
            raise InputError(
                "structure.dt_s",
                self.structure.dt_s,
                f"must divide time.dt_s = {self.time.dt_s} s exactly",
                f"Use for example {self.time.dt_s / max(1, math.ceil(ratio)):.6g} s.",
            )
        return round(ratio)


def parse_case(data: Any, *, source: str = "case") -> CaseConfig:
    """Validate a case given as plain data (what JSON holds).

    Raises
    ------
    InputError
        Naming the first offending field, its value, the limit and the remedy.
    """
    if not isinstance(data, dict):
        raise InputError(source, data, "must be a JSON object", "See docs/case.schema.json for its fields.")
    others = [name for name in SEA_SOURCES[1:] if data.get(name) is not None]
    if others:
        if data.get("sea_state") is not None:
            raise InputError(
                others[0], "and sea_state", "must not both be given", "Set one of the two to null."
            )
        data = {**data, "sea_state": None}
    try:
        # Validation from JSON text: strict types, yet lists become the tuples of a frozen object.
        return CaseConfig.model_validate_json(json.dumps(data))
    except ValidationError as error:
        raise input_error(error, CaseConfig, remedy="See docs/case.schema.json.") from None


def load_case(path: str | Path) -> CaseConfig:
    """Read and validate a case file (JSON).

    Raises
    ------
    InputError
        If the file cannot be read, is not JSON, or holds a value that the model refuses.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not UTF-8 text"
        raise InputError(
            "case file", str(path), f"cannot be read ({reason})", "Give a readable JSON file."
        ) from None
    return parse_case_text(text, field="case file", shown=str(path))


def parse_case_text(text: str, *, field: str = "case_json", shown: str | None = None) -> CaseConfig:
    """Validate a case given as JSON text.

    Parameters
    ----------
    text : str
        The case.
    field, shown : str
        Where it comes from, for messages; the text itself if `shown` is left out.

    Raises
    ------
    InputError
        If it is not JSON, or holds a value that the model refuses.
    """
    try:
        data = json.loads(text, object_pairs_hook=_no_duplicates)
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        reason = str(error).splitlines()[0]
        value = text if shown is None else shown
        raise InputError(field, value, f"is not JSON ({reason})", "Check its syntax.") from None
    return parse_case(data)


def _no_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Refuse a JSON object that names a key twice: one of the two values would be lost."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise InputError(key, value, "is given twice in the case file", "Keep one of the two.")
        found[key] = value
    return found
