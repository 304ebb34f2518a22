"""Steady current: a horizontal velocity that depends on the level only."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.sea_config import Current

__all__ = ["current_velocity"]


def current_velocity(case: CaseConfig, z: Float[np.ndarray, " point"]) -> Float[np.ndarray, "point 2"]:
    """Velocity in m/s of the current of `case` at levels z, along global x and y.

    Above still water the current keeps its value there: it neither stretches nor moves with the surface.
    Zeros where the case has no current.

    Parameters
    ----------
    case : CaseConfig
        Its current and its water depth.
    z : float array [point]
        Levels in m, up from still water.
    """
    if case.current is None:
        return np.zeros((z.size, 2))
    b = np.deg2rad(case.current.direction_deg)
    speed = _speed(case.current, np.minimum(z, 0.0), case.water_depth_m)
    return np.outer(speed, [np.cos(b), np.sin(b)])


def _speed(current: Current, z: Float[np.ndarray, " point"], depth: float) -> Float[np.ndarray, " point"]:
    """Speed in m/s at levels z <= 0: v, v (1 + z/d)^p, or linear in a table and constant beyond it."""
    if current.table is not None:
        level, speed = np.array(sorted(current.table)).T
        return np.asarray(np.interp(z, level, speed))
    if current.profile == "uniform":
        return np.full(z.size, current.speed_m_s)
    above_bed = np.maximum(1.0 + z / depth, 0.0)
    return np.asarray(current.speed_m_s * above_bed**current.exponent)
