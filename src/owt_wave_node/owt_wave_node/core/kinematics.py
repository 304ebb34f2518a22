"""Elevation and kinematics of a case at its points: what ``owt waves`` writes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from owt_model.config import CaseConfig
from owt_model.errors import ComputationError, InputError
from owt_model.parallel import slices
from owt_wave_node.core.current import current_velocity
from owt_wave_node.core.field import Field
from owt_wave_node.core.profile import check_extrapolation
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state, sea_field, sea_height

__all__ = ["Kinematics", "check_bed", "wave_kinematics"]

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
        Total of the asked order, and the current; a point above the surface holds the stretched value.
    velocity2, acceleration2 : float arrays [time, point, 3]
        The second-order part of them, zero at order 1; without the current.
    wet : bool array [time, point]
        True where the point lies at or below the instantaneous surface.
    error_estimate : float
        Error of the second order relative to its standard deviation; zero where all pairs were summed.
    """

    t: Float[np.ndarray, " time"]
    eta1: Float[np.ndarray, "time point"]
    eta2: Float[np.ndarray, "time point"]
    velocity: Float[np.ndarray, "time point 3"]
    acceleration: Float[np.ndarray, "time point 3"]
    velocity2: Float[np.ndarray, "time point 3"]
    acceleration2: Float[np.ndarray, "time point 3"]
    wet: Bool[np.ndarray, "time point"]
    error_estimate: float = 0.0


def check_bed(case: CaseConfig, lowest: float) -> None:
    """Refuse a surface that falls to the sea bed: no level below it is left, and nothing that moves.

    Parameters
    ----------
    lowest : float
        Lowest surface in m.

    Raises
    ------
    InputError
        If it lies at or below the sea bed.
    """
    if lowest <= -case.water_depth_m:
        raise InputError(
            sea_field(case),
            sea_height(case),
            f"lowers the surface to z = {lowest:.2f} m, below the sea bed at z = {-case.water_depth_m:g} m",
            "Use lower waves or deeper water.",
        )


def wave_kinematics(case: CaseConfig) -> Kinematics:
    """Evaluate elevation and kinematics at the points of `case`.

    Raises
    ------
    InputError
        If the case has no points, or its sea is not one that can be computed, or falls below the bed.
    ComputationError
        If a result is not finite.
    """
    if case.points_m is None:
        raise InputError("points_m", None, "is missing", "List points [x, y, z] in m, z up from still water.")
    sea = build_sea_state(case)
    frame = Frame(sea.direction_deg)
    place = frame.place(np.array(case.points_m, dtype=float))
    z = place[:, 2].copy()
    check_extrapolation(sea.stretching, sea.wavenumber_rad_m, float(z.max()))
    field = make_field(case, sea)
    n, size = case.time.n, len(place)
    eta = np.empty((2, n, size))
    motion = np.empty((4, n, size, 3))
    for rows in slices(size, BLOCK):
        for out, series in zip(eta[:, :, rows], field.elevation(place[rows]), strict=True):
            out[...] = series.T
        check_bed(case, float(eta[:, :, rows].sum(axis=0).min()))  # Wheeler divides by 1 + eta / d
        _fill(field, place[rows], frame, motion[:, :, rows])
    motion[0, :, :, :2] += current_velocity(case, z)
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
        error_estimate=float(getattr(field, "error_estimate", 0.0)),
    )


def _fill(
    field: Field,
    place: Float[np.ndarray, "point 3"],
    frame: Frame,
    motion: Float[np.ndarray, "4 time point 3"],
) -> None:
    """Fill the view of one block of points with its motion."""
    second = field.second(place)
    total = field.first(place) + second
    axes = frame.axes[[0, 2] if field.n_axes == 2 else slice(None)]
    for out, source in zip(motion, (*_halves(total), *_halves(second)), strict=True):
        out[...] = source.transpose(2, 0, 1) @ axes


def _halves(
    motion: Float[np.ndarray, "point channel time"],
) -> tuple[Float[np.ndarray, "point axis time"], Float[np.ndarray, "point axis time"]]:
    """Velocities and accelerations."""
    n_axes = motion.shape[1] // 2
    return motion[:, :n_axes], motion[:, n_axes:]
