"""``owt superelement``: the reduced jacket with its loads as a file, and such a file under a tower."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from owt_model.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from jaxtyping import Float

    from owt_model.config import CaseConfig
    from owt_model.superelement import Superelement
    from owt_structure_node.core.assembly import Assembly
    from owt_structure_node.core.reduction import Reduction
    from owt_wave_node.core.stage import WaveStage

HELP = "reduced jacket and wave loads as a Flex5/ExtPtfm superelement file: export, show, run"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION", parser_class=type(parser))
    export = _action(actions, "export", "write the reduced jacket of a case and its wave loads")
    export.add_argument("case", type=Path, metavar="CASE.json", help="case file")
    export.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="file to write")
    export.add_argument(
        "--openfast5",
        type=Path,
        metavar="FORCES",
        help="write for OpenFAST 5, whose ExtPtfm takes the loads from this second file",
    )
    export.add_argument(
        "--elevation",
        action="store_true",
        help="add a last column, the elevation at the first gauge point, which not every reader takes",
    )
    show = _action(actions, "show", "dimension, masses, frequencies and record of a file")
    show.add_argument(
        "--tower", metavar="MODEL", help="also the frequencies under the tower of this structure"
    )
    show.add_argument("--json", action="store_true", help="print one JSON object")
    respond = _action(actions, "run", "motion under the loads of a file, with a tower on it")
    respond.add_argument(
        "--tower", metavar="MODEL", required=True, help="structure whose upper part is on it"
    )
    respond.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.npz", help="file to write")
    respond.add_argument("--dt", type=float, help="integration step in s (default: that of the loads)")
    for sub in (show, respond):
        sub.add_argument(
            "--static", action="store_true", help="count the geometric stiffness of the weights on the tower"
        )
        sub.add_argument("file", type=Path, metavar="FILE", help="superelement file, FlexASCII or GuyanASCII")
        sub.add_argument(
            "--forces", type=Path, metavar="FILE", help="file of loads that OpenFAST 5 has apart"
        )
    respond.add_argument("--alpha", type=float, help="Rayleigh coefficient of the upper part in 1/s ")
    respond.add_argument("--beta", type=float, help="and in s (default: those of the file)")


def _action(actions: Any, name: str, text: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(name, help=text, description=text)
    return parser


def run(options: argparse.Namespace) -> int:
    """Do what the action says."""
    return {"export": _export, "show": _show, "run": _respond}[options.action](options)


# --- export -------------------------------------------------------------------------------------------


def _export(options: argparse.Namespace) -> int:
    from owt_bringup.output import atomic_path
    from owt_bringup.sea_notes import load_resolved_case, print_notes
    from owt_model.superelement import extptfm_notes, write_openfast5, write_superelement

    case = load_resolved_case(options.case)
    _check_case(case)
    if options.openfast5 is not None and options.openfast5.absolute() == options.output.absolute():
        raise InputError("openfast5", str(options.openfast5), "is the output as well", "Give two names.")
    from owt_model.mesh import build_mesh
    from owt_model.structure import case_structure
    from owt_structure_node.core.assembly import assemble
    from owt_wave_node.core.stage import build_wave_stage

    mesh = build_mesh(case_structure(case.structure))
    stage = build_wave_stage(case, mesh)
    element, notes = _element(case, assemble(mesh), stage, elevation=options.elevation)
    if options.openfast5 is None:
        with atomic_path(options.output) as path, path.open("w", encoding="ascii") as stream:
            write_superelement(stream, element)
    else:
        with (
            atomic_path(options.output) as path,
            atomic_path(options.openfast5) as second,
            path.open("w", encoding="ascii") as stream,
            second.open("w", encoding="ascii") as forces,
        ):
            write_openfast5(stream, forces, element)
    for note in (*notes, *extptfm_notes(element)):
        print(f"note: {note}", file=sys.stderr)
    print_notes(case, "superelement", mesh)
    print(f"{options.output}: {element.n_dof} degrees of freedom, {len(element.loads)} samples of loads")
    return 0


def _check_case(case: CaseConfig) -> None:
    """Refuse what a superelement cannot carry, before anything is computed."""
    from owt_structure_node.core.superelement import check_reduction

    check_reduction(case.structure.reduction)
    if case.structure.damping.mode_ratio:
        raise InputError(
            "structure.damping.modes",
            case.structure.damping.modes,
            "are modes of jacket and tower together: no damping matrix of the jacket alone has them",
            "Leave them out, and give them in the tool that reads the file.",
        )


def _element(
    case: CaseConfig, assembly: Assembly, stage: WaveStage, *, elevation: bool
) -> tuple[Superelement, tuple[str, ...]]:
    """Reduce the jacket and project the loads of the record, block by block."""
    from owt_structure_node.core.auto import Target, chosen_reduction
    from owt_structure_node.core.damping import above_interface, all_vectors
    from owt_structure_node.core.stage import n_mta
    from owt_structure_node.core.superelement import jacket_superelement

    structure, mesh = case.structure, assembly.mesh
    basis = stage.load_basis(n_mta(structure.reduction))
    target = Target(structure.tolerance, structure.damping, case.time.dt_s)
    reduced, notes = chosen_reduction(assembly, structure.reduction, basis, target)
    alpha, beta = structure.damping.rayleigh
    dashpots = all_vectors(mesh, structure.damping, basis)
    on_tower, below = above_interface(mesh, dashpots)
    damped_tower, weighed = bool((on_tower & ~below).any()), mesh.structure.static_state is not None
    loads, surface = _loads(stage, assembly, reduced, elevation=elevation)
    place = ", ".join(f"{x:g}" for x in mesh.node_position[mesh.transition_piece])
    element = jacket_superelement(
        assembly,
        reduced,
        loads,
        dt=case.time.dt_s,
        alpha=alpha,
        beta=beta,
        dashpots=dashpots,
        elevation=surface,
        comments=(
            f"{mesh.structure.name} {mesh.structure.content_hash[:12]}, reduction {reduced.name}, SI units",
            f"Interface at ({place}) m: surge, sway, heave, roll, pitch, yaw; z up from still water",
            f"Damping alpha {alpha:g} 1/s, beta {beta:g} s{' and dashpots' if below.any() else ''}",
            "Transition piece and tower left out",
            "Loads of waves alone, without weight and buoyancy",
            *(("Stiffness with the geometric stiffness of all weights",) if weighed else ()),
            *(() if surface is None else ("Elevation at ({:g}, {:g}) m".format(*stage.gauge[0]),)),
        ),
    )
    return element, (*notes, *_left_out(case, damped_tower=damped_tower, weighed=weighed))


def _loads(
    stage: WaveStage, assembly: Assembly, reduced: Reduction, *, elevation: bool
) -> tuple[Float[np.ndarray, "sample dof"], Float[np.ndarray, " sample"] | None]:
    """Generalised loads of the record, and its elevation at the first gauge point."""
    import numpy as np

    from owt_bringup.output import ProgressBar
    from owt_structure_node.core.superelement import project_loads

    bar, loads, surface = ProgressBar("superelement"), [], []
    for i in range(stage.n_blocks):
        block = stage.load_block(i)
        loads.append(project_loads(assembly, reduced, block.node, block.nodal))
        if elevation:
            surface.append(stage.elevation_block(i).total[:, 0])
        bar.callback((block.start + len(block.nodal)) * block.dt, stage.sea_state.duration_s)
    bar.close()
    return np.concatenate(loads), np.concatenate(surface) if elevation else None


def _left_out(case: CaseConfig, *, damped_tower: bool, weighed: bool) -> tuple[str, ...]:
    """What the case asks for and the file does not hold, one line each."""
    structure, notes = case.structure, []
    if damped_tower:
        notes.append("dashpots at the tower top are not in the file: they damp the tower")
    if weighed:
        notes.append(
            "the jacket has the geometric stiffness of all weights: the tower that goes on it must count its "
            "own (run --static)"
        )
    if case.wind is not None:
        notes.append("wind is not in the file: load and damping of the rotor act on the tower")
    if structure.ramp_s > 0.0:
        notes.append("structure.ramp_s is not in the file: its loads start at once")
    if case.morison.buoyancy:
        notes.append("morison.buoyancy is not in the file: it is a static load that `owt loads` writes")
    return tuple(notes)


# --- what a file holds --------------------------------------------------------------------------------


def _read(options: argparse.Namespace) -> Superelement:
    """Read the file of the command line, and that of its loads."""
    from owt_model.superelement_file import parse_superelement

    text = options.file.read_text(encoding="utf-8", errors="replace")
    forces = None
    if options.forces is not None:
        forces = options.forces.read_text(encoding="utf-8", errors="replace"), str(options.forces)
    return parse_superelement(text, source=str(options.file), forces=forces)


def _tower(model: str, *, static: bool) -> Assembly:
    """Assemble the structure whose upper part goes on the file's jacket."""
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure, with_weights
    from owt_structure_node.core.assembly import assemble

    structure = load_structure(model)
    return assemble(build_mesh(with_weights(structure) if static else structure))


