"""What the commands say about the sea of a case on standard error: where it came from, and warnings."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from owt_model.config import CaseConfig, load_case

if TYPE_CHECKING:
    from owt_model.structure import Structure
    from owt_wave_node.sea_source import SourceReport

__all__ = ["load_reported_case", "load_resolved_case", "print_warnings"]


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


def print_warnings(case: CaseConfig, structure: Structure | None = None) -> None:
    """Print one line for each model that `case`, its sea resolved, uses outside its range."""
    from owt_wave_node.core.regime import regime_warnings
    from owt_wave_node.core.sea import build_sea_state

    for line in regime_warnings(case, build_sea_state(case), structure):
        print(f"warning: {line}", file=sys.stderr)
