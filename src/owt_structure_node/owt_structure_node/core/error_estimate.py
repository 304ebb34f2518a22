"""Error of a reduced model under given loads, before it is integrated.

Static part, of the mean potential energy: the static residual of the loads 1 - E[f' K_r^-1 f]/E[f' K^-1 f]
with the second moments of the loads (mean and proper orthogonal values) instead of one history, and with the
energy of the denominator at its dynamic value, which the low modes set. Dynamic part: what left-out functions
lack in inertia, and the shift of the low modes' frequencies, which moves their resonance. Member forces: the
displacement that the basis leaves out, under loads and interface accelerations, recovered at member ends.

The amplitudes of the load vectors are taken as uncorrelated at every frequency, not only on the whole.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve
from scipy.sparse import csc_array

from owt_model.contracts import LoadBasis
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import Assembly
from owt_structure_node.core.damping import all_vectors, modal_damping
from owt_structure_node.core.modes import dense_modes, lowest_modes
from owt_structure_node.core.recovery import end_force_map, end_sections
from owt_structure_node.core.reduction import Reduction, guyan, interface_loads, load_vectors

__all__ = ["ErrorEstimate", "ErrorModel"]

#: Low modes of the whole structure whose dynamic response is counted.
LOW_MODES = 6
#: Frequencies per band of the spectra at which the response of the low modes is evaluated.
PER_BAND = 64
#: Member ends whose stress has less than this share of the largest standard deviation do not count.
RELEVANT = 0.01


@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated relative errors of a basis.

    Attributes
    ----------
    static, dynamic : float
        Parts of the error in mean potential energy.
    member_force : float
        Standard deviation of the error in normal force and bending moments, as stress, over that of the
        forces themselves: the largest of all member ends.
    member_end : str
        Where that is.
    """

    static: float
    dynamic: float
    member_force: float
    member_end: str

    @property
    def energy(self) -> float:
        """Error in mean potential energy."""
        return self.static + self.dynamic


