"""Circular hollow section: area and second moments of area."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

__all__ = ["area", "bending_inertia", "polar_inertia"]

Array = Float[np.ndarray, "..."]


def area(diameter: Array, thickness: Array) -> Array:
    """Cross-section area in m2 of a tube of outer `diameter` and wall `thickness` in m [eq. 4.72]."""
    r_o, r_i = diameter / 2.0, diameter / 2.0 - thickness
    return np.asarray(np.pi * (r_o**2 - r_i**2))


def bending_inertia(diameter: Array, thickness: Array) -> Array:
    """Second moment of area in m4 about a diameter [eq. 4.73]."""
    r_o, r_i = diameter / 2.0, diameter / 2.0 - thickness
    return np.asarray(0.25 * np.pi * (r_o**4 - r_i**4))


def polar_inertia(diameter: Array, thickness: Array) -> Array:
    """Polar second moment of area in m4 [eq. 4.78]."""
    return 2.0 * bending_inertia(diameter, thickness)
