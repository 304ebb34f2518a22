"""Where a case lies: wave theory (figure 2.8), kind of load (figure 2.9), and what its models leave out.

An irregular sea is classified by the wave of height Hs and period Tp, and by the largest wave expected.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_model.structure import Structure
from owt_wave_node.core.coefficients import coefficient_at
from owt_wave_node.core.current import current_velocity
from owt_wave_node.core.sea_statistics import component_statistics
from owt_wave_node.core.wave_theory import (
    LONG_WAVE_URSELL,
    THEORIES,
    RegularRegime,
    regular_regime,
)

__all__ = ["MemberRegime", "SeaRegime", "orbital_speed", "regime_warnings", "sea_regime"]

#: Kinematic viscosity of sea water at 15 degrees in m2/s (ITTC 7.5-02-01-03, 2011).
VISCOSITY = 1.19e-6
#: Diameter over wave length above which a member diffracts the waves (thesis 2.9, DNV-RP-C205 chapter 6).
MAX_DIAMETER_OVER_LENGTH = 0.2
#: KC below which the flow stays attached, and above which drag governs: H/D = 10 in deep water (figure 2.9).
KC_ATTACHED, KC_DRAG = 2.0, 10.0 * math.pi
#: Largest steepness 2 pi Hs / (g Tp^2) of sea states: Tp in s, steepness (DNV-RP-C205 section 3.5.4).
SEA_STEEPNESS = ((8.0, 15.0), (1.0 / 15.0, 1.0 / 25.0))
#: Second harmonic over the first order above which long components are beyond second order.
MAX_HARMONIC = 0.25
#: Instants of a period at which the trough beside a focused crest is looked for.
INSTANTS = 64


@dataclass(frozen=True)
class MemberRegime:
    """The members of one diameter below still water.

    Attributes
    ----------
    diameter_m : float
        Marine growth included where it counts.
    count : int
        Number of members.
    level_m, keulegan_carpenter, reynolds : tuple of two floats
        At their highest wet and lowest point: u T / D and u D / nu, u the largest orbital velocity plus the
        current.
    length_over_diameter, diffraction : float
        L/D and pi D/L.
    drag_over_inertia : float, optional
        Largest drag over largest inertia force at the highest wet point, Cd KC / (pi^2 Cm); None at Cm 0.
    load : str
        "diffraction", "inertia", "inertia and drag" or "drag".
    """

    diameter_m: float
    count: int
    level_m: tuple[float, float]
    keulegan_carpenter: tuple[float, float]
    reynolds: tuple[float, float]
    length_over_diameter: float
    diffraction: float
    drag_over_inertia: float | None
    load: str


@dataclass(frozen=True)
class SeaRegime:
    """A sea, its wave theory, its members, and one line for each model that is used outside its range.

    Attributes
    ----------
    wave, largest : RegularRegime
        The wave of Hs and Tp, and the largest wave expected in the record at Tp, or that of the focused crest
        where it is higher; of a regular sea twice the wave itself.
    n_waves : float
        Waves expected in the record.
    sea_steepness : float
        2 pi Hs / (g Tp^2).
    cutoff_rad_s, steepness_cutoff_rad_s : float
        Highest component used, and sqrt(2 g / Hs), the highest for which second order holds.
    """

    wave: RegularRegime
    largest: RegularRegime
    n_waves: float
    sea_steepness: float
    cutoff_rad_s: float
    steepness_cutoff_rad_s: float
    members: tuple[MemberRegime, ...]
    warnings: tuple[str, ...]


def orbital_speed(wave: RegularRegime, z: float) -> float:
    """Largest horizontal velocity in m/s of the linear wave at the level z <= 0."""
    k, d = 2.0 * math.pi / wave.length_m, wave.depth_m
    # cosh k(z + d) / sinh kd without overflow.
    profile = (math.exp(k * z) + math.exp(-k * (z + 2.0 * d))) / -math.expm1(-2.0 * k * d)
    return math.pi * wave.height_m / wave.period_s * profile


def sea_regime(case: CaseConfig, sea: SeaState, structure: Structure | None = None) -> SeaRegime:
    """Classify a case and its sea.

    Parameters
    ----------
    case, sea
        The case and what :func:`~owt_wave_node.core.sea.build_sea_state` made of it.
    structure : Structure, optional
        Whose members are classified.

    Raises
    ------
    InputError
        If the sea holds no energy.
    """
    spectrum = component_statistics(sea.omega_rad_s, sea.amplitude_m)
    water = {"depth": sea.water_depth_m, "gravity": sea.gravity_m_s2}
    if case.regular is not None:
        hs = highest = case.regular.height_m
        tp = 2.0 * math.pi / float(sea.omega_rad_s[0])
        n_waves = sea.duration_s / tp
    else:
        hs, tp = (sea.hs_m, sea.tp_s) if sea.hs_m > 0.0 else (spectrum.hm0_m, spectrum.peak_period_s)
        n_waves = max(sea.duration_s / spectrum.tm02_s, math.e)
        highest = max(hs * math.sqrt(0.5 * math.log(n_waves)), _focused_height(case, sea))
    wave = regular_regime(height=hs, period=tp, **water)
    largest = regular_regime(height=highest, period=tp, **water)
    members = () if structure is None else _members(case, structure, wave)
    found = SeaRegime(
        wave=wave,
        largest=largest,
        n_waves=n_waves,
        sea_steepness=2.0 * math.pi * hs / (sea.gravity_m_s2 * tp**2),
        cutoff_rad_s=sea.cutoff_rad_s or float(sea.omega_rad_s.max()),
        steepness_cutoff_rad_s=math.sqrt(2.0 * sea.gravity_m_s2 / hs),
        members=members,
        warnings=(),
    )
    return SeaRegime(**{**vars(found), "warnings": _warnings(case, sea, found)})


def regime_warnings(case: CaseConfig, sea: SeaState, structure: Structure | None = None) -> tuple[str, ...]:
    """One line for each model that `case` uses outside its range; none for a flat sea."""
    return sea_regime(case, sea, structure).warnings if sea.amplitude_m.any() else ()


def _focused_height(case: CaseConfig, sea: SeaState) -> float:
    """Crest to the deeper trough beside it, in m, of the first order at the focus; 0 without one."""
    if case.sea_state is None or case.sea_state.focus is None:
        return 0.0
    focus = case.sea_state.focus
    angle = np.deg2rad(sea.component_direction_deg)
    x, y = focus.place_m
    phase = sea.wavenumber_rad_m * (x * np.cos(angle) + y * np.sin(angle)) + sea.phase_rad
    beside = case.sea_state.tp_s * np.linspace(-1.0, 1.0, 2 * INSTANTS + 1)
    trough = min(
        float(sea.amplitude_m @ np.cos(sea.omega_rad_s * (focus.time_s + t) - phase)) for t in beside.tolist()
    )
    return focus.crest_m - min(trough, 0.0)


def _too_long(sea: SeaState) -> tuple[float, float]:
    """Frequency in rad/s of the highest component below which second order fails, and its second harmonic.

    The second harmonic of a component over its own amplitude is a k (3 - T^2) / (4 T^3), T = tanh kd. Long
    components, kd < 1, count with the amplitude of all that are no shorter. (0, 0) where none fails.
    """
    order = np.argsort(sea.omega_rad_s)
    omega, k, amplitude = (v[order] for v in (sea.omega_rad_s, sea.wavenumber_rad_m, sea.amplitude_m))
    long = k * sea.water_depth_m < 1.0
    together = np.where(long, np.sqrt(np.cumsum(amplitude**2)), amplitude)
    tanh = np.tanh(k * sea.water_depth_m)
    harmonic = together * k * (3.0 - tanh**2) / (4.0 * tanh**3)
    failing = np.flatnonzero(long & (amplitude > 0.0) & (harmonic > MAX_HARMONIC))
    return (float(omega[failing[-1]]), float(harmonic[failing].max())) if failing.size else (0.0, 0.0)


def _members(case: CaseConfig, structure: Structure, wave: RegularRegime) -> tuple[MemberRegime, ...]:
    """Members below still water, by diameter, the thickest first."""
    growth = structure.marine_growth if case.morison.marine_growth else None
    wet: dict[float, list[tuple[float, float]]] = {}
    for member in structure.members.values():
        z = [structure.joints[joint][2] for joint in member.joints]
        low, high = max(min(z), -case.water_depth_m), min(max(z), 0.0)
        if low >= high:
            continue
        diameter = structure.sections[member.section].diameter_m
        if growth is not None and low < growth.z_top_m and high > growth.z_bottom_m:
            diameter += 2.0 * growth.thickness_m
        wet.setdefault(diameter, []).append((low, high))
    return tuple(
        _member(case, wave, diameter, len(ends), max(b for _, b in ends), min(a for a, _ in ends))
        for diameter, ends in sorted(wet.items(), reverse=True)
    )


def _member(
    case: CaseConfig, wave: RegularRegime, diameter: float, count: int, top: float, bottom: float
) -> MemberRegime:
    current = np.linalg.norm(current_velocity(case, np.array([top, bottom])), axis=1)
    speed = [orbital_speed(wave, z) + float(v) for z, v in zip((top, bottom), current, strict=True)]
    kc = speed[0] * wave.period_s / diameter, speed[1] * wave.period_s / diameter
    at = np.array([top])
    cd, cm = (float(coefficient_at(value, at)[0]) for value in (case.morison.cd, case.morison.cm))
    if diameter / wave.length_m > MAX_DIAMETER_OVER_LENGTH:
        load = "diffraction"
    else:
        load = "inertia" if kc[0] < KC_ATTACHED else "drag" if kc[0] > KC_DRAG else "inertia and drag"
    return MemberRegime(
        diameter_m=diameter,
        count=count,
        level_m=(top, bottom),
        keulegan_carpenter=kc,
        reynolds=(speed[0] * diameter / VISCOSITY, speed[1] * diameter / VISCOSITY),
        length_over_diameter=wave.length_m / diameter,
        diffraction=math.pi * diameter / wave.length_m,
        drag_over_inertia=cd * kc[0] / (math.pi**2 * cm) if cm > 0.0 else None,
        load=load,
    )


def _warnings(case: CaseConfig, sea: SeaState, found: SeaRegime) -> tuple[str, ...]:
    """One line for each model that `case` uses outside its range."""
    lines = _load_warnings(case, found)
    if case.regular is not None:
        return (*lines, *_regular_warnings(case, found))
    focused = _focused_height(case, sea) >= found.largest.height_m
    largest = (
        "the wave of the focused crest" if focused else f"the largest of about {found.n_waves:.0f} waves"
    )
    # At order 1 constant and Wheeler stretching hold the velocities of short components in the crest down.
    if case.wave.order == 2 or case.wave.stretching in ("taylor", "none"):
        lines += _cutoff_warnings(case, found)
    if case.wave.order == 2:
        lines += _second_order_warnings(sea, found, focused=focused)
    if found.largest.theory == "breaking":
        lines.append(
            f"{largest}, {found.largest.height_m:.2f} m, is above the breaking height "
            f"{found.largest.breaking_height_m:.2f} m of its period: breaking is left out. "
            "Use a lower or longer sea, or deeper water."
        )
    return tuple(lines)


def _load_warnings(case: CaseConfig, found: SeaRegime) -> list[str]:
    """Members so thick that they diffract the waves, which Morison's equation leaves out."""
    # Below half a wave length nothing moves, and nothing diffracts.
    reach = -0.5 * found.wave.length_m
    diffracting = [m for m in found.members if m.load == "diffraction" and m.level_m[0] > reach]
    if not diffracting or case.morison.diffraction != "none":
        return []
    widest = diffracting[0].diameter_m
    return [
        f"diameter {widest:.4g} m over wave length {found.wave.length_m:.4g} m is "
        f"{widest / found.wave.length_m:.3g}, above {MAX_DIAMETER_OVER_LENGTH}: Morison's equation leaves "
        "diffraction out. Set morison.diffraction to maccamy-fuchs."
    ]


