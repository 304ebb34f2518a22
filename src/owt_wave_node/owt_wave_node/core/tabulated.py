"""A spectrum given as a table over frequency and direction, and its realisation by components.

The energy of a row of the table is its density times the width of its bin, whose bounds lie half-way to the
neighbours. Within a bin the density follows the table linearly, scaled so that the bin keeps its energy;
each component takes the energy between the frequencies half-way to its neighbours. So no energy is lost or
won, whatever the two spacings are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_wave_node.core.realisation import DIRECTION_STREAM, amplitudes, derived_numbers, phases

__all__ = ["TabulatedComponents", "TabulatedSpectrum", "realise_table"]


@dataclass(frozen=True)
class TabulatedSpectrum:
    """Variance density over frequency and direction.

    Attributes
    ----------
    frequency : float array [f]
        Hz, ascending, two or more.
    direction_deg : float array [direction]
        Direction the waves travel to in degrees, ascending; a single one for long-crested waves.
    low_deg, high_deg : float arrays [direction]
        Bounds of the directional bins.
    density : float array [f, direction]
        m2/(Hz degree), >= 0.
    """

    frequency: Float[np.ndarray, " f"]
    direction_deg: Float[np.ndarray, " direction"]
    low_deg: Float[np.ndarray, " direction"]
    high_deg: Float[np.ndarray, " direction"]
    density: Float[np.ndarray, "f direction"]

    @property
    def share(self) -> Float[np.ndarray, "f direction"]:
        """Density times the width of the directional bin in m2/Hz."""
        return np.asarray(self.density * (self.high_deg - self.low_deg))

    @cached_property
    def one_dimensional(self) -> Float[np.ndarray, " f"]:
        """Density over frequency in m2/Hz."""
        return np.asarray(self.share.sum(axis=1))

    @cached_property
    def bounds(self) -> Float[np.ndarray, " bound"]:
        """Bounds of the frequency bins in Hz."""
        f = self.frequency
        middle = 0.5 * (f[1:] + f[:-1])
        return np.concatenate([[max(0.0, 1.5 * f[0] - 0.5 * f[1])], middle, [1.5 * f[-1] - 0.5 * f[-2]]])

    @property
    def hs_m(self) -> float:
        """Significant wave height 4 sqrt(m0) of the whole table in m."""
        return 4.0 * math.sqrt(float(self.one_dimensional @ np.gradient(self.frequency)))

    @property
    def mean_direction_deg(self) -> float:
        """Direction in degrees of the sum of unit vectors times energy."""
        energy = np.gradient(self.frequency) @ self.share
        angle = np.deg2rad(self.direction_deg)
        return math.degrees(math.atan2(energy @ np.sin(angle), energy @ np.cos(angle))) % 360.0

    def energy_below(self, frequency: Float[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
        """Variance in m2 below each of `frequency` in Hz."""
        s, bounds = self.one_dimensional, self.bounds
        # Knots: bounds and centres in turn; the density is linear between them, and jumps at bounds.
        knot = np.empty(2 * s.size + 1)
        knot[0::2], knot[1::2] = bounds, self.frequency
        at = np.interp(knot, self.frequency, s)
        width = np.diff(knot)
        raw = 0.5 * (at[1:] + at[:-1]) * width
        within = raw[0::2] + raw[1::2]
        energy = s * np.gradient(self.frequency)
        scale = np.divide(energy, within, out=np.zeros_like(energy), where=within > 0.0).repeat(2)
        total = np.concatenate([[0.0], np.cumsum(raw * scale)])
        place = np.clip(frequency, knot[0], knot[-1])
        i = np.clip(np.searchsorted(knot, place, side="right") - 1, 0, width.size - 1)
        step = place - knot[i]
        slope = np.divide(at[1:] - at[:-1], width, out=np.zeros_like(width), where=width > 0.0)
        return np.asarray(total[i] + scale[i] * (at[i] + 0.5 * slope[i] * step) * step)

    def directions(
        self, frequency: Float[np.ndarray, " component"], number: Float[np.ndarray, " component"]
    ) -> Float[np.ndarray, " component"]:
        """Direction in degrees below which waves of `frequency` in Hz travel with probability `number`.

        The distribution of a frequency is that of the table, linear between its rows and constant within a
        directional bin.
        """
        f, share = self.frequency, self.share
        i = np.clip(np.searchsorted(f, frequency) - 1, 0, f.size - 2)
        weight = np.clip((frequency - f[i]) / (f[i + 1] - f[i]), 0.0, 1.0)[:, None]
        row = (1.0 - weight) * share[i] + weight * share[i + 1]
        total = np.cumsum(row, axis=1)
        target = number * total[:, -1]
        j = np.minimum((total <= target[:, None]).sum(axis=1), row.shape[1] - 1)
        pick = np.arange(j.size), j
        part = np.divide(
            target - (total[pick] - row[pick]), row[pick], out=np.full(j.size, 0.5), where=row[pick] > 0
        )
        drawn = self.low_deg[j] + part * (self.high_deg[j] - self.low_deg[j])
        return np.where(total[:, -1] > 0.0, drawn, self.mean_direction_deg)


@dataclass(frozen=True)
class TabulatedComponents:
    """Components of a tabulated spectrum, in rad/s, m, rad and degrees, and the variance they stand for."""

    omega: Float[np.ndarray, " component"]
    amplitude: Float[np.ndarray, " component"]
    phase: Float[np.ndarray, " component"]
    direction_deg: Float[np.ndarray, " component"]
    variance: Float[np.ndarray, " component"]


def realise_table(
    table: TabulatedSpectrum,
    *,
    duration: float,
    cutin: float = 0.0,
    cutoff: float | None = None,
    amplitude: Literal["deterministic", "rayleigh"] = "deterministic",
    directional: bool = True,
    seed: int = 1,
) -> TabulatedComponents:
    """Realise a table by components omega_m = 2 pi m / duration within its band.

    Random numbers belong to m, as those of :func:`~owt_wave_node.core.realisation.realise`.

    Parameters
    ----------
    table : TabulatedSpectrum
    duration : float
        Length n dt of the record in s.
    cutin, cutoff : float
        Lowest and highest component in rad/s; None for the end of the table's last bin. The components hold
        the energy between both.
    amplitude : str
        Deterministic sqrt(2 S df), or Rayleigh distributed about it.
    directional : bool
        One direction per component, drawn from the distribution of its frequency; else the mean direction.
    seed : int

    Raises
    ------
    InputError
        If no component or no energy lies in the band.
    """
    low = max(cutin / (2.0 * math.pi), float(table.bounds[0]))
    high = float(table.bounds[-1])
    if cutoff is not None:
        high = min(high, cutoff / (2.0 * math.pi))
    first = max(1, math.ceil(low * duration * (1.0 - 1e-12)))
    last = math.floor(high * duration * (1.0 + 1e-12))
    band = f"{2.0 * math.pi * low:.4g} to {2.0 * math.pi * high:.4g} rad/s"
    if first > last:
        raise InputError(
            "spectrum_file.cutoff_rad_s",
            cutoff,
            f"leaves no component 2 pi m/(n dt) in the band {band}",
            "Widen the band or use a longer record.",
        )
    f = np.arange(first, last + 1) / duration
    edge = np.concatenate([[low], 0.5 * (f[1:] + f[:-1]), [high]])
    variance = np.maximum(np.diff(table.energy_below(edge)), 0.0)
    if not variance.sum() > 0.0:
        raise InputError(
            "spectrum_file", 0.0, f"holds no energy in the band {band}", "Choose another spectrum or band."
        )
    if directional and table.direction_deg.size > 1:
        direction = table.directions(f, derived_numbers(last, seed, DIRECTION_STREAM)[first - 1 :])
    else:
        direction = np.full(f.size, table.mean_direction_deg)
    return TabulatedComponents(
        omega=2.0 * math.pi * f,
        amplitude=amplitudes(variance, kind=amplitude, seed=seed, first=first),
        phase=phases(last, seed)[first - 1 :],
        direction_deg=direction,
        variance=variance,
    )
