"""What the commands say about the sea of a case on standard error: where it came from, and warnings."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from owt_model.config import CaseConfig, load_case

if TYPE_CHECKING:
    from owt_model.structure import Structure

__all__ = ["load_resolved_case", "print_warnings"]


def load_resolved_case(path: Path) -> CaseConfig:
    """Read a case; a sea in a file becomes components, and one line says how well.

    Raises
    ------
    InputError
        If the case or the file of its sea is refused.
    ComputationError
        If the first order of a record is not found.
    """
    case = load_case(path)
    if case.spectrum_file is None and case.measured is None:
        return case
    from owt_wave_node.sea_source import resolve

    case, report = resolve(case)
    if report is not None:
        print(f"note: {report.line}", file=sys.stderr)
    return case


def print_warnings(case: CaseConfig, structure: Structure | None = None) -> None:
    """Print one line for each model that `case`, its sea resolved, uses outside its range."""
    from owt_wave_node.core.regime import regime_warnings
    from owt_wave_node.core.sea import build_sea_state

    for line in regime_warnings(case, build_sea_state(case), structure):
        print(f"warning: {line}", file=sys.stderr)
