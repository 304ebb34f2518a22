"""Elevation and kinematics of a case at its points: what ``owt waves`` writes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from owt_model.config import CaseConfig
from owt_model.errors import ComputationError, InputError
from owt_wave_node.core.field import Field
from owt_wave_node.core.profile import check_extrapolation
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Heading, build_sea_state, waves

__all__ = ["Kinematics", "wave_kinematics"]

#: Points per block, so that work arrays stay small beside the result.
BLOCK = 32


@dataclass(frozen=True)
class Kinematics:
    """Elevation in m, velocity in m/s and local acceleration in m/s2 at points, in global axes.

    Attributes
    ----------
    eta1, eta2 : float arrays [time, point]
        First- and second-order elevation at the place of each point.
    velocity, acceleration : float arrays [time, point, 3]
        Total of the asked order; a point above the surface holds the stretched value.
    velocity2, acceleration2 : float arrays [time, point, 3]
        The second-order part of them, zero at order 1.
    wet : bool array [time, point]
        True where the point lies at or below the instantaneous surface.
    """

    t: Float[np.ndarray, " time"]
    eta1: Float[np.ndarray, "time point"]
    eta2: Float[np.ndarray, "time point"]
    velocity: Float[np.ndarray, "time point 3"]
    acceleration: Float[np.ndarray, "time point 3"]
    velocity2: Float[np.ndarray, "time point 3"]
    acceleration2: Float[np.ndarray, "time point 3"]
    wet: Bool[np.ndarray, "time point"]


def wave_kinematics(case: CaseConfig) -> Kinematics:
    """Evaluate elevation and kinematics at the points of `case`.

    Raises
    ------
    InputError
        If the case has no points, or its sea is not one that can be computed.
    ComputationError
        If a result is not finite.
    """
    if case.points_m is None:
        raise InputError("points_m", None, "is missing", "List points [x, y, z] in m, z up from still water.")
    sea = build_sea_state(case)
    heading = Heading(sea.direction_deg)
    points = np.array(case.points_m, dtype=float)
    x, z = heading.along(points), points[:, 2].copy()
    check_extrapolation(sea.stretching, sea.wavenumber_rad_m, float(z.max()))
    field = make_field(waves(sea))
    n, size = case.time.n, len(points)
    eta = np.empty((2, n, size))
    motion = np.empty((4, n, size, 3))
    for i in range(0, size, BLOCK):
        rows = slice(i, min(i + BLOCK, size))
        _fill(field, x[rows], z[rows], heading, eta[:, :, rows], motion[:, :, rows])
    if not (np.isfinite(eta).all() and np.isfinite(motion).all()):
        raise ComputationError("wave kinematics are not finite")
    return Kinematics(
        t=np.arange(n) * case.time.dt_s,
        eta1=eta[0],
        eta2=eta[1],
        velocity=motion[0],
        acceleration=motion[1],
        velocity2=motion[2],
        acceleration2=motion[3],
        wet=z[None, :] <= eta[0] + eta[1],
    )


def _fill(
    field: Field,
    x: Float[np.ndarray, " point"],
    z: Float[np.ndarray, " point"],
    heading: Heading,
    eta: Float[np.ndarray, "2 time point"],
    motion: Float[np.ndarray, "4 time point 3"],
) -> None:
    """Fill the views of one block of points."""
    for out, series in zip(eta, field.elevation(x), strict=True):
        out[...] = series.T
    second = field.second(x, z)
    total = field.first(x, z) + second
    cos_b, sin_b = heading.unit
    for out, source, c in (
        (motion[0], total, 0),
        (motion[1], total, 2),
        (motion[2], second, 0),
        (motion[3], second, 2),
    ):
        out[:, :, 0] = source[:, c].T * cos_b
        out[:, :, 1] = source[:, c].T * sin_b
        out[:, :, 2] = source[:, c + 1].T
