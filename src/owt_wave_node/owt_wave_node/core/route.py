"""The choice of route: which field gives the kinematics of a sea."""

from __future__ import annotations

from dataclasses import replace

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_model.errors import ComputationError
from owt_wave_node.core.compressed import AutoField, CompressedField
from owt_wave_node.core.compression import CompressedSea
from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.directional import DirectionalField
from owt_wave_node.core.field import Field, GridField
from owt_wave_node.core.grid import FrequencyGrid, frequency_grid
from owt_wave_node.core.regular import RegularField
from owt_wave_node.core.sea import Waves, waves
from owt_wave_node.core.wheeler import WheelerField

__all__ = ["EXACT", "component_field", "make_field"]

#: Longest record, in samples, whose pairs are summed exactly unless asked otherwise.
EXACT = 6000
#: Components off any grid up to which direct sums take about as long as spreading them over one.
FEW = 24


def make_field(case: CaseConfig, sea: SeaState) -> Field:
    """Return the wave field of a case and its sea."""
    if case.regular is not None and case.regular.theory != "airy":
        return RegularField(case, sea)
    route: str = case.wave.route
    if route == "auto" and case.wave.window is not None and case.wave.window < case.time.n:
        route = "windows"
    return component_field(waves(sea), route)


def component_field(components: Waves, route: str = "auto") -> Field:
    """Choose the route for components.

    - ``exact``: every pair at every point, by Fourier transforms on a frequency grid, or by direct sums where
      the components lie on none;
    - ``direct``: direct sums;
    - ``compressed``: pairs compressed in wave number (:mod:`~owt_wave_node.core.compressed`);
    - ``auto``: exact for up to 6000 samples on a grid or few components off any, else compressed, unless that
      is refused: the waves are too short beside the depth, or their second order all but vanishes somewhere;
      ``windows`` is the same at any length.

    Components of different directions have a field of their own, which is exact.
    """
    if components.stretching == "wheeler":
        linear = component_field(replace(components, stretching="constant"), route)
        return WheelerField(components, linear)
    if components.angle.any():
        return DirectionalField(components)
    if route == "direct":
        return DirectField(components)
    grid = frequency_grid(components.omega, dt=components.dt, n=components.n, order=components.order)
    small = components.omega.size <= FEW if grid is None else components.n <= EXACT
    if route != "exact" and not (route == "auto" and small):
        try:
            compressed = CompressedSea(components, grid)
            compressed.pairs(0)  # here, where another route is left, not at the first point
            if route == "compressed":
                return CompressedField(compressed)
            return AutoField(compressed, lambda: _exact(components, grid))
        except ComputationError:
            if route == "compressed":
                raise
    return _exact(components, grid)


def _exact(components: Waves, grid: FrequencyGrid | None) -> Field:
    """Every pair, with Fourier transforms where there is a grid."""
    return DirectField(components) if grid is None else GridField(components, grid)
