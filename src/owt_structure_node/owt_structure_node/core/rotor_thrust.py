"""Thrust of a wind turbine's rotor, as the wrench on the tower top: a stand-in for an aeroelastic series.

A steady thrust curve followed by an ideal, slow controller, plus an aerodynamic gain for what is too fast for
it: turbulence sampled by the turning blades, tower passing, wind shear. One force at the hub, along the wind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError
from owt_structure_node.core.rotor_wind import Wind, realise_rotor_wind, rotor_variance, turbulence_at

__all__ = [
    "BLADES",
    "Rotor",
    "RotorThrust",
    "blade_wind",
    "passing_harmonics",
    "passing_wind",
    "rotor_thrust",
    "slow_part",
    "thrust_curve",
    "tower_deficit",
    "tower_top_wrench",
]

BLADES = 3
#: Azimuths of the mean over a turn that gives the harmonics of the passing blades, and the highest of these.
AZIMUTHS, HIGHEST = 7200, 120
#: Points along the blade of the mean over the wind shear.
SHEAR_POINTS = 24
#: Thrust coefficient of momentum theory at its largest power (Betz): beyond it no smaller loading is found.
BETZ = 8.0 / 9.0
#: Share of the variance of the rotor's wind below which a record says that it lacks the rest.
LEAST_SHARE = 0.8


@dataclass(frozen=True)
class Rotor:
    """A three-bladed upwind rotor; the defaults are a generic machine of 4 MW and 130 m.

    Attributes
    ----------
    diameter, hub_height : float
        m; height above still water.
    hub_above_top : float
        Height of the hub above the tower-top node in m.
    cut_in, rated_speed, cut_out : float
        Wind speeds in m/s; from `rated_speed` on the power is constant. 10.5 m/s is where a rotor of 130 m
        reaches 4 MW at a power coefficient of 0.43; makers' rated speeds of about 12 m/s are the end of a
        rounded bend, which this curve does not have.
    max_rpm : float
        Rotor speed from `rated_speed` on in 1/min; below, it is proportional to the wind.
    thrust_coefficient : float
        C_T below `rated_speed`.
    damping : float
        c = dT/dV at constant rotor speed and pitch in N s/m: gain of the fast wind and, as the tower top
        moves through the same air, the dashpot between it and the ground along the wind. 6.1e4 N s/m is the
        tower-top dashpot that reproduces the thesis' damping model (logarithmic decrement 30 %, 5.3).
    controller_time : float
        Time constant in s with which the operating point follows the wind.
    air_density : float
        kg/m3.
    tower_diameter, tower_distance : float
        Diameter of the tower in m, and distance in m of the passing blade from the tower's axis, both taken
        as constant along the blade.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    diameter: float = 130.0
    hub_height: float = 91.0
    hub_above_top: float = 2.0
    cut_in: float = 4.0
    rated_speed: float = 10.5
    cut_out: float = 25.0
    max_rpm: float = 14.0
    thrust_coefficient: float = 0.8
    damping: float = 6.1e4
    controller_time: float = 5.0
    air_density: float = 1.225
    tower_diameter: float = 4.5
    tower_distance: float = 9.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (value >= 0.0 and math.isfinite(value)):
                raise InputError(f"rotor.{field.name}", value, "must be >= 0", f"Use {field.default}.")
            if value == 0.0 and field.name not in {"hub_above_top", "damping", "tower_diameter"}:
                raise InputError(f"rotor.{field.name}", value, "must be > 0", f"Use {field.default}.")
        if not self.hub_height > 0.5 * self.diameter:
            limit = f"must be below twice the height of the hub over the water, {self.hub_height:g} m"
            raise InputError("rotor.diameter", self.diameter, limit, "Raise the hub.")
        if not self.cut_in < self.rated_speed < self.cut_out:
            limit = f"must lie between cut-in ({self.cut_in:g}) and cut-out ({self.cut_out:g} m/s)"
            raise InputError("rotor.rated_speed", self.rated_speed, limit, "Use 10.5.")
        if not self.thrust_coefficient <= BETZ:
            raise InputError(
                "rotor.thrust_coefficient", self.thrust_coefficient, "must be <= 8/9", "Use 0.8."
            )
        if not self.tower_distance > 0.5 * self.tower_diameter:
            limit = f"must be above half the tower diameter of {self.tower_diameter:g} m"
            raise InputError("rotor.tower_distance", self.tower_distance, limit, "Use 9.")

    @property
    def radius(self) -> float:
        """Half the diameter in m."""
        return 0.5 * self.diameter

    def frequency(self, speed: float) -> float:
        """Rotor frequency P in Hz at a mean wind in m/s."""
        return self.max_rpm / 60.0 * min(1.0, speed / self.rated_speed)