def _show(options: argparse.Namespace) -> int:
    from owt_model.superelement import extptfm_notes

    element = _read(options)
    report = _report(element, options.tower, static=options.static)
    if options.json:
        print(json.dumps(report, allow_nan=False))
        return 0
    for comment in element.comments:
        print(f"  {comment}")
    print(f"{element.n_dof} degrees of freedom, {element.n_dof - 6} of them inside")
    masses = ", ".join(f"{mass / 1e3:.1f}" for mass in report["interface_mass_kg"])
    print(f"mass that moves with the interface in x, y, z: {masses} t")
    damping = report["rayleigh"]
    print(
        "damping: "
        + (f"alpha {damping[0]:.4g} 1/s, beta {damping[1]:.4g} s" if damping else "not Rayleigh's")
    )
    record = f"{report['samples']} samples, {report['duration_s']:g} s in steps of {report['dt_s']:g} s"
    print(f"loads: {record if report['samples'] > 1 else 'none in this file (see --forces)'}")
    for key, title in (
        ("fixed_interface_frequencies_hz", "interface held"),
        ("frequencies_hz", "no tower"),
        ("tower_frequencies_hz", f"tower of {options.tower}"),
    ):
        if report.get(key):
            print(f"{title}: " + "  ".join(f"{f:.4f}" for f in report[key][:10]) + " Hz")
    for note in extptfm_notes(element):
        print(f"note: {note}", file=sys.stderr)
    return 0


