"""Thesis figures 4.6 and 4.7: a member through the surface, with a node that moves with it or without.

A linear regular wave, its kinematics continued vertically, passes a member inclined along its way. With the
rule "on or off by the midpoint" (as USFOS) each element of 1 m switches at once: a zigzag in time, and force
at frequencies that the waves do not have. A last wet node that moves with the surface avoids both.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import parse_structure
from owt_wave_node.core.loads import jacket_loads

HEIGHT, PERIOD, DT, N = 6.0, 10.0, 0.1, 2000
FOOT, HEAD = (-2.0, 0.0, -6.0), (6.0, 0.0, 8.0)
TUBE = {"diameter_m": 1.2, "thickness_m": 0.05, "youngs_modulus_pa": 2.1e11, "shear_modulus_pa": 8.1e10}


def inertia_force(surface: str, longest: float = 1.0) -> np.ndarray:
    """Inertia force along x in kN."""
    data = {
        "name": "inclined", "elements_per_member": 1, "mudline_z_m": -50.0,
        "sections": {"tube": TUBE | {"density_kg_m3": 7850.0}},
        "joints": {"foot": list(FOOT), "head": list(HEAD)},
        "members": {"m": {"joints": ["foot", "head"], "section": "tube"}}, "supports": {"foot": [True] * 6},
        "interface": {"joints": ["head"], "reference_m": list(HEAD)},
    }  # fmt: skip
    case = parse_case(
        {
            "regular": {"theory": "airy", "height_m": HEIGHT, "period_s": PERIOD},
            "wave": {"order": 1, "stretching": "constant"}, "time": {"dt_s": DT, "n": N},
            "morison": {"cd": 0.0, "surface": surface, "discretisation_m": longest},
        }
    )  # fmt: skip
    return 1e-3 * jacket_loads(case, build_mesh(parse_structure(data, source="example"))).force[:, 0]


def sketch(panel: plt.Axes) -> None:
    """Draw the stations near the surface, the one that moves, and the surface at two times."""
    foot, head = np.array(FOOT)[[0, 2]], np.array(HEAD)[[0, 2]]
    station = foot + np.outer(np.arange(17) / 16.0, head - foot)
    x = np.linspace(-2.5, 7.0, 200)
    for phase, colour in ((1.2, "#9cc3e6"), (0.2, "#1f5f99")):
        eta = 0.5 * HEIGHT * np.cos(2.0 * np.pi * x / 156.0 - phase)
        panel.plot(x, eta, color=colour, lw=1.5)
        level = foot[1] + (x - foot[0]) * (head - foot)[1] / (head - foot)[0]
        at = np.abs(level - eta).argmin()
        panel.plot(x[at], eta[at], "o", color="#c8602b", ms=8, zorder=3)
    panel.plot(*station.T, "-o", color="#1c2733", ms=3, lw=1)
    panel.set(xlim=(-2.5, 7.0), ylim=(-6.5, 8.5), xlabel="x (m)", ylabel="z (m)", title="moving node")
    panel.set_aspect("equal")


def main(folder: Path) -> None:
    forces = {
        "on or off by midpoints, 1 m": (inertia_force("midpoint"), "#c8602b", 1.1),
        "moving node, 1 m": (inertia_force("moving"), "#1f5f99", 2.0),
    }
    exact, t = inertia_force("moving", 0.05), np.arange(N) * DT
    figure, panels = plt.subplots(1, 3, figsize=(13, 4), layout="constrained", width_ratios=(0.8, 1.2, 1.2))
    sketch(panels[0])
    frequency, window = np.fft.rfftfreq(N, DT), t < 1.5 * PERIOD
    above = {}
    for name, (force, colour, width) in forces.items():
        panels[1].plot(t[window], force[window], color=colour, lw=width, label=name)
        amplitude = np.abs(np.fft.rfft(force)) * 2.0 / N
        lines = slice(20, None, 20)  # the record holds 20 waves: lines at multiples of their frequency
        panels[2].semilogy(frequency[lines], amplitude[lines], color=colour, lw=width, marker="o", ms=3)
        above[name] = float(np.sqrt((amplitude[frequency > 1.0] ** 2).sum()))
    panels[1].set(xlabel="time (s)", ylabel="inertia force along x (kN)", title="in time")
    panels[2].set(xlabel="frequency (Hz)", ylabel="amplitude (kN)", title="in frequency", xlim=(0, 5))
    for panel in panels:
        panel.grid(color="#e3e7eb")
        panel.spines[["top", "right"]].set_visible(False)
    panels[1].legend(frameon=False, fontsize=9, loc="upper left")
    figure.savefig(folder / "moving_surface.png", dpi=130)
    plt.close(figure)

    zigzag, smooth = (
        float(np.abs(force - exact).max() / np.abs(exact).max()) for force, _, _ in forces.values()
    )
    print(f"off by {zigzag:.1e} and {smooth:.1e} of the largest force; above 1 Hz {list(above.values())} kN")
    assert 100.0 * smooth < zigzag < 0.1
    assert above["moving node, 1 m"] < 0.1 * above["on or off by midpoints, 1 m"]


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
