"""The choice of route: which field gives the kinematics of a sea."""

from __future__ import annotations

from dataclasses import replace

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.field import Field, GridField
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.sea import Waves, waves
from owt_wave_node.core.wheeler import WheelerField

__all__ = ["component_field", "make_field"]


def make_field(case: CaseConfig, sea: SeaState) -> Field:
    """Return the wave field of a case and its sea."""
    return component_field(waves(sea))


def component_field(components: Waves) -> Field:
    """Choose the route for components: Fourier transforms on a frequency grid, direct sums elsewhere."""
    if components.stretching == "wheeler":
        return WheelerField(components, component_field(replace(components, stretching="constant")))
    grid = frequency_grid(components.omega, dt=components.dt, n=components.n, order=components.order)
    return DirectField(components) if grid is None else GridField(components, grid)
