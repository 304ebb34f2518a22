"""Kinematics from compressed components: a product of matrices per point, and a Fourier transform."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_model.errors import ComputationError
from owt_model.parallel import map_threads
from owt_wave_node.core.compression import CompressedSea, Table, product
from owt_wave_node.core.field import Field, Kinematics, Place, Prepared, Profile, Series
from owt_wave_node.core.profile import first_order_profile, second_order_level
from owt_wave_node.core.window import FINE, Window, window_of
from owt_wave_node.kernels import compressed as _kernel

__all__ = ["AutoField", "CompressedField"]

#: Points whose elevation is transformed together by a thread.
CHUNK = 16

#: Coefficients of a window's grid, real and imaginary.
Parts = Float[np.ndarray, "2 node bin"]


class CompressedField:
    """Compressed components over their record or a window of it."""

    def __init__(self, sea: CompressedSea, window: Window | None = None) -> None:
        self._sea, self._window = sea, sea.record if window is None else window
        self.waves, self.n_axes, self.n = sea.waves, 2, self._window.count
        self.wavenumber = sea.wavenumber
        self._kept: dict[str, tuple[int, list[Parts]]] = {}

    @property
    def error_estimate(self) -> float:
        """Error of the second order over its standard deviation; at order 1 that of the first order."""
        sea = self._sea
        kernels = FINE.error if sea.bins is None else 0.0
        return sea.error_estimate + kernels + (sea.bell.error if self._window is not sea.record else 0.0)

    def window(self, start: int, count: int) -> Field:
        """Return the field over `count` samples from `start`."""
        begin = self._window.start + start
        return CompressedField(self._sea, self._sea.window(begin, count))

    def _tables(self, part: str, stretch: int) -> list[Parts]:
        """Coefficients [bin, node] of "velocity" or "surface" on this window's grid, both orders."""
        if part not in self._kept or self._kept[part][0] != stretch:
            tables = getattr(self._sea.pairs(stretch), part)
            self._kept[part] = (stretch, map_threads(self._on_window, tables))
        return self._kept[part][1]

    def _on_window(self, table: Table) -> Parts:
        sea, window = self._sea, self._window
        if window is sea.record and window.divide is None:
            return _parts(table)
        spacing = window.grid.spacing
        if window is not sea.record:
            out = np.zeros((window.n_bins, 2, sea.wavenumber.size))
            used = int(np.flatnonzero(table.any(axis=1)).max(initial=-1)) + 1  # half of them at first order
            time = window.middle - sea.record.middle
            _kernel.spread_rows(sea.omega[:used], table[:used], time, *sea.weights(window), out)
            table = out[:, 0] + 1j * out[:, 1]
        # The phases of a bell count from the middle of the window.
        bins = np.arange(window.n_bins) + window.bottom
        turn = np.exp(-1j * spacing * sea.waves.dt * (window.count // 2) * bins)
        return _parts(table * turn[:, None])

    def _by_stretch(self, place: Place, part: Callable[[int, Int[np.ndarray, " some"]], None]) -> None:
        """Work through points by the stretch of x that they lie in."""
        stretch = np.array([self._sea.stretch(x) for x in place[:, 0].tolist()], dtype=np.int64)
        for number in np.unique(stretch).tolist():
            part(number, np.flatnonzero(stretch == number))

    def _phase(self, place: Place, stretch: int) -> Complex[np.ndarray, "point node"]:
        x = place[:, 0] - 2.0 * self._sea.reach * stretch
        return np.asarray(np.exp(-1j * self.wavenumber * x[:, None]))

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m [eq. 4.6, 4.18]."""
        out = np.empty((len(place), 2, self.n))

        def part(stretch: int, rows: Int[np.ndarray, " some"]) -> None:
            phase = self._phase(place[rows], stretch)
            tables = self._tables("surface", stretch)
            spectra = self._window.fold(np.stack([product(phase, table) for table in tables], axis=1))
            chunks = np.array_split(np.arange(rows.size), range(CHUNK, rows.size, CHUNK))

            def chunk(some: Int[np.ndarray, " some"]) -> None:
                out[rows[some]] = self._window.in_time(spectra, some, derive=False)

            map_threads(chunk, chunks)

        self._by_stretch(place, part)
        return out[:, 0].copy(), out[:, 1].copy()

    def _profile(self, z: Float[np.ndarray, " point"]) -> tuple[Profile, Profile]:
        """Vertical factors of the first order at the nodes."""
        return first_order_profile(
            self.wavenumber, z, water_depth=self.waves.depth, stretching=self.waves.stretching
        )

    def _spectra(
        self, place: Place, first: tuple[Profile, Profile] | None, *, second: bool
    ) -> Complex[np.ndarray, "point 2 bin"]:
        """Coefficients of u and w [eq. 4.8, 4.9, 4.20, 4.21], the first order with given vertical factors."""
        waves, k = self.waves, self.wavenumber
        out = np.zeros((len(place), 2, self._window.n_bins), dtype=complex)

        def part(stretch: int, rows: Int[np.ndarray, " some"]) -> None:
            one, two = self._tables("velocity", stretch)
            phase = self._phase(place[rows], stretch)
            # Coefficients belong to exp(kz) +- exp(-k(z+2d)); profiles are divided by 1 + exp(-2kd).
            scale = 1.0 + np.exp(-2.0 * k * waves.depth)
            for channel, turn in enumerate((1.0, 1j)):
                total = np.zeros((rows.size, self._window.n_bins), dtype=complex)
                if first is not None:
                    total += product(turn * scale * phase * first[channel][rows], one)
                if second and waves.order == 2:
                    total += product(turn * phase * self._vertical(place[rows])[channel], two)
                out[rows, channel] = total

        self._by_stretch(place, part)
        return self._window.fold(out)

    def _vertical(self, place: Place) -> tuple[Profile, Profile]:
        """Factors exp(Kz) +- exp(-K(z+2d)) of the second order at the nodes."""
        k = self.wavenumber
        z = second_order_level(place[:, 2], self.waves.stretching)[:, None]
        up, down = np.exp(k * z), np.exp(-k * (z + 2.0 * self.waves.depth))
        return up + down, up - down

    def _total(self, place: Place) -> Complex[np.ndarray, "point 2 bin"]:
        """Coefficients of u and w of both orders; below still water they have the same vertical factors."""
        below = np.flatnonzero(place[:, 2] <= 0.0)
        above = np.flatnonzero(place[:, 2] > 0.0)
        out = np.zeros((len(place), 2, self._window.n_bins), dtype=complex)

        def part(stretch: int, some: Int[np.ndarray, " some"]) -> None:
            rows = below[some]
            one, two = self._tables("velocity", stretch)
            both = one + two if self.waves.order == 2 else one
            phase = self._phase(place[rows], stretch)
            for channel, (turn, factor) in enumerate(
                zip((1.0, 1j), self._vertical(place[rows]), strict=True)
            ):
                out[rows, channel] = product(turn * phase * factor, both)

        self._by_stretch(place[below], part)
        folded = self._window.fold(out)
        if above.size:
            folded[above] = self._spectra(place[above], self._profile(place[above, 2].copy()), second=True)
        return folded

    def _in_time(self, spectra: Complex[np.ndarray, "point 2 bin"]) -> Kinematics:
        return self._window.in_time(spectra, np.arange(len(spectra)), derive=True)

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics, stretched above still water."""
        return self._in_time(self._spectra(place, self._profile(place[:, 2].copy()), second=False))

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors instead of those of a level."""
        return self._in_time(self._spectra(place, (horizontal, vertical), second=False))

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics; zero at order 1."""
        return self._in_time(self._spectra(place, None, second=True))

    def prepare(self, place: Place) -> Prepared:
        """Coefficients of the total velocities at points."""
        return _CompressedPrepared(self._window, self._total(place))


class AutoField(CompressedField):
    """Compressed components, and another field for the points of a stretch that is refused.

    Whether a stretch of x is accurate is known only when its pairs are summed.

    Parameters
    ----------
    exact : callable
        Makes the other field, over the same samples; called when it is needed first.
    """

    def __init__(self, sea: CompressedSea, exact: Callable[[], Field], window: Window | None = None) -> None:
        super().__init__(sea, window)
        self._exact = cache(exact)

    def window(self, start: int, count: int) -> Field:
        """Return the field over `count` samples from `start`."""
        begin = self._window.start + start
        exact = self._exact
        return AutoField(self._sea, lambda: window_of(exact(), start, count), self._sea.window(begin, count))

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m."""
        try:
            return super().elevation(place)
        except ComputationError:
            return self._exact().elevation(place)

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics."""
        try:
            return super().first(place)
        except ComputationError:
            return self._exact().first(place)

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors."""
        try:
            return super().shaped(place, horizontal, vertical)
        except ComputationError:
            return self._exact().shaped(place, horizontal, vertical)

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics."""
        try:
            return super().second(place)
        except ComputationError:
            return self._exact().second(place)

    def prepare(self, place: Place) -> Prepared:
        """Coefficients of the total velocities at points."""
        try:
            return super().prepare(place)
        except ComputationError:
            return self._exact().prepare(place)


def _parts(table: Table) -> Parts:
    """Real and imaginary parts, frequencies last."""
    return np.stack([table.real.T, table.imag.T])


class _CompressedPrepared:
    def __init__(self, window: Window, spectra: Complex[np.ndarray, "point 2 bin"]) -> None:
        self._window, self._spectra = window, spectra

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._window.in_time(self._spectra, index, derive=True)
