"""Wrench at the tower top on the grid of the load samples, and the damping that comes with it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBlock, WrenchBlock
from owt_model.errors import ComputationError, InputError
from owt_model.live_samples import LiveRules, SampleBuffer
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
        return beside(load, self.samples(load.start, load.start + len(load.nodal)))

    def samples(self, start: int, end: int) -> Float[np.ndarray, "sample 6"]:
        """Samples `start` to `end` - 1 of the record.

        Raises
        ------
        ComputationError
            If the record does not have them.
        """
        if self.wrench is None or end > len(self.wrench):
            held = 0 if self.wrench is None else len(self.wrench)
            raise ComputationError(
                f"tower-top load: samples {start} to {end} asked for, the record has {held}"
            )
        return self.wrench[start:end]


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
    rules : LiveRules
        What is done between messages, and without them.
    """

    def __init__(self, rules: LiveRules) -> None:
        self.buffer = SampleBuffer("tower-top wrench", 6, rules)

    def add(self, time_ns: int, wrench: Float[np.ndarray, " 6"]) -> None:
        """Take a message, stamped in simulated time, in any order.

        Raises
        ------
        ComputationError
            See :meth:`~owt_model.live_samples.SampleBuffer.add`.
        """
        self.buffer.add(time_ns, wrench)

    def reach(self, load: LoadBlock) -> bool:
        """Tell whether the wrench is known up to the last sample of a block."""
        return self.buffer.reach(sample_time_ns(load.start + len(load.nodal) - 1, load.dt))

    def block(self, load: LoadBlock, *, forced: bool = False) -> WrenchBlock:
        """Samples that go with a block of wave loads; messages before it are forgotten.

        Parameters
        ----------
        load : LoadBlock
            The block.
        forced : bool
            Go on although it is not reached; what has not come is missing.

        Raises
        ------
        ComputationError
            If a sample is missing and that is an error, or the block is not reached.
        """
        times = np.array([sample_time_ns(load.start + i, load.dt) for i in range(len(load.nodal))])
        wrench, filled = self.buffer.take(times, forced=forced)
        return replace(beside(load, wrench), filled=filled)
