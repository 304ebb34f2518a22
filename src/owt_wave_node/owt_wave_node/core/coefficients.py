"""Coefficients of Morison's equation that are one number, or depend on the level."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

__all__ = ["Levels", "coefficient_at", "levels_of"]

#: A number, or levels z in m and values.
Levels = float | tuple[tuple[float, float], ...]


def coefficient_at(value: Levels, z: Float[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
    """Coefficient at levels z in m: linear between the levels of a table, constant beyond them."""
    if not isinstance(value, tuple):
        return np.full(z.size, float(value))
    level, entry = np.array(sorted(value), dtype=float).T
    return np.asarray(np.interp(z, level, entry))


def levels_of(value: Levels) -> list[float]:
    """Levels in m at which the slope of a coefficient changes."""
    return [float(z) for z, _ in value] if isinstance(value, tuple) else []
