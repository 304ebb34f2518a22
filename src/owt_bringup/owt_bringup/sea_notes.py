"""What the commands say of a case on standard error: origin of the sea, options without effect, warnings."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from owt_model.config import CaseConfig, SeaStateConfig, Wave, load_case

if TYPE_CHECKING:
    from owt_model.mesh import Mesh
    from owt_model.structure import Structure
    from owt_wave_node.sea_source import SourceReport

__all__ = [
    "case_warnings",
    "ignored_options",
    "load_reported_case",
    "load_resolved_case",
    "print_notes",
    "print_warnings",
]


def load_resolved_case(path: Path) -> CaseConfig:
    """Read a case; a sea in a file becomes components, and one line says how well.

    Raises
    ------
    InputError, ComputationError
        See :func:`load_reported_case`.
    """
    return load_reported_case(path)[0]


def load_reported_case(path: Path) -> tuple[CaseConfig, SourceReport | None]:
    """Like :func:`load_resolved_case`, with the report of what was read; None without a file.

    Raises
    ------
    InputError
        If the case or the file of its sea is refused.
    ComputationError
        If the first order of a record is not found.
    """
    case = load_case(path)
    if case.spectrum_file is None and case.measured is None:
        return case, None
    from owt_wave_node.sea_source import resolve

    case, report = resolve(case)
    if report is not None:
        print(f"{report.kind}: {report.line}", file=sys.stderr)
    return case, report


def ignored_options(case: CaseConfig, command: str, mesh: Mesh | None = None) -> tuple[str, ...]:
    """One line for each option of `case` that is set and changes nothing in what `command` writes.

    Parameters
    ----------
    command : str
        "waves", "loads" or "simulate".
    mesh : Mesh, optional
        Of the structure, whose free ends are looked for.
    """
    lines, morison, sea = [], case.morison, case.sea_state
    if case.regular is not None and case.regular.theory != "airy":
        options = ("order", "stretching", "route")
        unused = [f"wave.{name}" for name in options if getattr(case.wave, name) != _default(name)]
        if unused:
            lines.append(
                f"{', '.join(unused)} without effect: a {case.regular.theory} wave needs no such option"
            )
    if (
        sea is not None
        and sea.cutoff == "steepness"
        and sea.cutoff_over_peak != SeaStateConfig.model_fields["cutoff_over_peak"].default
    ):
        lines.append("sea_state.cutoff_over_peak without effect: sea_state.cutoff is steepness")
    if command == "loads" and morison.hydrodynamic_damping:
        lines.append("morison.hydrodynamic_damping without effect on loads: it damps the motion of simulate")
    structure = case.structure
    if structure.reduction != "auto" and "tolerance" in structure.model_fields_set:
        lines.append("structure.tolerance without effect: it is that of the reduction auto")
    if structure.static_state is not None and not structure.static_state.p_delta:
        lines.append("structure.static_state without effect: p_delta is false")
    if case.live is not None and command != "simulate":
        lines.append(f"live without effect on {command}: the waves are those of sea_state, the expected sea")
    if command == "loads" and case.wind is not None:
        lines.append("wind without effect on loads: it acts at the tower top, in simulate and demo")
    if command == "simulate" and morison.buoyancy:
        lines.append("morison.buoyancy without effect on simulate: it is a static load that loads writes")
    if mesh is not None and (morison.end_cd > 0.0 or morison.end_ca > 0.0):
        from owt_wave_node.core.ends import free_ends

        if not free_ends(mesh):
            lines.append(f"morison.end_cd and end_ca without effect: {mesh.structure.name} has no free end")
    return tuple(lines)


def _default(name: str) -> object:
    """Default of an option of `wave`."""
    return Wave.model_fields[name].default


def print_notes(
    case: CaseConfig, command: str, mesh: Mesh | None = None, *, error_estimate: float = 0.0
) -> None:
    """Print what a user of the results must know: compression, options without effect, warnings.

    Parameters
    ----------
    command : str
        See :func:`ignored_options`.
    mesh : Mesh, optional
        Of the structure, where the command needs one.
    error_estimate : float
        Of the second order relative to its standard deviation; zero where all pairs were summed.
    """
    if error_estimate > 0.0:
        print(f"note: waves compressed, estimated error {error_estimate:.1g}", file=sys.stderr)
    for line in ignored_options(case, command, mesh):
        print(f"note: {line}", file=sys.stderr)
    print_warnings(case, None if mesh is None else mesh.structure)


def print_warnings(case: CaseConfig, structure: Structure | None = None) -> None:
    """Print what :func:`case_warnings` says."""
    for line in case_warnings(case, structure):
        print(f"warning: {line}", file=sys.stderr)


def case_warnings(case: CaseConfig, structure: Structure | None = None) -> list[str]:
    """One line for each model that `case`, its sea resolved, uses outside its range."""
    from owt_wave_node.core.regime import regime_warnings
    from owt_wave_node.core.sea import build_sea_state

    return list(regime_warnings(case, build_sea_state(case), structure))
