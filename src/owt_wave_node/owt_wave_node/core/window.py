"""Windows of a record: frequencies that need not lie on any grid, transformed by FFT over part of the time.

A line exp(i w t) is spread over the frequencies of a grid with a bell-shaped kernel; the transform of the
grid is the line times the transform of the kernel, by which the samples are divided (a non-uniform FFT;
kernel exp(b (sqrt(1 - x^2) - 1)) of Barnett, Magland and af Klinteberg, SIAM J. Sci. Comput. 41, 2019). The
work does not depend on the length of the record that the lines would need a grid for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float, Int
from numpy.polynomial.chebyshev import chebval

from owt_model.errors import ComputationError
from owt_model.parallel import slices
from owt_wave_node.core.chebyshev import chebyshev_basis
from owt_wave_node.core.field import Field, Kinematics, Place, Prepared, Profile, Series
from owt_wave_node.core.grid import FrequencyGrid
from owt_wave_node.core.transform import plan_transform
from owt_wave_node.kernels import compressed as _kernel

__all__ = ["FINE", "QUICK", "Bell", "SlicedField", "Window", "Windowed", "spread_window", "window_of"]

#: Bytes of the whole record that a slice of a field holds at a time.
SLICE_BYTES = 16 * 2**20
#: Points of the quadrature of a bell's transform.
QUADRATURE = 256
#: Points whose samples are divided by the window while they are in the cache.
TOGETHER = 4
#: Terms of the series of a bell's transform.
SERIES = 48
#: Samples whose quadrature is done together.
BLOCK = 2048


@dataclass(frozen=True)
class Bell:
    """A spreading kernel.

    Attributes
    ----------
    width : int
        Bins that a line is spread over.
    oversampling : float
        Length of the transform over the length of the window.
    """

    width: int
    oversampling: float

    @property
    def shape(self) -> float:
        """Exponent b of the kernel: 0.976 of the value that just keeps the aliases out."""
        return 0.976 * math.pi * self.width * (1.0 - 0.5 / self.oversampling)

    def value(self, x: Float[np.ndarray, "*any"]) -> Float[np.ndarray, "*any"]:
        """The kernel at places in bins from its middle."""
        u = 1.0 - (2.0 * x / self.width) ** 2
        return np.where(u > 0.0, np.exp(self.shape * (np.sqrt(np.maximum(u, 0.0)) - 1.0)), 0.0)

    @cached_property
    def _quadrature(self) -> tuple[Float[np.ndarray, " q"], Float[np.ndarray, " q"]]:
        """Places in [0, width / 2] and weights, the kernel included, of its transform."""
        # With x = sin a the integrand is smooth and all but vanishes at its ends, where the trapezoidal rule
        # is as good as Gauss'.
        angle = np.linspace(0.0, 0.5 * np.pi, QUADRATURE + 1)
        weight = np.full(angle.size, 0.5 * np.pi * self.width / QUADRATURE)
        weight[0] *= 0.5
        value = np.exp(self.shape * (np.cos(angle) - 1.0)) * np.cos(angle)
        return 0.5 * self.width * np.sin(angle), weight * value

    def transform(
        self, theta: Float[np.ndarray, " time"]
    ) -> tuple[Float[np.ndarray, " time"], Float[np.ndarray, " time"]]:
        """Fourier transform of the kernel and its derivative, at phases `theta` in rad per bin."""
        place, weight = self._quadrature
        value, slope = np.empty(theta.size), np.empty(theta.size)
        for i in range(0, theta.size, BLOCK):
            phase = np.outer(theta[i : i + BLOCK], place)
            value[i : i + BLOCK] = np.cos(phase) @ weight
            slope[i : i + BLOCK] = -np.sin(phase) @ (weight * place)
        return value, slope

    @cached_property
    def error(self) -> float:
        """Largest error of a spread line of amplitude 1 over the window, found on a fine mesh."""
        theta = np.linspace(0.0, math.pi / self.oversampling, 33)
        bins = np.arange(-self.width, self.width + 1)
        worst = 0.0
        for y in np.linspace(0.0, 0.5, 17):
            found = np.exp(1j * np.outer(theta, bins)) @ self.value(y - bins) / self.transform(theta)[0]
            worst = max(worst, float(np.abs(found - np.exp(1j * theta * y)).max()))
        return worst


#: As good as exact (2e-13), and the one for long records: a shorter transform for an error of 4e-9.
FINE, QUICK = Bell(20, 1.5), Bell(20, 1.15)


@dataclass(frozen=True)
class Window:
    """Samples start <= i < start + count of a record, and the frequency grid that gives them.

    Attributes
    ----------
    grid : FrequencyGrid
        Its transform; sample 0 is the first of the window.
    bottom, n_bins : int
        Lowest multiple of the spacing in use, at most 0, and number of multiples.
    middle : float
        Time in s, in the record, from which the phases of a bell count.
    divide, rate : float arrays [time] or None
        Reciprocal of the window that the samples carry, and its relative rate of change in 1/s; None if they
        carry none.
    """

    start: int
    grid: FrequencyGrid
    bottom: int
    n_bins: int
    middle: float
    divide: Float[np.ndarray, " time"] | None
    rate: Float[np.ndarray, " time"] | None

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.grid.n

    def fold(self, spectra: Complex[np.ndarray, "point c bin"]) -> Complex[np.ndarray, "point c some"]:
        """Coefficients of the frequencies from 0 up: of a real signal those below are conjugates."""
        low = -self.bottom
        if not low:
            return spectra
        out = spectra[..., low:].copy()
        out[..., 1 : low + 1] += spectra[..., low - 1 :: -1].conj()
        return out

    def in_time(
        self, spectra: Complex[np.ndarray, "point c bin"], index: Int[np.ndarray, " some"], *, derive: bool
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals of the points `index`, followed by their time derivatives if asked for.

        `spectra` are folded.
        """
        channels = spectra.shape[1] * (2 if derive else 1)
        if self.divide is None or self.rate is None:
            series = self._transform(spectra, index, channels)
            if self.grid.length == self.count:
                return series
            every = self.grid.oversampling
            return np.ascontiguousarray(series[..., : self.count * every : every])
        out = np.empty((index.size, channels, self.count))
        for i in range(0, index.size, TOGETHER):
            series = self._transform(spectra, index[i : i + TOGETHER], channels)
            derived = channels - spectra.shape[1]
            _kernel.finish(
                series, self.grid.oversampling, self.divide, self.rate, derived, out[i : i + TOGETHER]
            )
        return out

    def _transform(
        self, spectra: Complex[np.ndarray, "point c bin"], index: Int[np.ndarray, " some"], channels: int
    ) -> Float[np.ndarray, "some channel sample"]:
        """Signals over the whole length of the grid, and the derivatives of its own."""
        length, spacing = self.grid.length, self.grid.spacing
        plan = plan_transform(length, spectra.shape[2])
        if plan is not None and channels % 2 == 0:
            return plan.to_time(spectra, index, channels=channels, spacing=spacing)
        half = 0.5 * spectra[index]
        half[..., 0] = 2.0 * half[..., 0].real
        if channels > spectra.shape[1]:
            half = np.concatenate([half, 1j * spacing * np.arange(half.shape[2]) * half], axis=1)
        return np.fft.irfft(half, length, axis=-1, norm="forward")


