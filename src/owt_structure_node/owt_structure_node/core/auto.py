"""The choice of ``auto``: the smallest basis whose estimated error in energy meets a tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.reduction_name import AUTO_MODES, AUTO_VECTORS, parse_reduction
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import Assembly
from owt_structure_node.core.error_estimate import ErrorEstimate, ErrorModel
from owt_structure_node.core.reduction import Interior, Reduction, reduce, solve_interior

__all__ = ["Choice", "Target", "auto_reduction", "candidates", "chosen_reduction", "spectral_note"]

#: How far beyond the highest frequency of the loads the modes of the jacket should reach (thesis 3.6.1).
REACH = 1.5


@dataclass(frozen=True)
class Target:
    """What a basis is chosen for.

    Attributes
    ----------
    tolerance : float
        Estimated relative error in mean potential energy that is allowed.
    damping : Damping
        Of the structure.
    dt : float
        Time step of the loads in s.
    tower_top : float array [more, 6], optional
        Further dashpots at the tower top, as roots of their coefficients.
    """

    tolerance: float
    damping: Damping
    dt: float
    tower_top: Float[np.ndarray, "more 6"] | None = None


@dataclass(frozen=True)
class Choice:
    """The basis that was chosen, what is expected of it, and that in words."""

    reduced: Reduction
    estimate: ErrorEstimate
    note: str


def candidates(modes: int, vectors: int) -> list[str]:
    """Names on the ladder of ``auto``, the smallest basis first, of equal ones that with more modes.

    Parameters
    ----------
    modes, vectors : int
        Fixed-interface modes and load vectors that there are.
    """
    pairs = [(m, v) for m in AUTO_MODES for v in AUTO_VECTORS if m <= modes and v <= vectors]
    pairs.sort(key=lambda pair: (sum(pair), -pair[0]))
    return [f"CB{m:02d}" + (f"M{v:02d}" if v else "") for m, v in pairs]


def auto_reduction(
    assembly: Assembly,
    basis: LoadBasis,
    target: Target,
) -> Choice:
    """Choose the smallest basis that meets the tolerance and reaches beyond the frequencies of the loads.

    Parameters
    ----------
    assembly : Assembly
        The unreduced structure.
    basis : LoadBasis
        As many load vectors as the ladder asks for, or as the loads have.
    target : Target
        Tolerance, damping and time step.

    Returns
    -------
    Choice
        Where no basis meets the tolerance the one of least estimated error, with a note that says so.

    Raises
    ------
    InputError, ComputationError
        As :func:`owt_structure_node.core.reduction.reduce`.
    """
    tolerance = target.tolerance
    if not 0.0 < tolerance < 1.0:
        raise InputError("structure.tolerance", tolerance, "must lie between 0 and 1", "Use 0.001.")
    model = ErrorModel(
        assembly,
        basis,
        damping=target.damping,
        dt=target.dt,
        tower_top=target.tower_top,
    )
    highest_hz = basis.highest_frequency / target.dt
    ladder = candidates(assembly.internal, len(basis.vectors))
    interior = solve_interior(assembly, min(AUTO_MODES[-1] + 1, assembly.internal))
    best: tuple[Reduction, float] | None = None
    for name in ladder:
        if spectral_note(assembly, name, highest_hz, interior) is not None:
            continue
        reduced = reduce(assembly, name, basis, interior=interior)
        error = model.energy_error(reduced)
        if best is None or error < best[1]:
            best = (reduced, error)
        if error <= tolerance:
            break
    if best is None:
        best = (reduce(assembly, ladder[-1], basis), np.inf)
    estimate = model.estimate(best[0])
    return Choice(best[0], estimate, _words(best[0].name, estimate, tolerance))


def _words(name: str, estimate: ErrorEstimate, tolerance: float) -> str:
    verdict = "meets" if estimate.energy <= tolerance else "is the best there is but does not meet"
    return (
        f"auto: {name} {verdict} tolerance {tolerance:g}: estimated error in energy {estimate.energy:.1e} "
        f"(static {estimate.static:.1e}, dynamic {estimate.dynamic:.1e}), in member force "
        f"{estimate.member_force:.1e} at worst ({estimate.member_end})"
    )


def spectral_note(
    assembly: Assembly, reduction: str, highest_hz: float, interior: Interior | None = None
) -> str | None:
    """Say that a basis stops below 1.5 times the highest frequency of the loads (thesis 3.6.1), if it does.

    The first fixed-interface mode that it leaves out decides. None too where that frequency is 0, not known.
    """
    kept = parse_reduction(reduction).fixed_interface_modes
    if highest_hz == 0.0 or kept >= assembly.internal:
        return None
    if interior is None:
        interior = solve_interior(assembly, kept + 1)
    left_out = float(np.sqrt(interior.omega_squared[kept])) / (2.0 * np.pi)
    if left_out >= REACH * highest_hz:
        return None
    return (
        f"{reduction} leaves out a mode of the jacket at {left_out:.2f} Hz, below {REACH} times the highest "
        f"frequency of the loads, {highest_hz:.2f} Hz: keep more fixed-interface modes"
    )


def chosen_reduction(
    assembly: Assembly,
    reduction: str,
    basis: LoadBasis | None,
    target: Target | None,
    interior: Interior | None = None,
) -> tuple[Reduction, tuple[str, ...]]:
    """Reduce as named, or as ``auto`` chooses for the target; and what is to be noted.

    `interior` is that of the structure, with one mode more than named, where it is known.

    Raises
    ------
    InputError, ComputationError
        As :func:`owt_structure_node.core.reduction.reduce`; also if ``auto`` has no loads or no target.
    """
    if reduction == "auto":
        if basis is None or target is None:
            raise InputError(
                "structure.reduction", reduction, "chooses a basis for given loads", "Give a load basis."
            )
        choice = auto_reduction(assembly, basis, target)
        return choice.reduced, (choice.note, *choice.reduced.notes)
    name = parse_reduction(reduction)
    if basis is None or target is None or name.fixed_interface_modes >= assembly.internal:
        reduced = reduce(assembly, reduction, basis, interior=interior)
        return reduced, reduced.notes
    if interior is None:
        interior = solve_interior(assembly, name.fixed_interface_modes + 1)
    reduced = reduce(assembly, reduction, basis, interior=interior)
    note = spectral_note(assembly, reduction, basis.highest_frequency / target.dt, interior)
    return reduced, reduced.notes if note is None else (*reduced.notes, note)
