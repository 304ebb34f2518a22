"""Building, reducing and integrating the OC4 turbine, reduced and not, against plain ways to do the same."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.sparse.linalg import splu

from benchmarks.measure import ROOT, Table, Timing, process, timing

MODEL, REDUCTION = "oc4-thesis", "CB10M10"
LOADS, LOAD_STEP, STEP = 6000, 0.1, 0.02
ALPHA, BETA = 0.027, 0.002
#: Elements per member that make the turbine as large as the model of a real one: 1692 degrees of freedom.
FINE = 3

Solve = Callable[[np.ndarray], np.ndarray]


def bench_building(table: Table) -> None:
    """Mesh, matrices and reduction of the OC4 turbine, and of one with more elements."""
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure
    from owt_structure_node.core.assembly import assemble
    from owt_structure_node.core.reduction import reduce

    shipped = load_structure(MODEL)
    for elements in (shipped.elements_per_member, FINE):
        structure = shipped.model_copy(update={"elements_per_member": elements})
        mesh = build_mesh(structure)
        assembly, basis = assemble(mesh), _random_basis(mesh)
        modes = partial(_dense_modes, assembly)
        error = np.abs(reduce(assembly, REDUCTION, basis).fixed_interface / modes() - 1.0).max()
        assert error < 1e-6, f"fixed-interface modes differ from the dense ones by {error:.1e}"
        what = f"mesh of {MODEL}, {elements} elements a member, {mesh.n_dof} degrees of freedom"
        table.add("structure", what, timing(partial(build_mesh, structure)))
        table.add("structure", "  stiffness and mass", timing(partial(assemble, mesh)))
        reduced = timing(partial(reduce, assembly, REDUCTION, basis))
        beside = {"its 10 modes alone, scipy.linalg.eigh": timing(modes, 1).wall}
        table.add("structure", f"  reduction to {REDUCTION}", reduced, beside)


def _dense_modes(assembly: Any) -> np.ndarray:
    n = assembly.internal
    matrices = (a[:n, :n].toarray() for a in (assembly.jacket_stiffness, assembly.jacket_mass))
    return np.asarray(eigh(*matrices, subset_by_index=(0, 9))[0])


def _random_basis(mesh: Any) -> Any:
    """Ten load vectors on the nodes below water."""
    from owt_model.pod import load_basis

    below = (mesh.node_position[:, 2] < 0.0) & (mesh.node_dof >= 0).all(axis=1)
    node = np.flatnonzero(below)
    nodal = np.random.default_rng(3).standard_normal((40, len(node), 6))
    return load_basis(nodal, node, 10, model_hash=mesh.structure.content_hash)


def bench_response(table: Table) -> None:
    """600 s of second-order waves: projection and integration, stresses, streaming; reduced and not."""
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure
    from owt_structure_node.core.assembly import assemble
    from owt_structure_node.core.reduction import reduce
    from owt_wave_node.core.stage import build_wave_stage

    mesh = build_mesh(load_structure(MODEL))
    assembly, waves = assemble(mesh), build_wave_stage(_case(REDUCTION), mesh)
    load, basis = waves.load_block(0), waves.load_basis(10)

    def cholesky() -> np.ndarray:
        reduced = reduce(assembly, REDUCTION, basis)
        return newmark_reduced(reduced.mass, reduced.stiffness, _free(assembly, load) @ reduced.shapes)

    def sparse() -> np.ndarray:
        interface = slice(assembly.internal, assembly.internal + 6)
        return newmark_unreduced(assembly.mass, assembly.stiffness, _free(assembly, load), interface)

    model, batch = _rows(
        table, _case(REDUCTION), mesh, basis, load, LOADS, "coupled, factors of Cholesky", cholesky
    )
    stream = timing(partial(stresses, model, load, 50), 5)
    table.add("structure", "  the same in blocks of 50 samples", stream, {"in one block": batch.wall})
    table.note("structure", "blocks of 50 samples over one block", stream.wall / batch.wall, "x")
    _rows(table, _case("full"), mesh, None, load, 500, "coupled, sparse factors", sparse)


def bench_simulate(table: Table) -> None:
    """The whole chain as a command, with its memory."""
    with tempfile.TemporaryDirectory() as folder:
        for name in (REDUCTION, "full"):
            path = Path(folder) / f"{name}.json"
            path.write_text(json.dumps({"structure": {"model": MODEL, "reduction": name}}))
            command = [str(ROOT / "owt"), "simulate", str(path), "-o", f"{folder}/{name}"]
            table.add("structure", f"./owt simulate, 600 s, second order, {MODEL}, {name}", process(command))


def _case(reduction: str) -> Any:
    from owt_model.config import parse_case

    damping = {"alpha": ALPHA, "beta": BETA}
    structure = {"model": MODEL, "reduction": reduction, "dt_s": STEP, "damping": damping}
    time = {"dt_s": LOAD_STEP, "n": LOADS}
    return parse_case({"structure": structure, "time": time, "stream": {"block": LOADS}})


def _rows(
    table: Table, case: Any, mesh: Any, basis: Any, load: Any, block: int, name: str, plain: Callable[[], Any]
) -> tuple[Any, Timing]:
    """Add the rows of one model beside a plain way to integrate it; return it and its time with stresses."""
    from owt_structure_node.core.stage import build_response_model

    build = partial(build_response_model, case, mesh, basis)
    model, expected = build(), []
    beside = {f"{name}, numpy and scipy": timing(lambda: expected.append(plain()), 1).wall}
    found, reduction = motion(model, load, block), case.structure.reduction
    error = np.abs(found - expected[0]).max() / np.abs(expected[0]).max()
    assert error < 1e-6, f"{reduction}: the interface moves otherwise than by plain Newmark, by {error:.1e}"
    modes = len(model.oscillators.stiffness)
    repeats = 2 if reduction == "full" else 5
    table.add("structure", f"{MODEL}, {reduction}, {modes} modes: building", timing(build, repeats))
    integrated = timing(partial(motion, model, load, block), repeats)
    table.add("structure", f"  projection and integration, 600 s at {STEP} s", integrated, beside)
    stressed = timing(partial(stresses, model, load, block), repeats)
    table.add("structure", f"  with stress at all {len(mesh.end_name)} member ends and energies", stressed)
    return model, stressed


# --- ours ---------------------------------------------------------------------------------------------


def motion(model: Any, load: Any, block: int) -> np.ndarray:
    """Project loads on the modes and integrate, block by block; motion of the interface [time, 6]."""
    from owt_structure_node.core.motion import integrate, static_state

    nodal = load.nodal.reshape(len(load.nodal), -1)
    shapes = model.node_basis[load.node].reshape(nodal.shape[1], -1)
    state, out = None, []
    for start in range(0, len(nodal), block):
        modal = nodal[start : start + block] @ shapes
        if model.amplitude is not None:
            modal = modal @ model.amplitude.T
        if state is None:
            state, modal = static_state(model.oscillators, modal[0]), modal[1:]
            out.append(state.displacement[None] @ model.coordinate[:, :6])
        state, part = integrate(model.oscillators, state, modal)
        out.append(part.displacement @ model.coordinate[:, :6])
    return np.concatenate(out)


def stresses(model: Any, load: Any, block: int) -> None:
    """The structure stage over the record, block by block; results are dropped."""
    from owt_structure_node.core.stage import initial_state, step

    state, count = initial_state(model), len(load.nodal)
    for i, start in enumerate(range(0, count, block)):
        rows = slice(start, start + block)
        part = {"nodal": load.nodal[rows], "fixed_end": load.fixed_end[rows]}
        state, _ = step(
            model, state, replace(load, sequence=i, start=start, last=start + block >= count, **part)
        )


# --- the plain way ------------------------------------------------------------------------------------


def _free(assembly: Any, load: Any) -> np.ndarray:
    """Loads on the free degrees of freedom [sample, dof]."""
    full = np.zeros((len(load.nodal), assembly.mesh.n_nodes, 6))
    full[:, load.node] = load.nodal
    return np.asarray((assembly.expansion.T @ full.reshape(len(full), -1).T).T)


def newmark_reduced(mass: np.ndarray, stiffness: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Motion of the interface by Newmark on the coupled reduced system, factorised once [eq. F.5-F.8]."""
    damping = ALPHA * mass + BETA * stiffness
    factor = cho_factor(mass + 0.5 * STEP * damping + 0.25 * STEP**2 * stiffness)
    solve = partial(cho_solve, factor, check_finite=False)
    return _newmark(solve, damping, stiffness, np.linalg.solve(stiffness, load[0]), load, slice(0, 6))


