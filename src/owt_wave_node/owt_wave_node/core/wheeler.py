"""Wheeler stretching of the first order [eq. 2.17, 2.18]."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.field import Field, GridField, Kinematics, Points, Prepared, Series
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.parallel import map_threads
from owt_wave_node.core.sea import Waves
from owt_wave_node.kernels import wheeler as _kernel

__all__ = ["WheelerField", "make_field"]

#: Samples per call of the kernel, so that its tables stay small.
BLOCK = 512


class WheelerField:
    """First order at z' = (z - eta) / (1 + eta / d), evaluated at every time (order 1 only).

    Velocities and local accelerations are those of the linear field at the level z'. Above the surface, where
    the formula does not hold, the profile continues along its tangent at the surface.
    """

    def __init__(self, waves: Waves, surface: Field) -> None:
        self.waves = waves
        self._surface = surface

    def elevation(self, x: Points) -> tuple[Series, Series]:
        """First-order elevation in m and zeros."""
        return self._surface.elevation(x)

    def first(self, x: Points, z: Points) -> Kinematics:
        """Stretched kinematics."""
        waves = self.waves
        eta, _ = self.elevation(x)
        level = np.maximum((z[:, None] - eta) / (1.0 + eta / waves.depth), -waves.depth)
        out = np.empty((x.size, 4, waves.n))

        def part(start: int) -> None:
            rows = slice(start, min(start + BLOCK, waves.n))
            result = np.empty((x.size, 4, rows.stop - start))
            _kernel.stretched(
                x, np.ascontiguousarray(level[:, rows]), waves.omega, waves.wavenumber, waves.amplitude,
                waves.depth, waves.gravity, start, waves.dt, result,
            )  # fmt: skip
            out[:, :, rows] = result

        map_threads(part, range(0, waves.n, BLOCK))
        return out

    def second(self, x: Points, z: Points) -> Kinematics:
        """Zeros: Wheeler stretches the first order only."""
        return np.zeros((x.size, 4, self.waves.n))

    def prepare(self, x: Points, z: Points) -> Prepared:
        """Remember the points."""
        return _WheelerPrepared(self, x, z)


class _WheelerPrepared:
    def __init__(self, field: WheelerField, x: Points, z: Points) -> None:
        self._field, self._x, self._z = field, x, z

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some 4 time"]:
        return self._field.first(self._x[index], self._z[index])


def make_field(waves: Waves) -> Field:
    """Choose the route: Fourier transforms where the components lie on a grid, direct sums elsewhere."""
    grid = frequency_grid(waves.omega, dt=waves.dt, n=waves.n, order=waves.order)
    field: Field = DirectField(waves) if grid is None else GridField(waves, grid)
    return WheelerField(waves, field) if waves.stretching == "wheeler" else field
