"""Vertical profile of the first order, and what is done with it above still water [2.6]."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["check_extrapolation", "first_order_profile", "second_order_level"]

#: Exponent k z above which the profile of stretching "none" is refused: it has lost all meaning.
MAX_EXPONENT = 100.0


def check_extrapolation(stretching: str, wavenumber: Float[np.ndarray, " component"], top: float) -> None:
    """Refuse to continue the profile itself (stretching "none") to where it explodes.

    Raises
    ------
    InputError
        If k z exceeds 100 at the height `top` in m.
    """
    if stretching == "none" and wavenumber.max() * top > MAX_EXPONENT:
        raise InputError(
            "wave.stretching",
            "none",
            f"continues exp(k z) to z = {top:g} m, where it exceeds exp({MAX_EXPONENT:g})",
            "Use taylor or constant, or lower points.",
        )


def first_order_profile(
    wavenumber: Float[np.ndarray, " component"],
    level: Float[np.ndarray, " point"],
    *,
    water_depth: float,
    stretching: str,
) -> tuple[Float[np.ndarray, "point component"], Float[np.ndarray, "point component"]]:
    """Vertical factors of the horizontal and the vertical first-order velocity.

    Up to still water cosh k(z+d) / cosh kd and sinh k(z+d) / cosh kd [eq. 4.8, 4.9]. Above it,

    - ``taylor``: value and slope at still water, C(0) + z C'(0) [eq. 2.19, for both velocities];
    - ``constant``: the value at still water [eq. 2.16];
    - ``none``: no modification, the profile itself is evaluated at z.

    Parameters
    ----------
    wavenumber : float array [component]
        rad/m.
    level : float array [point]
        z in m, up from still water.
    """
    k, z = wavenumber[None, :], level[:, None]
    below = z if stretching == "none" else np.minimum(z, 0.0)
    up, down = np.exp(k * below), np.exp(-k * (below + 2.0 * water_depth))
    scale = 1.0 / (1.0 + np.exp(-2.0 * k * water_depth))
    horizontal, vertical = (up + down) * scale, (up - down) * scale
    if stretching == "taylor":
        above = np.maximum(z, 0.0) * k
        horizontal = horizontal + above * np.tanh(k * water_depth)
        vertical = vertical + above
    return horizontal, vertical


def second_order_level(level: Float[np.ndarray, " point"], stretching: str) -> Float[np.ndarray, " point"]:
    """Level in m at which the second-order field is evaluated: still water for points above it."""
    return level if stretching == "none" else np.minimum(level, 0.0)
