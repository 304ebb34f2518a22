"""``owt eigen``: frequencies, damping, masses."""

from __future__ import annotations

import argparse
import json

HELP = "eigenfrequencies, damping, mass and Guyan stiffness of a structure"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "--model", default="oc4", help="shipped structure, YAML file or SubDyn deck (default oc4)"
    )
    parser.add_argument("--reduction", default=None, help="CBnn: also the frequencies of the reduced model")
    parser.add_argument("--modes", type=int, default=20, help="number of modes (default 20)")
    parser.add_argument(
        "--fixed-interface", action="store_true", help="clamp the interface: fixed-interface modes"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Print the report, as a table or as JSON."""
    from owt_model.structure import load_structure
    from owt_structure_node.core.eigen import eigen_report

    report = eigen_report(
        load_structure(options.model),
        reduction=options.reduction,
        n_modes=options.modes,
        fixed_interface=options.fixed_interface,
    )
    if options.json:
        print(json.dumps(report, allow_nan=False))
        return 0
    print(f"{report['model']}: {report['mass_kg'] / 1000:.1f} t")
    key = "fixed_interface_frequencies_hz" if options.fixed_interface else "frequencies_hz"
    print("mode  frequency [Hz]")
    for i, frequency in enumerate(report[key], 1):
        print(f"{i:4d}  {frequency:14.4f}")
    return 0
