"""A measured elevation record at one place, as first-order components that give it back.

The record holds every order. Its first order is sought such that first plus second order at that place are
the record: eta1 = B[record - eta2(eta1)], B the projection on the components 2 pi m / (n dt) of the band.
Plain iteration of this equation converges slowly in steep seas, and diverges where the shortest waves are
steeper than about one over the height of the longest; Anderson's mixing of the latest iterates (1965,
J. ACM 12, 547-560) converges there as well, at the same cost per iteration. What the record holds far below
its mean frequency is second order nearly all: taken as first order at the start, waves that long would have
a second order larger than themselves, so the iteration starts without them, and the longest are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_model.errors import ComputationError, InputError
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import Waves

__all__ = ["Band", "Gauge", "MeasuredSea", "components_of_record"]

Spectrum = Complex[np.ndarray, " component"]
Series = Float[np.ndarray, " time"]

#: Share of the mean frequency below which the iteration starts from nothing.
LONG = 0.5
#: Wave number times depth below which a component is left out: its own second order, 3 a^2 / (4 k^2 d^3),
#: would exceed it at millimetres of amplitude.
SHALLOWEST = 0.05
#: Former iterates that a new one is mixed from.
MEMORY = 10
#: Change over the largest component from which nothing comes back.
DIVERGED = 1e6
#: Largest elevation in m that is one: far beyond it squares overflow.
HIGHEST = 1e6
#: Residual over the standard deviation of the record above which the components are not its waves.
MOST_RESIDUAL = 0.5


@dataclass(frozen=True)
class Band:
    """What counts as first order, and when the iteration ends.

    Attributes
    ----------
    cutin, cutoff : float
        Lowest and highest component in rad/s; waves with k d below 0.05 are left out in any case.
    tolerance : float
        Change of a component, over the largest one, that ends iteration.
    """

    cutin: float
    cutoff: float
    tolerance: float = 1e-6
    max_iterations: int = 50


@dataclass(frozen=True)
class MeasuredSea:
    """Components of a record, and how well they give it back.

    Attributes
    ----------
    omega, amplitude, phase : float arrays [component]
        rad/s, m, rad: eta1 = sum a cos(omega t - k x - phase), t from the first sample, x from the origin.
    residual_rms, residual_max : float
        Of the record minus first and second order, both without their means, over the record's standard
        deviation: what lies outside the band and is no second order of what lies within.
    mean_m : float
        Mean of the record in m. It is left out: the datum of a gauge is not known to millimetres.
    set_down_m : float
        Mean of the second order in m, which the sea of these components has.
    """

    omega: Float[np.ndarray, " component"]
    amplitude: Float[np.ndarray, " component"]
    phase: Float[np.ndarray, " component"]
    iterations: int
    residual_rms: float
    residual_max: float
    std_m: float
    mean_m: float
    set_down_m: float


class Gauge:
    """Long-crested components at a gauge, of all records of one length.

    Parameters
    ----------
    n : int
        Samples of a record.
    dt, depth, gravity : float
        s, m, m/s2.
    band : Band
    order : int
        At 1 records are taken as linear.

    Raises
    ------
    InputError
        If the band holds no component, or reaches the record's Nyquist frequency.
    """

    def __init__(self, n: int, *, dt: float, depth: float, gravity: float, band: Band, order: int) -> None:
        # tanh kd = kd to 0.1 % there
        longest = SHALLOWEST * math.sqrt(gravity / depth)
        self.band = band
        self.bins = _bins(n, dt, replace(band, cutin=max(band.cutin, longest)))
        self.omega = self.bins * (2.0 * math.pi / (n * dt))
        self.k = wavenumber(self.omega, water_depth=depth, gravity=gravity)
        self._flat = Waves(
            omega=self.omega,
            wavenumber=self.k,
            angle=np.zeros(self.omega.size),
            amplitude=np.zeros(self.omega.size, dtype=complex),
            depth=depth,
            gravity=gravity,
            order=order,
            stretching="none",
            dt=dt,
            n=n,
        )

    def elevation(self, A: Spectrum) -> tuple[Series, Series]:
        """First- and second-order elevation in m at the gauge of amplitudes in m there."""
        first, second = component_field(self.waves(A)).elevation(np.zeros((1, 3)))
        return first[0], second[0]

    def waves(self, A: Spectrum, *, stretching: str = "none") -> Waves:
        """Waves of some amplitudes in m."""
        return replace(self._flat, amplitude=A, stretching=stretching)

    def at_origin(self, A: Spectrum, x: float) -> Spectrum:
        """Amplitudes at the origin of amplitudes at a gauge `x` m along the heading from it."""
        return np.asarray(A * np.exp(1j * self.k * x))

    def solve(self, record: Series) -> tuple[Spectrum, int]:
        """Solve A = B[record - eta2(A)]; return the complex amplitudes at the gauge and the iterations used.

        Raises
        ------
        InputError
            If the band leaves all of the record.
        ComputationError
            If the iteration does not converge.
        """
        bins, band = self.bins, self.band
        target = _project(record, bins)
        energy = np.abs(target) ** 2
        A = target * (bins * energy.sum() > LONG * float(bins @ energy))
        if not A.any():
            raise _outside(band, "leaves all of the record")
        points: list[Spectrum] = []
        steps: list[Spectrum] = []
        change = math.inf
        for i in range(1, band.max_iterations + 1):
            step = target - _project(self.elevation(A)[1], bins) - A
            change = float(np.abs(step).max()) / float(np.abs(A).max())
            if not change < DIVERGED:
                break
            if change <= band.tolerance:
                return A + step, i
            points, steps = [*points[-MEMORY:], A], [*steps[-MEMORY:], step]
            A = _mix(points, steps)
        raise ComputationError(
            f"first order of the measured record not found: after {band.max_iterations} iterations a "
            f"component changes by {change:.1e} of the largest one, above {band.tolerance:g}. Lower "
            "measured.cutoff_rad_s or raise measured.cutin_rad_s: the second order of very steep or very "
            "long waves does not converge"
        )


def components_of_record(
    record: Series,
    *,
    dt: float,
    x: float,
    depth: float,
    gravity: float,
    band: Band,
    order: int = 2,
) -> MeasuredSea:
    """Return the long-crested components whose elevation at `x` is `record`.

    Parameters
    ----------
    record : float array [time]
        Elevation in m, sampled every `dt` s. It is taken as periodic.
    x : float
        Place of the gauge along the heading in m.
    depth, gravity : float
        m, m/s2.
    band : Band
    order : int
        At 1 the record is taken as linear and nothing is removed.

    Raises
    ------
    InputError
        If the band holds no component, reaches the record's Nyquist frequency or holds less of the record
        than it leaves out; or if the record is constant or no elevation in m.
    ComputationError
        If the iteration does not converge.
    """
    highest = float(np.abs(record).max())
    if not highest <= HIGHEST:
        raise InputError(
            "measured.path", highest, f"is no elevation in m: above {HIGHEST:g} m", "Check the record."
        )
    std = float(record.std())
    if not std > 1e-12 * highest:
        raise InputError(
            "measured.path", std, "is the standard deviation in m: no waves", "Check the record."
        )
    gauge = Gauge(record.size, dt=dt, depth=depth, gravity=gravity, band=band, order=order)
    A, iterations = gauge.solve(record)
    first, second = gauge.elevation(A)
    rest = record - first - second
    rest -= rest.mean()
    residual = float(np.sqrt(np.mean(rest**2))) / std
    if residual > MOST_RESIDUAL:
        raise _outside(band, f"leaves {residual:.2g} of the record's standard deviation")
    A = gauge.at_origin(A, x)
    return MeasuredSea(
        omega=gauge.omega,
        amplitude=np.abs(A),
        phase=-np.angle(A),
        iterations=iterations,
        residual_rms=residual,
        residual_max=float(np.abs(rest).max()) / std,
        std_m=std,
        mean_m=float(record.mean()),
        set_down_m=float(second.mean()),
    )


def _outside(band: Band, what: str) -> InputError:
    """The refusal of a band that the waves of the record do not lie in."""
    return InputError(
        "measured.cutoff_rad_s",
        band.cutoff,
        f"{what} to neither order, above {MOST_RESIDUAL:g}: the band from {band.cutin:.4g} rad/s on does not "
        "hold its waves",
        "Set measured.cutin_rad_s and measured.cutoff_rad_s about the waves of the record.",
    )


def _bins(n: int, dt: float, band: Band) -> Int[np.ndarray, " component"]:
    """Numbers m of the components 2 pi m / (n dt) within the band."""
    nyquist = math.pi / dt
    if band.cutoff >= nyquist:
        raise InputError(
            "measured.cutoff_rad_s",
            band.cutoff,
            f"must lie below the record's Nyquist frequency, {nyquist:.4g} rad/s",
            "Lower it to the highest frequency of the waves.",
        )
    spacing = 2.0 * math.pi / (n * dt)
    first = max(1, math.ceil(band.cutin / spacing * (1.0 - 1e-12)))
    last = math.floor(band.cutoff / spacing * (1.0 + 1e-12))
    if last < first:
        raise InputError(
            "measured.cutoff_rad_s",
            band.cutoff,
            f"leaves no component: they are multiples of {spacing:.4g} rad/s, from {band.cutin:.4g} rad/s on",
            "Widen the band or use a longer record.",
        )
    return np.arange(first, last + 1)


def _project(series: Series, bins: Int[np.ndarray, " component"]) -> Spectrum:
    """Complex amplitudes of a series at the frequencies of `bins`."""
    return np.asarray(2.0 / series.size * np.fft.rfft(series)[bins], dtype=complex)


def _mix(points: list[Spectrum], steps: list[Spectrum]) -> Spectrum:
    """Anderson's next iterate: the combination of the iterates with the smallest step, plus that step."""
    A, step = points[-1], steps[-1]
    if len(points) == 1:
        return np.asarray(A + step)
    d_point = np.array([A - other for other in points[:-1]])
    d_step = np.array([step - other for other in steps[:-1]])
    stacked = np.concatenate([d_step.real, d_step.imag], axis=1).T
    weight = np.linalg.lstsq(stacked, np.concatenate([step.real, step.imag]), rcond=1e-12)[0]
    return np.asarray(A + step - weight @ (d_point + d_step))
