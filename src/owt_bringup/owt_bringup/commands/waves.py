"""``owt waves``: elevation and kinematics at points."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "wave elevation and kinematics at the points of a case file"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("case", type=Path, metavar="CASE.json", help="case file with points_m")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.npz", help="file to write")


def run(options: argparse.Namespace) -> int:
    """Compute and write t, eta1, eta2, velocity, acceleration, velocity2, acceleration2 and wet."""
    from owt_bringup.output import write_npz
    from owt_bringup.sea_notes import load_resolved_case, print_warnings

    case = load_resolved_case(options.case)  # before the costly imports: bad input is refused at once
    from owt_wave_node.core.kinematics import wave_kinematics

    result = wave_kinematics(case)
    names = ("t", "eta1", "eta2", "velocity", "acceleration", "velocity2", "acceleration2", "wet")
    write_npz(options.output, {name: getattr(result, name) for name in names})
    print_warnings(case)
    return 0
