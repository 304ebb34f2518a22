"""Plans of the inverse Fourier transforms: how a length is split, and the tables for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_wave_node.kernels import fft as _kernel
from owt_wave_node.kernels.simd import LANES

__all__ = ["Transform", "plan_transform"]

#: Measured work per sample of a step of each radix, and of one coefficient per sample where the table of its
#: factors stays in the second-level cache and where it does not.
COST, COEFFICIENT = {4: 1.6, 5: 1.9, 3: 1.4, 2: 1.2}, (2.0, 5.0)
#: Numbers in a work array: four such arrays stay in the second-level cache.
CACHED = 8192


@dataclass(frozen=True)
class Transform:
    """Coefficients of bins 0 to `n_bins` - 1 to `length` samples; see :mod:`owt_wave_node.kernels.fft`.

    Attributes
    ----------
    lanes : int
        Interleaved records that are transformed together.
    radices : int array [step]
        Their product is the length of such a record.
    turn_real, turn_imag : float arrays [bin, split]
        exp(2 pi i j p / length).
    factor_real, factor_imag : float arrays [factor]
        exp(2 pi i k l / m) of the steps, in their order; ones for the last.
    """

    length: int
    lanes: int
    radices: Int[np.ndarray, " step"]
    turn_real: Float[np.ndarray, "bin split"]
    turn_imag: Float[np.ndarray, "bin split"]
    factor_real: Float[np.ndarray, " factor"]
    factor_imag: Float[np.ndarray, " factor"]

    @property
    def _plan(self) -> tuple[np.ndarray, ...]:
        return self.radices, self.turn_real, self.turn_imag, self.factor_real, self.factor_imag

    def to_time(
        self,
        spectra: Complex[np.ndarray, "row signal bin"],
        index: Int[np.ndarray, " some"],
        *,
        channels: int,
        spacing: float,
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals Re sum_j Y_j exp(i j spacing t) of the rows `index`, then their time derivatives.

        As many of both as there are `channels`, an even number.
        """
        out = np.empty((index.size, channels, self.length))
        _kernel.to_time(spectra, index, spacing, self.lanes, self._plan, out)
        return out


@lru_cache(maxsize=8)
def plan_transform(length: int, n_bins: int) -> Transform | None:
    """Split `length` for coefficients of `n_bins` bins.

    Returns
    -------
    Transform or None
        None if the length is no multiple of 4 with a second factor of twos, threes and fives.
    """
    best: tuple[float, int, list[int]] | None = None
    for split in range(LANES, length // 2 + 1, LANES):
        if length % split or (radices := _radices(length // split)) is None:
            continue
        table = n_bins * split
        cost = COEFFICIENT[table > CACHED] * table / length + sum(COST[r] for r in radices)
        if best is None or cost < best[0]:
            best = cost, split, radices
    if best is None:
        return None
    _, split, radices = best
    short = length // split
    lanes = max(
        (n for n in range(LANES, split + 1, LANES) if split % n == 0 and n * short <= CACHED), default=LANES
    )
    turn = _roots(length, np.outer(np.arange(n_bins), np.arange(split)) % length)
    factors, m = [], short
    for r in radices[:-1]:
        factors.append(_roots(m, np.outer(np.arange(m // r), np.arange(1, r)).ravel()))
        m //= r
    factor = np.concatenate([*factors, np.ones(radices[-1] - 1)])
    return Transform(
        length,
        lanes,
        np.array(radices),
        turn.real.copy(),
        turn.imag.copy(),
        factor.real.copy(),
        factor.imag.copy(),
    )


def _roots(n: int, power: Int[np.ndarray, "*any"]) -> Complex[np.ndarray, "*any"]:
    """exp(2 pi i power / n)."""
    return np.asarray(np.exp(2j * np.pi / n * power))


def _radices(length: int) -> list[int] | None:
    """Factors 4, 5, 3 and 2 of a length; None if others are left or there is none."""
    found = []
    for r in COST:
        while length % r == 0:
            found.append(r)
            length //= r
    return found if found and length == 1 else None
