"""The frozen data that crosses stages: sea state, elevation, loads, response, stress, energy, fatigue.

A block holds consecutive samples of one stream: time axis first, C order, float64, SI units.
``sequence`` counts blocks from 0, ``start`` is the index of the first sample in the stream, whose
time is ``start * dt``; the block marked ``last`` ends the stream.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.timing import sample_time_ns

__all__ = [
    "END_FORCE",
    "Block",
    "ElevationBlock",
    "EnergyBlock",
    "FatigueBlock",
    "LoadBasis",
    "LoadBlock",
    "LoadRows",
    "MeasuredBlock",
    "ModalBlock",
    "ReducedDescription",
    "SeaState",
    "StressBlock",
    "WrenchBlock",
    "sea_facts",
]


@dataclass(frozen=True)
class SeaState:
    """First-order components of a sea and the water they travel on.

    eta1 = sum a cos(omega t - k (x cos b + y sin b) - phase), b the direction each component travels to;
    ``direction_deg`` is the heading of them all, and ``source`` the key of the case that gave the sea.
    ``hs_m``, ``tp_s`` and ``gamma`` are zero for a sea given by its components.
    """

    omega_rad_s: Float[np.ndarray, " component"]
    amplitude_m: Float[np.ndarray, " component"]
    phase_rad: Float[np.ndarray, " component"]
    wavenumber_rad_m: Float[np.ndarray, " component"]
    component_direction_deg: Float[np.ndarray, " component"]
    direction_deg: float
    water_depth_m: float
    gravity_m_s2: float
    density_kg_m3: float
    order: int
    stretching: str
    dt_s: float
    n: int
    hs_m: float = 0.0
    tp_s: float = 0.0
    gamma: float = 0.0
    seed: int = 0
    cutoff_rad_s: float = 0.0
    source: str = "sea_state"

    @property
    def duration_s(self) -> float:
        """Length n dt of the record in s."""
        return self.n * self.dt_s


def sea_facts(sea: Any) -> dict[str, Any]:
    """Scalars of a sea state, or of its message, that a report shows.

    What only a spectrum has (Hs, Tp, gamma, seed) is None for a sea given otherwise, and so is the gamma of a
    spectrum without peak enhancement.
    """
    names = ("direction_deg", "order", "stretching", "cutoff_rad_s", "water_depth_m", "duration_s")
    spectral = ("hs_m", "tp_s", "gamma", "seed")
    listed = not sea.hs_m > 0.0
    facts = {name: None if listed else getattr(sea, name) for name in spectral}
    facts |= {name: getattr(sea, name) for name in names}
    if facts["gamma"] == 0.0:
        facts["gamma"] = None
    return facts


@dataclass(frozen=True)
class Block:
    """What every block of samples carries."""

    sequence: int
    start: int
    dt: float
    last: bool

    @property
    def time_ns(self) -> int:
        """Simulated time of the first sample in ns, exact to the ns."""
        return sample_time_ns(self.start, self.dt)


@dataclass(frozen=True)
class ElevationBlock(Block):
    """Surface elevation in m at the gauge points."""

    gauge: Float[np.ndarray, "gauge 2"]
    first_order: Float[np.ndarray, "sample gauge"]
    total: Float[np.ndarray, "sample gauge"]


@dataclass(frozen=True)
class LoadBlock(Block):
    """Wave loads on the mesh: forces in N, moments in N m.

    Attributes
    ----------
    node : int array [loaded]
        Mesh nodes that any load can reach; all others carry none.
    element : int array [fixed]
        Loaded elements at member ends: those whose fixed-end forces stress recovery needs.
    nodal : float array [sample, loaded, 6]
        Consistent nodal forces and moments, global axes.
    fixed_end : float array [sample, fixed, 12]
        Fixed-end forces in element axes: what a fully clamped element exerts on the loads' behalf,
        i.e. minus the equivalent nodal loads of the element.
    """

    model_hash: str
    node: Int[np.ndarray, " loaded"]
    element: Int[np.ndarray, " fixed"]
    nodal: Float[np.ndarray, "sample loaded 6"]
    fixed_end: Float[np.ndarray, "sample fixed 12"]


#: Where the equivalent nodal loads of an element lie among its twelve end forces: Fy1, Mz1, Fy2, Mz2, Fz1,
#: My1, Fz2, My2 and, where there are loads along it, Fx1, Fx2.
END_FORCE = (1, 5, 7, 11, 2, 4, 8, 10, 0, 6)


@dataclass(frozen=True)
class LoadRows:
    """Wave loads of consecutive samples in one process, one row per channel and time last: no block to send.

    Attributes
    ----------
    start : int
        Index of the first sample in the record, whose time is ``start * dt``.
    node, element : int arrays [loaded], [fixed]
        As in :class:`LoadBlock`.
    nodal : float array [loaded, 6, sample]
        Consistent nodal forces in N and moments in N m, global axes.
    end_rows : float array [fixed, row, sample]
        Equivalent nodal loads of the elements at member ends, in element axes, in the order of
        :data:`END_FORCE`: minus the fixed-end forces.
    """

    start: int
    dt: float
    node: Int[np.ndarray, " loaded"]
    element: Int[np.ndarray, " fixed"]
    nodal: Float[np.ndarray, "loaded 6 sample"]
    end_rows: Float[np.ndarray, "fixed row sample"]


@dataclass(frozen=True)
class WrenchBlock(Block):
    """Force in N and moment in N m on the tower-top node, global axes, at the load step.

    ``filled`` marks the samples that no message gave; it is empty where the load does not come by messages.
    """

    wrench: Float[np.ndarray, "sample 6"]
    filled: Bool[np.ndarray, " filled"] = field(default_factory=lambda: np.zeros(0, dtype=bool))


@dataclass(frozen=True)
class MeasuredBlock(Block):
    """Measured elevation in m at the load step; ``filled`` marks the samples that no message gave."""

    elevation: Float[np.ndarray, " sample"]
    filled: Bool[np.ndarray, " sample"]


@dataclass(frozen=True)
class LoadBasis:
    """Proper orthogonal decomposition of a load history (thesis appendix E).

    Attributes
    ----------
    vectors : float array [vector, loaded, 6]
        Orthonormal spatial load vectors, the most energetic first.
    singular_values : float array [vector]
        Singular values of the snapshot matrix whose mean is removed; POV = sigma^2 / snapshots.
    total_variance : float
        Sum of the squares of all singular values, those of the vectors left out included.
    mean : float array [loaded, 6]
        Mean load, which the snapshots leave out.
    damping : float array [loaded, 3, 3] or [0, 3, 3]
        Damping in N s/m of the nodes' translations by the drag on their own motion; empty where the case
        leaves that out.
    spectrum : float array [vector, band] or [0, 0]
        Variance of each vector's amplitude in equal bands from 0 to half the sampling frequency; their sum
        over the bands is the POV. Empty where it is not known.
    highest_frequency : float
        Below it lies all but a thousandth of the variance of the loads, in cycles per sample; 0 where it is
        not known.
    """

    model_hash: str
    node: Int[np.ndarray, " loaded"]
    vectors: Float[np.ndarray, "vector loaded 6"]
    singular_values: Float[np.ndarray, " vector"]
    total_variance: float
    mean: Float[np.ndarray, "loaded 6"]
    snapshots: int
    damping: Float[np.ndarray, "damped 3 3"] = field(default_factory=lambda: np.zeros((0, 3, 3)))
    spectrum: Float[np.ndarray, "shape band"] = field(default_factory=lambda: np.zeros((0, 0)))
    highest_frequency: float = 0.0

    @property
    def pov(self) -> Float[np.ndarray, " vector"]:
        """Proper orthogonal values sigma^2 / snapshots [eq. E.7]: variance that each vector carries."""
        return np.asarray(self.singular_values**2 / self.snapshots)

    @property
    def variance_fraction(self) -> float:
        """Share of the variance of the loads that the kept vectors carry; zero without vectors."""
        return float((self.singular_values**2).sum()) / self.total_variance if len(self.vectors) else 0.0


@dataclass(frozen=True)
class ReducedDescription:
    """Names and frequencies of the assembled reduced model, in the order of its arrays.

    ``substructure_name`` are the parts that the energies are given for. ``end_usage`` is the standard
    deviation in Pa of the normal stress that the load basis lets expect at each end; empty where not known.

    ``reduction`` is the basis in use, where the case leaves the choice (``auto``) too; ``notes`` say what it
    has less than was asked for, and what is known of its error.
    """

    model_name: str
    model_hash: str
    reduction: str
    coordinate_name: tuple[str, ...]
    frequency_hz: Float[np.ndarray, " mode"]
    damping_ratio: Float[np.ndarray, " mode"]
    end_name: tuple[str, ...]
    tower_top_coordinate: int
    notes: tuple[str, ...] = ()
    substructure_name: tuple[str, ...] = ()
    end_usage: Float[np.ndarray, " end"] = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class ModalBlock(Block):
    """Generalised displacements, velocities and accelerations of the assembled reduced model.

    Read from a bag that leaves them out, velocity and acceleration have no columns.
    """

    displacement: Float[np.ndarray, "sample coordinate"]
    velocity: Float[np.ndarray, "sample velocity"]
    acceleration: Float[np.ndarray, "sample acceleration"]


@dataclass(frozen=True)
class StressBlock(Block):
    """Stress in Pa at the member ends, in the order of :attr:`Mesh.end_name`.

    ``axial`` is positive in tension. The signed normal stress at the angle theta round the section,
    from element axis y towards z, is axial + bending_y sin(theta) + bending_z cos(theta); the sign of
    either bending stress is that of the normal stress which it causes at its extreme fibre (+z, +y).
    ``von_mises`` is eq. 4.79 and unsigned.
    """

    axial: Float[np.ndarray, "sample end"]
    bending_y: Float[np.ndarray, "sample end"]
    bending_z: Float[np.ndarray, "sample end"]
    von_mises: Float[np.ndarray, "sample end"]


@dataclass(frozen=True)
class EnergyBlock(Block):
    """Potential and kinetic energy in J: total, per mode of the assembled reduced model, per substructure.

    Modes may be fewer than the model has; the substructures add up to the total.
    """

    potential: Float[np.ndarray, " sample"]
    kinetic: Float[np.ndarray, " sample"]
    potential_mode: Float[np.ndarray, "sample mode"]
    kinetic_mode: Float[np.ndarray, "sample mode"]
    potential_substructure: Float[np.ndarray, "sample part"]
    kinetic_substructure: Float[np.ndarray, "sample part"]


@dataclass(frozen=True)
class FatigueBlock(Block):
    """Running rainflow results per member end, over all samples counted so far.

    Attributes
    ----------
    cycles : float array [end]
        Cycles counted at the hot spot of largest damage, the residue as half cycles.
    damage : float array [end]
        Palmgren-Miner sum, the largest of the end's hot spots.
    total_stress : float array [end]
        Sum of range times count of the von Mises stress in Pa, the thesis' measure (chapter 5).
    max_range : float array [end]
        Largest range in Pa of the signed stress of the end's hot spots.
    side : int array [end]
        Of the hot spot of largest damage: 0 wall, 1 chord, 2 brace; none of an older recording.
    angle_deg : float array [end]
        Of the same hot spot.
    """

    samples_counted: int
    sn_curve: str
    cycles: Float[np.ndarray, " end"]
    damage: Float[np.ndarray, " end"]
    total_stress: Float[np.ndarray, " end"]
    max_range: Float[np.ndarray, " end"]
    side: Int[np.ndarray, " known"]
    angle_deg: Float[np.ndarray, " known"]
