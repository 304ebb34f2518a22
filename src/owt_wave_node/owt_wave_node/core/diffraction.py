"""Diffraction of waves by an upright cylinder (MacCamy and Fuchs 1954), as an inertia coefficient.

The force per length that linear diffraction theory gives is rho pi D^2 / 4 times the undisturbed acceleration
on the axis times a complex coefficient of ka = k D / 2 alone, 2 for waves much longer than the diameter. Its
ratio to that limit scales Morison's inertia force: of each component of the first order, on all members, by
the diameter of each. The second order is not corrected.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_wave_node.core.field import Field, Place
from owt_wave_node.core.profile import first_order_profile

__all__ = ["extra_acceleration", "inertia_ratio", "refuse_impossible"]

#: Where ka is below this the ratio is one to double precision.
LONG_WAVE = 1e-8


def inertia_ratio(ka: Float[np.ndarray, " component"]) -> Complex[np.ndarray, " component"]:
    """Inertia coefficient over its long-wave limit 2, for amplitudes in the sense of A exp(i omega t).

    -2 i / (pi (ka)^2 H1'(ka)), H1 the Hankel function of the second kind, outgoing for exp(i omega t).
    """
    from scipy.special import h2vp  # here: costly to import, and few cases ask for it

    x = np.maximum(ka, LONG_WAVE)
    return np.asarray(np.where(ka > LONG_WAVE, -2j / (np.pi * x**2 * h2vp(1, x)), 1.0 + 0j))


def refuse_impossible(case: CaseConfig) -> None:
    """Refuse diffraction where the waves are no sum of linear components.

    Raises
    ------
    InputError
        For Wheeler stretching, and for regular waves of a nonlinear theory.
    """
    if case.morison.diffraction == "none":
        return
    nonlinear = case.regular is not None and case.regular.theory != "airy"
    if nonlinear or case.wave.stretching == "wheeler":
        raise InputError(
            "morison.diffraction",
            case.morison.diffraction,
            "needs linear components, which neither Wheeler stretching nor a nonlinear regular wave has",
            "Use another stretching, components or an airy wave, or diffraction none.",
        )


def extra_acceleration(
    field: Field, place: Place, diameter: float, *, water_depth: float, stretching: str
) -> Float[np.ndarray, "point axis time"]:
    """What diffraction adds to the first-order acceleration in m/s2, as an inertia force sees it.

    Parameters
    ----------
    field : Field
        The waves.
    place : float array [point, 3]
        Points in m in wave axes.
    diameter : float
        m.
    """
    change = inertia_ratio(0.5 * diameter * np.abs(field.wavenumber)) - 1.0
    horizontal, vertical = first_order_profile(
        field.wavenumber, place[:, 2].copy(), water_depth=water_depth, stretching=stretching
    )
    return field.shaped(place, change * horizontal, change * vertical)[:, field.n_axes :]