@lru_cache(maxsize=2)
def _deconvolution(
    bell: Bell, count: int, turn: float
) -> tuple[Float[np.ndarray, " time"], Float[np.ndarray, " time"]]:
    """Reciprocal of the window and its relative rate per sample; phases advance by `turn` rad per sample.

    Both are so smooth, the first in its logarithm, that a short Chebyshev series is as exact as the bell.
    """
    place = np.arange(count) - count // 2
    top = max(count // 2, 1)
    node, basis = chebyshev_basis(SERIES)
    value, slope = bell.transform(turn * top * node)
    logarithm, rate = (chebval(place / top, basis @ part) for part in (np.log(value), slope / value))
    return np.exp(-logarithm), turn * rate


def good_length(least: int) -> int:
    """Smallest product of 16 and of twos, threes and fives not below `least`."""
    odd = [int(3**i * 5**j) for i in range(14) for j in range(10)]
    return min(int(16 * m * 2 ** max(0, math.ceil(math.log2(least / (16 * m))))) for m in odd)


def spread_window(
    *, start: int, count: int, dt: float, top: float, bell: Bell, bottom: float = 0.0
) -> Window:
    """Window over samples start <= i < start + count for lines from `bottom` <= 0 up to `top` rad/s.

    Raises
    ------
    ComputationError
        If the kernel is too narrow to be trusted.
    """
    if not bell.error < 1e-6:
        raise ComputationError(f"spreading over {bell.width} bins has an error of {bell.error:.1g}")
    finer = max(1, math.ceil(top * dt / (0.8 * math.pi)))  # samples between two, so that no line aliases
    reach = bell.width // 2 + 2
    # All lines, and the bins beside them, lie below half the length.
    least = max(bell.oversampling * count * finer, reach / (0.5 - top * dt / (2.0 * math.pi * finer)))
    length = good_length(math.ceil(least))
    spacing = 2.0 * math.pi / (length * dt / finer)
    divide, rate = _deconvolution(bell, count, spacing * dt)
    lowest = math.floor(bottom / spacing) - reach
    return Window(
        start=start,
        grid=FrequencyGrid(np.zeros(0, dtype=np.int64), spacing, length, finer, count),
        bottom=lowest,
        n_bins=math.ceil(top / spacing) + reach - lowest,
        middle=(start + count // 2) * dt,
        divide=divide,
        rate=rate / dt,
    )


@runtime_checkable
class Windowed(Protocol):
    """A field that can restrict itself to part of its record."""

    def window(self, start: int, count: int) -> Field:
        """Return the field over `count` samples from `start`."""
        ...


def window_of(field: Field, start: int, count: int) -> Field:
    """Return a field over `count` samples from `start`; any field has one, some only at the whole's cost."""
    if (start, count) == (0, field.n):
        return field
    return field.window(start, count) if isinstance(field, Windowed) else SlicedField(field, start, count)


class SlicedField:
    """Part of the record of a field that only knows the whole: everything is computed and cut.

    Work is that of the whole record; the whole record of a few points is held at a time.
    """

    def __init__(self, whole: Field, start: int, count: int) -> None:
        self._whole, self._samples = whole, slice(start, start + count)
        self.n_axes, self.n, self.wavenumber = whole.n_axes, count, whole.wavenumber

    def _cut(
        self, evaluate: Callable[[slice], Float[np.ndarray, "some channel time"]], size: int
    ) -> Kinematics:
        step = max(1, SLICE_BYTES // (16 * self.n_axes * self._whole.n))
        parts = [evaluate(rows)[..., self._samples].copy() for rows in slices(size, step)]
        return np.concatenate(parts) if parts else np.zeros((0, 2 * self.n_axes, self.n))

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m."""
        both = self._cut(lambda rows: np.stack(self._whole.elevation(place[rows]), axis=1), len(place))
        return (both[:, 0].copy(), both[:, 1].copy())

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics, stretched above still water."""
        return self._cut(lambda rows: self._whole.first(place[rows]), len(place))

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics; zero at order 1."""
        return self._cut(lambda rows: self._whole.second(place[rows]), len(place))

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors instead of those of a level."""
        return self._cut(
            lambda rows: self._whole.shaped(place[rows], horizontal[rows], vertical[rows]), len(place)
        )

    def prepare(self, place: Place) -> Prepared:
        """Remember the points: coefficients of the whole record would not fit."""
        return _SlicedPrepared(self, place)


class _SlicedPrepared:
    def __init__(self, field: SlicedField, place: Place) -> None:
        self._field, self._place = field, place

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        field, place = self._field, self._place[index]
        return field._cut(
            lambda rows: field._whole.prepare(place[rows]).kinematics(np.arange(len(place[rows]))), len(place)
        )
