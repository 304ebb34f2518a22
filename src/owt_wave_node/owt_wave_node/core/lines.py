"""Signals of any list of frequencies: what an inverse Fourier transform is to a frequency grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int

__all__ = ["FrequencyLines"]

#: Numbers per work array.
BLOCK = 2**21


@dataclass(frozen=True)
class FrequencyLines:
    """Frequencies in rad/s, summed directly at n samples dt s apart."""

    frequency: Float[np.ndarray, " line"]
    dt: float
    n: int

    def series(
        self,
        spectra: Complex[np.ndarray, "row signal line"],
        index: Int[np.ndarray, " some"],
        *,
        channels: int,
    ) -> Float[np.ndarray, "some channel time"]:
        """Signals of the rows `index`, then as many of their time derivatives as make up `channels`."""
        chosen = spectra[index]
        return self.signal(np.concatenate([chosen, 1j * self.frequency * chosen], axis=1)[:, :channels])

    def signal(self, spectra: Complex[np.ndarray, "*batch line"]) -> Float[np.ndarray, "*batch time"]:
        """Return the real signal Re sum_j Y_j exp(i omega_j t) of the coefficients Y.

        The time is split as t = t_b + t_c into about sqrt(n) coarse and fine steps, whose phasors multiply:
        few are evaluated, and the sum over lines is one matrix product with the fine ones.
        """
        batch, lines = spectra.shape[:-1], self.frequency.size
        flat = spectra.reshape(-1, lines)
        fine = math.isqrt(self.n - 1) + 1
        coarse = -(-self.n // fine)
        out = np.zeros((len(flat), coarse * fine))
        step = max(1, BLOCK // (4 * coarse))
        for i in range(0, lines, step):
            omega = self.frequency[i : i + step]
            shift = np.exp(1j * self.dt * fine * np.outer(np.arange(coarse), omega))
            phasor = np.exp(1j * self.dt * np.outer(omega, np.arange(fine)))
            table = np.concatenate([phasor.real, -phasor.imag])
            rows = max(1, BLOCK // (2 * coarse * omega.size))
            for r in range(0, len(flat), rows):
                moved = flat[r : r + rows, None, i : i + step] * shift
                pair = np.concatenate([moved.real, moved.imag], axis=-1)
                out[r : r + rows] += (pair @ table).reshape(len(moved), -1)
        return np.ascontiguousarray(out[:, : self.n]).reshape(*batch, self.n)
