"""Second order in N log N: pairs of components compressed by interpolation in their wave number.

At a point every pair enters by exp(K z - i K x) and its image below the bottom, K = k_m +- k_n: smooth
functions of K. A polynomial through their values at the Chebyshev nodes of 0 <= K <= 2 k_max replaces the
pair by "equivalent waves" of the nodes' wave numbers: pairs are summed once, for all points, into
coefficients [frequency, node], and a point costs a product with that matrix. The first order is the same with
K = k_m.

Frequencies are the multiples of the grid that the components lie on or, for components of any frequency, a
grid that each pair is spread over (:mod:`~owt_wave_node.core.window`). The coefficients hold for a stretch of
x, beyond which the polynomial would need too many nodes; points elsewhere have coefficients of their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_model.errors import ComputationError
from owt_model.parallel import map_threads, slices
from owt_wave_node.core.chebyshev import chebyshev_basis
from owt_wave_node.core.grid import FrequencyGrid
from owt_wave_node.core.sea import Waves
from owt_wave_node.core.transfer import set_down
from owt_wave_node.core.window import FINE, QUICK, Bell, Window, spread_window
from owt_wave_node.kernels import compressed as _kernel

__all__ = ["MAX_ERROR", "CompressedSea", "Pairs", "Table", "product"]

#: Largest relative error of the second order that is accepted.
MAX_ERROR = 1e-6
#: Largest error of the interpolation of exp(K z - i K x), whose values are at most 1: on a grid and off it.
TOLERANCE, FINE_TOLERANCE = 1e-9, 1e-12
#: Phase in rad of half a stretch of x, over half the range of K.
STRETCH = 24.0
MAX_NODES = 600
#: Rows of a table per task of a thread; a fixed number, so that sums do not depend on the threads.
ROWS = 256
#: Rows of a product per task of a thread.
TOGETHER = 64
#: Stretches of x that are kept.
KEPT = 4
#: Levels below still water, over the depth, at which the error is looked at; at 2 is still water's image.
LEVELS = (0.0, 0.05, 0.2, 0.5, 1.0, 2.0)

Table = Complex[np.ndarray, "row node"]
Nodes = Float[np.ndarray, " node"]
Spread = tuple[Int[np.ndarray, " row"], Float[np.ndarray, "row width"]]


def _interpolation_error(count: int, half: float, reach: float, depth: float) -> Float[np.ndarray, " level"]:
    """Error of a polynomial through `count` nodes at the edge of a stretch, at several levels."""
    node, matrix = chebyshev_basis(count)
    check = np.cos(np.linspace(0.0, np.pi, 4 * count + 1))
    interpolate = np.cos(np.outer(np.arccos(check), np.arange(count))) @ matrix
    exponent = -np.array(LEVELS) * depth - 1j * reach
    exact, known = (np.exp(half * (s[:, None] + 1.0) * exponent) for s in (check, node))
    return np.asarray(np.abs(interpolate @ known - exact).max(axis=0))


@dataclass(frozen=True)
class Pairs:
    """Coefficients of a stretch of x about `middle` [row, node]: both orders of velocity and elevation.

    `error` is that of the second order, relative to its standard deviation.
    """

    middle: float
    velocity: tuple[Table, Table]
    surface: tuple[Table, Table]
    error: float


class CompressedSea:
    """What the windows of a record share: components, nodes, frequencies, and the pairs of each stretch of x.

    Parameters
    ----------
    waves : Waves
        The components.
    grid : FrequencyGrid, optional
        Their grid; None for components of any frequency.
    bell : Bell
        Spreading kernel of windows that are shorter than the record.
    nodes : int, optional
        Number of nodes in wave number, a multiple of 6; as many as round-off asks for.

    Raises
    ------
    ComputationError
        If the sea is too wide to be compressed.
    """

    def __init__(
        self, waves: Waves, grid: FrequencyGrid | None, *, bell: Bell = QUICK, nodes: int | None = None
    ) -> None:
        self.waves, self.bell = (waves if grid is None else _merged(waves, grid)), bell
        self.bins = None if grid is None else np.unique(grid.bins)
        self.half = 0.5 * waves.order * float(waves.wavenumber.max())
        self.reach = STRETCH / self.half
        place, self.matrix = chebyshev_basis(self._enough() if nodes is None else nodes)
        self.wavenumber = self.half * (place + 1.0)
        self.node_error = _interpolation_error(place.size, self.half, self.reach, waves.depth)
        if grid is None or self.bins is None:
            top = waves.order * float(waves.omega.max())
            self.record = spread_window(start=0, count=waves.n, dt=waves.dt, top=top, bell=FINE)
        else:
            used = waves.order * int(self.bins[-1]) + 1
            self.record = Window(0, replace(grid, bins=grid.bins[:0]), 0, used, 0.0, None, None)
        self._stretches: dict[int, Pairs] = {}
        self._weights: tuple[tuple[int, int], Spread] | None = None

    def _enough(self) -> int:
        """Number of nodes, a multiple of 6, that interpolate to round-off."""
        tolerance = FINE_TOLERANCE if self.bins is None else TOLERANCE
        for count in range(18, MAX_NODES, 6):
            if _interpolation_error(count, self.half, self.reach, self.waves.depth).max() < tolerance:
                return count
        raise ComputationError(
            f"the waves are too short beside the depth to be compressed ({MAX_NODES} nodes do not do); "
            "set wave.route to exact or direct, or lower the cut-off"
        )

    @property
    def omega(self) -> Float[np.ndarray, " row"]:
        """Frequency in rad/s of each row of the coefficients."""
        return (np.arange(self.record.n_bins) + self.record.bottom) * self.record.grid.spacing

    def stretch(self, x: float) -> int:
        """Number of the stretch of x, in m, that a place lies in."""
        return round(x / (2.0 * self.reach))

    def pairs(self, stretch: int) -> Pairs:
        """Coefficients of a stretch; those of the last few are kept.

        Raises
        ------
        ComputationError
            If their error exceeds 1e-6.
        """
        if stretch not in self._stretches:
            while len(self._stretches) >= KEPT:
                self._stretches.pop(next(iter(self._stretches)))
            self._stretches[stretch] = _compress(self, 2.0 * self.reach * stretch)
        return self._stretches[stretch]

    @property
    def error_estimate(self) -> float:
        """Error of the second order from compression alone, relative to its standard deviation."""
        if self.waves.order == 1:
            return 0.0
        return next(iter(self._stretches.values())).error if self._stretches else self.pairs(0).error

    def window(self, start: int, count: int) -> Window:
        """Frequency grid of part of the record."""
        record = self.record
        if (start, count) == (0, record.count):
            return record
        omega = self.omega
        part = spread_window(
            start=start, count=count, dt=self.waves.dt, bell=self.bell,
            bottom=min(0.0, float(omega[0])), top=float(omega[-1]),
        )  # fmt: skip
        if record.divide is None or record.rate is None or part.divide is None or part.rate is None:
            return part
        cut = slice(start, start + count)
        return replace(part, divide=part.divide * record.divide[cut], rate=part.rate + record.rate[cut])

    def weights(self, window: Window) -> Spread:
        """First bin of a window that each row is spread over, and its weights; kept for equal windows."""
        key = window.grid.length, window.bottom
        if self._weights is None or self._weights[0] != key:
            y = self.omega / window.grid.spacing
            start = np.ceil(y - 0.5 * self.bell.width).astype(np.int64)
            place = (y - start)[:, None] - np.arange(self.bell.width)
            self._weights = key, (start - window.bottom, self.bell.value(place))
        return self._weights[1]


def _merged(waves: Waves, grid: FrequencyGrid) -> Waves:
    """One component per bin, in ascending order."""
    bins, first, group = np.unique(grid.bins, return_index=True, return_inverse=True)
    if bins.size == grid.bins.size:
        return waves
    amplitude = np.zeros(bins.size, dtype=complex)
    np.add.at(amplitude, group, waves.amplitude)
    return replace(
        waves,
        omega=waves.omega[first],
        wavenumber=waves.wavenumber[first],
        angle=waves.angle[first],
        amplitude=amplitude,
    )


def _compress(sea: CompressedSea, middle: float) -> Pairs:
    """Sum the components and their pairs into coefficients of the nodes, about x = `middle` in m."""
    waves, record, nodes = sea.waves, sea.record, sea.wavenumber.size
    amplitude = waves.amplitude * np.exp(1j * (waves.omega * record.middle - waves.wavenumber * middle))
    first, second = (np.zeros((record.n_bins, 4, nodes)) for _ in range(2))
    _add_components(sea, amplitude, first)
    power = np.zeros(2)
    if waves.order == 2:
        power = _add_pairs(sea, amplitude, second)
        # The mean set-down has frequency and wave number 0.
        for row, factor in _rows_of(sea, np.zeros(1)):
            second[row, 2] += factor[:, None] * set_down(waves) * (-1.0) ** np.arange(nodes)
    velocity, surface = (
        (_coefficients(sea, first[:, i : i + 2]), _coefficients(sea, second[:, i : i + 2])) for i in (0, 2)
    )
    error = _relative_error(sea, velocity[1], surface[1], power) if waves.order == 2 else 0.0
    if not error <= MAX_ERROR:
        raise ComputationError(
            f"compression to {nodes} wave numbers has an error of {error:.1g} of the second order; "
            "set wave.route to exact"
        )
    return Pairs(middle, velocity, surface, error)


def _coefficients(sea: CompressedSea, moments: Float[np.ndarray, "row 2 node"]) -> Table:
    """Coefficients of the nodes from the moments of the polynomials, real and imaginary."""
    return product(moments[:, 0] + 1j * moments[:, 1], np.stack([sea.matrix, 0.0 * sea.matrix]))


def product(
    factor: Complex[np.ndarray, "row node"], table: Float[np.ndarray, "2 node bin"]
) -> Complex[np.ndarray, "row bin"]:
    """Product of matrices in threads, the second one's real and imaginary parts apart.

    The bits do not depend on the number of threads, which those of a BLAS do.
    """
    out = np.empty((len(factor), table.shape[2]), dtype=complex)
    map_threads(lambda some: _kernel.product(factor[some], table, out[some]), slices(len(factor), TOGETHER))
    return out


def _add_components(
    sea: CompressedSea, amplitude: Complex[np.ndarray, " component"], out: Float[np.ndarray, "row 4 node"]
) -> None:
    """Add the moments of the first order [eq. 4.8, 4.9, 4.6]."""
    waves = sea.waves
    k = waves.wavenumber
    speed = waves.gravity * k / waves.omega / (1.0 + np.exp(-2.0 * k * waves.depth)) * amplitude
    weight = np.stack([speed.real, speed.imag, amplitude.real, amplitude.imag], axis=1)
    s = np.clip(k / sea.half - 1.0, -1.0, 1.0)
    poly = np.cos(np.outer(np.arccos(s), np.arange(sea.wavenumber.size)))
    moments = weight[:, :, None] * poly[:, None, :]
    for row, factor in _rows_of(sea, waves.omega):
        np.add.at(out, row, factor[:, None, None] * moments)


def _add_pairs(
    sea: CompressedSea, amplitude: Complex[np.ndarray, " component"], out: Float[np.ndarray, "row 4 node"]
) -> Float[np.ndarray, " 2"]:
    """Add the moments of all pairs; return the sums of their squared amplitudes in velocity and elevation."""
    waves, record = sea.waves, sea.record
    k = waves.wavenumber
    q = np.exp(-2.0 * k * waves.depth)
    e = 2.0 * q / (1.0 + q)
    root = waves.omega / math.sqrt(waves.gravity)
    table = np.stack([k, root, e, k * k * e * (2.0 - e), 1.0 / root, q])
    re, im = amplitude.real.copy(), amplitude.imag.copy()
    at = np.zeros(0, dtype=np.int64)
    if sea.bins is not None:
        at = np.full(int(sea.bins[-1]) + 1, -1, dtype=np.int64)
        at[sea.bins] = np.arange(sea.bins.size)

    def part(first: int) -> Float[np.ndarray, " 2"]:
        last, power = min(first + ROWS, record.n_bins), np.zeros(2)
        if sea.bins is not None:
            _kernel.gather_rows(
                first, last, sea.bins, at, table, re, im, waves.depth, waves.gravity, sea.half, out, power
            )
        else:
            _kernel.spread_pairs(
                first, last, record.bottom, record.grid.spacing, FINE.width, FINE.shape, table, re, im,
                waves.depth, waves.gravity, sea.half, out, power,
            )  # fmt: skip
        return power

    return np.asarray(np.sum(map_threads(part, range(0, record.n_bins, ROWS)), axis=0))


def _rows_of(
    sea: CompressedSea, omega: Float[np.ndarray, " line"]
) -> list[tuple[Int[np.ndarray, " line"], Float[np.ndarray, " line"]]]:
    """Rows that lines of given frequency add to, and with what factor."""
    record = sea.record
    y = omega / record.grid.spacing
    if sea.bins is not None:
        return [(np.round(y).astype(np.int64), np.ones(y.size))]
    start = np.ceil(y - 0.5 * FINE.width).astype(np.int64)
    rows = [start + i for i in range(FINE.width)]
    return [(row - record.bottom, FINE.value(y - row)) for row in rows]


def _relative_error(
    sea: CompressedSea, velocity: Table, surface: Table, power: Float[np.ndarray, " 2"]
) -> float:
    """Error of the interpolation over the standard deviation, the largest over the depth.

    The errors of the pairs, each taken at its largest, add as if their phases were random.
    """
    worst = 0.0
    for level, miss in zip(LEVELS, sea.node_error, strict=True):
        # The image of still water adds to what is there, and that of the bed to the bed.
        level = min(level, 2.0 - level)
        signal = np.linalg.norm(velocity @ np.exp(-sea.wavenumber * level * sea.waves.depth))
        worst = max(worst, float(miss * math.sqrt(power[0]) / max(signal, 1e-300)))
    signal = np.linalg.norm(surface.sum(axis=1))
    return max(worst, float(sea.node_error[0] * math.sqrt(power[1]) / max(signal, 1e-300)))
