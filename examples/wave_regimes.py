"""Thesis figures 2.8 and 2.9: where the sea states of the load-case table lie among theories and loads.

The wave theory that a regular wave of given height, period and depth asks for, with the breaking limit; and
for the legs of the OC4 jacket whether inertia, drag or diffraction governs. Each dot is a cell of the
load-case table (thesis table 4.5) by its Hs and Tp, each ring the largest wave of a thousand.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_wave_node.core.regime import KC_ATTACHED, KC_DRAG, MAX_DIAMETER_OVER_LENGTH, orbital_speed
from owt_wave_node.core.wave_theory import THEORIES, breaking_height, linear_wavenumber, regular_regime

ROOT = Path(__file__).parents[1]
G, DEPTH, DIAMETER = 9.81, 50.0, 1.2
#: Hmax / Hs of a thousand waves.
LARGEST = np.sqrt(0.5 * np.log(1000.0))
SHADES = ["#f3f7fb", "#dbe8f3", "#b9d3e8", "#8db6d6", "#f6dfae", "#e9e4e1"]
INK, DOT, RING = "#1c2733", "#1f5f99", "#c8602b"


def sea_states() -> np.ndarray:
    """Hs in m and Tp in s of the cells, each pair once."""
    with (ROOT / "test" / "data" / "waves" / "load_cases.csv").open() as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return np.unique([[float(row["hs_m"]), float(row["tp_s"])] for row in rows], axis=0)


def draw(axes: plt.Axes, x: np.ndarray, y: np.ndarray, words: dict[str, tuple[float, float]]) -> None:
    """Draw dots, rings and words."""
    axes.plot(x, y, "o", ms=3.0, color=DOT, label="Hs and Tp of a cell")
    axes.plot(x, LARGEST * y, "o", ms=3.6, mfc="none", color=RING, mew=0.7, label="largest of 1000 waves, Tp")
    for word, at in words.items():
        axes.text(*at, word, ha="right", va="center", color=INK, fontsize=9)


def theories(axes: plt.Axes, seas: np.ndarray) -> None:
    """Figure 2.8; a wave of T = 1 s stands for all of its d/(g T^2) and H/(g T^2)."""
    x, y = np.geomspace(4e-4, 0.4, 220), np.geomspace(5e-5, 0.04, 180)
    of = [[regular_regime(height=h * G, period=1.0, depth=d * G, gravity=G).theory for d in x] for h in y]
    rank = [[THEORIES.index(theory) for theory in row] for row in of]
    axes.contourf(x, y, rank, levels=np.arange(-0.5, 6.0), colors=SHADES)
    limit = [breaking_height(linear_wavenumber(1.0, depth=d * G, gravity=G), d * G) / G for d in x]
    axes.loglog(x, limit, color=INK, lw=1.6)
    scale = G * seas[:, 1] ** 2
    draw(axes, DEPTH / scale, seas[:, 0] / scale, {
        "Airy": (0.37, 2.2e-4), "Stokes 2": (0.046, 1.0e-3), "Stokes 3": (0.37, 0.0113),
        "Stokes 5": (0.37, 0.018), "stream function": (2.9e-3, 3e-4), "breaking": (3e-3, 0.01),
    })  # fmt: skip
    axes.set(xlabel="d / (g T$^2$)", ylabel="H / (g T$^2$)", xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    axes.set_title(f"wave theory; dots at d = {DEPTH:g} m", fontsize=10)
    axes.legend(loc="lower left", fontsize=8, framealpha=0.9)


def loads(axes: plt.Axes, ratio: np.ndarray, kc: np.ndarray) -> None:
    """Figure 2.9, with the Keulegan-Carpenter number for H/D: in deep water it is pi H/D."""
    left, right, low, high = 8e-3, 3.0, 0.02, 2e2
    for bottom, top, shade in ((low, KC_ATTACHED, 0), (KC_ATTACHED, KC_DRAG, 1), (KC_DRAG, high, 2)):
        axes.axhspan(bottom, top, color=SHADES[shade], lw=0)
    axes.axvspan(np.pi * MAX_DIAMETER_OVER_LENGTH, right, color=SHADES[4], lw=0)
    x = np.geomspace(left, right, 50)
    breaks = 0.142 * np.pi**2 / x
    axes.fill_between(x, breaks, high, color=SHADES[5], lw=0)
    axes.loglog(x, breaks, color=INK, lw=1.6)
    draw(axes, ratio, kc, {
        "inertia": (0.08, 0.2), "inertia and drag": (0.42, 2.6), "drag": (0.0135, 70.0),
        "diffraction": (1.9, 0.05), "breaking (deep water)": (1.9, 50.0),
    })  # fmt: skip
    axes.set(xlabel="$\\pi$ D / L", ylabel="Keulegan-Carpenter number at still water")
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_title(f"load on the legs, D = {DIAMETER} m", fontsize=10)


def main(folder: Path) -> None:
    seas = sea_states()
    waves = [regular_regime(height=h, period=t, depth=DEPTH, gravity=G) for h, t in seas]
    ratio = np.array([np.pi * DIAMETER / wave.length_m for wave in waves])
    kc = np.array([orbital_speed(wave, 0.0) * wave.period_s / DIAMETER for wave in waves])
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 5.0), layout="constrained")
    theories(left, seas)
    loads(right, ratio, kc)
    figure.savefig(folder / "wave_regimes.png", dpi=130)
    second = float(np.mean([wave.theory in ("airy", "stokes 2") for wave in waves]))
    print(f"{len(seas)} sea states: second order does for {second:.0%}; KC {kc.min():.2g} to {kc.max():.2g}")
    # Morison's equation holds for every sea state of the table; one in ten asks for a third order.
    assert ratio.max() < np.pi * MAX_DIAMETER_OVER_LENGTH
    assert second > 0.9
    assert kc.min() < KC_ATTACHED < kc.max() < KC_DRAG


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
