"""Realisation of a spectrum: amplitudes, phases and directions of its components from one seed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from owt_model.config import SeaStateConfig
from owt_wave_node.core.spectrum import band_variance
from owt_wave_node.core.spreading import angle_of

__all__ = ["Realisation", "amplitudes", "derived_numbers", "directions", "phases", "realise"]

Array = Float[np.ndarray, " component"]

#: Streams of random numbers derived from a seed, beside that of the phases.
AMPLITUDE_STREAM, DIRECTION_STREAM = 1, 2


def phases(count: int, seed: int) -> Array:
    """Phases in rad, uniform in (0, 2 pi), of components 1 to `count`.

    They are ``2 pi * numpy.random.Generator(numpy.random.PCG64(seed)).random(count)``, in ascending
    frequency: PCG64 and its conversion to doubles are fixed, so that a seed gives the same sea everywhere,
    and a longer band begins with the phases of a shorter one.
    """
    return 2.0 * math.pi * np.random.Generator(np.random.PCG64(seed)).random(count)


def derived_numbers(count: int, seed: int, stream: int) -> Array:
    """Numbers uniform in [0, 1) of components 1 to `count`, from a stream of their own.

    ``PCG64(SeedSequence(seed, spawn_key=(stream,)))``: independent of the phases, which therefore do not
    depend on whether amplitudes or directions are drawn too.
    """
    sequence = np.random.SeedSequence(seed, spawn_key=(stream,))
    return np.random.Generator(np.random.PCG64(sequence)).random(count)


def amplitudes(
    variance: Array, *, kind: Literal["deterministic", "rayleigh"], seed: int, first: int = 1
) -> Array:
    """Amplitudes in m of components of expected variance S df in m2.

    Deterministic: sqrt(2 S df) [eq. 4.7]. Rayleigh: sqrt(-2 S df ln U), U uniform, which has the density of
    eq. 2.23 and E[a^2] = 2 S df. The variance of one Rayleigh realisation differs from that of the
    spectrum, as that of a finite record of a Gaussian sea does (Tucker, Challenor and Carter, 1984), and is
    not scaled back.

    Parameters
    ----------
    variance : float array [component]
        In ascending frequency.
    kind, seed
        How to draw, and the seed.
    first : int
        Number of the first component: component m of a seed is the same in every band.
    """
    if kind == "deterministic":
        return np.sqrt(2.0 * variance)
    drawn = derived_numbers(first - 1 + variance.size, seed, AMPLITUDE_STREAM)[first - 1 :]
    return np.asarray(np.sqrt(-2.0 * variance * np.log1p(-drawn)))  # 1 - drawn lies in (0, 1]: no ln 0


def directions(count: int, seed: int, *, exponent: float) -> Array:
    """Angles in rad from the mean direction of components 1 to `count`, of the spreading cos^2s.

    One direction per component: a sum over frequencies of waves in random directions, not a double sum over
    frequencies and directions. No two components share a frequency, so no pair of directions is phase
    locked and the sea is homogeneous and ergodic (Jefferys, 1987); its directional distribution is met on
    average over many components.
    """
    return angle_of(derived_numbers(count, seed, DIRECTION_STREAM), exponent)


@dataclass(frozen=True)
class Realisation:
    """Components of one realisation, in ascending frequency.

    Attributes
    ----------
    omega : float array [component]
        rad/s.
    variance : float array [component]
        Expected variance S df in m2.
    amplitude, phase : float arrays [component]
        m, rad.
    direction_deg : float array [component]
        Direction each travels to in degrees.
    """

    omega: Array
    variance: Array
    amplitude: Array
    phase: Array
    direction_deg: Array


def realise(sea: SeaStateConfig, *, duration: float, gravity: float) -> Realisation:
    """Realise a spectrum by components omega_m = 2 pi m / duration within its band.

    Random numbers belong to m, whatever the band: phases of :func:`phases`, and amplitudes and directions
    from streams derived from the same seed.

    Raises
    ------
    InputError
        If no component, or next to no energy, lies in the band.
    """
    numbers = sea.component_numbers(duration=duration, gravity=gravity)
    f, variance = band_variance(sea, duration=duration, gravity=gravity)
    first, last = numbers.start, numbers[-1]
    direction = np.full(f.size, sea.direction_deg)
    if sea.spreading is not None:
        direction += np.rad2deg(directions(last, sea.seed, exponent=sea.spreading)[first - 1 :])
    return Realisation(
        omega=2.0 * math.pi * f,
        variance=variance,
        amplitude=amplitudes(variance, kind=sea.amplitudes, seed=sea.seed, first=first),
        phase=phases(last, sea.seed)[first - 1 :],
        direction_deg=direction,
    )
