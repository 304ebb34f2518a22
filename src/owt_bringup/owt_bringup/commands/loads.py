"""``owt loads``: wave loads on a jacket."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "Morison loads of a case on its jacket: total force and moment, nodal loads"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("case", type=Path, metavar="CASE.json", help="case file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.npz", help="file to write")


def run(options: argparse.Namespace) -> int:
    """Compute and write t, force, moment, nodal and where the nodes are."""
    import numpy as np

    from owt_bringup.output import write_npz
    from owt_bringup.sea_notes import load_resolved_case, print_warnings
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure

    case = load_resolved_case(options.case)  # before the costly imports: bad input is refused at once
    mesh = build_mesh(load_structure(case.structure.model))
    from owt_wave_node.core.loads import jacket_loads

    result = jacket_loads(case, mesh)
    arrays = {name: getattr(result, name) for name in ("t", "force", "moment")}
    arrays["nodal"] = result.nodal()
    arrays["node_position_m"] = mesh.node_position
    arrays["node_name"] = np.array(mesh.node_name)
    write_npz(options.output, arrays)
    print_warnings(case, mesh.structure)
    return 0
