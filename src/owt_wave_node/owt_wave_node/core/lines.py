"""From coefficients of frequencies to signals: on a grid, at any frequencies, over part of a record.

Every route offers the same: load coefficients (once per point), then transform them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_wave_node.core.grid import FrequencyGrid
from owt_wave_node.core.window import FINE, Window, spread_window
from owt_wave_node.kernels import compressed as _kernel

__all__ = ["FrequencyLines", "Lines", "SpreadLines", "grid_lines", "listed_lines"]

#: Numbers per work array.
BLOCK = 2**21
#: Number of lines up to which summing them directly costs less than spreading them over a grid.
FEW = 256

Loaded = Complex[np.ndarray, "row signal bin"]


@runtime_checkable
class Lines(Protocol):
    """Signals Re sum_j Y_j exp(i omega_j t) of coefficients Y at given frequencies, at `n` samples."""

    @property
    def n(self) -> int:
        """Number of samples."""
        ...

    @property
    def bins(self) -> int:
        """Number of loaded coefficients of a signal."""
        ...

    def load(self, coefficients: Complex[np.ndarray, "row signal line"]) -> Loaded:
        """Prepare coefficients for :meth:`series`."""
        ...

    def series(
        self, loaded: Loaded, index: Int[np.ndarray, " some"], *, channels: int
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals of the rows `index`, then as many of their time derivatives as make up `channels`."""
        ...


def grid_lines(grid: FrequencyGrid, bins: int) -> Lines:
    """Lines at the first `bins` multiples of the spacing of a grid, from zero, over its record."""
    return GridLines(grid, bins)


def listed_lines(frequency: Float[np.ndarray, " line"], *, dt: float, start: int, count: int) -> Lines:
    """Lines at ascending `frequency` in rad/s, over `count` samples dt s apart from sample `start`."""
    if frequency.size <= FEW:
        return FrequencyLines(frequency, dt, count, start)
    window = spread_window(start=start, count=count, dt=dt, top=float(frequency[-1]), bell=FINE)
    return SpreadLines(frequency, dt, window)


@dataclass(frozen=True)
class GridLines:
    """The first `bins` multiples of a spacing, from zero: inverse Fourier transforms."""

    grid: FrequencyGrid
    bins: int

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.grid.n

    def load(self, coefficients: Complex[np.ndarray, "row signal line"]) -> Loaded:
        """Return them as they are."""
        return coefficients

    def series(
        self, loaded: Loaded, index: Int[np.ndarray, " some"], *, channels: int
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals of the rows `index`, then their time derivatives."""
        return self.grid.series(loaded, index, channels=channels)


@dataclass(frozen=True)
class FrequencyLines:
    """Frequencies in rad/s, summed directly at n samples dt s apart from sample `start`."""

    frequency: Float[np.ndarray, " line"]
    dt: float
    n: int
    start: int = 0

    @property
    def bins(self) -> int:
        """Number of frequencies."""
        return self.frequency.size

    def load(self, coefficients: Complex[np.ndarray, "row signal line"]) -> Loaded:
        """Count phases from the first sample."""
        return coefficients * np.exp(1j * self.frequency * (self.start * self.dt))

    def series(
        self, loaded: Loaded, index: Int[np.ndarray, " some"], *, channels: int
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals of the rows `index`, then their time derivatives.

        The time is split as t = t_b + t_c into about sqrt(n) coarse and fine steps, whose phasors multiply:
        few are evaluated, and the sum over lines is one matrix product with the fine ones.
        """
        chosen, lines = loaded[index], self.frequency.size
        chosen = np.concatenate([chosen, 1j * self.frequency * chosen], axis=1)[:, :channels]
        flat = chosen.reshape(-1, lines)
        fine = math.isqrt(self.n - 1) + 1
        coarse = -(-self.n // fine)
        shift = np.exp(1j * self.dt * fine * np.outer(np.arange(coarse), self.frequency))
        phasor = np.exp(1j * self.dt * np.outer(self.frequency, np.arange(fine)))
        table = np.concatenate([phasor.real, -phasor.imag])
        out = np.empty((len(flat), coarse * fine))
        rows = max(1, BLOCK // (2 * coarse * lines))
        for r in range(0, len(flat), rows):
            moved = flat[r : r + rows, None, :] * shift
            pair = np.concatenate([moved.real, moved.imag], axis=-1)
            out[r : r + rows] = (pair @ table).reshape(len(moved), -1)
        return np.ascontiguousarray(out[:, : self.n]).reshape(index.size, channels, self.n)


@dataclass(frozen=True)
class SpreadLines:
    """Many frequencies in rad/s, spread over the grid of a window of the record (an error of 2e-13)."""

    frequency: Float[np.ndarray, " line"]
    dt: float
    window: Window

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.window.count

    @property
    def bins(self) -> int:
        """Number of multiples of the window's spacing from zero."""
        return self.window.n_bins + self.window.bottom

    def load(self, coefficients: Complex[np.ndarray, "row signal line"]) -> Loaded:
        """Spread the coefficients over the bins of the window."""
        window, (rows, signals, lines) = self.window, coefficients.shape
        spacing, bell = window.grid.spacing, FINE
        y = self.frequency / spacing
        start = np.ceil(y - 0.5 * bell.width).astype(np.int64)
        weight = bell.value((y - start)[:, None] - np.arange(bell.width))
        out = np.zeros((window.n_bins, 2, rows * signals))
        lined_up = np.ascontiguousarray(coefficients.reshape(-1, lines).T)
        _kernel.spread_rows(self.frequency, lined_up, window.middle, start - window.bottom, weight, out)
        # Phases of a bell count from the middle of the window, those of a transform from its first sample.
        bins = np.arange(window.n_bins) + window.bottom
        turn = np.exp(-1j * spacing * self.dt * (window.count // 2) * bins)
        spectra = ((out[:, 0] + 1j * out[:, 1]).T * turn).reshape(rows, signals, window.n_bins)
        return window.fold(np.ascontiguousarray(spectra))

    def series(
        self, loaded: Loaded, index: Int[np.ndarray, " some"], *, channels: int
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals of the rows `index`, then their time derivatives."""
        return self.window.in_time(loaded, index, derive=channels > loaded.shape[1])
