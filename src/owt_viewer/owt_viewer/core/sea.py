"""The sea surface on a grid, first order, at any time [eq. 4.30]."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Int

__all__ = ["SeaSurface", "grid_triangles"]


def grid_triangles(n_x: int, n_y: int) -> Int[np.ndarray, " corner"]:
    """Corners of the triangles of a grid whose point (i, j) has number i n_y + j, three to a triangle."""
    first = (np.arange(n_x - 1)[:, None] * n_y + np.arange(n_y - 1)).reshape(-1, 1)
    return np.asarray((first + np.array([0, n_y, n_y + 1, 0, n_y + 1, 1])).reshape(-1))


class SeaSurface:
    """First-order elevation on a square grid round the origin.

    On a grid the spatial part of each component is a product, exp(-i k x cos b) exp(-i k y sin b): the table
    of each axis is kept and the sum over the components is one matrix product, so that memory grows with the
    side of the grid and not with its area.

    Parameters
    ----------
    sea : SeaState or its message
        Components of the first order.
    extent_m : float
        Side of the square in m.
    points : int
        Grid points along a side, 2 at least.
    """

    def __init__(self, sea: Any, extent_m: float, points: int) -> None:
        names = ("omega_rad_s", "amplitude_m", "phase_rad", "wavenumber_rad_m", "component_direction_deg")
        omega, a, phase, k, b = (np.array(getattr(sea, name), dtype=np.float64) for name in names)
        self.axis: Float[np.ndarray, " point"] = np.linspace(-0.5 * extent_m, 0.5 * extent_m, points)
        self._omega = omega
        b = np.deg2rad(b)
        along_x = np.exp(-1j * np.outer(self.axis, k * np.cos(b)))
        self._x: Complex[np.ndarray, "point component"] = along_x * (a * np.exp(-1j * phase))
        self._y: Complex[np.ndarray, "component point"] = np.exp(-1j * np.outer(k * np.sin(b), self.axis))
        #: Twice the standard deviation in m: what the colours span.
        self.amplitude = float(2.0 * np.sqrt(0.5 * (a**2).sum()))
        self.triangles = grid_triangles(points, points)

    def elevation(self, time_s: float) -> Float[np.ndarray, "point point"]:
        """Elevation in m at time `time_s`, [x, y]."""
        turned = self._x * np.exp(1j * self._omega * time_s)
        return np.asarray((turned @ self._y).real)

    def points(self, time_s: float) -> Float[np.ndarray, "grid 3"]:
        """All points of the surface at time `time_s` in m."""
        x, y = np.meshgrid(self.axis, self.axis, indexing="ij")
        return np.stack([x, y, self.elevation(time_s)], axis=2).reshape(-1, 3)
