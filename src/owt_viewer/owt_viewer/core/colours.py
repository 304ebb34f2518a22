"""Numbers as colours: the scale of a legend, and the two maps of the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

__all__ = ["GREY", "Scale", "damage_scale", "rising_limit", "sea_colours", "stress_scale"]

#: Red, green, blue and opacity, each 0 to 1.
Colour = Float[np.ndarray, " 4"]
Colours = Float[np.ndarray, "point 4"]

#: Of what has no value: the tower, and ends that a message leaves out.
GREY = np.array([0.46, 0.50, 0.54, 1.0])
#: From the least to the largest value.
_WARM = np.array(
    [
        [0.86, 0.89, 0.90, 1.0],
        [0.98, 0.88, 0.42, 1.0],
        [0.97, 0.58, 0.15, 1.0],
        [0.87, 0.22, 0.12, 1.0],
        [0.55, 0.02, 0.14, 1.0],
    ]
)
#: From trough to crest.
_WATER = np.array([[0.04, 0.18, 0.36, 0.62], [0.13, 0.40, 0.62, 0.60], [0.62, 0.83, 0.93, 0.62]])
#: Decades of damage that the scale spans.
_DECADES = 4


def _between(table: Float[np.ndarray, "stop 4"], share: Float[np.ndarray, " point"]) -> Colours:
    """Colours of `table` at `share` of its length, the ends beyond it."""
    stops = np.linspace(0.0, 1.0, len(table))
    return np.stack([np.interp(share, stops, column) for column in table.T], axis=1)


@dataclass(frozen=True)
class Scale:
    """From a value to its colour.

    Attributes
    ----------
    low, high : float
        Values of the first and the last colour, in `unit`.
    logarithmic : bool
        Whether equal ratios of the value are equal steps of colour; otherwise colour goes by the root of the
        value, so that a single large wave does not leave the rest of the run without colour.
    quantity, unit : str
        For the legend.
    factor : float
        From SI to `unit`.
    """

    low: float
    high: float
    logarithmic: bool
    quantity: str
    unit: str
    factor: float = 1.0

    def share(self, value: Float[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
        """Place of values in SI on the scale, 0 to 1; what lies beyond an end counts as the end."""
        shown = value * self.factor
        if self.logarithmic:
            low, high = math.log(self.low), math.log(self.high)
            return np.asarray((np.log(np.clip(shown, self.low, self.high)) - low) / (high - low))
        return np.asarray(np.sqrt(np.clip((shown - self.low) / (self.high - self.low), 0.0, 1.0)))

    def value(self, share: Float[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
        """Values in SI at places on the scale: the inverse of :meth:`share`."""
        if self.logarithmic:
            return np.asarray(self.low * (self.high / self.low) ** share / self.factor)
        return np.asarray((self.low + share**2 * (self.high - self.low)) / self.factor)

    def colours(self, value: Float[np.ndarray, " point"], known: Bool[np.ndarray, " point"]) -> Colours:
        """Colours of values in SI; grey where none is known."""
        return np.where(known[:, None], _between(_WARM, self.share(value)), GREY)

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Places and texts of the legend: both ends and the middle; a logarithmic scale shows its decades."""
        if self.logarithmic:
            n = round(math.log10(self.high / self.low))
            texts = [f"{self.low * 10.0**i:.0e}" for i in range(n + 1)]
            return [(i / n, text) for i, text in enumerate(texts)]
        return [(s, f"{self.low + s**2 * (self.high - self.low):g}") for s in (0.0, 0.5, 1.0)]


def rising_limit(largest: float, before: float) -> float:
    """End of a scale that only grows: 1, 2 or 5 times a power of ten, at least `largest` and `before`.

    A `largest` of zero, or one that is not finite, changes nothing.
    """
    if not (math.isfinite(largest) and largest > before):
        return before
    power = 10.0 ** math.floor(math.log10(largest))
    return float(
        next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= largest * (1.0 - 1e-12))
    )


def stress_scale(limit_pa: float) -> Scale:
    """Scale of von Mises stress from zero to `limit_pa`; to 1 MPa where nothing is known yet."""
    return Scale(0.0, 1e-6 * limit_pa if limit_pa > 0.0 else 1.0, False, "von Mises stress", "MPa", 1e-6)


def damage_scale(limit: float) -> Scale:
    """Scale of damage over four decades up to `limit`; up to 1 where nothing is known yet."""
    high = limit if limit > 0.0 else 1.0
    high = 10.0 ** math.ceil(math.log10(high) - 1e-9)
    return Scale(high * 10.0**-_DECADES, high, True, "damage so far", "-")


def sea_colours(elevation: Float[np.ndarray, " point"], amplitude: float) -> Colours:
    """Colours of the water: darkest at -`amplitude` m and below, lightest at +`amplitude` m and above."""
    return _between(
        _WATER, 0.5 + 0.5 * elevation / amplitude if amplitude > 0.0 else np.full(len(elevation), 0.5)
    )
