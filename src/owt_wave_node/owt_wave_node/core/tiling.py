"""Windows of a record that grows: what each is decomposed from, and how one fades into the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

__all__ = ["Tiling"]

#: Share of the lag over which a window is tapered; the rest keeps what is used away from the taper.
TAPERED = 0.75


@dataclass(frozen=True)
class Tiling:
    """Which samples each window is decomposed from, and which it is used for; all in samples.

    Window k is used for kH - F <= i < (k + 1) H, H the hop and F the fade: over the first F samples it
    replaces window k - 1. It ends `lag` after its last one.

    Attributes
    ----------
    n : int
        Samples of the case; the record has `lag` more.
    """

    n: int
    window: int
    lag: int
    hop: int
    fade: int

    @property
    def record(self) -> int:
        """Samples of the record."""
        return self.n + self.lag

    def windows(self, rows: range) -> range:
        """Windows that samples are made of."""
        return range(rows.start // self.hop, (rows.stop - 1 + self.fade) // self.hop + 1)

    def end(self, k: int) -> int:
        """Sample at which a window ends."""
        return min((k + 1) * self.hop + self.lag, self.record)

    def used(self, k: int) -> range:
        """Samples that a window is used for."""
        return range(max(0, k * self.hop - self.fade), min((k + 1) * self.hop, self.n))

    def weight(self, k: int, rows: range) -> Float[np.ndarray, " sample"]:
        """Weights of a window at some samples; those of all windows sum to one."""
        i = np.arange(rows.start, rows.stop)
        rise = _step((i - (k * self.hop - self.fade) + 0.5) / self.fade) if k else np.ones(i.size)
        return np.asarray(rise - _step((i - ((k + 1) * self.hop - self.fade) + 0.5) / self.fade))

    def taper(self, k: int) -> Float[np.ndarray, " sample"]:
        """Factors on the samples of a window; zero before the record begins."""
        begin, end = self.end(k) - self.window, self.end(k)
        i, length = np.arange(begin, end), TAPERED * self.lag
        rise, fall = i - max(begin, 0) + 0.5, end - i - 0.5
        if not self.lag:
            return np.asarray(rise > 0.0, dtype=float)
        return np.asarray(_step(rise / length) * _step(fall / length))


def _step(u: Float[np.ndarray, " sample"]) -> Float[np.ndarray, " sample"]:
    """Smooth rise from 0 at u = 0 to 1 at u = 1."""
    return np.asarray(np.sin(0.5 * np.pi * np.clip(u, 0.0, 1.0)) ** 2)
