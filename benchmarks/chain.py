"""What comes after the loads: integration of the structure and counting of cycles."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.alternatives import newmark_coupled, rainflow_half_cycles
from benchmarks.measure import Table, timing
from benchmarks.structure import bench_building, bench_response, bench_simulate


def bench_structure(table: Table) -> None:
    """Integration of oscillators, and the OC4 turbine: building, reduction, response, whole command."""
    _oscillators(table)
    bench_building(table)
    bench_response(table)
    bench_simulate(table)


def _oscillators(table: Table) -> None:
    """Integration of a system as large as the reduced turbine, against coupled Newmark in numpy."""
    from owt_structure_node.core.motion import Oscillators, integrate, static_state

    rng = np.random.default_rng(1)
    n, steps, h = 128, 30_000, 0.02
    omega = 2 * np.pi * np.geomspace(0.38, 60.0, n)
    shapes = np.linalg.qr(rng.standard_normal((n, n)))[0]
    damping = 0.027 + 0.002 * omega**2
    force = rng.standard_normal((steps, n)).cumsum(axis=0)
    modal = np.ascontiguousarray(force @ shapes)
    system = Oscillators(stiffness=omega**2, damping=damping, step=h, substeps=1)
    state = static_state(system, modal[0])

    def ours() -> Any:
        return integrate(system, state, modal[1:])

    def theirs() -> np.ndarray:
        stiffness = shapes * omega**2 @ shapes.T
        return newmark_coupled(np.eye(n), shapes * damping @ shapes.T, stiffness, force, h)

    _, motion = ours()
    reference = (theirs() @ shapes)[1:]
    found = motion.displacement
    error = np.abs(found - reference).max() / np.abs(reference).max()
    assert error < 1e-8, f"modal Newmark differs from the coupled one by {error:.1e}"
    beside = {"coupled Newmark in numpy": timing(theirs, 1).wall}
    table.add("structure", "Newmark, 128 modes, 30,000 steps", timing(ours), beside)


def bench_rainflow(table: Table) -> None:
    """One long series, against the rule in plain Python."""
    from owt_postproc import rainflow

    series = np.random.default_rng(2).standard_normal(200_000).cumsum()
    ranges, _, counts = rainflow(series)
    reference = sorted(rainflow_half_cycles(series))
    assert np.allclose(sorted(zip(ranges, counts, strict=True)), reference)
    beside = {"the rule in plain Python": timing(lambda: rainflow_half_cycles(series), 1).wall}
    table.add("rainflow", "rainflow, 200,000 samples", timing(lambda: rainflow(series)), beside)
