"""Short-crested seas: components of different directions, to second order, at any points.

A signal is the sum of Re Y_j exp(i omega_j t) over slots j. Per point the pairs (m, n) of components give
the coefficients Y at omega_m + omega_n and omega_m - omega_n. On a frequency grid slots are its bins and the
signals follow by inverse Fourier transforms; else each distinct frequency has a slot and they are summed
directly. Factors that depend on the level alone are shared by the points at that level.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_wave_node.core.field import Kinematics, Place, Prepared, Profile, Series
from owt_wave_node.core.grid import PHASE_TOLERANCE, FrequencyGrid, frequency_grid
from owt_wave_node.core.lines import FrequencyLines
from owt_wave_node.core.parallel import map_threads, thread_count
from owt_wave_node.core.profile import first_order_profile, second_order_level
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.transfer import set_down
from owt_wave_node.kernels import directional as _kernel

__all__ = ["DirectionalField"]

#: Points per task of a thread.
CHUNK = 64
#: Points per inverse transform.
TRANSFORMED = 8
#: Bytes of coefficients that are held at a time, per task and by a prepared field.
TASK_BYTES, PREPARED_BYTES = 2**25, 2**28
#: Digits of a level in m to which points share it.
LEVEL_DIGITS = 12
#: Ranges of rows into which the tables of pairs are split for the threads.
TABLE_TASKS = 16

Coefficients = Complex[np.ndarray, "point 3 slot"]


class DirectionalField:
    """Components of any directions and frequencies.

    Velocities are along x, y and z of the wave axes. The Bernoulli constant is that of long-crested waves:
    D- of a component with itself is zero, and the elevation includes the mean set-down. Two components of
    one frequency and different directions add a steady elevation that varies in space, and no steady flow.
    """

    n_axes = 3

    def __init__(self, waves: Waves) -> None:
        order = np.lexsort((waves.angle, waves.omega))
        self.waves = waves = replace(
            waves,
            omega=waves.omega[order],
            wavenumber=waves.wavenumber[order],
            angle=waves.angle[order],
            amplitude=waves.amplitude[order],
        )
        self.n, self.wavenumber = waves.n, waves.wavenumber
        self._along, self._across = np.cos(waves.angle), np.sin(waves.angle)
        self._k_x, self._k_y = waves.wavenumber * self._along, waves.wavenumber * self._across
        self._choose_slots()
        if waves.order == 2:
            self._tabulate()

    def _choose_slots(self) -> None:
        """Bins of a frequency grid, or one slot per distinct frequency."""
        waves = self.waves
        grid = frequency_grid(waves.omega, dt=waves.dt, n=waves.n, order=waves.order)
        self._listed = grid is None
        self._pair_slots = (np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32))
        self._lines: FrequencyLines | FrequencyGrid
        if grid is not None:
            self._lines, self._slots = grid, grid.bins
            self._frequency = grid.spacing * np.arange(waves.order * int(grid.bins[-1]) + 1)
            return
        omega, size = waves.omega, waves.omega.size
        every = [np.zeros(1), omega]
        if waves.order == 2:
            m, n = np.tril_indices(size)
            every.append(omega[m] + omega[n])
            m, n = np.tril_indices(size, -1)
            every.append(omega[m] - omega[n])
        together = np.concatenate(every)
        key = np.rint(together * (waves.n * waves.dt / PHASE_TOLERANCE))
        _, first, slot = np.unique(key, return_index=True, return_inverse=True)
        self._frequency = together[first]
        self._lines = FrequencyLines(self._frequency, waves.dt, waves.n)
        slots = np.split(slot, np.cumsum([part.size for part in every])[:-1])
        self._slots = slots[1]
        if waves.order == 2:
            self._pair_slots = (slots[2].astype(np.int32), slots[3].astype(np.int32))

    def _tabulate(self) -> None:
        """Factors of all pairs m >= n (sums) and m > n (differences)."""
        waves, size = self.waves, self.waves.omega.size
        sums, differences = size * (size + 1) // 2, size * (size - 1) // 2
        self._velocity = (np.empty(sums), np.empty(differences))
        self._surface = (np.empty(sums), np.empty(differences))
        # Rows grow in length: equal areas of the triangle.
        bounds = np.rint(size * np.sqrt(np.linspace(0.0, 1.0, TABLE_TASKS + 1))).astype(int)

        def part(rows: tuple[int, int]) -> None:
            _kernel.tables(
                *rows, waves.wavenumber, waves.omega, waves.angle, waves.depth, waves.gravity,
                *self._velocity, *self._surface,
            )  # fmt: skip

        map_threads(part, list(pairwise(np.unique(bounds).tolist())))

    def _chunk(self, points: int) -> int:
        """Points per task, of about equal size and within memory."""
        limit = max(1, TASK_BYTES // (96 * self._frequency.size))
        return max(1, min(CHUNK, limit, -(-points // thread_count())))

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """First- and second-order elevation in m."""
        waves = self.waves

        def part(rows: slice) -> tuple[Series, Series]:
            x, y = place[rows, 0].copy(), place[rows, 1].copy()
            first = np.zeros((x.size, self._frequency.size), dtype=complex)
            self._gather(waves.amplitude * self._turned(x, y), first)
            if waves.order == 1:
                return self._lines.signal(first), np.zeros((x.size, self.n))
            second = np.zeros_like(first)
            _kernel.elevation(
                x, y, self._k_x, self._k_y, waves.amplitude, set_down(waves), self._surface,
                self._listed, self._slots, self._pair_slots, second,
            )  # fmt: skip
            return self._lines.signal(first), self._lines.signal(second)

        parts = map_threads(part, _slices(len(place), self._chunk(len(place))))
        return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])

    def _turned(
        self, x: Float[np.ndarray, " point"], y: Float[np.ndarray, " point"]
    ) -> Complex[np.ndarray, "point component"]:
        """Phasors exp(-i k.x) of the components at points."""
        return np.asarray(np.exp(-1j * (np.outer(x, self._k_x) + np.outer(y, self._k_y))))

    def _gather(
        self, values: Complex[np.ndarray, "point component"], out: Complex[np.ndarray, "point slot"]
    ) -> None:
        """Add values of the components to their slots, which several may share."""
        slots, start = np.unique(self._slots, return_index=True)
        out[:, slots] += np.add.reduceat(values, start, axis=1)

    def _first_order(self, place: Place, horizontal: Profile, vertical: Profile, out: Coefficients) -> None:
        """Add the coefficients of u, v and w of the first order [eq. 4.8, 4.9 along each component]."""
        waves = self.waves
        speed = waves.gravity * waves.wavenumber / waves.omega * waves.amplitude
        here = speed * self._turned(place[:, 0], place[:, 1])
        along = here * horizontal
        self._gather(along * self._along, out[:, 0])
        self._gather(along * self._across, out[:, 1])
        self._gather(1j * here * vertical, out[:, 2])

    def _add_first(self, place: Place, out: Coefficients) -> None:
        """Add the first order, stretched above still water."""
        waves = self.waves

        def part(rows: slice) -> None:
            profile = first_order_profile(
                waves.wavenumber, place[rows, 2].copy(), water_depth=waves.depth, stretching=waves.stretching
            )
            self._first_order(place[rows], *profile, out[rows])

        map_threads(part, _slices(len(place), self._chunk(len(place))))

    def _add_second(self, place: Place, out: Coefficients) -> None:
        """Add the second order, level by level."""
        waves = self.waves
        level = np.round(second_order_level(place[:, 2].copy(), waves.stretching), LEVEL_DIGITS)
        z, where = np.unique(level, return_inverse=True)
        chunk = self._chunk(len(place))
        order, ends = np.argsort(where, kind="stable"), np.cumsum(np.bincount(where))
        tasks = [
            (here, points[at])
            for here, points in zip(z.tolist(), np.split(order, ends[:-1]), strict=True)
            for at in _slices(points.size, chunk)
        ]

        def part(task: tuple[float, Int[np.ndarray, " some"]]) -> None:
            z, points = task
            here = np.zeros((points.size, *out.shape[1:]), dtype=complex)
            _kernel.level_velocity(
                place[points, 0], place[points, 1], z, self._k_x, self._k_y, waves.amplitude, waves.depth,
                self._velocity, self._listed, self._slots, self._pair_slots, here,
            )  # fmt: skip
            out[points] += here

        map_threads(part, tasks)

    def _coefficients(self, place: Place, *, first: bool, second: bool) -> Coefficients:
        out = np.zeros((len(place), 3, self._frequency.size), dtype=complex)
        if first:
            self._add_first(place, out)
        if second and self.waves.order == 2:
            self._add_second(place, out)
        return out

    def _in_time(
        self, velocity: Coefficients, index: Int[np.ndarray, " some"]
    ) -> Float[np.ndarray, "some channel time"]:
        """Velocities and their time derivatives at the points `index`."""
        return self._lines.series(velocity, index, channels=6)

    def _kinematics(self, place: Place, *, first: bool, second: bool) -> Kinematics:
        """Kinematics at all points, with the coefficients of some at a time."""
        out = np.empty((len(place), 6, self.n))
        for rows in _slices(len(place), max(1, PREPARED_BYTES // (48 * self._frequency.size))):
            velocity = self._coefficients(place[rows], first=first, second=second)
            block = out[rows]

            def part(at: slice, velocity: Coefficients = velocity, block: Kinematics = block) -> None:
                block[at] = self._in_time(velocity, np.arange(at.start, at.stop))

            map_threads(part, _slices(len(velocity), TRANSFORMED))
        return out

    def first(self, place: Place) -> Kinematics:
        """First-order kinematics, stretched above still water."""
        return self._kinematics(place, first=True, second=False)

    def second(self, place: Place) -> Kinematics:
        """Second-order kinematics; zero at order 1."""
        if self.waves.order == 1:
            return np.zeros((len(place), 6, self.n))
        return self._kinematics(place, first=False, second=True)

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """First-order kinematics with given vertical factors instead of those of a level."""
        velocity = np.zeros((len(place), 3, self._frequency.size), dtype=complex)
        self._first_order(place, horizontal, vertical, velocity)
        return self._in_time(velocity, np.arange(len(place)))

    def prepare(self, place: Place) -> Prepared:
        """Coefficients of the total velocities at points, or the points where those are too many to keep."""
        if 48 * len(place) * self._frequency.size > PREPARED_BYTES:
            return _OnDemand(self, place)
        return _Stored(self, self._coefficients(place, first=True, second=True))


class _Stored:
    def __init__(self, field: DirectionalField, velocity: Coefficients) -> None:
        self._field, self._velocity = field, velocity

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._field._in_time(self._velocity, index)


class _OnDemand:
    def __init__(self, field: DirectionalField, place: Place) -> None:
        self._field, self._place = field, place

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._field._kinematics(self._place[index], first=True, second=True)


def _slices(size: int, step: int) -> list[slice]:
    """Consecutive ranges of at most `step`."""
    return [slice(i, min(i + step, size)) for i in range(0, size, step)]
