"""Thesis appendix C: regular wave of H 2.5 m, T 5 s on the OC4 jacket, total force over one period.

The thesis compares its model with USFOS and shows that both agree, USFOS with a zigzag: it loads a whole
element once its midpoint is wet. Only the picture holds that curve, no number of it is printed. Here the
code is compared with Morison's equation summed over pieces of the members, written out below: of 0.05 m up to
the surface, and of 1 m that are on or off by their midpoints, as in USFOS.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.loads import jacket_loads

HEIGHT, PERIOD, DEPTH, RHO, G, CD, CM = 2.5, 5.0, 50.0, 1025.0, 9.81, 1.0, 2.0
DT, N = 0.02, 250


def written_out(t: np.ndarray, longest: float, *, to_surface: bool) -> np.ndarray:
    """Total force along x in N: pieces of the members, as far as they are wet, or while their midpoint is."""
    omega, a = 2.0 * math.pi / PERIOD, 0.5 * HEIGHT
    k = float(wavenumber(np.array([omega]), water_depth=DEPTH, gravity=G)[0])
    structure, total = load_structure("oc4"), np.zeros(t.size)
    for member in structure.members.values():
        start, end = (np.array(structure.joints[name]) for name in member.joints)
        diameter = structure.sections[member.section].diameter_m
        length = float(np.linalg.norm(end - start))
        axis, count = (end - start) / length, math.ceil(length / longest)
        for x, _, z in start + (np.arange(count)[:, None] + 0.5) / count * (end - start):
            if not -DEPTH <= z <= a + longest:
                continue
            psi, level = omega * t - k * x, min(z, 0.0)  # constant above still water, eq. 2.16
            speed = a * G * k / omega / math.cosh(k * DEPTH)
            c, s = speed * math.cosh(k * (level + DEPTH)), speed * math.sinh(k * (level + DEPTH))
            v = np.column_stack([c * np.cos(psi), 0.0 * t, -s * np.sin(psi)])
            dv = omega * np.column_stack([-c * np.sin(psi), 0.0 * t, -s * np.cos(psi)])
            v, dv = v - np.outer(v @ axis, axis), dv - np.outer(dv @ axis, axis)
            drag = 0.5 * RHO * CD * diameter * np.linalg.norm(v, axis=1) * v[:, 0]
            force = drag + 0.25 * RHO * CM * math.pi * diameter**2 * dv[:, 0]
            wet, rise = a * np.cos(psi) - z, abs(end[2] - start[2]) / count if to_surface else 0.0
            total += np.clip(wet / max(rise, 1e-9) + 0.5, 0.0, 1.0) * force * length / count
    return total


def main(folder: Path) -> None:
    case = parse_case(
        {
            "regular": {"theory": "airy", "height_m": HEIGHT, "period_s": PERIOD},
            "wave": {"order": 1, "stretching": "constant"},
            "time": {"dt_s": DT, "n": N},
            "morison": {"cd": CD, "cm": CM, "discretisation_m": 1.0},
        }
    )
    loads = jacket_loads(case, build_mesh(load_structure("oc4")))
    t, force = loads.t, loads.force[:, 0] * 1e-6
    fine = written_out(t, 0.05, to_surface=True) * 1e-6
    midpoints = written_out(t, 1.0, to_surface=False) * 1e-6

    figure, panels = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    near = np.abs(t - t[force.argmax()]) < 0.4
    for panel, title, at in zip(
        panels, ("one period", "around the maximum"), (t < PERIOD, near), strict=True
    ):
        panel.plot(t[at], midpoints[at], color="#c8602b", lw=1.2, label="1 m, on and off at midpoints")
        panel.plot(t[at], force[at], color="#1f5f99", lw=2.0, label="owt, 1 m, moving surface")
        some = np.flatnonzero(at)[:: 10 if title == "one period" else 3]
        panel.plot(t[some], fine[some], "o", color="#1c2733", ms=3.5, label="written out, 0.05 m")
        panel.set(xlabel="time (s)", ylabel="total force along x (MN)", title=title)
        panel.grid(color="#e3e7eb")
        panel.spines[["top", "right"]].set_visible(False)
    panels[0].legend(frameon=False, fontsize=9)
    figure.savefig(folder / "usfos.png", dpi=130)
    plt.close(figure)

    peak = np.abs(fine).max()
    ours, zigzag = (float(np.abs(force - fine).max() / peak) for force in (force, midpoints))
    print(f"largest force {peak:.4f} MN; off by {ours:.1e} of it with 1 m, by {zigzag:.1e} with midpoints")
    assert ours < 2e-3 < zigzag


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
