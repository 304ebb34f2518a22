"""Directions of a short-crested sea: the distribution cos^2s of half the angle to the mean."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

__all__ = ["angle_of", "mean_direction", "spreading_density", "turn_between"]

#: Difference in degrees between directions that are one but for round-off.
SAME_DIRECTION = 1e-9


def turn_between(
    heading_deg: float, direction_deg: Float[np.ndarray, " component"]
) -> Float[np.ndarray, " component"]:
    """Turn in degrees, within half a turn, from a heading to directions; exactly 0 for the same direction."""
    turn = (direction_deg - heading_deg + 180.0) % 360.0 - 180.0
    return np.where(np.abs(turn) < SAME_DIRECTION, 0.0, turn)


def spreading_density(angle: Float[np.ndarray, " angle"], exponent: float) -> Float[np.ndarray, " angle"]:
    """Density in 1/rad of directions at `angle` in rad, within +-pi, from the mean.

    D = Gamma(s + 1) / (2 sqrt(pi) Gamma(s + 1/2)) cos^2s(angle/2), s the exponent (Longuet-Higgins,
    Cartwright and Smith, 1963): it integrates to 1 over the circle, and its mean vector is s / (s + 1) long.
    """
    s = exponent
    scale = math.exp(math.lgamma(s + 1.0) - math.lgamma(s + 0.5)) / (2.0 * math.sqrt(math.pi))
    return np.asarray(scale * np.cos(0.5 * angle) ** (2.0 * s))


def angle_of(
    probability: Float[np.ndarray, " component"], exponent: float
) -> Float[np.ndarray, " component"]:
    """Angle in rad from the mean direction below which a direction falls with `probability`.

    sin^2(angle/2) of a positive angle has a beta distribution with parameters 1/2 and s + 1/2; its inverse
    turns uniform numbers in (0, 1) into directions of density :func:`spreading_density`.
    """
    from scipy.special import betaincinv  # here: a long-crested sea starts without it

    side = 2.0 * probability - 1.0
    return np.asarray(2.0 * np.sign(side) * np.arcsin(np.sqrt(betaincinv(0.5, exponent + 0.5, np.abs(side)))))


def mean_direction(
    direction_deg: Float[np.ndarray, " component"], weight: Float[np.ndarray, " component"]
) -> float:
    """Heading in degrees of components of given directions and energies.

    The common direction, modulo a turn, of those that carry energy; else the direction of the sum of unit
    vectors times energy. Where that sum vanishes (equal and opposite waves), the direction of the largest.
    """
    largest = int(weight.argmax())
    first = float(direction_deg[largest])
    if not turn_between(first, direction_deg[weight > 0.0]).any():
        return first
    angle = np.deg2rad(direction_deg)
    x, y = float(weight @ np.cos(angle)), float(weight @ np.sin(angle))
    if math.hypot(x, y) <= 1e-9 * float(weight.sum()):
        return first
    return math.degrees(math.atan2(y, x))
