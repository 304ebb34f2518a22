"""``owt loads``: wave loads on a jacket."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from owt_bringup.output import NpzFile
    from owt_wave_node.core.loads import LoadWindows

HELP = "Morison loads of a case on its jacket: total force and moment, nodal loads"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("case", type=Path, metavar="CASE.json", help="case file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.npz", help="file to write")


#: Samples of nodal loads that are written at a time.
ROWS = 256


def run(options: argparse.Namespace) -> int:
    """Compute and write t, force, moment, nodal and where the nodes are, window by window."""
    from owt_bringup.output import npz_file
    from owt_bringup.sea_notes import load_resolved_case, print_notes
    from owt_model.mesh import build_mesh
    from owt_model.structure import case_structure

    case = load_resolved_case(options.case)  # before the costly imports: bad input is refused at once
    mesh = build_mesh(case_structure(case.structure))
    from owt_wave_node.core.loads import prepare_loads
    from owt_wave_node.core.route import make_field
    from owt_wave_node.core.sea import build_sea_state

    sea = build_sea_state(case)
    windows = replace(prepare_loads(case, mesh, sea, make_field(case, sea)), keep_ends=False)
    with npz_file(options.output) as file:
        _write(file, windows)
    print_notes(case, "loads", mesh, error_estimate=windows.error_estimate)
    return 0


def _write(file: NpzFile, windows: LoadWindows) -> None:
    """Write the arrays; the resultants of all windows are kept until the nodal loads are through."""
    import numpy as np

    from owt_model.parallel import slices
    from owt_wave_node.core.loads import nodal_rows, resultant

    mesh, n = windows.hydro.mesh, windows.field.n
    total = []
    with file.rows("nodal", (n, mesh.n_nodes, 6), np.dtype(float)) as write:
        for i in range(len(windows)):
            history = windows.window(i)
            total.append(resultant(history))
            for rows in slices(len(total[-1]), ROWS):
                write(nodal_rows(history, rows))
            del history  # before the next window is computed
    resultants = np.concatenate(total)
    file.add("t", np.arange(n) * windows.case.time.dt_s)
    file.add("force", resultants[:, :3])
    file.add("moment", resultants[:, 3:])
    file.add("error_estimate", np.array(windows.error_estimate))
    file.add("node_position_m", mesh.node_position)
    file.add("node_name", np.array(mesh.node_name))
    if windows.case.morison.buoyancy:
        from owt_wave_node.core.buoyancy import buoyancy

        file.add("buoyancy", buoyancy(windows.case, mesh))
