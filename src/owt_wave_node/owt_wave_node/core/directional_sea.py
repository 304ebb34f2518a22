"""What a short-crested sea gives at points, whatever the time: coefficients of its frequencies.

A signal is the sum of Re Y_j exp(i omega_j t) over slots j. Per point the pairs (m, n) of components give
the coefficients Y at omega_m + omega_n and omega_m - omega_n. On a frequency grid slots are its bins; else
each distinct frequency has a slot. Factors that depend on the level alone are shared by the points there.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_model.parallel import map_threads, slices, thread_count
from owt_wave_node.core.field import Place, Profile
from owt_wave_node.core.grid import PHASE_TOLERANCE, frequency_grid
from owt_wave_node.core.profile import first_order_profile, second_order_level
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.transfer import set_down
from owt_wave_node.kernels import directional as _kernel

__all__ = ["Coefficients", "DirectionalSea"]

#: Points per task of a thread, and bytes of coefficients of a task.
CHUNK, TASK_BYTES = 64, 2**25
#: Digits of a level in m to which points share it.
LEVEL_DIGITS = 12
#: Ranges of rows into which the tables of pairs are split for the threads.
TABLE_TASKS = 16

Coefficients = Complex[np.ndarray, "point c slot"]


class DirectionalSea:
    """Components of any directions and frequencies, sorted, with the tables of their pairs.

    The Bernoulli constant is that of long-crested waves: D- of a component with itself is zero, and the
    elevation includes the mean set-down. Two components of one frequency and different directions add a
    steady elevation that varies in space, and no steady flow.

    Attributes
    ----------
    frequency : float array [slot]
        rad/s.
    grid : FrequencyGrid or None
        The grid whose bins are the slots, where the components lie on one.
    """

    def __init__(self, waves: Waves) -> None:
        order = np.lexsort((waves.angle, waves.omega))
        self.waves = waves = replace(
            waves,
            omega=waves.omega[order],
            wavenumber=waves.wavenumber[order],
            angle=waves.angle[order],
            amplitude=waves.amplitude[order],
        )
        self._along, self._across = np.cos(waves.angle), np.sin(waves.angle)
        self._k_x, self._k_y = waves.wavenumber * self._along, waves.wavenumber * self._across
        self._choose_slots()
        if waves.order == 2:
            self._tabulate()

    def _choose_slots(self) -> None:
        """Bins of a frequency grid, or one slot per distinct frequency."""
        waves = self.waves
        self.grid = grid = frequency_grid(waves.omega, dt=waves.dt, n=waves.n, order=waves.order)
        self._listed = grid is None
        self._pair_slots = (np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32))
        if grid is not None:
            self._slots = grid.bins
            self.frequency = grid.spacing * np.arange(waves.order * int(grid.bins[-1]) + 1)
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
        self.frequency = together[first]
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
        limit = max(1, TASK_BYTES // (96 * self.frequency.size))
        return max(1, min(CHUNK, limit, -(-points // thread_count())))

    def elevation(self, place: Place) -> Coefficients:
        """Coefficients of the first- and the second-order elevation [point, 2, slot]."""
        waves = self.waves
        out = np.zeros((len(place), 2, self.frequency.size), dtype=complex)

        def part(rows: slice) -> None:
            x, y = place[rows, 0].copy(), place[rows, 1].copy()
            self._gather(waves.amplitude * self._turned(x, y), out[rows, 0])
            if waves.order == 2:
                second = np.zeros((x.size, self.frequency.size), dtype=complex)
                _kernel.elevation(
                    x, y, self._k_x, self._k_y, waves.amplitude, set_down(waves), self._surface,
                    self._listed, self._slots, self._pair_slots, second,
                )  # fmt: skip
                out[rows, 1] = second

        map_threads(part, slices(len(place), self._chunk(len(place))))
        return out

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

        map_threads(part, slices(len(place), self._chunk(len(place))))

    def _add_second(self, place: Place, out: Coefficients) -> None:
        """Add the second order, level by level."""
        waves = self.waves
        level = second_order_level(place[:, 2].copy(), waves.stretching)
        _, one, where = np.unique(np.round(level, LEVEL_DIGITS), return_index=True, return_inverse=True)
        chunk = self._chunk(len(place))
        order, ends = np.argsort(where, kind="stable"), np.cumsum(np.bincount(where))
        tasks = [
            (here, points[at])
            for here, points in zip(level[one].tolist(), np.split(order, ends[:-1]), strict=True)
            for at in slices(points.size, chunk)
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

    def velocity(self, place: Place, *, first: bool, second: bool) -> Coefficients:
        """Coefficients of the velocities of either or both orders [point, 3, slot]."""
        out = np.zeros((len(place), 3, self.frequency.size), dtype=complex)
        if first:
            self._add_first(place, out)
        if second and self.waves.order == 2:
            self._add_second(place, out)
        return out

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Coefficients:
        """Coefficients of first-order velocities with given vertical factors."""
        out = np.zeros((len(place), 3, self.frequency.size), dtype=complex)
        self._first_order(place, horizontal, vertical, out)
        return out
