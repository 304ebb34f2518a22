"""Statistics of a sea: moments of its spectrum, and the waves of a record between zero up-crossings.

Spectral moments are m_n = int f^n S(f) df with f in Hz. The waves of a record lie between consecutive
up-crossings of its mean; a crossing is placed between two samples by linear interpolation.
Definitions: IAHR/PIANC, List of sea-state parameters (1989); DNV-RP-C205 section 3.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = [
    "RecordStatistics",
    "SpectralStatistics",
    "component_statistics",
    "density_statistics",
    "record_statistics",
]

#: Orders of the moments that are computed.
ORDERS = (-1, 0, 1, 2, 3, 4)


@dataclass(frozen=True)
class SpectralStatistics:
    """Moments and what follows from them.

    Attributes
    ----------
    moment : tuple of float
        m_-1, m_0, ..., m_4 in m2 Hz^n.
    peak_period_s : float
        Period of the largest density. Of listed components 1 / f with f weighted by a^8 (Young 1995, Ocean
        Eng. 22, 669-686), since the largest of random amplitudes may lie anywhere near the peak.
    """

    moment: tuple[float, ...]
    peak_period_s: float

    def m(self, n: int) -> float:
        """Moment m_n in m2 Hz^n, n from -1 to 4."""
        return self.moment[ORDERS.index(n)]

    @property
    def hm0_m(self) -> float:
        """Significant wave height 4 sqrt(m0)."""
        return 4.0 * math.sqrt(self.m(0))

    @property
    def tm01_s(self) -> float:
        """Mean period m0 / m1."""
        return self.m(0) / self.m(1)

    @property
    def tm02_s(self) -> float:
        """Mean zero up-crossing period sqrt(m0 / m2) of a Gaussian record."""
        return math.sqrt(self.m(0) / self.m(2))

    @property
    def tm10_s(self) -> float:
        """Energy period m_-1 / m0."""
        return self.m(-1) / self.m(0)

    @property
    def width(self) -> float:
        """Bandwidth nu = sqrt(m0 m2 / m1^2 - 1) of Longuet-Higgins; zero for one component."""
        return math.sqrt(max(self.m(0) * self.m(2) / self.m(1) ** 2 - 1.0, 0.0))

    @property
    def broadness(self) -> float:
        """Bandwidth epsilon = sqrt(1 - m2^2 / (m0 m4)) of Cartwright and Longuet-Higgins."""
        return math.sqrt(max(1.0 - self.m(2) ** 2 / (self.m(0) * self.m(4)), 0.0))

    def as_dict(self) -> dict[str, float]:
        """Plain numbers with units in their keys."""
        moments = {f"m{n}" if n >= 0 else "m_minus_1": m for n, m in zip(ORDERS, self.moment, strict=True)}
        names = ("hm0_m", "peak_period_s", "tm01_s", "tm02_s", "tm10_s", "width", "broadness")
        return moments | {name: getattr(self, name) for name in names}


def component_statistics(
    omega: Float[np.ndarray, " component"], amplitude: Float[np.ndarray, " component"]
) -> SpectralStatistics:
    """Statistics of components of frequency omega in rad/s and amplitude in m: a^2/2 of variance each.

    Raises
    ------
    InputError
        If no component carries energy.
    """
    f, variance = omega / (2.0 * math.pi), 0.5 * amplitude**2
    moment = _moments(f, variance)
    weight = (variance / variance.max()) ** 4
    return SpectralStatistics(moment, float(weight.sum() / (weight @ f)))


def density_statistics(
    frequency: Float[np.ndarray, " f"], density: Float[np.ndarray, " f"]
) -> SpectralStatistics:
    """Statistics of a variance density in m2/Hz at ascending frequencies in Hz, > 0, by trapezoids.

    Raises
    ------
    InputError
        If the spectrum holds no energy.
    """
    width = np.gradient(frequency)
    width[[0, -1]] *= 0.5
    moment = _moments(frequency, density * width)
    return SpectralStatistics(moment, 1.0 / float(frequency[density.argmax()]))


def _moments(frequency: Float[np.ndarray, " f"], variance: Float[np.ndarray, " f"]) -> tuple[float, ...]:
    if not variance.sum() > 0.0:
        raise InputError("spectrum", 0.0, "holds no energy", "Check the amplitudes of the sea.")
    return tuple(float(np.sum(frequency ** float(n) * variance)) for n in ORDERS)


@dataclass(frozen=True)
class RecordStatistics:
    """Moments of a record and its waves between zero up-crossings.

    What needs a wave is None where the record holds none.

    Attributes
    ----------
    mean_m, std_m : float
        `std_m` over all samples (divided by n).
    skewness, kurtosis : float
        Third and fourth central moments over powers of the standard deviation; 0 and 3 for a Gaussian record,
        both zero for a constant one.
    height_m, period_s, crest_m : float arrays [wave]
        Crest to trough, between up-crossings, and largest value of each wave over the mean.
    """

    mean_m: float
    std_m: float
    minimum_m: float
    maximum_m: float
    skewness: float
    kurtosis: float
    height_m: Float[np.ndarray, " wave"]
    period_s: Float[np.ndarray, " wave"]
    crest_m: Float[np.ndarray, " wave"]

    @property
    def n_waves(self) -> int:
        """Number of complete waves."""
        return len(self.height_m)

    @property
    def hm0_m(self) -> float:
        """Four standard deviations."""
        return 4.0 * self.std_m

    def mean_of_highest(self, part: int) -> float | None:
        """Mean height in m of the highest 1/`part` of the waves (at least one)."""
        if not self.n_waves:
            return None
        highest = np.sort(self.height_m)[-max(1, round(self.n_waves / part)) :]
        return float(highest.mean())

    def as_dict(self) -> dict[str, float | int | None]:
        """Plain numbers with units in their keys."""
        names = ("mean_m", "std_m", "minimum_m", "maximum_m", "skewness", "kurtosis", "hm0_m", "n_waves")
        waves = self.n_waves > 0
        return {name: getattr(self, name) for name in names} | {
            "mean_height_m": float(self.height_m.mean()) if waves else None,
            "h13_m": self.mean_of_highest(3),
            "h110_m": self.mean_of_highest(10),
            "hmax_m": float(self.height_m.max()) if waves else None,
            "tz_s": float(self.period_s.mean()) if waves else None,
            "highest_crest_m": float(self.crest_m.max()) if waves else None,
        }


def record_statistics(elevation: Float[np.ndarray, " time"], dt: float) -> RecordStatistics:
    """Statistics of a record in m, sampled every `dt` s.

    The part before the first and after the last up-crossing belongs to no wave. Heights are those of the
    samples: a crest between two samples is missed by at most (pi dt / T)^2 / 2 of the amplitude.

    Raises
    ------
    InputError
        If the record is empty or not finite.
    """
    if elevation.size < 2 or not np.isfinite(elevation).all():
        raise InputError(
            "record", elevation.size, "must hold two finite samples or more", "Check the record."
        )
    mean = float(elevation.mean())
    deviation = elevation - mean
    std = float(np.sqrt(np.mean(deviation**2)))
    flat = std <= 1e-14 * max(abs(mean), 1e-300)
    skewness, kurtosis = (0.0 if flat else float(np.mean((deviation / std) ** n)) for n in (3, 4))
    below = deviation <= 0.0
    before = np.flatnonzero(below[:-1] & ~below[1:])
    fraction = deviation[before] / (deviation[before] - deviation[before + 1])
    bounds = before + 1
    crest = np.empty(max(bounds.size - 1, 0))
    trough = np.empty_like(crest)
    if crest.size:
        within = deviation[: bounds[-1]]
        crest[:] = np.maximum.reduceat(within, bounds[:-1])
        trough[:] = np.minimum.reduceat(within, bounds[:-1])
    return RecordStatistics(
        mean_m=mean,
        std_m=std,
        minimum_m=float(elevation.min()),
        maximum_m=float(elevation.max()),
        skewness=skewness,
        kurtosis=kurtosis,
        height_m=crest - trough,
        period_s=np.diff(before + fraction) * dt if before.size else np.empty(0),
        crest_m=crest,
    )