def _cutoff_warnings(case: CaseConfig, found: SeaRegime) -> list[str]:
    """Cut-offs above where the series holds."""
    if found.cutoff_rad_s <= found.steepness_cutoff_rad_s * (1.0 + 1e-9):
        return []
    order = "second order" if case.wave.order == 2 else f"first order, stretching {case.wave.stretching},"
    remedy = (
        "Set sea_state.cutoff to steepness" if case.sea_state is not None else "Leave out what lies above"
    )
    return [
        f"cut-off {found.cutoff_rad_s:.3g} rad/s is above sqrt(2 g/Hs) = "
        f"{found.steepness_cutoff_rad_s:.3g} rad/s, up to which {order} holds: crest velocities "
        f"depend on it. {remedy}, or compare both."
    ]


def _second_order_warnings(sea: SeaState, found: SeaRegime, *, focused: bool) -> list[str]:
    """Seas too steep or too shallow for the second order, or with too long components."""
    lines = []
    wave = found.wave
    steepest = float(np.interp(wave.period_s, *SEA_STEEPNESS))
    if found.sea_steepness > steepest:
        lines.append(
            f"steepness 2 pi Hs/(g Tp^2) = {found.sea_steepness:.3g} is above {steepest:.3g}, the limit of "
            "sea states of this period: second order underrates such waves. Use Tp of at least "
            f"{_longest_enough(wave):.3g} s with Hs {wave.height_m:.3g} m."
        )
    if focused and found.largest.theory in ("stokes 5", "stream function"):
        lines.append(
            f"the wave of the focused crest, {found.largest.height_m:.2f} m, asks for {found.largest.theory} "
            "theory: second order underrates it. Lower sea_state.focus.crest_m, or use a regular wave."
        )
    ursell = max(wave.ursell, found.largest.ursell if focused else 0.0)
    long, harmonic = _too_long(sea)
    if ursell > LONG_WAVE_URSELL:
        lines.append(
            f"Ursell number H L^2/d^3 = {ursell:.3g} is above {LONG_WAVE_URSELL:g}: second order does "
            "not hold in water this shallow. Use a regular wave of stream function theory."
        )
    elif long > 0.0:
        lines.append(
            f"the component at {long:.3g} rad/s and what is longer have second harmonics of up to "
            f"{harmonic:.2g} of their amplitude, above {MAX_HARMONIC:g}: second order does not hold for such "
            f"waves. Set a cut-in (cutin_rad_s, cutin_over_peak) above {long:.3g} rad/s, or leave "
            "such components out."
        )
    return lines


