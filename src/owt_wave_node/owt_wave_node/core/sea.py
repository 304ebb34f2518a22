"""The sea of a case: its direction, its components, and those of them that carry energy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from owt_model.config import SEA_SOURCES, CaseConfig, Components, SeaStateConfig
from owt_model.contracts import SeaState
from owt_model.errors import InputError
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.focus import focused
from owt_wave_node.core.realisation import realise
from owt_wave_node.core.spectrum import peak_enhancement
from owt_wave_node.core.spreading import mean_direction, turn_between

__all__ = ["Frame", "Waves", "build_sea_state", "sea_field", "sea_height", "waves"]

#: Amplitude over the largest one below which a component cannot change a sum in double precision.
NEGLIGIBLE = 1e-20


@dataclass(frozen=True)
class Frame:
    """Wave axes: x along the heading b, measured from global +x towards +y, y to its left, z up.

    Short-crested components travel at angles to the heading; see :attr:`Waves.angle`.
    """

    direction_deg: float

    @cached_property
    def axes(self) -> Float[np.ndarray, "3 3"]:
        """Unit vectors of the wave axes, by row, in global axes."""
        b = np.deg2rad(self.direction_deg)
        return np.array([[np.cos(b), np.sin(b), 0.0], [-np.sin(b), np.cos(b), 0.0], [0.0, 0.0, 1.0]])

    def place(self, points: Float[np.ndarray, "point axis"]) -> Float[np.ndarray, "point 3"]:
        """Points [x, y, z] or [x, y] in global axes, as [x, y, z] in wave axes."""
        n_axes = points.shape[1]
        return np.ascontiguousarray(points @ self.axes[:, :n_axes].T)


#: The field that sets the height of the waves, for every way to give the sea.
HEIGHT_FIELDS = {
    "sea_state": "sea_state.hs_m",
    "components": "components.amplitude_m",
    "spectrum_file": "spectrum_file.path",
    "measured": "measured.path",
    "regular": "regular.height_m",
}


def _source(case: CaseConfig) -> str:
    """Key of the case that gives its sea: the one of :data:`SEA_SOURCES` that is set."""
    return next(name for name in SEA_SOURCES if getattr(case, name) is not None)


def sea_field(case: CaseConfig) -> str:
    """Name of the field of `case` that sets the height of the waves; of those read, with their source."""
    if case.sea_state is not None and case.sea_state.focus is not None:
        return "sea_state.focus.crest_m"
    field = HEIGHT_FIELDS[_source(case)]
    if case.components is not None and case.components.source is not None:
        field += f" (from {case.components.source})"
    return field


def sea_height(case: CaseConfig) -> float:
    """Value in m of :func:`sea_field`, of components the largest.

    Raises
    ------
    InputError
        If the sea is still in a file.
    """
    if case.sea_state is not None:
        return case.sea_state.hs_m if case.sea_state.focus is None else case.sea_state.focus.crest_m
    if case.regular is not None:
        return case.regular.height_m
    if case.components is not None:
        return max(case.components.amplitude_m)
    raise _unread(case)


def build_sea_state(case: CaseConfig) -> SeaState:
    """Return the components of the sea of `case`: realised from its spectrum, listed, or of a regular wave.

    Raises
    ------
    InputError
        If no component lies in the band, or the sea is still in a file.
    """
    if case.sea_state is not None:
        return _realised(case, case.sea_state)
    if case.components is not None:
        return _listed(case, case.components)
    if case.regular is not None:
        from owt_wave_node.core.regular import regular_sea_state  # here: that module needs this one

        return regular_sea_state(case)
    raise _unread(case)


def _unread(case: CaseConfig) -> InputError:
    """The refusal of a sea that is still in a file."""
    return InputError(
        f"{_source(case)}.path",
        getattr(case, _source(case)).path,
        "is not read here: the components of this sea are not known yet",
        "Turn the file into components first, with owt_wave_node.sea_source.resolve_case.",
    )


def _realised(case: CaseConfig, sea: SeaStateConfig) -> SeaState:
    """Sea realised from a spectrum, with its focused crest where one is wanted."""
    gravity = case.gravity_m_s2
    realised = realise(sea, duration=case.time.duration_s, gravity=gravity)
    k = wavenumber(realised.omega, water_depth=case.water_depth_m, gravity=gravity)
    amplitude, phase = realised.amplitude, realised.phase
    if sea.focus is not None:
        amplitude, phase = focused(sea.focus, realised, k)
    return SeaState(
        omega_rad_s=realised.omega,
        amplitude_m=amplitude,
        phase_rad=phase,
        wavenumber_rad_m=k,
        component_direction_deg=realised.direction_deg,
        direction_deg=float(sea.direction_deg),
        hs_m=sea.hs_m,
        tp_s=sea.tp_s,
        gamma=peak_enhancement(sea, gravity=gravity),
        seed=sea.seed,
        cutoff_rad_s=2.0 * np.pi * sea.cutoff_hz(gravity),
        source="sea_state",
        **_water(case),
    )


def _listed(case: CaseConfig, listed: Components) -> SeaState:
    """Sea given by its components; its heading is their direction, or the mean weighted by energy."""
    omega, amplitude, phase = (
        np.array(values, dtype=float) for values in (listed.omega_rad_s, listed.amplitude_m, listed.phase_rad)
    )
    direction = np.broadcast_to(np.array(listed.direction_deg, dtype=float), omega.shape).copy()
    return SeaState(
        omega_rad_s=omega,
        amplitude_m=amplitude,
        phase_rad=phase,
        wavenumber_rad_m=wavenumber(omega, water_depth=case.water_depth_m, gravity=case.gravity_m_s2),
        component_direction_deg=direction,
        direction_deg=mean_direction(direction, amplitude**2),
        cutoff_rad_s=float(omega.max()),
        source="components",
        **_water(case),
    )


def _water(case: CaseConfig) -> dict[str, Any]:
    """Fields of a sea state that do not depend on where the sea comes from."""
    return {
        "water_depth_m": case.water_depth_m,
        "gravity_m_s2": case.gravity_m_s2,
        "density_kg_m3": case.density_kg_m3,
        "order": case.wave.order,
        "stretching": case.wave.stretching,
        "dt_s": case.time.dt_s,
        "n": case.time.n,
    }


@dataclass(frozen=True)
class Waves:
    """Components in ascending frequency, one per frequency and direction, those without energy left out.

    Attributes
    ----------
    omega, wavenumber : float arrays [component]
        rad/s, rad/m.
    angle : float array [component]
        Direction from the heading in rad, zero for long-crested waves.
    amplitude : complex array [component]
        a exp(-i phase) in m: eta1 = Re sum amplitude exp(i (omega t - k x)), x along the component.
    """

    omega: Float[np.ndarray, " component"]
    wavenumber: Float[np.ndarray, " component"]
    angle: Float[np.ndarray, " component"]
    amplitude: Complex[np.ndarray, " component"]
    depth: float
    gravity: float
    order: int
    stretching: str
    dt: float
    n: int

    @cached_property
    def peak_wavenumber(self) -> float:
        """Wave number in rad/m of the largest component."""
        return float(self.wavenumber[np.abs(self.amplitude).argmax()])


def waves(sea: SeaState) -> Waves:
    """Sort the components of `sea`, merge those of one frequency and direction, drop those without energy."""
    turn = turn_between(sea.direction_deg, sea.component_direction_deg)
    key = np.column_stack((sea.omega_rad_s, np.round(turn, 9)))  # directions equal but for round-off are one
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    amplitude = np.zeros(first.size, dtype=complex)
    np.add.at(amplitude, group, sea.amplitude_m * np.exp(-1j * sea.phase_rad))
    keep = np.abs(amplitude) > NEGLIGIBLE * np.abs(amplitude).max()
    if not keep.any():
        keep[0] = True  # a flat sea keeps one component of zero amplitude
    first = first[keep]
    return Waves(
        omega=sea.omega_rad_s[first],
        wavenumber=sea.wavenumber_rad_m[first],
        angle=np.deg2rad(turn[first]),
        amplitude=amplitude[keep],
        depth=sea.water_depth_m,
        gravity=sea.gravity_m_s2,
        order=sea.order,
        stretching=sea.stretching,
        dt=sea.dt_s,
        n=sea.n,
    )
