"""A crest of given height at a given time and place: NewWave, alone or embedded in an irregular sea."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.config import Focus
from owt_wave_node.core.realisation import Realisation

__all__ = ["focused"]

Array = Float[np.ndarray, " component"]


def focused(focus: Focus, sea: Realisation, wavenumber: Array) -> tuple[Array, Array]:
    """Amplitudes in m and phases in rad of the components of `sea` with the crest of `focus`.

    With S df the expected variances s, psi the phase of a component at the place and time of the focus, and
    m0 = sum s, m2 = sum omega^2 s, the crest's group alone (NewWave: the most probable shape, the
    autocorrelation of the sea) is crest / m0 sum s cos(psi). Embedded, the random sea keeps what the
    crest does not determine:

        eta = eta_r + (crest - eta_r0) / m0 sum s cos(psi) - eta_t0 / m2 sum omega s sin(psi)

    with eta_r0 and eta_t0 the elevation and its rate of change of the random sea there: a crest of the given
    height with zero slope in time, distributed as such crests of the sea are (Taylor, Jonathan and Harland,
    1997). The first order only is constrained; the second order of these components is added as ever.
    Short-crested components keep their directions, and the group spreads as the sea does.

    Parameters
    ----------
    focus : Focus
        Height, time and place of the crest.
    sea : Realisation
        Components of the random sea.
    wavenumber : float array [component]
        rad/m.
    """
    angle = np.deg2rad(sea.direction_deg)
    x, y = focus.place_m
    # Phase gained from the origin to the focus: there, a component is Re amplitude exp(i gained).
    gained = sea.omega * focus.time_s - wavenumber * (x * np.cos(angle) + y * np.sin(angle))
    s, omega = sea.variance, sea.omega
    group = s / float(s.sum())
    if focus.background:
        there = sea.amplitude * np.exp(1j * (gained - sea.phase))
        elevation, rate = float(there.real.sum()), -float(omega @ there.imag)
        there = there + (focus.crest_m - elevation) * group
        there += 1j * rate * omega * s / float(omega**2 @ s)
    else:
        there = (focus.crest_m * group).astype(complex)
    amplitude = there * np.exp(-1j * gained)
    return np.abs(amplitude), -np.angle(amplitude) % (2.0 * np.pi)
