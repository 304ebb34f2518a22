"""Wave fields: elevation and kinematics of the components at any points, over the whole record.

Several routes, one interface: :class:`GridField` for components on a frequency grid (single summation over
pairs and inverse FFT), :class:`~owt_wave_node.core.direct.DirectField` for any components (direct sum), and
:class:`~owt_wave_node.core.wheeler.WheelerField` for Wheeler stretching. Coordinates are those of the
waves (:class:`~owt_wave_node.core.sea.Frame`): x along them, y to the left, z up from still water.
Kinematics are [point, channel, time]: the velocities, then the local accelerations, along x and z where
`n_axes` is 2, and along x, y and z where it is 3.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float, Inexact, Int

from owt_model.parallel import map_threads, slices
from owt_wave_node.core.grid import FrequencyGrid
from owt_wave_node.core.profile import first_order_profile, second_order_level
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.transfer import pair_tables, set_down
from owt_wave_node.kernels import spectra as _kernel

__all__ = ["Field", "GridField", "Prepared"]

Place = Float[np.ndarray, "point 3"]
Series = Float[np.ndarray, "point time"]
Kinematics = Float[np.ndarray, "point channel time"]
#: Complex where a factor also turns the phase: it multiplies the amplitude of exp(i (omega t - k x)).
Profile = Inexact[np.ndarray, "point component"]
Phasor = Complex[np.ndarray, "point component"]

#: Largest exponent in the scaled factors of the difference pairs; exp(700) would overflow.
MAX_SCALED = 300.0
#: Points per task of a thread.
CHUNK = 16


@runtime_checkable
class Prepared(Protocol):
    """Total kinematics of a set of points, transformed to time on demand."""

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        """Velocities in m/s and accelerations in m/s2 of the points `index`."""
        ...


@runtime_checkable
class Field(Protocol):
    """What every route offers; places are [x, y, z] in m in wave axes.

    Attributes
    ----------
    n_axes : int
        2 where all velocities lie in the plane of x and z, else 3.
    n : int
        Number of samples.
    wavenumber : float array [component]
        rad/m, one per column of the profiles of :meth:`shaped`; a route may merge components.
    """

    n_axes: int
    n: int
    wavenumber: Float[np.ndarray, " component"]

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m."""
        ...

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics, stretched above still water."""
        ...

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors, real or complex, not those of a level."""
        ...

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics; zero at order 1."""
        ...

    def prepare(self, place: Place) -> Prepared:
        """Do what is common to all times for the total kinematics at points."""
        ...


class GridField:
    """Components on a frequency grid: Fourier coefficients per point, one inverse FFT per signal."""

    def __init__(self, waves: Waves, grid: FrequencyGrid) -> None:
        self.waves = waves
        self.grid = grid
        self.n_axes, self.n = 2, waves.n
        self.bins, self.wavenumber, self.omega, self.amplitude, self.dense = _pack(waves, grid)
        # Consecutive bins as a slice: no index array is followed.
        self._used = slice(int(self.bins[0]), int(self.bins[-1]) + 1) if self.dense else self.bins
        self._tables = None
        if waves.order == 2:
            packed = replace(
                waves,
                omega=self.omega,
                wavenumber=self.wavenumber,
                angle=np.zeros(self.omega.size),
                amplitude=self.amplitude,
            )
            self._tables = pair_tables(packed).spaced(self.bins.size)
            self._set_down = set_down(packed)
            self._blocks = _blocks(self.wavenumber, waves.depth)

    @property
    def _n_bins(self) -> int:
        return self.waves.order * int(self.bins[-1]) + 1

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m [eq. 4.30, 4.43]."""
        x = place[:, 0].copy()

        first, second = np.empty((x.size, self.n)), np.zeros((x.size, self.n))

        def part(rows: slice) -> None:
            phasor = self._phasors(x[rows])
            spectra = np.zeros((len(phasor), 2, self._n_bins), dtype=complex)
            if self._tables is None:
                spectra[:, 0, self._used] = phasor
                first[rows] = self.grid.signal(spectra[:, 0])
                return
            tables = self._tables.surface_sum, self._tables.surface_difference
            self._add_second(phasor, np.zeros(len(phasor)), tables, spectra, image=False)
            spectra[:, 1] = spectra[:, 0]
            spectra[:, 1, 0] += self._set_down
            spectra[:, 0] = 0.0
            spectra[:, 0, self._used] = phasor
            series = self.grid.series(spectra, np.arange(len(phasor)), channels=2)
            first[rows], second[rows] = series[:, 0], series[:, 1]

        map_threads(part, slices(x.size, CHUNK))
        return first, second

    def _phasors(self, x: Float[np.ndarray, " point"]) -> Phasor:
        """Amplitudes A exp(-i k x) at points."""
        out = np.empty((x.size, self.wavenumber.size), dtype=complex)
        _kernel.phasors(x, self.wavenumber, self.amplitude, out)
        return out

    def _add_first(
        self,
        phasor: Phasor,
        horizontal: Profile,
        vertical: Profile,
        out: Complex[np.ndarray, "point 2 bin"],
    ) -> None:
        """Add the coefficients of u and w of the first order [eq. 4.32, 4.33]."""
        here = self.waves.gravity * self.wavenumber / self.omega * phasor
        out[:, 0, self._used] += here * horizontal
        out[:, 1, self._used] += 1j * (here * vertical)

    def _add_second(
        self,
        phasor: Phasor,
        level: Float[np.ndarray, " point"],
        tables: tuple[Float[np.ndarray, " entry"], Float[np.ndarray, " entry"]],
        out: Complex[np.ndarray, "point 2 bin"],
        *,
        image: bool,
    ) -> None:
        """Add the coefficients of u and w of the second order, or of the elevation twice."""
        _kernel.second_order(
            phasor, level, self.wavenumber, self.bins, self.dense, self.waves.depth,
            self.waves.peak_wavenumber, self._blocks, image, *tables, out,
        )  # fmt: skip

    def _spectra(self, place: Place, *, first: bool, second: bool) -> Complex[np.ndarray, "point 2 bin"]:
        """Coefficients of u and w [eq. 4.32, 4.33, 4.50, 4.51]."""
        waves, x, z = self.waves, place[:, 0].copy(), place[:, 2].copy()
        out = np.zeros((x.size, 2, self._n_bins), dtype=complex)

        def part(rows: slice) -> None:
            phasor = self._phasors(x[rows])
            if first:
                profile = first_order_profile(
                    self.wavenumber, z[rows], water_depth=waves.depth, stretching=waves.stretching
                )
                self._add_first(phasor, *profile, out[rows])
            if second and self._tables is not None:
                tables = self._tables.velocity_sum, self._tables.velocity_difference
                level = second_order_level(z[rows], waves.stretching)
                self._add_second(phasor, level, tables, out[rows], image=True)

        map_threads(part, slices(x.size, CHUNK))
        return out

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics, stretched above still water."""
        return self._in_time(self._spectra(place, first=True, second=False), np.arange(len(place)))

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors instead of those of a level."""
        spectra = np.zeros((len(place), 2, self._n_bins), dtype=complex)
        self._add_first(self._phasors(place[:, 0].copy()), horizontal, vertical, spectra)
        return self._in_time(spectra, np.arange(len(place)))

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics; zero at order 1."""
        return self._in_time(self._spectra(place, first=False, second=True), np.arange(len(place)))

    def prepare(self, place: Place) -> Prepared:
        """Coefficients of the total velocities at points."""
        return _GridPrepared(self, self._spectra(place, first=True, second=True))

    def _in_time(
        self, spectra: Complex[np.ndarray, "point 2 bin"], index: Int[np.ndarray, " some"]
    ) -> Float[np.ndarray, "some channel time"]:
        return self.grid.series(spectra, index, channels=4)


class _GridPrepared:
    def __init__(self, field: GridField, spectra: Complex[np.ndarray, "point 2 bin"]) -> None:
        self._field, self._spectra = field, spectra

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._field._in_time(self._spectra, index)


def _pack(
    waves: Waves, grid: FrequencyGrid
) -> tuple[
    Int[np.ndarray, " packed"],
    Float[np.ndarray, " packed"],
    Float[np.ndarray, " packed"],
    Complex[np.ndarray, " packed"],
    bool,
]:
    """Bins, wave numbers, frequencies and amplitudes, one per bin, and whether the bins are consecutive.

    Components that share a bin are merged.
    """
    bins, first, group = np.unique(grid.bins, return_index=True, return_inverse=True)
    amplitude = np.zeros(bins.size, dtype=complex)
    np.add.at(amplitude, group, waves.amplitude)
    dense = bool(np.all(np.diff(bins) == 1))
    return bins, waves.wavenumber[first], waves.omega[first], amplitude, dense


def _blocks(wavenumber: Float[np.ndarray, " component"], depth: float) -> Int[np.ndarray, " bound"]:
    """Bounds of ranges of components within which exp((k - k_first) 2 d) stays far from overflow."""
    bounds = [0]
    for n, k in enumerate(wavenumber):
        if (k - wavenumber[bounds[-1]]) * 2.0 * depth > MAX_SCALED:
            bounds.append(n)
    return np.array([*bounds, wavenumber.size], dtype=np.int64)
