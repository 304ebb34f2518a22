"""Short-crested seas: components of different directions, to second order, at any points.

Coefficients per point come from :mod:`~owt_wave_node.core.directional_sea`, signals from
:mod:`~owt_wave_node.core.lines`: by inverse Fourier transforms on a frequency grid, else from the distinct
frequencies. A window of the record has its own transform; coefficients are kept from one to the next.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float, Int

from owt_model.parallel import map_threads, slices
from owt_wave_node.core.directional_sea import Coefficients, DirectionalSea
from owt_wave_node.core.field import Kinematics, Place, Prepared, Profile, Series
from owt_wave_node.core.lines import Lines, grid_lines, listed_lines
from owt_wave_node.core.sea import Waves

__all__ = ["DirectionalField"]

#: Points per inverse transform.
TRANSFORMED = 8
#: Bytes of coefficients that are made at a time, for one record and for several windows, and that are kept.
BLOCK_BYTES, WINDOW_BYTES, KEPT_BYTES = 2**26, 2**28, 2**29
#: Bytes that a prepared field may hold.
HELD_BYTES = 2**28


class DirectionalField:
    """Components of any directions and frequencies; velocities along x, y and z of the wave axes.

    Attributes
    ----------
    sea : DirectionalSea
        What does not depend on time; windows of one record share it.
    """

    n_axes = 3

    def __init__(self, waves: Waves) -> None:
        self.sea = DirectionalSea(waves)
        grid, waves = self.sea.grid, self.sea.waves
        self._show(
            grid_lines(grid, self.sea.frequency.size)
            if grid is not None
            else listed_lines(self.sea.frequency, dt=waves.dt, start=0, count=waves.n)
        )
        self._kept: dict[tuple[str, bytes], Coefficients] | None = None

    def _show(self, lines: Lines) -> None:
        self._lines, self.n = lines, lines.n
        self.wavenumber = self.sea.waves.wavenumber

    def window(self, start: int, count: int) -> DirectionalField:
        """Return the field over `count` samples from `start`; it shares tables and coefficients."""
        if self._kept is None:
            self._kept = {}
        part = object.__new__(DirectionalField)
        part.sea, part._kept = self.sea, self._kept
        part._show(listed_lines(self.sea.frequency, dt=self.sea.waves.dt, start=start, count=count))
        return part

    def _keep(self, kind: str, place: Place, make: Callable[[Place], Coefficients]) -> Coefficients:
        """Coefficients at points, from an earlier window if there was one."""
        if self._kept is None:
            return make(place)
        key = (kind, place.tobytes())
        if key not in self._kept:
            made = make(place)
            while self._kept and made.nbytes + sum(c.nbytes for c in self._kept.values()) > KEPT_BYTES:
                del self._kept[next(iter(self._kept))]  # the oldest
            self._kept[key] = made
        return self._kept[key]

    def _blocks(self, place: Place) -> list[slice]:
        """Ranges of points whose coefficients may be made together."""
        limit = BLOCK_BYTES if self._kept is None else WINDOW_BYTES
        return slices(len(place), max(1, limit // (48 * self.sea.frequency.size)))

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m."""
        out = np.empty((len(place), 2, self.n))
        for rows in self._blocks(place):
            self._transform(self._keep("elevation", place[rows], self.sea.elevation), out[rows])
        if self.sea.waves.order == 1:
            out[:, 1] = 0.0  # not what round-off of a transform of two signals leaves there
        return out[:, 0].copy(), out[:, 1].copy()

    def _transform(self, coefficients: Coefficients, out: Float[np.ndarray, "point channel time"]) -> None:
        """Signals, and their time derivatives where `out` has twice the channels."""

        def part(at: slice) -> None:
            loaded = self._lines.load(coefficients[at])
            out[at] = self._lines.series(loaded, np.arange(len(loaded)), channels=out.shape[1])

        map_threads(part, slices(len(out), TRANSFORMED))

    def _kinematics(self, place: Place, *, first: bool, second: bool) -> Kinematics:
        """Kinematics at all points, with the coefficients of some at a time."""
        out = np.empty((len(place), 6, self.n))
        for rows in self._blocks(place):
            self._transform(self.sea.velocity(place[rows], first=first, second=second), out[rows])
        return out

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics, stretched above still water."""
        return self._kinematics(place, first=True, second=False)

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics; zero at order 1."""
        if self.sea.waves.order == 1:
            return np.zeros((len(place), 6, self.n))
        return self._kinematics(place, first=False, second=True)

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors instead of those of a level."""
        out = np.empty((len(place), 6, self.n))
        self._transform(self.sea.shaped(place, horizontal, vertical), out)
        return out

    def _total(self, place: Place) -> Coefficients:
        return self.sea.velocity(place, first=True, second=True)

    def prepare(self, place: Place) -> Prepared:
        """Coefficients of the total velocities at points, or the points where those are too many to hold."""
        lines, bins = self._lines, self._lines.bins
        if 48 * len(place) * bins > HELD_BYTES:
            return _OnDemand(self, place)
        loaded = np.empty((len(place), 3, bins), dtype=complex)
        for rows in self._blocks(place):
            velocity, block = self._keep("velocity", place[rows], self._total), loaded[rows]

            def part(at: slice, velocity: Coefficients = velocity, block: Coefficients = block) -> None:
                block[at] = lines.load(velocity[at])

            map_threads(part, slices(len(block), TRANSFORMED))
        return _Stored(lines, loaded)


class _Stored:
    def __init__(self, lines: Lines, loaded: Coefficients) -> None:
        self._lines, self._loaded = lines, loaded

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._lines.series(self._loaded, index, channels=6)


class _OnDemand:
    def __init__(self, field: DirectionalField, place: Place) -> None:
        self._field, self._place = field, place

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._field._kinematics(self._place[index], first=True, second=True)
