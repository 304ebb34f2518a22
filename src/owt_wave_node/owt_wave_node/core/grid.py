"""The frequency grid that turns sums over components into fast Fourier transforms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from owt_wave_node.core.transform import plan_transform

__all__ = ["FrequencyGrid", "frequency_grid"]

#: Phase in rad by which a component may miss the grid over the record.
PHASE_TOLERANCE = 1e-9
#: Longest transform that the grid is extended to (a record is never refused for its own length).
MAX_LENGTH = 2**20
#: Components that every number of periods is tried with.
SIEVE = 16


@dataclass(frozen=True)
class FrequencyGrid:
    """Multiples of 2 pi / (periods n dt), transformed with a step of dt / oversampling.

    Attributes
    ----------
    bins : int array [component]
        Multiple of the spacing at which each component lies.
    spacing : float
        rad/s.
    length : int
        Length of the transform, periods * n * oversampling.
    """

    bins: Int[np.ndarray, " component"]
    spacing: float
    length: int
    oversampling: int
    n: int

    def series(
        self,
        spectra: Complex[np.ndarray, "row signal bin"],
        index: Int[np.ndarray, " some"],
        *,
        channels: int,
    ) -> Float[np.ndarray, "some channel time"]:
        """Real signals Re sum_j Y_j exp(i j spacing t) of the rows `index`, then their time derivatives.

        As many channels in all as `channels`, an even number.
        """
        plan = plan_transform(self.length, spectra.shape[2])
        if plan is None:
            chosen = spectra[index]
            rates = 1j * self.spacing * np.arange(spectra.shape[2])
            half = 0.5 * np.concatenate([chosen, rates * chosen], axis=1)[:, :channels]
            half[..., 0] *= 2.0
            return self._samples(np.fft.irfft(half, self.length, axis=-1, norm="forward"))
        return self._samples(plan.to_time(spectra, index, channels=channels, spacing=self.spacing))

    def signal(self, spectra: Complex[np.ndarray, "*batch bin"]) -> Float[np.ndarray, "*batch time"]:
        """Real signals Re sum_j Y_j exp(i j spacing t) of any number of coefficients Y."""
        n_bins = spectra.shape[-1]
        rows = spectra.reshape(-1, n_bins)
        pairs = np.concatenate([rows, np.zeros((len(rows) % 2, n_bins))])
        series = self.series(pairs.reshape(-1, 2, n_bins), np.arange(len(pairs) // 2), channels=2)
        return series.reshape(-1, self.n)[: len(rows)].reshape(*spectra.shape[:-1], self.n)

    def _samples(self, series: Float[np.ndarray, "*batch length"]) -> Float[np.ndarray, "*batch time"]:
        if self.length == self.n:
            return series
        return np.ascontiguousarray(series[..., : self.n * self.oversampling : self.oversampling])


def _on_grid(
    turns: Float[np.ndarray, "#p component"], periods: Float[np.ndarray, "p 1"]
) -> Bool[np.ndarray, "p component"]:
    """True where `turns` cycles in the record are a whole number in `periods` records, within tolerance."""
    cycles = turns * periods
    miss = np.abs(cycles - np.round(cycles)) / periods
    return np.asarray((2.0 * math.pi * miss <= PHASE_TOLERANCE) & (np.round(cycles) >= 1))


def frequency_grid(
    omega: Float[np.ndarray, " component"], *, dt: float, n: int, order: int
) -> FrequencyGrid | None:
    """Find the smallest integer p for which all `omega` are multiples of 2 pi / (p n dt).

    A component counts as on the grid if its phase misses it by at most 1e-9 rad over the record. The
    transform is p n samples long, times the smallest integer that brings `order` times the highest
    component below its Nyquist frequency; it is then subsampled, which is exact.

    Parameters
    ----------
    omega : float array [component]
        rad/s, ascending.
    dt, n : float, int
        Time step in s and number of samples of the record.
    order : int
        Perturbation order: the highest frequency is `order` times that of the components.

    Returns
    -------
    FrequencyGrid or None
        None if there is no such p with a transform of at most 2^20 samples.
    """
    turns = omega * (n * dt) / (2.0 * math.pi)
    candidates = np.arange(1.0, max(1, MAX_LENGTH // n) + 1.0)[:, None]
    for turn in turns[:SIEVE]:  # few p pass the first components, and those are tried with all
        candidates = candidates[_on_grid(np.array([[turn]]), candidates)[:, 0]]
    for candidate in candidates:
        if _on_grid(turns[None, :], candidate[None, :]).all():
            break
    else:
        return None
    periods = int(candidate[0])
    bins = np.round(turns * periods).astype(np.int64)
    length = periods * n
    oversampling = (2 * order * int(bins[-1])) // length + 1
    return FrequencyGrid(bins, 2.0 * math.pi / (length * dt), length * oversampling, oversampling, n)
