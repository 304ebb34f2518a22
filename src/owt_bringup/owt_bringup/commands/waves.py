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
    """Compute and write elevation, kinematics and the estimated error."""
    from owt_bringup.output import write_npz
    from owt_bringup.sea_notes import load_resolved_case, print_notes

    case = load_resolved_case(options.case)  # before the costly imports: bad input is refused at once
    import numpy as np

    from owt_wave_node.core.kinematics import wave_kinematics

    result = wave_kinematics(case)
    names = ("t", "eta1", "eta2", "velocity", "acceleration", "velocity2", "acceleration2", "wet")
    arrays = {name: getattr(result, name) for name in names}
    write_npz(options.output, arrays | {"error_estimate": np.array(result.error_estimate)})
    print_notes(case, "waves", error_estimate=result.error_estimate)
    return 0
