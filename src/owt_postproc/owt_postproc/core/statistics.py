"""Statistics and spectra of series."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["SeriesStatistics", "Spectrum", "spectrum", "statistics"]


@dataclass(frozen=True)
class SeriesStatistics:
    """Moments and extremes of a series, in its unit.

    Attributes
    ----------
    mean, std, minimum, maximum : float
        `std` over all samples (divided by n).
    skewness : float
        Third central moment over std^3; zero for a constant series.
    zero_up_crossings : int
        Upward crossings of the mean.
    """

    mean: float
    std: float
    minimum: float
    maximum: float
    skewness: float
    zero_up_crossings: int

    def as_dict(self, unit: str) -> dict[str, float | int]:
        """Plain numbers with the unit in their keys, as summary files hold them."""
        return {
            f"mean_{unit}": self.mean,
            f"std_{unit}": self.std,
            f"min_{unit}": self.minimum,
            f"max_{unit}": self.maximum,
            "skewness": self.skewness,
            "zero_up_crossings": self.zero_up_crossings,
        }


@dataclass(frozen=True)
class Spectrum:
    """One-sided power spectral density; its integral is the variance of the series.

    Attributes
    ----------
    frequency : float array [f]
        In Hz, without zero.
    density : float array [f]
        In (unit of the series)^2/Hz.
    resolution : float
        Spacing of the frequencies in Hz.
    """

    frequency: Float[np.ndarray, " f"]
    density: Float[np.ndarray, " f"]
    resolution: float


def statistics(series: Float[np.ndarray, " n"]) -> SeriesStatistics:
    """Statistics of a series of at least one finite sample.

    Raises
    ------
    InputError
        If it is empty or not finite.
    """
    _check(series, 1)
    mean = float(series.mean())
    deviation = series - mean
    std = float(np.sqrt(np.mean(deviation**2)))
    flat = std <= 1e-14 * max(abs(mean), 1e-300)
    above = deviation > 0.0
    return SeriesStatistics(
        mean=mean,
        std=std,
        minimum=float(series.min()),
        maximum=float(series.max()),
        skewness=0.0 if flat else float(np.mean((deviation / std) ** 3)),
        zero_up_crossings=int(np.count_nonzero(above[1:] & ~above[:-1])),
    )


def spectrum(series: Float[np.ndarray, " n"], dt: float, *, parts: int = 8) -> Spectrum:
    """Power spectral density by Welch's method: Hann windows that overlap by half, mean removed.

    Parameters
    ----------
    series : float array [n]
    dt : float
        Sampling interval in s.
    parts : int
        Segment length is ``2 n / (parts + 1)``, so that `parts` half-overlapping segments fit.

    Raises
    ------
    InputError
        If there are fewer than four samples, or they are not finite.
    """
    _check(series, 4)
    length = max(4, 2 * len(series) // (parts + 1))
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    starts = range(0, len(series) - length + 1, length - length // 2)
    deviation = series - series.mean()
    power = np.zeros(length // 2 + 1)
    for start in starts:
        power += np.abs(np.fft.rfft(window * deviation[start : start + length])) ** 2
    density = 2.0 * dt * power / (len(starts) * np.sum(window**2))
    if length % 2 == 0:
        density[-1] *= 0.5  # the highest frequency has no negative twin
    frequency = np.fft.rfftfreq(length, dt)
    return Spectrum(frequency[1:], density[1:], 1.0 / (length * dt))


def _check(series: Float[np.ndarray, " n"], least: int) -> None:
    if len(series) < least:
        raise InputError("series", f"{len(series)} samples", f"must have at least {least}", "Record longer.")
    if not np.isfinite(series).all():
        raise InputError("series", "NaN or inf", "must be finite", "Check where it comes from.")