def _report(element: Superelement, tower: str | None, *, static: bool) -> dict[str, Any]:
    """Figures of a superelement, plain numbers."""
    from owt_structure_node.core.superelement import attach, frequencies, rayleigh_coefficients

    try:
        rayleigh: list[float] | None = list(rayleigh_coefficients(element))
    except InputError:
        rayleigh = None
    report = {
        "dimension": element.n_dof,
        "comments": list(element.comments),
        "interface_mass_kg": element.mass.diagonal()[:3].tolist(),
        "interface_stiffness": element.stiffness[:6, :6].tolist(),
        "rayleigh": rayleigh,
        "samples": len(element.loads),
        "dt_s": element.dt,
        "duration_s": element.duration,
        "has_elevation": element.elevation is not None,
        "fixed_interface_frequencies_hz": frequencies(
            element.stiffness[6:, 6:], element.mass[6:, 6:]
        ).tolist(),
        "frequencies_hz": frequencies(element.stiffness, element.mass).tolist(),
    }
    if tower is not None:
        attached = attach(element, _tower(tower, static=static), alpha=0.0, beta=0.0)
        report["tower"] = tower
        report["tower_frequencies_hz"] = frequencies(attached.stiffness, attached.mass).tolist()
    return report


# --- response -----------------------------------------------------------------------------------------


def _respond(options: argparse.Namespace) -> int:
    import numpy as np

    from owt_bringup.output import write_npz
    from owt_structure_node.core.superelement import attach, rayleigh_coefficients
    from owt_structure_node.core.superelement_response import respond

    if (options.alpha is None) != (options.beta is None):
        raise InputError("alpha, beta", (options.alpha, options.beta), "belong together", "Give both.")
    for name in ("alpha", "beta"):
        value = getattr(options, name)
        if value is not None and not 0.0 <= value < float("inf"):
            raise InputError(name, value, "must be finite and >= 0", "Give that of the case.")
    element = _read(options)
    if len(element.loads) < 2:
        raise InputError(
            "file", str(options.file), "has no loads to respond to", "Give their file by --forces FORCES."
        )
    given = None if options.alpha is None else (options.alpha, options.beta)
    alpha, beta = rayleigh_coefficients(element) if given is None else given
    attached = attach(element, _tower(options.tower, static=options.static), alpha=alpha, beta=beta)
    response = respond(element, attached, step=options.dt)
    arrays = {"t": response.dt * np.arange(len(response.force)), "interface_force": response.force}
    for place, motion in (("interface", response.interface), ("tower_top", response.top)):
        for name in ("displacement", "velocity", "acceleration"):
            arrays[f"{place}_{name}"] = getattr(motion, name)
    write_npz(options.output, arrays)
    top = float(np.abs(response.top.displacement[:, :3]).max())
    print(f"{options.output}: {len(response.force)} samples, largest tower-top displacement {top:.3f} m")
    return 0
