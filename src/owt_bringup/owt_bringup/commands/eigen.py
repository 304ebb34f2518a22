"""``owt eigen``: frequencies, damping, masses."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING

from owt_model.errors import InputError

if TYPE_CHECKING:
    from owt_model.contracts import LoadBasis
    from owt_model.structure import Structure

HELP = "eigenfrequencies, damping, mass and Guyan stiffness of a structure"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "--model", default="oc4", help="shipped structure, YAML file or SubDyn deck (default oc4)"
    )
    parser.add_argument(
        "--reduction",
        help="reduce first: full, CBnn, CBnnMmm or Mmm (with orders jk, interface vectors Y, +SIM) or auto; "
        "MTA vectors take the second-order loads of Hs 8.25 m, Tp 11.5 s towards 210 degrees, seed 1",
    )
    parser.add_argument(
        "--tolerance", type=float, help="estimated error in energy that auto allows (default 0.001)"
    )
    parser.add_argument(
        "--sensitivity",
        choices=("reference", "damping", "damping-modal", "frequency"),
        metavar="NAME",
        help="as a model of thesis 5.3: reference, damping (tower-top dashpot), damping-modal (30 %% on two "
        "modes) or frequency (softer jacket)",
    )
    parser.add_argument("--modes", type=int, default=20, help="number of modes (default 20)")
    parser.add_argument("--fixed-interface", action="store_true", help="clamp the interface")
    parser.add_argument(
        "--static",
        action="store_true",
        help="count the geometric stiffness of all weights (P-delta), and show what it does",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Print the report, as a table or as JSON."""
    from owt_model.sensitivity import sensitivity_model
    from owt_model.structure import case_structure, with_weights
    from owt_model.structure_config import StructureConfig
    from owt_structure_node.core.eigen import eigen_report

    if options.fixed_interface and options.reduction:
        raise InputError(
            "reduction", options.reduction, "has no meaning with --fixed-interface", "Leave one of them out."
        )
    if options.fixed_interface and options.sensitivity in ("damping", "damping-modal"):
        raise InputError(
            "sensitivity",
            options.sensitivity,
            "damps modes of the turbine, not of the jacket with its interface held",
            "Leave one of the two out.",
        )
    if options.tolerance is not None and options.reduction != "auto":
        raise InputError("tolerance", options.tolerance, "is that of auto", "Give --reduction auto as well.")
    config = sensitivity_model(options.sensitivity or "reference", StructureConfig(model=options.model))
    structure = with_weights(case_structure(config)) if options.static else case_structure(config)
    report = eigen_report(
        structure,
        damping=config.damping,
        reduction=options.reduction,
        n_modes=options.modes,
        fixed_interface=options.fixed_interface,
        basis=_load_basis(structure, options.reduction),
        static=options.static,
        tolerance=0.001 if options.tolerance is None else options.tolerance,
    )
    for note in report["notes"]:
        print(f"note: {note}", file=sys.stderr)
    if options.json:
        print(json.dumps(report, allow_nan=False))
        return 0
    tonnes = report["mass_kg"] / 1000.0
    print(f"{report['model']}, {report['reduction']}: {tonnes:.1f} t of steel and lumped masses")
    for note in report["not_supported"]:
        print(f"not supported: {note}")
    state = report.get("static_state")
    if state is not None:
        factor = state["buckling_factor"]
        limit = "nothing buckles" if factor is None else f"buckling at {factor:.1f} times all weights"
        print(f"weight less buoyancy {state['weight_n'] / 1e6:.2f} MN, {limit}")
    print("mode  frequency [Hz]  log decrement [%]" + ("  by weights [%]" if state else ""))
    for i, (f, d) in enumerate(zip(report["frequencies_hz"], report["logdec_percent"], strict=True), 1):
        change = f"  {state['change_percent'][i - 1]:+14.3f}" if state else ""
        print(f"{i:4d}  {f:14.4f}  {'overdamped' if d is None else f'{d:.2f}':>17}{change}")
    return 0


def _load_basis(structure: Structure, reduction: str | None) -> LoadBasis | None:
    """Load vectors of a reduction that needs them."""
    from owt_structure_node.core.stage import n_mta

    vectors = n_mta(reduction) if reduction else 0
    if vectors == 0:
        return None
    from owt_campaign.standard_load import standard_load_basis

    return standard_load_basis(structure, vectors)