def _longest_enough(wave: RegularRegime) -> float:
    """Peak period in s at which the height of `wave` meets the limit of the steepness of sea states."""
    periods = np.linspace(wave.period_s, 10.0 * wave.period_s, 1000)
    steepness = 2.0 * math.pi * wave.height_m / (wave.gravity_m_s2 * periods**2)
    possible = periods[steepness <= np.interp(periods, *SEA_STEEPNESS)]
    return float(possible[0]) if possible.size else float(periods[-1])


def _regular_warnings(case: CaseConfig, found: SeaRegime) -> list[str]:
    """A regular wave that breaks, or that its theory does not describe."""
    regular, wave = case.regular, found.wave
    assert regular is not None
    if wave.theory == "breaking":
        return [
            f"regular wave of {wave.height_m:.4g} m is above the breaking height of its period, "
            f"{wave.breaking_height_m:.4g} m. Lower regular.height_m."
        ]
    given = {"airy": 0, "stream": THEORIES.index("stream function")}.get(regular.theory)
    if given is None:
        order = 5 if regular.order is None else regular.order
        given = sum(order >= n for n in (2, 3, 5))
    if given >= THEORIES.index(wave.theory):
        return []
    return [
        f"regular wave of {wave.height_m:.4g} m and {wave.period_s:.4g} s (Ursell number {wave.ursell:.3g}, "
        f"{wave.height_m / wave.breaking_height_m:.2g} of breaking) asks for {wave.theory} theory. Set "
        "regular.theory to stream."
    ]