@dataclass(frozen=True)
class RotorThrust:
    """A record of the thrust; streams take its samples block by block.

    Attributes
    ----------
    dt : float
        Time step in s; sample i is at i dt.
    wind, slow_wind : float array [sample]
        Wind averaged over the blades and what of it the controller follows, in m/s.
    thrust : float array [sample]
        Force on the hub along the wind in N.
    wrench : float array [sample, 6]
        Forces in N and moments in N m on the tower-top node, global axes.
    damping : float
        Dashpot at the tower top along the wind in N s/m that goes with this thrust; it is not in it.
    rotor_frequency : float
        P in Hz.
    notes : tuple of str
        What the record lacks, in words.
    """

    dt: float
    wind: Float[np.ndarray, " sample"]
    slow_wind: Float[np.ndarray, " sample"]
    thrust: Float[np.ndarray, " sample"]
    wrench: Float[np.ndarray, "sample 6"]
    damping: float
    rotor_frequency: float
    notes: tuple[str, ...]


def thrust_curve(speed: Float[np.ndarray, " sample"], rotor: Rotor) -> Float[np.ndarray, " sample"]:
    """Steady thrust in N at wind speeds in m/s.

    T = 1/2 rho A C_T V^2. Below the rated speed C_T is constant. Above, the power is, and by momentum theory
    C_P = 4 a (1 - a)^2 falls with V^-3 from its value at the rated speed; C_T = 4 a (1 - a) of the smaller
    induction factor a, the root of a cubic (Burton et al., Wind energy handbook, 2nd ed., 3.2). The curve
    goes on beyond cut-in and cut-out; it is zero below zero wind.
    """
    V = np.maximum(speed, 0.0)
    rated = 0.5 * (1.0 - math.sqrt(1.0 - rotor.thrust_coefficient))
    power = 4.0 * rated * (1.0 - rated) ** 2 / np.maximum(V / rotor.rated_speed, 1.0) ** 3
    # b = 1 - a is the largest root of b^3 - b^2 + C_P/4 = 0, by the trisection of an angle.
    b = (1.0 + 2.0 * np.cos(np.arccos(np.clip(1.0 - 27.0 / 8.0 * power, -1.0, 1.0)) / 3.0)) / 3.0
    swept = math.pi * rotor.radius**2
    return np.asarray(0.5 * rotor.air_density * swept * 4.0 * b * (1.0 - b) * V**2)


def slow_part(
    series: Float[np.ndarray, " sample"], *, dt: float, time_constant: float
) -> Float[np.ndarray, " sample"]:
    """First-order low-pass 1/(1 + i omega tau) of a periodic series, in its periodic state.

    Parameters
    ----------
    series : float array [sample]
        One period.
    dt, time_constant : float
        Time step and tau in s.
    """
    omega = 2.0 * math.pi * np.fft.rfftfreq(series.size, dt)
    return np.asarray(np.fft.irfft(np.fft.rfft(series) / (1.0 + 1j * omega * time_constant), series.size))


