"""What is done with samples that come from outside while the graph runs, and the live measured elevation."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from owt_model.errors import InputError
from owt_model.sea_config import Coordinate, Direction
from owt_model.validation import Frozen

__all__ = ["LiveElevation", "LiveSamples"]


class LiveSamples(Frozen):
    """Samples that somebody publishes while the graph runs, stamped in simulated time."""

    timeout_s: float = Field(
        10.0, gt=0.0, le=3600.0, description="wall time in s that a missing message is waited for"
    )
    reorder_s: float = Field(
        0.0,
        ge=0.0,
        le=3600.0,
        description="simulated time in s by which a message may follow later ones and surely still counts",
    )


class LiveElevation(LiveSamples):
    """A surface elevation measured at one place while the graph runs; `sea_state` is the expected sea."""

    place_m: tuple[Coordinate, Coordinate] = Field((0.0, 0.0), description="place [x, y] of the gauge in m")
    direction_deg: Direction | None = Field(
        None, description="direction the waves travel to, in degrees; null for that of sea_state"
    )
    window_s: float = Field(
        120.0, gt=0.0, le=3600.0, description="length in s of the record that is decomposed at a time"
    )
    lag_s: float = Field(
        10.0,
        ge=0.0,
        le=600.0,
        description="length in s of the record beyond a sample that its load needs; as much is tapered",
    )
    hop_s: float = Field(5.0, gt=0.0, le=600.0, description="time in s from one window to the next")
    missing: Literal["error", "hold", "interpolate"] = Field(
        "error", description="what a missing sample becomes: an error, the value before, or a line across"
    )
    max_gap_s: float = Field(
        1.0, gt=0.0, le=3600.0, description="longest time in s between two messages that counts as covered"
    )

    def samples(self, dt: float) -> tuple[int, int, int, int]:
        """Window, lag, hop and fade from one window to the next, in samples of `dt` s.

        The fade is half the hop.

        Raises
        ------
        InputError
            If the window is too short for the rest, or the hop shorter than two samples.
        """
        window, lag, hop = (round(length / dt) for length in (self.window_s, self.lag_s, self.hop_s))
        if hop < 2:
            raise InputError(
                "live.hop_s", self.hop_s, f"must hold two samples of time.dt_s = {dt:g} s", "Raise it."
            )
        fade = hop // 2
        if window < 2 * lag + hop + fade:
            least = (2 * lag + hop + fade) * dt
            raise InputError(
                "live.window_s",
                self.window_s,
                f"must be at least twice the lag and one and a half times the hop, {least:g} s",
                "Use a longer window.",
            )
        return window, lag, hop, fade
