"""The choice of route: which field gives the kinematics of a sea."""

from __future__ import annotations

from dataclasses import replace

from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.field import Field, GridField
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.wheeler import WheelerField

__all__ = ["make_field"]


def make_field(waves: Waves) -> Field:
    """Choose the route: Fourier transforms where the components lie on a grid, direct sums elsewhere."""
    if waves.stretching == "wheeler":
        return WheelerField(waves, make_field(replace(waves, stretching="constant")))
    grid = frequency_grid(waves.omega, dt=waves.dt, n=waves.n, order=waves.order)
    return DirectField(waves) if grid is None else GridField(waves, grid)