def tower_deficit(azimuth: Float[np.ndarray, " azimuth"], rotor: Rotor) -> Float[np.ndarray, " azimuth"]:
    """Relative change of the wind by the tower, mean over a blade with weight r, at an azimuth in rad.

    Potential flow round a cylinder of radius b changes the wind at the distance e upstream of its axis and y
    aside by -b^2 (e^2 - y^2)/(e^2 + y^2)^2. With y = r sin(azimuth), 0 where the blade points down, the mean
    over int 2 r/R^2 dr is, q = (R sin(azimuth)/e)^2,

        -(b/e)^2 (2 q/(1 + q) - ln(1 + q)) / q,    -(b/e)^2 for q -> 0

    The tower ends at the hub: a blade that points up meets none.
    """
    q = (rotor.radius * np.sin(azimuth) / rotor.tower_distance) ** 2
    safe = np.maximum(q, 1e-6)  # below, the series 1 - 3 q/2 + ... is 1 to 1e-6
    mean = np.where(q > 1e-6, (2.0 * safe / (1.0 + safe) - np.log1p(safe)) / safe, 1.0)
    depth = (0.5 * rotor.tower_diameter / rotor.tower_distance) ** 2
    return np.asarray(np.where(np.cos(azimuth) > 0.0, -depth * mean, 0.0))


def blade_wind(
    azimuth: Float[np.ndarray, " azimuth"], rotor: Rotor, wind: Wind
) -> Float[np.ndarray, " azimuth"]:
    """Steady deviation in m/s from the wind at the hub, mean over a blade with weight r, by its azimuth.

    The sum of :func:`tower_deficit` times V and of the shear V ((z/z_hub)^p - 1), z = z_hub - r cos(azimuth).
    """
    points, weights = np.polynomial.legendre.leggauss(SHEAR_POINTS)
    x = 0.5 * (points + 1.0)
    height = 1.0 - rotor.radius / rotor.hub_height * np.cos(azimuth)[:, None] * x
    shear = (height**wind.shear_exponent - 1.0) @ (weights * x)
    return np.asarray(wind.speed * (tower_deficit(azimuth, rotor) + shear))


def passing_harmonics(
    rotor: Rotor, wind: Wind, highest: int
) -> tuple[Float[np.ndarray, " harmonic"], Float[np.ndarray, " harmonic"]]:
    """Numbers n = 3, 6, ... to `highest`, and amplitudes in m/s of cos(n azimuth) in :func:`blade_wind`."""
    n = np.arange(BLADES, highest + 1, BLADES).astype(float)
    # Midpoints: the jump where the tower ends, at a quarter turn, lies between two of them.
    azimuth = 2.0 * math.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    values = blade_wind(azimuth, rotor, wind)
    return n, np.asarray(np.cos(np.outer(n, azimuth)) @ values * (2.0 / AZIMUTHS))


def passing_wind(rotor: Rotor, wind: Wind, *, dt: float, n: int) -> Float[np.ndarray, " sample"]:
    """Deviation in m/s of the mean over the three blades as they pass the tower and go through the shear.

    The mean over the blades of :func:`blade_wind` keeps the harmonics 3, 6, ... of the rotor frequency; those
    below the Nyquist frequency are summed, so that nothing is folded back (and none above 120). The mean is
    left out: it belongs to the thrust curve. A blade points down at t = 0. The rotor frequency need not fit
    the record.

    Parameters
    ----------
    rotor, wind
        The machine and its wind.
    dt, n : float, int
        Time step in s and number of samples.
    """
    P = rotor.frequency(wind.speed)
    highest = min(HIGHEST, math.ceil(0.5 / (dt * P)) - 1)
    angle = 2.0 * math.pi * P * dt * np.arange(n)
    total = np.zeros(n)
    for number, amplitude in zip(*passing_harmonics(rotor, wind, highest), strict=True):
        total += amplitude * np.cos(number * angle)
    return total


