"""The sea of a case: its direction, its components, and those of them that carry energy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from owt_model.config import CaseConfig, Components
from owt_model.contracts import SeaState
from owt_model.errors import InputError
from owt_wave_node.core import spectrum
from owt_wave_node.core.dispersion import wavenumber

__all__ = ["Frame", "Waves", "build_sea_state", "sea_field", "waves"]

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

    def turn_back(self, vectors: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """Vectors in wave axes, as vectors in global axes."""
        return np.asarray(vectors @ self.axes)


def sea_field(case: CaseConfig) -> str:
    """Name of the field of `case` that sets the height of the waves."""
    return "components.amplitude_m" if case.components is not None else "sea_state.hs_m"


def _one_direction(components: Components) -> float:
    """Direction of listed components in degrees; refuses more than one."""
    given = components.direction_deg
    if not isinstance(given, tuple):
        return float(given)
    different = [b for b in given if (b - given[0]) % 360.0 != 0.0]
    if different:
        raise InputError(
            "components.direction_deg",
            different[0],
            f"differs from {given[0]}; short-crested seas are not available yet",
            "Give one direction for all components.",
        )
    return float(given[0])


def build_sea_state(case: CaseConfig) -> SeaState:
    """Return the components of the sea of `case`, realised from the spectrum or as listed.

    Raises
    ------
    InputError
        If no component lies in the band, or components travel in different directions.
    """
    depth, gravity = case.water_depth_m, case.gravity_m_s2
    extra: dict[str, float | int] = {}
    if case.components is not None:
        listed = case.components
        omega, amplitude, phase = (
            np.array(values, dtype=float)
            for values in (listed.omega_rad_s, listed.amplitude_m, listed.phase_rad)
        )
        direction = _one_direction(listed)
        extra = {"cutoff_rad_s": float(omega.max())}
    else:
        sea = case.sea_state
        assert sea is not None  # CaseConfig holds one of the two
        gamma = spectrum.gamma_rule(sea.hs_m, sea.tp_s) if sea.gamma is None else sea.gamma
        omega, amplitude, phase = spectrum.components(
            hs=sea.hs_m,
            tp=sea.tp_s,
            gamma=gamma,
            cutoff_over_peak=sea.cutoff_over_peak,
            duration=case.time.duration_s,
            seed=sea.seed,
        )
        direction = float(sea.direction_deg)
        extra = {
            "hs_m": sea.hs_m,
            "tp_s": sea.tp_s,
            "gamma": gamma,
            "seed": sea.seed,
            "cutoff_rad_s": sea.cutoff_over_peak * 2.0 * np.pi / sea.tp_s,
        }
    return SeaState(
        omega_rad_s=omega,
        amplitude_m=amplitude,
        phase_rad=phase,
        wavenumber_rad_m=wavenumber(omega, water_depth=depth, gravity=gravity),
        direction_deg=direction,
        component_direction_deg=np.full(omega.size, direction),
        water_depth_m=depth,
        gravity_m_s2=gravity,
        density_kg_m3=case.density_kg_m3,
        order=case.wave.order,
        stretching=case.wave.stretching,
        dt_s=case.time.dt_s,
        n=case.time.n,
        **extra,  # type: ignore[arg-type]
    )


@dataclass(frozen=True)
class Waves:
    """Components in ascending frequency, one per frequency, those without energy left out.

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
    """Sort the components of `sea`, merge those of one frequency and drop those without energy."""
    omega, first, group = np.unique(sea.omega_rad_s, return_index=True, return_inverse=True)
    amplitude = np.zeros(omega.size, dtype=complex)
    np.add.at(amplitude, group, sea.amplitude_m * np.exp(-1j * sea.phase_rad))
    keep = np.abs(amplitude) > NEGLIGIBLE * np.abs(amplitude).max()
    if not keep.any():
        keep[0] = True  # a flat sea keeps one component of zero amplitude
    return Waves(
        omega=omega[keep],
        wavenumber=sea.wavenumber_rad_m[first][keep],
        angle=np.zeros(int(keep.sum())),
        amplitude=amplitude[keep],
        depth=sea.water_depth_m,
        gravity=sea.gravity_m_s2,
        order=sea.order,
        stretching=sea.stretching,
        dt=sea.dt_s,
        n=sea.n,
    )