class ErrorModel:
    """What the estimates of all bases share: static responses, moments of the loads, low modes.

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    basis : LoadBasis
        Shapes, variances and spectra of the loads.
    damping : Damping
        Of the structure.
    dt : float
        Time step of the loads in s.
    tower_top : float array [more, 6], optional
        Further dashpots at the tower top, as roots of their coefficients.

    Raises
    ------
    InputError, ComputationError
        As :func:`owt_structure_node.core.reduction.load_vectors` and the eigenvalue solution.
    """

    def __init__(
        self,
        assembly: Assembly,
        basis: LoadBasis,
        *,
        damping: Damping,
        dt: float,
        tower_top: Float[np.ndarray, "more 6"] | None = None,
    ) -> None:
        n = assembly.internal
        self.assembly = assembly
        self.stiffness = csc_array(assembly.jacket_stiffness[:n, :n])
        self.mass = csc_array(assembly.jacket_mass[:n, :n])
        self.guyan = guyan(assembly)
        every = replace(  # the mean load as one more vector, the last
            basis,
            vectors=np.concatenate([basis.vectors, basis.mean[None]]),
            singular_values=np.append(basis.singular_values, 0.0),
        )
        loads = load_vectors(assembly, every)
        self.inside = loads[:n]
        self.static = self.guyan.factor.solve(self.inside)
        self.inertia = np.asarray(self.mass @ self.static)
        self.quasi = self.guyan.factor.solve(self.inertia)
        y = interface_loads(assembly, self.guyan)
        self.y, self.y_static = y, self.guyan.factor.solve(y)
        self.end_name = assembly.mesh.end_name
        self._moments(basis, dt)
        self._energies(basis, loads)
        self.damping = damping.of_lowest(LOW_MODES)
        self.dashpots = all_vectors(assembly.mesh, damping, basis, tower_top) @ assembly.expansion
        self._low_modes(loads)
        self._reference_stress()

    def _moments(self, basis: LoadBasis, dt: float) -> None:
        """Variances of the amplitudes, of their rates and second rates; the mean load comes last."""
        self.variance = np.append(basis.pov, 1.0)
        self.spectrum, self.rate, self.acceleration = basis.spectrum, 0.0 * self.variance, 0.0 * self.variance
        bands = self.spectrum.shape[1]
        self.omega = np.zeros(0)
        if not bands:
            return
        centre = np.pi * (np.arange(bands) + 0.5) / bands / dt
        self.rate[:-1] = self.spectrum @ centre**2
        self.acceleration[:-1] = self.spectrum @ centre**4
        self.omega = np.pi * (np.arange(bands * PER_BAND) + 0.5) / (bands * PER_BAND) / dt

    def _energies(self, basis: LoadBasis, loads: Float[np.ndarray, "dof load"]) -> None:
        """Twice the static energy of each load vector: inside the jacket, interface held, and in all."""
        n, upper = self.assembly.internal, self.assembly.upper_stiffness
        self.own = np.einsum("dv,dv->v", self.inside, self.static)
        outer = loads[n:].copy()
        outer[:6] += self.guyan.constraint.T @ self.inside
        stiffness = upper[n:, n:].toarray()
        stiffness[:6, :6] += self.guyan.stiffness
        self.boundary = solve(stiffness, outer, assume_a="pos")
        # Twice the energy with the interface free to move.
        self.total = self.own + np.einsum("dv,dv->v", outer, self.boundary)
        # What the vectors left out of the basis do: their variance, at the compliance of the last ones kept.
        missing = max(basis.total_variance / basis.snapshots - float(basis.pov.sum()), 0.0)
        kept = len(basis.pov)
        last = self.own[max(0, kept - max(1, kept // 4)) : kept]
        self.tail = missing * float(last.mean()) if kept else 0.0

    def _low_modes(self, loads: Float[np.ndarray, "dof load"]) -> None:
        """Low modes of the structure, and the energy that they have beyond their static response."""
        assembly, n = self.assembly, self.assembly.internal
        count = min(LOW_MODES, assembly.mesh.n_dof)
        self.low_square, shapes = lowest_modes(assembly.stiffness, assembly.mass, count)
        self.loads, self.low_boundary = loads[:, :-1], shapes[n : n + 6]
        motion = self._amplitude(self.low_square, shapes, 0)
        self.low_swing = self._amplitude(self.low_square, shapes, 4).sum(axis=1)
        static = (shapes.T @ self.loads) ** 2 * self.variance[:-1] / self.low_square[:, None] ** 2
        # Half of it: the correlation of the amplitudes, not known, takes some away where waves are short.
        self.low_gain = 0.5 * np.maximum((motion - static).sum(axis=1), 0.0)
        self.low_energy = self.low_square @ motion
        self.energy = float(self.variance @ self.total) + float(self.low_square @ self.low_gain)
        self.low_shapes = shapes

    def _amplitude(
        self, square: Float[np.ndarray, " mode"], shapes: Float[np.ndarray, "dof mode"], power: int
    ) -> Float[np.ndarray, "mode load"]:
        """Variance of each mode's amplitude by each load vector, under omega to the `power` [s^-power]."""
        force = (shapes.T @ self.loads) ** 2
        if not len(self.omega):
            return np.asarray(0.0 * force)
        found = np.zeros_like(force)
        for i, (own, rate) in enumerate(zip(square, self._rate(square, shapes), strict=True)):
            response = self.omega**power / ((own - self.omega**2) ** 2 + (rate * self.omega) ** 2)
            found[i] = force[i] * (self.spectrum @ response.reshape(-1, PER_BAND).mean(axis=1))
        return np.asarray(found)

    def _rate(
        self, square: Float[np.ndarray, " mode"], shapes: Float[np.ndarray, "dof mode"]
    ) -> Float[np.ndarray, " mode"]:
        """2 zeta omega of low modes in 1/s; of dashpots what they do to each mode alone."""
        return modal_damping(square, self.damping, self.dashpots @ shapes).diagonal

    def _square(self, inside: Float[np.ndarray, "internal case"]) -> Float[np.ndarray, "case end"]:
        """Squares of :meth:`_stress` summed, of motion inside the jacket, interface held."""
        shapes = np.zeros((self.assembly.mesh.n_dof, inside.shape[1]))
        shapes[: len(inside)] = inside
        return np.asarray((self._stress(shapes) ** 2).sum(axis=-1))

    def _stress(self, shapes: Float[np.ndarray, "dof case"]) -> Float[np.ndarray, "case end 3"]:
        """Normal stress in Pa by normal force and by both moments at the member ends, from K_e u_e."""
        ends = end_sections(self.assembly.mesh)
        force = end_force_map(self.assembly, shapes)
        return np.asarray(force[:, :, [0, 4, 5]] * ends.factor[[0, 1, 1]].T)

    def _reference_stress(self) -> None:
        """Variance of the stress at the member ends: static, with the low modes at their dynamic value."""
        shapes = np.vstack([self.static + self.guyan.constraint @ self.boundary[:6], self.boundary])
        square = (self._stress(shapes)[:-1] ** 2).sum(axis=-1)
        low = (self._stress(self.low_shapes) ** 2).sum(axis=-1)
        self.stress_variance = self.variance[:-1] @ square + self.low_gain @ low

    def estimate(self, reduced: Reduction) -> ErrorEstimate:
        """Errors of a reduced model of the structure."""
        static, dynamic = self._energy_parts(reduced)
        worst, end = self._member_force(reduced)
        return ErrorEstimate(static, dynamic, worst, end)

    def energy_error(self, reduced: Reduction) -> float:
        """Error in mean potential energy alone, which costs less."""
        return sum(self._energy_parts(reduced))

    def _functions(self, reduced: Reduction) -> Float[np.ndarray, "internal function"]:
        """What the basis keeps inside the jacket, each of unit energy."""
        square = np.concatenate([reduced.fixed_interface, reduced.pseudo])
        inside = reduced.shapes[: self.assembly.internal, 6 : 6 + len(square)]
        return np.asarray(inside / np.sqrt(square))

    def _energy_parts(self, reduced: Reduction) -> tuple[float, float]:
        """Static and dynamic error in mean potential energy."""
        if not self.energy > 0.0:  # a flat sea
            return 0.0, 0.0
        functions = self._functions(reduced)
        share = functions.T @ self.inside
        seen = functions @ share
        if reduced.improvement is not None:
            static = 0.0
        else:
            residual = np.maximum(self.own - (share**2).sum(axis=0), 0.0)
            static = float(self.variance @ residual) + self.tail
        # Inertia left out, to second and fourth order in frequency.
        second = self._moment(self.static, self.mass) - self._moment(seen, self.mass)
        fourth = self._moment(self._lag(functions, seen), self.stiffness)
        dynamic = abs(float(self.rate @ second)) + 1.5 * float(self.acceleration @ fourth)
        return static / self.energy, (dynamic + self._resonance(reduced)) / self.energy

    def _lag(
        self, functions: Float[np.ndarray, "internal function"], seen: Float[np.ndarray, "internal load"]
    ) -> Float[np.ndarray, "internal load"]:
        """Response to the inertia of the static response that the basis does not follow."""
        return np.asarray(self.quasi - functions @ (functions.T @ (self.mass @ seen)))

    @staticmethod
    def _moment(shape: Float[np.ndarray, "internal case"], matrix: csc_array) -> Float[np.ndarray, " case"]:
        return np.asarray(np.einsum("dv,dv->v", shape, matrix @ shape))

    def _resonance(self, reduced: Reduction) -> float:
        """Energy of the low modes that frequencies and shapes of the reduced model change.

        Once under a spectrum that is smooth round the resonance, load by load, and once for the lines of one
        record: there the energy beyond the static one may change by shift / damping ratio.
        """
        square, modes = dense_modes(reduced.stiffness, reduced.mass)
        square, shapes = square[: len(self.low_square)], reduced.shapes @ modes[:, : len(self.low_square)]
        smooth = np.abs(square @ self._amplitude(square, shapes, 0) - self.low_energy).sum()
        full = self.low_square[: len(square)]
        ratio = self._rate(full, self.low_shapes[:, : len(full)]) / (2.0 * np.sqrt(full))
        shift = np.abs(np.sqrt(square / full) - 1.0)
        moved = np.minimum(np.divide(shift, ratio, out=np.sign(shift), where=ratio > 0.0), 1.0)
        return 0.5 * float(smooth) + float(full @ (self.low_gain[: len(full)] * moved))

    def _member_force(self, reduced: Reduction) -> tuple[float, str]:
        """Largest ratio of standard deviations, and its member end."""
        functions = self._functions(reduced)
        seen = functions @ (functions.T @ self.inside)
        variance = self.acceleration[:-1] @ self._square(self._lag(functions, seen)[:, :-1])
        if reduced.improvement is None:
            variance = variance + self.variance[:-1] @ self._square((self.static - seen)[:, :-1])
        left = (self.y_static - functions @ (functions.T @ self.y)) @ self.low_boundary
        variance = variance + self.low_swing @ self._square(left)
        relevant = self.stress_variance > RELEVANT**2 * self.stress_variance.max(initial=0.0)
        ratio = np.sqrt(variance[relevant] / self.stress_variance[relevant])
        if not len(ratio):
            return 0.0, ""
        worst = int(ratio.argmax())
        return float(ratio[worst]), self.end_name[int(np.flatnonzero(relevant)[worst])]
