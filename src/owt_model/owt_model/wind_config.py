"""Load at the tower top of a case: a series in a file, a ROS topic, or the thrust of a simple rotor."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from owt_model.errors import InputError
from owt_model.live_config import LiveSamples
from owt_model.sea_config import Direction
from owt_model.validation import Frozen

__all__ = ["RotorConfig", "ThrustConfig", "WindConfig", "WrenchSeries", "WrenchTopic"]

Positive = Annotated[float, Field(gt=0.0, le=1e6)]
NonNegative = Annotated[float, Field(ge=0.0, le=1e12)]


class WrenchSeries(Frozen):
    """A wrench series in a CSV file."""

    path: str = Field(
        min_length=1,
        description="CSV file headed by names: time_s, and those that are not zero of fx_n, fy_n, fz_n, "
        "mx_nm, my_nm, mz_nm",
    )
    direction_deg: Direction = Field(
        0.0, description="direction of the file's x axis, measured from +x towards +y, in degrees"
    )


class WrenchTopic(LiveSamples):
    """A wrench that somebody publishes while the graph runs."""

    interpolation: Literal["linear", "hold"] = Field(
        "linear", description="value between two messages: linear, or that of the earlier one"
    )
    max_gap_s: float | None = Field(
        None,
        gt=0.0,
        le=3600.0,
        description="longest time in s between two messages that counts as covered; null for any",
    )
    missing: Literal["error", "hold", "zero"] = Field(
        "error", description="what a missing sample becomes: an error, the value before, or no load"
    )


class RotorConfig(Frozen):
    """A three-bladed upwind rotor; the defaults are a generic machine of 4 MW."""

    diameter_m: Positive = Field(130.0, description="rotor diameter in m")
    hub_above_top_m: float = Field(
        2.0, ge=0.0, le=100.0, description="height of the hub above the tower top in m"
    )
    cut_in_m_s: Positive = Field(4.0, description="lowest wind speed of operation in m/s")
    rated_speed_m_s: Positive = Field(10.5, description="wind speed from which the power is constant, in m/s")
    cut_out_m_s: Positive = Field(25.0, description="highest wind speed of operation in m/s")
    max_rpm: Positive = Field(14.0, description="rotor speed from the rated wind speed on, in 1/min")
    thrust_coefficient: Positive = Field(0.8, description="thrust coefficient below the rated wind speed")
    damping_n_s_m: NonNegative = Field(
        6.1e4, description="change of thrust with the wind at constant speed and pitch, in N s/m"
    )
    controller_time_s: Positive = Field(5.0, description="time constant in s of the controller")
    air_density_kg_m3: Positive = Field(1.225, description="density of the air in kg/m3")
    tower_diameter_m: NonNegative = Field(4.5, description="diameter of the tower that the blades pass, in m")
    tower_distance_m: Positive = Field(9.0, description="distance of the blades from the tower's axis in m")


class ThrustConfig(Frozen):
    """Turbulent wind on a simple rotor: a stand-in for an aeroelastic series."""

    speed_m_s: float = Field(12.0, gt=0.0, le=100.0, description="mean wind speed at the hub in m/s")
    direction_deg: Direction = Field(
        210.0, description="direction the wind blows to, measured from +x towards +y, in degrees"
    )
    turbulence: Literal["A", "B", "C"] = Field(
        "B", description="category of the normal turbulence model (IEC 61400-1)"
    )
    turbulence_intensity: float | None = Field(
        None, gt=0.0, le=1.0, description="standard deviation over the mean speed, instead of a category"
    )
    shear_exponent: float = Field(0.14, ge=0.0, le=1.0, description="exponent of the mean wind's power law")
    seed: int = Field(1, ge=0, le=2**63 - 1, description="seed of the wind's random phases")
    aerodynamic_damping: bool = Field(
        True, description="the rotor's damping_n_s_m also damps the motion of the hub along the wind"
    )
    rotor: RotorConfig = Field(default_factory=RotorConfig)


class WindConfig(Frozen):
    """The load at the tower top; exactly one of its keys is set."""

    series: WrenchSeries | None = None
    topic: WrenchTopic | None = None
    thrust: ThrustConfig | None = None

    @model_validator(mode="after")
    def _one_source(self) -> WindConfig:
        given = [name for name in WindConfig.model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            raise InputError(
                f"wind.{given[1]}" if given else "wind",
                given or None,
                f"the load must be given once, by one of {', '.join(WindConfig.model_fields)}",
                "Leave all of them out but one.",
            )
        return self