def newmark_unreduced(mass: Any, stiffness: Any, load: np.ndarray, shown: slice) -> np.ndarray:
    """The same of the unreduced structure, with sparse matrices and factors."""
    damping = ALPHA * mass + BETA * stiffness
    solve = splu((mass + 0.5 * STEP * damping + 0.25 * STEP**2 * stiffness).tocsc()).solve
    return _newmark(
        solve, damping.tocsr(), stiffness.tocsr(), splu(stiffness.tocsc()).solve(load[0]), load, shown
    )


def _newmark(
    solve: Solve, damping: Any, stiffness: Any, start: np.ndarray, load: np.ndarray, shown: slice
) -> np.ndarray:
    substeps, h = round(LOAD_STEP / STEP), STEP
    q, v, a = start, np.zeros_like(start), np.zeros_like(start)
    out = np.empty((substeps * (len(load) - 1) + 1, shown.stop - shown.start))
    out[0] = q[shown]
    for i in range(1, len(out)):
        sample, part = divmod(i - 1, substeps)
        force = load[sample] + (part + 1) / substeps * (load[sample + 1] - load[sample])
        q_new, v_new = q + h * v + 0.25 * h**2 * a, v + 0.5 * h * a
        a = solve(force - damping @ v_new - stiffness @ q_new)
        q, v = q_new + 0.25 * h**2 * a, v_new + 0.5 * h * a
        out[i] = q[shown]
    return out
