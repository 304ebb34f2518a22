"""What the sea of a case may be (spectrum, components, file, record, regular wave), and the current."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from owt_model.errors import InputError
from owt_model.validation import Frozen

__all__ = [
    "Components",
    "Coordinate",
    "Current",
    "Direction",
    "Focus",
    "Measured",
    "RegularWave",
    "SeaStateConfig",
    "SpectrumFile",
    "most_probable_systems",
]

Direction = Annotated[float, Field(ge=-360.0, le=360.0)]
#: Beyond a thousand km a phase k x has lost its last digits.
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
#: Significant wave height in m, peak period in s and shape parameter lambda of one wave system.
System = tuple[
    Annotated[float, Field(gt=0.0, le=30.0)],
    Annotated[float, Field(gt=0.0, le=60.0)],
    Annotated[float, Field(gt=0.0, le=20.0)],
]

#: Relative difference between Hs and the total of two given systems that is taken as rounding.
TOTAL_HEIGHT = 0.01
#: Relative difference of tp_s from the peak period of given, and of the most probable systems.
GIVEN_PEAK, PROBABLE_PEAK = 0.01, 0.1


def most_probable_systems(hs: float) -> tuple[System, System]:
    """Ochi and Hubble's most probable swell and wind sea of a given total Hs in m (their table 2b).

    Hs in m, Tp in s and shape of each. Their heights 0.84 Hs and 0.54 Hs add up to 0.9986 Hs.

    References
    ----------
    M. K. Ochi, E. N. Hubble, Six-parameter wave spectra, Proc. 15th Coastal Engineering Conf., 1976.
    """
    swell = (0.84 * hs, 2.0 * math.pi / (0.70 * math.exp(-0.046 * hs)), 3.00)
    return swell, (0.54 * hs, 2.0 * math.pi / (1.15 * math.exp(-0.039 * hs)), 1.54 * math.exp(-0.062 * hs))


class Focus(Frozen):
    """A crest of given height at a given time and place (NewWave)."""

    crest_m: float = Field(gt=0.0, le=50.0, description="height of the linear crest over still water in m")
    time_s: float = Field(ge=0.0, le=1e9, description="time of the crest in s")
    place_m: tuple[Coordinate, Coordinate] = Field((0.0, 0.0), description="place [x, y] of the crest in m")
    background: bool = Field(
        True, description="embed in the irregular sea; false for the crest's group alone"
    )


class SeaStateConfig(Frozen):
    """A stationary irregular sea state (thesis 2.7 and 4.4)."""

    hs_m: float = Field(6.0, gt=0.0, le=30.0, description="significant wave height in m")
    tp_s: float = Field(
        9.45, gt=0.0, le=60.0, description="peak period in s, of two systems that of the more energetic one"
    )
    gamma: float | None = Field(
        None, ge=1.0, le=10.0, description="JONSWAP peak enhancement; null for the rule of eq. 4.80"
    )
    direction_deg: Direction = Field(
        210.0, description="direction the waves travel to, measured from +x towards +y, in degrees"
    )
    seed: int = Field(1, ge=0, le=2**63 - 1, description="seed of the random phases")
    cutoff_over_peak: float = Field(
        4.0, gt=1.0, le=20.0, description="highest component over the (highest) peak frequency"
    )
    cutoff: Literal["over_peak", "steepness"] = Field(
        "over_peak", description="highest component: cutoff_over_peak times the peak, or sqrt(2 g / Hs)"
    )
    cutin_over_peak: float = Field(
        0.0,
        ge=0.0,
        lt=1.0,
        description="lowest component over the (lowest) peak frequency; 0 for the lowest there is",
    )
    spectrum: Literal["jonswap", "pierson-moskowitz", "ochi-hubble", "torsethaugen"] = Field(
        "jonswap", description="shape of the spectrum"
    )
    scale: Literal["band", "formula"] = Field(
        "band", description="Hs exact within the band, or the spectrum's own formula as printed"
    )
    amplitudes: Literal["deterministic", "rayleigh"] = Field(
        "deterministic", description="amplitudes sqrt(2 S df), or Rayleigh distributed about them"
    )
    spreading: float | None = Field(
        None, ge=0.5, le=1000.0, description="exponent s of the spreading cos^2s; null for long-crested waves"
    )
    systems: tuple[System, System] | None = Field(
        None, description="[Hs m, Tp s, shape] of both Ochi-Hubble systems; null for the most probable ones"
    )
    focus: Focus | None = Field(None, description="a crest embedded in the sea; null for none")

    @model_validator(mode="after")
    def _parameters_belong_to_the_shape(self) -> SeaStateConfig:
        if self.gamma is not None and self.spectrum != "jonswap":
            raise InputError(
                "sea_state.gamma",
                self.gamma,
                f"is that of a jonswap spectrum, not of {self.spectrum}",
                "Leave gamma out, or set sea_state.spectrum to jonswap.",
            )
        if self.systems is not None and self.spectrum != "ochi-hubble":
            raise InputError(
                "sea_state.systems",
                self.spectrum,
                "are those of an ochi-hubble spectrum only",
                "Set sea_state.spectrum to ochi-hubble or leave systems out.",
            )
        if self.wave_systems is not None:
            self._check_systems(self.wave_systems)
        return self

    def _check_systems(self, systems: tuple[System, System]) -> None:
        """Refuse an Hs or a Tp that is not that of the systems: these alone make the sea."""
        total = math.hypot(*(height for height, _, _ in systems))
        if abs(total - self.hs_m) > TOTAL_HEIGHT * total:
            raise InputError(
                "sea_state.hs_m",
                self.hs_m,
                f"must be the total sqrt(Hs1^2 + Hs2^2) = {total:.4g} m of the systems",
                f"Set it to {total:.4g}.",
            )
        allowed = PROBABLE_PEAK if self.systems is None else GIVEN_PEAK
        highest = max(height for height, _, _ in systems)
        peaks = [period for height, period, _ in systems if height == highest]
        if all(abs(self.tp_s - period) > allowed * period for period in peaks):
            whose = f"most probable systems of Hs {self.hs_m:g} m" if self.systems is None else "systems"
            raise InputError(
                "sea_state.tp_s",
                self.tp_s,
                f"must be within {100.0 * allowed:g} % of the peak period {peaks[0]:.4g} s of the more "
                f"energetic of the {whose}",
                f"Set it to {peaks[0]:.4g}{', or give systems' if self.systems is None else ''}.",
            )

    @property
    def wave_systems(self) -> tuple[System, System] | None:
        """Both systems of an ochi-hubble sea, given or most probable; None for other spectra."""
        if self.spectrum != "ochi-hubble":
            return None
        return most_probable_systems(self.hs_m) if self.systems is None else self.systems

    def peaks_hz(self) -> tuple[float, float]:
        """Lowest and highest peak frequency in Hz; they differ for two systems given by themselves."""
        if self.wave_systems is None:
            return 1.0 / self.tp_s, 1.0 / self.tp_s
        periods = [period for _, period, _ in self.wave_systems]
        return 1.0 / max(periods), 1.0 / min(periods)

    def cutoff_hz(self, gravity: float) -> float:
        """Highest frequency in Hz a component may have, for `gravity` in m/s2."""
        if self.cutoff == "steepness":
            return math.sqrt(2.0 * gravity / self.hs_m) / (2.0 * math.pi)
        return self.cutoff_over_peak * self.peaks_hz()[1]

    def component_numbers(self, *, duration: float, gravity: float) -> range:
        """Numbers m of the components m / duration within the band, for a record of `duration` s.

        Raises
        ------
        InputError
            If the band is empty, or the record too short for a component within it.
        """
        peak = self.peaks_hz()[0]
        lowest, highest = self.cutin_over_peak * peak, self.cutoff_hz(gravity)
        if lowest >= highest:
            raise InputError(
                "sea_state.cutin_over_peak",
                self.cutin_over_peak,
                f"lies above the cut-off at {highest / peak:.3g} of the peak frequency",
                "Lower the cut-in or raise the cut-off.",
            )
        # A component on the limit belongs to the band, whatever its last digit.
        first = max(1, math.ceil(lowest * duration * (1.0 - 1e-12)))
        last = math.floor(highest * duration * (1.0 + 1e-12))
        if first > last:
            band = f"{2.0 * math.pi * lowest:.3g} to {2.0 * math.pi * highest:.3g} rad/s"
            raise InputError(
                "time.n",
                f"{duration:g} s of record",
                f"is too short: no component 2 pi m/(n dt) lies in the band {band}, below the cut-off",
                "Use a longer record.",
            )
        return range(first, last + 1)


class Components(Frozen):
    """Explicit first-order components: eta1 = sum a cos(omega t - k (x cos b + y sin b) - phase)."""

    omega_rad_s: tuple[Annotated[float, Field(ge=1e-4, le=100.0)], ...] = Field(
        min_length=1, description="angular frequencies in rad/s"
    )
    amplitude_m: tuple[Annotated[float, Field(ge=0.0, le=50.0)], ...] = Field(
        min_length=1, description="amplitudes in m"
    )
    phase_rad: tuple[Annotated[float, Field(ge=-1e6, le=1e6)], ...] = Field(
        min_length=1, description="phases in rad"
    )
    direction_deg: Direction | tuple[Direction, ...] = Field(
        0.0, description="direction the waves travel to, one or one per component, in degrees"
    )
    source: Literal["spectrum_file", "measured"] | None = Field(
        None, description="what they were made from, for messages; null where they are listed by hand"
    )

    @model_validator(mode="after")
    def _same_length(self) -> Components:
        n = len(self.omega_rad_s)
        lengths = {"amplitude_m": len(self.amplitude_m), "phase_rad": len(self.phase_rad)}
        if isinstance(self.direction_deg, tuple):
            lengths["direction_deg"] = len(self.direction_deg)
        for name, length in lengths.items():
            if length != n:
                raise InputError(
                    f"components.{name}",
                    length,
                    f"must have as many entries as omega_rad_s ({n})",
                    "Give one value per component.",
                )
        return self


class SpectrumFile(Frozen):
    """A spectrum, one- or two-dimensional, read through the wavespectra library."""

    path: str = Field(min_length=1, description="file that the wavespectra library reads")
    reader: str = Field("netcdf", min_length=1, description="reader of the library, e.g. netcdf, swan, ww3")
    index: int = Field(0, ge=0, description="which of the file's spectra, counted over time and site")
    direction_deg: Direction | None = Field(
        None, description="direction of a spectrum that holds none, waves travelling to, in degrees"
    )
    directional: bool = Field(True, description="short-crested waves from a two-dimensional spectrum")
    seed: int = Field(1, ge=0, le=2**63 - 1, description="seed of the random phases")
    amplitudes: Literal["deterministic", "rayleigh"] = Field(
        "deterministic", description="amplitudes sqrt(2 S df), or Rayleigh distributed about them"
    )
    cutin_rad_s: float = Field(0.0, ge=0.0, le=100.0, description="lowest component in rad/s")
    cutoff_rad_s: float | None = Field(
        None, gt=0.0, le=100.0, description="highest component in rad/s; null for the file's last frequency"
    )


class Measured(Frozen):
    """A measured surface elevation at one place, turned into components."""

    path: str = Field(min_length=1, description="CSV file with two columns: time in s, elevation in m")
    place_m: tuple[Coordinate, Coordinate] = Field((0.0, 0.0), description="place [x, y] of the gauge in m")
    direction_deg: Direction = Field(0.0, description="direction the waves travel to, in degrees")
    cutin_rad_s: float = Field(0.0, ge=0.0, le=100.0, description="lowest first-order component in rad/s")
    cutoff_rad_s: float = Field(gt=0.0, le=100.0, description="highest first-order component in rad/s")
    tolerance: float = Field(
        1e-6,
        gt=0.0,
        le=0.1,
        description="change of the first order, over its largest value, that ends iteration",
    )
    max_iterations: int = Field(
        50, ge=1, le=1000, description="iterations before non-convergence is an error"
    )


class RegularWave(Frozen):
    """One regular wave of permanent form; its crest passes x = y = 0 at t = phase / omega."""

    theory: Literal["airy", "stokes", "stream"] = Field("stream", description="wave theory")
    height_m: float = Field(gt=0.0, le=60.0, description="trough to crest in m")
    period_s: float | None = Field(None, gt=0.0, le=100.0, description="period in s; or give length_m")
    length_m: float | None = Field(None, gt=0.0, le=1e5, description="length in m; or give period_s")
    order: int | None = Field(
        None, ge=1, le=100, description="order of the theory; null for 5 (stokes) or 20 (stream)"
    )
    direction_deg: Direction = Field(0.0, description="direction the waves travel to, in degrees")
    phase_rad: float = Field(0.0, ge=-1e6, le=1e6, description="phase at x = y = 0, t = 0")

    @model_validator(mode="after")
    def _one_of_period_and_length(self) -> RegularWave:
        if (self.period_s is None) == (self.length_m is None):
            raise InputError(
                "regular.period_s",
                self.period_s,
                "and length_m: exactly one of the two must be given",
                "Give the period in s or the length in m.",
            )
        return self


class Current(Frozen):
    """A steady current; above still water it keeps its value there."""

    profile: Literal["uniform", "power", "table"] = Field("uniform", description="shape over the depth")
    speed_m_s: float = Field(0.0, ge=0.0, le=10.0, description="speed at still water in m/s (uniform, power)")
    direction_deg: Direction = Field(0.0, description="direction the current flows to, from +x towards +y")
    exponent: float = Field(1.0 / 7.0, gt=0.0, le=10.0, description="exponent of (1 + z/d) in the power law")
    table: tuple[tuple[Coordinate, Annotated[float, Field(ge=-10.0, le=10.0)]], ...] | None = Field(
        None,
        min_length=1,
        description="levels z in m and speeds in m/s of a table, z descending or ascending",
    )

    @model_validator(mode="after")
    def _table_where_needed(self) -> Current:
        if (self.profile == "table") != (self.table is not None):
            raise InputError(
                "current.table",
                self.table,
                f"does not fit profile {self.profile!r}",
                "Give a table of [z, speed] with profile table, and only then.",
            )
        levels = [z for z, _ in self.table or ()]
        if len(set(levels)) != len(levels):
            raise InputError("current.table", levels, "repeats a level", "Give each level once.")
        return self
