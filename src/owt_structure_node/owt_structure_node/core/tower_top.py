"""Wrench at the tower top on the grid of the load samples, and the damping that comes with it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBlock, WrenchBlock
from owt_model.errors import ComputationError, InputError
from owt_model.timing import sample_time_ns
from owt_model.wind_config import ThrustConfig
from owt_structure_node.core.rotor_thrust import BLADES, Rotor, rotor_thrust, tower_top_wrench
from owt_structure_node.core.rotor_wind import Wind

__all__ = ["TowerTopLoad", "WrenchSamples", "beside", "thrust_load", "turned"]

#: What the case calls the fields of the rotor.
ROTOR = {
    "diameter": "diameter_m",
    "hub_above_top": "hub_above_top_m",
    "cut_in": "cut_in_m_s",
    "rated_speed": "rated_speed_m_s",
    "cut_out": "cut_out_m_s",
    "max_rpm": "max_rpm",
    "thrust_coefficient": "thrust_coefficient",
    "damping": "damping_n_s_m",
    "controller_time": "controller_time_s",
    "air_density": "air_density_kg_m3",
    "tower_diameter": "tower_diameter_m",
    "tower_distance": "tower_distance_m",
}
#: What it calls the fields that rotor and wind refuse.
FIELDS = {f"rotor.{name}": f"wind.thrust.rotor.{given}" for name, given in ROTOR.items()} | {
    "wind.speed": "wind.thrust.speed_m_s"
}


@dataclass(frozen=True)
class TowerTopLoad:
    """The wrench of a whole record, or that it comes sample by sample.

    Attributes
    ----------
    wrench : float array [sample, 6], optional
        Forces in N and moments in N m on the tower-top node, global axes, at the load step; None where a
        topic brings it.
    dashpots : float array [direction, 6]
        Damping that belongs to the load, as roots of its coefficients.
    notes : tuple of str
        What the load lacks.
    blade_passing_hz : float
        Frequency in Hz at which blades pass the tower; 0 of a load that is not a rotor's.
    """

    wrench: Float[np.ndarray, "sample 6"] | None
    dashpots: Float[np.ndarray, "direction 6"] = field(default_factory=lambda: np.zeros((0, 6)))
    notes: tuple[str, ...] = ()
    blade_passing_hz: float = 0.0

    def block(self, load: LoadBlock) -> WrenchBlock:
        """Samples that go with a block of wave loads.

        Raises
        ------
        ComputationError
            If the record does not have them.
        """
        end = load.start + len(load.nodal)
        if self.wrench is None or end > len(self.wrench):
            held = 0 if self.wrench is None else len(self.wrench)
            raise ComputationError(
                f"tower-top load: samples {load.start} to {end} asked for, the record has {held}"
            )
        return beside(load, self.wrench[load.start : end])


def beside(load: LoadBlock, wrench: Float[np.ndarray, "sample 6"]) -> WrenchBlock:
    """Block of tower-top loads at the times of a block of wave loads."""
    return WrenchBlock(
        sequence=load.sequence,
        start=load.start,
        dt=load.dt,
        last=load.last,
        wrench=np.ascontiguousarray(wrench),
    )


def thrust_load(options: ThrustConfig, *, tower_top_z: float, dt: float, n: int) -> TowerTopLoad:
    """Thrust of a simple rotor and its aerodynamic damping.

    The motion of the hub along the wind meets the damping c of the rotor: C = c d d', d the force and moment
    at the tower top of a unit thrust at the hub.

    Parameters
    ----------
    options : ThrustConfig
        Wind and rotor.
    tower_top_z : float
        Level of the tower top above still water in m; the hub is `hub_above_top_m` higher.
    dt, n : float, int
        Load step in s and number of samples.

    Raises
    ------
    InputError
        As :func:`~owt_structure_node.core.rotor_thrust.rotor_thrust`, in the words of the case.
    """
    wind = Wind(
        speed=options.speed_m_s,
        turbulence=options.turbulence
        if options.turbulence_intensity is None
        else options.turbulence_intensity,
        direction_deg=options.direction_deg,
        shear_exponent=options.shear_exponent,
        seed=options.seed,
    )
    try:
        given = {name: getattr(options.rotor, key) for name, key in ROTOR.items()}
        rotor = Rotor(hub_height=tower_top_z + options.rotor.hub_above_top_m, **given)
        found = rotor_thrust(rotor, wind, dt=dt, n=n)
    except InputError as error:
        field, value = FIELDS.get(error.field, error.field), error.value
        raise InputError(field, value, error.limit, error.remedy) from None
    unit = tower_top_wrench(np.ones(1), direction_deg=wind.direction_deg, hub_above_top=rotor.hub_above_top)
    damped = options.aerodynamic_damping and found.damping > 0.0
    dashpots = np.sqrt(found.damping) * unit if damped else np.zeros((0, 6))
    return TowerTopLoad(found.wrench, dashpots, found.notes, BLADES * found.rotor_frequency)


def turned(wrench: Float[np.ndarray, "sample 6"], direction_deg: float) -> Float[np.ndarray, "sample 6"]:
    """Wrench in global axes of one whose x axis has a direction, from +x towards +y; z is up in both."""
    angle = np.deg2rad(direction_deg)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    return np.asarray((wrench.reshape(-1, 2, 3) @ turn.T).reshape(-1, 6))


class WrenchSamples:
    """Wrenches that arrive one by one, read out on the grid of the load samples.

    Parameters
    ----------
    hold : bool
        Take the value of the last message before a time; else interpolate linearly.
    """

    def __init__(self, *, hold: bool) -> None:
        self._hold = hold
        self._time: deque[int] = deque()
        self._wrench: deque[Float[np.ndarray, " 6"]] = deque()

    def add(self, time_ns: int, wrench: Float[np.ndarray, " 6"]) -> None:
        """Take the next message, stamped in simulated time.

        Raises
        ------
        ComputationError
            If it is not later than the one before, or not finite.
        """
        if not np.isfinite(wrench).all():
            raise ComputationError(f"tower-top wrench at {_seconds(time_ns)} holds NaN or inf")
        if self._time and time_ns <= self._time[-1]:
            raise ComputationError(
                f"tower-top wrench at {_seconds(time_ns)} comes after that of {_seconds(self._time[-1])}: "
                "stamps must increase"
            )
        self._time.append(time_ns)
        self._wrench.append(wrench)

    def reach(self, load: LoadBlock) -> bool:
        """Tell whether the wrench is known up to the last sample of a block."""
        last = sample_time_ns(load.start + len(load.nodal) - 1, load.dt)
        return bool(self._time) and self._time[-1] >= last

    def block(self, load: LoadBlock) -> WrenchBlock:
        """Samples that go with a block of wave loads that is reached; messages before it are forgotten.

        Raises
        ------
        ComputationError
            If the first message is later than the first sample, or the block is not reached.
        """
        time_ns = [sample_time_ns(load.start + i, load.dt) for i in range(len(load.nodal))]
        if not self.reach(load) or self._time[0] > time_ns[0]:
            known = f"{_seconds(self._time[0])} to {_seconds(self._time[-1])}" if self._time else "nothing"
            raise ComputationError(
                f"tower-top wrench: asked for {_seconds(time_ns[0])} to {_seconds(time_ns[-1])}, known is "
                f"{known}; its first message must be stamped 0"
            )
        needed = 1 + next(i for i, time in enumerate(self._time) if time >= time_ns[-1])
        known_time = np.fromiter(islice(self._time, needed), np.int64, needed)
        value, times = np.array(list(islice(self._wrench, needed))), np.array(time_ns, dtype=np.int64)
        before = np.searchsorted(known_time, times, side="right") - 1
        found = value[before]
        if not self._hold:
            after = np.minimum(before + 1, len(value) - 1)
            span = np.maximum(known_time[after] - known_time[before], 1)
            part = (times - known_time[before]) / span
            found = found + part[:, None] * (value[after] - found)
        for _ in range(int(before[-1])):  # what comes next lies after the last time
            self._time.popleft()
            self._wrench.popleft()
        return beside(load, found)


def _seconds(time_ns: int) -> str:
    return f"{time_ns * 1e-9:.9g} s"
