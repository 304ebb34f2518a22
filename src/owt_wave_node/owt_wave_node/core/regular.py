"""Regular waves of permanent form: Airy, Stokes (Fenton 1985), stream function (Rienecker and Fenton 1981).

The coefficients of the last two are those of the raschii library. A wave that travels without changing is a
Fourier series in psi = omega t - k x - phase,

    eta = sum a_j cos(j psi),    u = sum U_j C_j(z) cos(j psi),    w = -sum U_j S_j(z) sin(j psi),

with C_j = cosh jk(z+d) / cosh jkd and S_j = sinh jk(z+d) / cosh jkd, so that local accelerations are exact
too. The mean of the horizontal velocity at a point that always is wet is zero (Stokes' first definition of
the wave speed): a current is added to these waves and does not change them.

No stretching is needed or done: `wave.order` and `wave.stretching` are for Airy waves and spectra only. Airy
waves are components of first order, see :func:`~owt_wave_node.core.route.make_field`.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from jaxtyping import Complex, Float, Int

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_wave_node.core.field import Kinematics, Place, Prepared, Profile, Series
from owt_wave_node.core.profile import first_order_profile
from owt_wave_node.core.steady import SteadyWave, steady_wave

__all__ = ["RegularField", "regular_sea_state"]

#: Samples whose harmonics are held at a time.
BLOCK = 4096
#: Share of the first harmonic, at the crest, below which the last ones are left out.
NEGLIGIBLE = 1e-17
#: Phase in rad that a record may drift by, over all of it, and still repeat itself.
DRIFT = 1e-10
#: Samples after which a repetition is not looked for.
LATE = 100_000


def _wave_of(case: CaseConfig) -> SteadyWave:
    """Solve the regular wave of `case`."""
    wave = case.regular
    assert wave is not None  # callers dispatch on it
    return steady_wave(
        wave.theory,
        height=wave.height_m,
        period=wave.period_s,
        length=wave.length_m,
        order=wave.order,
        depth=case.water_depth_m,
        gravity=case.gravity_m_s2,
    )


def regular_sea_state(case: CaseConfig) -> SeaState:
    """Return the regular wave of `case` as a sea of one component, half as high as the wave.

    Its wave number is that of the theory, its order that of the theory (the highest harmonic).

    Raises
    ------
    InputError
        If the wave would break, or the theory does not hold for it.
    """
    given, wave = case.regular, _wave_of(case)
    assert given is not None
    airy = given.theory == "airy"
    return SeaState(
        omega_rad_s=np.array([wave.omega]),
        amplitude_m=np.array([0.5 * given.height_m]),
        phase_rad=np.array([given.phase_rad]),
        wavenumber_rad_m=np.array([wave.wavenumber]),
        direction_deg=float(given.direction_deg),
        component_direction_deg=np.array([float(given.direction_deg)]),
        water_depth_m=case.water_depth_m,
        gravity_m_s2=case.gravity_m_s2,
        density_kg_m3=case.density_kg_m3,
        order=wave.elevation.size,
        stretching=case.wave.stretching if airy else "none",
        dt_s=case.time.dt_s,
        n=case.time.n,
        cutoff_rad_s=wave.omega,
        source="regular",
    )


def _repeats(omega: float, dt: float, n: int) -> int:
    """Samples after which a record of n samples repeats itself; n if it does not, or late."""
    count = np.arange(1, min(n, LATE) + 1)
    turns = count * (omega * dt / (2.0 * np.pi))
    drift = 2.0 * np.pi * np.abs(turns - np.round(turns)) * (n / count)
    found = np.flatnonzero((drift <= DRIFT) & (np.round(turns) >= 1))
    return int(count[found[0]]) if found.size else n


class RegularField:
    """A Stokes or stream function wave: a Fourier series of few harmonics, summed directly.

    A record that repeats itself, as one of 10 s waves sampled every 0.1 s does, is summed once.

    At a point between trough and crest the series is evaluated at the point's own level at all times, also
    while the point is dry. Above the crest, where its high harmonics would explode, it continues along its
    tangent at the crest.
    """

    def __init__(self, case: CaseConfig, sea: SeaState) -> None:
        self._wave = wave = _wave_of(case)
        self.n_axes, self.n, self._start = 2, sea.n, 0
        self._dt, self._depth = sea.dt_s, sea.water_depth_m
        self._phase = float(sea.phase_rad[0])
        self._repeat = _repeats(wave.omega, sea.dt_s, sea.n)
        harmonic = np.arange(1, wave.elevation.size + 1)
        at_crest = harmonic * wave.speed * np.exp(harmonic * wave.wavenumber * wave.crest)
        size = np.maximum(np.abs(at_crest / at_crest[0]), np.abs(wave.elevation / wave.elevation[0]))
        count = int(np.flatnonzero(size > NEGLIGIBLE)[-1]) + 1
        self._harmonic = harmonic[:count]
        self._elevation, self._speed = wave.elevation[:count], wave.speed[:count]
        self.wavenumber = self._harmonic * wave.wavenumber

    def window(self, start: int, count: int) -> RegularField:
        """Return the field over `count` samples from `start`."""
        part = copy(self)
        part._start, part.n = self._start + start, count
        return part

    def _sum(
        self, place: Place, coefficient: Complex[np.ndarray, "point channel harmonic"]
    ) -> Float[np.ndarray, "point channel time"]:
        """Re sum_j c_j exp(i j psi) at all times."""
        phase = np.outer(place[:, 0] * self._wave.wavenumber + self._phase, self._harmonic)
        here = coefficient * np.exp(-1j * phase)[:, None, :]
        factors = np.concatenate([here.real, -here.imag], axis=2)
        summed = min(self.n, self._repeat)
        out = np.empty((*coefficient.shape[:2], summed))
        for start in range(0, summed, BLOCK):
            t = (self._start + np.arange(start, min(start + BLOCK, summed))) * self._dt
            turn = np.exp(1j * self._wave.omega * t)
            phasor = np.cumprod(np.broadcast_to(turn, (self._harmonic.size, t.size)), axis=0)
            out[:, :, start : start + t.size] = factors @ np.concatenate([phasor.real, phasor.imag])
        return out if summed == self.n else np.take(out, np.arange(self.n) % summed, axis=2)

    def elevation(self, place: Place) -> tuple[Series, Series]:
        """Elevation of all orders in m, and zeros: the orders of these theories are not apart."""
        amplitude = np.tile(self._elevation.astype(complex), (len(place), 1, 1))
        return self._sum(place, amplitude)[:, 0], np.zeros((len(place), self.n))

    def first(self, place: Place) -> Kinematics:
        """Kinematics of all orders."""
        k, crest = self.wavenumber, self._wave.crest
        level = place[:, 2].copy()
        horizontal, vertical = first_order_profile(
            k, np.minimum(level, crest), water_depth=self._depth, stretching="none"
        )
        rise = np.maximum(level - crest, 0.0)[:, None] * k
        return self.shaped(place, horizontal + rise * vertical, vertical + rise * horizontal)

    def shaped(self, place: Place, horizontal: Profile, vertical: Profile) -> Kinematics:
        """Kinematics with given vertical factors of the harmonics instead of those of a level."""
        u = self._speed * horizontal
        w = 1j * self._speed * vertical
        rate = 1j * self._harmonic * self._wave.omega
        return self._sum(place, np.stack([u, w, rate * u, rate * w], axis=1))

    def second(self, place: Place) -> Kinematics:
        """Zeros: all orders are in :meth:`first`."""
        return np.zeros((len(place), 2 * self.n_axes, self.n))

    def prepare(self, place: Place) -> Prepared:
        """Remember the points."""
        return _RegularPrepared(self, place)


class _RegularPrepared:
    def __init__(self, field: RegularField, place: Place) -> None:
        self._field, self._place = field, place

    def kinematics(self, index: Int[np.ndarray, " some"]) -> Float[np.ndarray, "some channel time"]:
        return self._field.first(self._place[index])
