"""``./owt bench``: every figure is a ratio to a named alternative or a matrix product in the same run.

``--demo`` also times the graph; ``-o FILE`` writes the figures as JSON.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.alternatives import newmark_coupled, rainflow_half_cycles, second_order_double_sum

ROOT = Path(__file__).resolve().parents[1]
REPEATS = 5


def seconds(work: Callable[[], Any], repeats: int = REPEATS) -> float:
    """Median wall time in s after one run that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def row(label: str, ours: float, alternative: str, theirs: float) -> dict[str, Any]:
    """One line of the table."""
    print(f"{label:<58} {ours:9.4f} s   {theirs / ours:10.1f} x faster than {alternative} ({theirs:.3f} s)")
    return {"what": label, "seconds": ours, "alternative": alternative, "alternative_seconds": theirs}


def bench_waves(matmul: float) -> list[dict[str, Any]]:
    """Second-order kinematics at a point, and the loads of the default case."""
    from owt_model.config import parse_case
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure
    from owt_wave_node.core.kinematics import wave_kinematics
    from owt_wave_node.core.sea import build_sea_state
    from owt_wave_node.core.stage import build_wave_stage

    case = parse_case({"points_m": [[3.0, -2.0, -6.0]]})
    sea = build_sea_state(case)
    ours = wave_kinematics(case)
    b = np.deg2rad(sea.direction_deg)
    some = np.arange(0, sea.n, 60)

    def double_sum() -> np.ndarray:
        return second_order_double_sum(
            ours.t[some], 3.0 * np.cos(b) - 2.0 * np.sin(b), -6.0, omega=sea.omega_rad_s,
            k=sea.wavenumber_rad_m, a=sea.amplitude_m, phase=sea.phase_rad, depth=sea.water_depth_m,
            gravity=sea.gravity_m_s2,
        )  # fmt: skip

    reference = double_sum()
    along = ours.velocity2[some, 0] @ np.array([np.cos(b), np.sin(b), 0.0])
    error = np.abs(along - reference).max() / np.abs(reference).max()
    assert error < 1e-10, f"second order differs from the double sum by {error:.1e}"
    plain = seconds(double_sum, 1) * len(ours.t) / len(some)
    rows = [
        row("second-order kinematics, 1 point, 6000 samples", seconds(lambda: wave_kinematics(case)),
            "the numpy double sum", plain)
    ]  # fmt: skip
    mesh = build_mesh(load_structure("oc4"))
    for order in (1, 2):
        whole = parse_case({"wave": {"order": order}})
        elapsed = seconds(partial(build_wave_stage, whole, mesh))
        rows.append(
            row(
                f"waves and loads, order {order}, OC4, 600 s", elapsed, "a 1500 x 1500 matrix product", matmul
            )
        )
    return rows


def bench_structure() -> list[dict[str, Any]]:
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
    return [
        row("Newmark, 128 modes, 30,000 steps", seconds(ours), "coupled Newmark in numpy", seconds(theirs, 1))
    ]


def bench_rainflow() -> list[dict[str, Any]]:
    """One long series, against the rule in plain Python."""
    from owt_postproc import rainflow

    series = np.random.default_rng(2).standard_normal(200_000).cumsum()
    ranges, _, counts = rainflow(series)
    reference = sorted(rainflow_half_cycles(series))
    assert np.allclose(sorted(zip(ranges, counts, strict=True)), reference)
    plain = seconds(lambda: rainflow_half_cycles(series), 1)
    return [row("rainflow, 200,000 samples", seconds(lambda: rainflow(series)), "plain Python", plain)]


def bench_commands(with_demo: bool) -> list[dict[str, Any]]:
    """Whole commands as a user runs them: wall time and peak memory of the largest process."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "case.json"
        case.write_text("{}")
        commands = {
            "simulate, 600 s, order 2, CB10M10": ["simulate", str(case), "-o", folder],
            "loads, 600 s, order 2": ["loads", str(case), "-o", f"{folder}/loads.npz"],
        }
        if with_demo:
            commands["demo, 600 s, order 2, CB10M10"] = ["demo", "--bag", f"{folder}/demo"]
        for label, command in commands.items():
            start = time.perf_counter()
            subprocess.run([ROOT / "owt", *command], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
            elapsed = time.perf_counter() - start
            memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
            print(f"./owt {label:<52} {elapsed:9.1f} s   largest process so far {memory:.0f} MiB")
            rows.append({"what": f"./owt {label}", "seconds": elapsed, "peak_mib_so_far": memory})
    return rows


def main() -> int:
    """Run every benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--demo", action="store_true", help="also time the graph")
    parser.add_argument("-o", "--output", type=Path, help="JSON file to write")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    a, b = rng.standard_normal((2, 1500, 1500))
    matmul = seconds(lambda: a @ b)
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "all")
    print(f"{os.cpu_count()} processors, BLAS threads: {threads}; matrix product 1500: {matmul:.3f} s")
    rows = [*bench_waves(matmul), *bench_structure(), *bench_rainflow(), *bench_commands(options.demo)]
    if options.output:
        options.output.write_text(json.dumps({"matmul_1500_s": matmul, "rows": rows}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