def tower_top_wrench(
    thrust: Float[np.ndarray, " sample"], *, direction_deg: float, hub_above_top: float
) -> Float[np.ndarray, "sample 6"]:
    """Forces in N and moments in N m on the tower top of a thrust in N at the hub, global axes.

    F = T (cos b, sin b, 0), M = (0, 0, h) x F. The hub's overhang is along the wind and has no moment.

    Parameters
    ----------
    thrust : float array [sample]
        N, positive the way the wind blows.
    direction_deg, hub_above_top : float
        b in degrees, h in m.
    """
    b, h = math.radians(direction_deg), hub_above_top
    axis = np.array([math.cos(b), math.sin(b), 0.0, -h * math.sin(b), h * math.cos(b), 0.0])
    return np.ascontiguousarray(np.outer(thrust, axis))


def rotor_thrust(rotor: Rotor, wind: Wind, *, dt: float, n: int) -> RotorThrust:
    """Thrust of `rotor` in `wind`: T(t) = T_curve(V_slow(t)) + c (V(t) - V_slow(t)).

    V is the wind averaged over the blades (turbulence of :func:`realise_rotor_wind` and
    :func:`passing_wind`), V_slow the mean and turbulence that pass the controller's low-pass. The rotor speed
    is that of the mean wind throughout. The turbulence is periodic in the record.

    Parameters
    ----------
    rotor, wind
        The machine and its wind.
    dt, n : float, int
        Time step in s and number of samples.

    Raises
    ------
    InputError
        If the turbine does not run at the mean wind, or the samples are too far apart or too few.
    """
    _check_operation(rotor, wind, dt)
    P, turbulence = rotor.frequency(wind.speed), turbulence_at(wind, rotor.hub_height)
    u = realise_rotor_wind(turbulence, radius=rotor.radius, rotor_frequency=P, dt=dt, n=n, seed=wind.seed)
    slow = wind.speed + slow_part(u, dt=dt, time_constant=rotor.controller_time)
    felt = wind.speed + u + passing_wind(rotor, wind, dt=dt, n=n)
    thrust = thrust_curve(slow, rotor) + rotor.damping * (felt - slow)
    share = float(np.var(u)) / rotor_variance(turbulence, rotor.radius)
    return RotorThrust(
        dt=dt,
        wind=felt,
        slow_wind=slow,
        thrust=thrust,
        wrench=tower_top_wrench(thrust, direction_deg=wind.direction_deg, hub_above_top=rotor.hub_above_top),
        damping=rotor.damping,
        rotor_frequency=P,
        notes=tuple(_notes(rotor, slow, share=share, dt=dt, rotor_frequency=P)),
    )


def _check_operation(rotor: Rotor, wind: Wind, dt: float) -> None:
    if not rotor.cut_in <= wind.speed <= rotor.cut_out:
        limit = f"lies outside cut-in ... cut-out, {rotor.cut_in:g} ... {rotor.cut_out:g} m/s"
        remedy = "Leave the wind out: an idling rotor has next to no thrust."
        raise InputError("wind.speed", wind.speed, limit, remedy)
    if not 0.0 < dt <= 0.5 * rotor.controller_time:
        limit = f"must be > 0 and at most half the controller's time constant, {rotor.controller_time:g} s"
        raise InputError("time.dt_s", dt, limit, "Use 0.1.")


def _notes(
    rotor: Rotor, slow: Float[np.ndarray, " sample"], *, share: float, dt: float, rotor_frequency: float
) -> list[str]:
    """What a record lacks."""
    notes = []
    nyquist = 0.5 / dt
    lost = [f"{n}P ({n * rotor_frequency:.3g} Hz)" for n in (3, 6) if n * rotor_frequency >= nyquist]
    if lost:
        which = " and ".join(lost)
        notes.append(f"wind: {which} left out, above the Nyquist frequency of {nyquist:.3g} Hz")
    if share < LEAST_SHARE:
        notes.append(
            f"wind: the record holds {share:.2f} of the variance of the wind over the rotor; the rest is "
            "slower than its length or faster than its samples"
        )
    if not rotor.cut_in <= slow.min() <= slow.max() <= rotor.cut_out:
        notes.append(
            f"wind: the slow wind, {slow.min():.3g} ... {slow.max():.3g} m/s, leaves cut-in ... cut-out; "
            "stops and starts are left out"
        )
    return notes
