"""Thesis figure 2.5: horizontal velocity under a high crest of an irregular sea, by five models.

A crest of 7 m is embedded in a sea of Hs 6 m and Tp 9.45 s in 100 m of water. Linear models reach up to the
linear crest, the second order and Grue's profile up to the crest that includes the second order.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_model.config import parse_case
from owt_wave_node.core.grue import grue_crest, trough_to_trough
from owt_wave_node.core.kinematics import wave_kinematics

DEPTH, G, DT, AT = 100.0, 9.81, 0.1, 3000
LEVELS = np.arange(-40.0, 10.01, 0.25)
MODELS = {  # name: order, stretching, colour, line style
    "linear, extrapolated": (1, "none", "#8a949e", "--"),
    "linear, constant": (1, "constant", "#d9a400", "-"),
    "linear, Wheeler": (1, "wheeler", "#3a9bd9", "-"),
    "second order, Taylor": (2, "taylor", "#1f4e79", "-"),
}


def under_crest(order: int, stretching: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Levels up to the crest in m, velocity there in m/s, and the elevation in m over the record."""
    case = parse_case(
        {
            "water_depth_m": DEPTH,
            "gravity_m_s2": G,
            "sea_state": {
                "hs_m": 6.0,
                "tp_s": 9.45,
                "direction_deg": 0.0,
                "cutoff": "steepness",
                "focus": {"crest_m": 7.0, "time_s": AT * DT},
            },
            "wave": {"order": order, "stretching": stretching},
            "time": {"dt_s": DT, "n": 6000},
            "points_m": [[0.0, 0.0, float(z)] for z in LEVELS],
        }
    )
    k = wave_kinematics(case)
    eta = k.eta1[:, 0] + k.eta2[:, 0]
    wet = eta[AT] >= LEVELS
    return LEVELS[wet], k.velocity[AT, wet, 0], eta


def main(folder: Path) -> None:
    figure, axes = plt.subplots(figsize=(6.4, 5.0), layout="constrained")
    profiles = {}
    for name, (order, stretching, colour, style) in MODELS.items():
        z, u, eta = under_crest(order, stretching)
        profiles[name] = z, u
        axes.plot(u, z, color=colour, ls=style, lw=2.0, label=name)
    # The last record is that of the second order: its crest and troughs are those of Grue's profile.
    crest, period = float(eta[AT]), trough_to_trough(np.arange(eta.size) * DT, eta, AT)
    z = profiles["second order, Taylor"][0]
    profiles["Grue"] = z, grue_crest(crest, period, water_depth=DEPTH, gravity=G).velocity(z)
    axes.plot(*profiles["Grue"][::-1], color="#c8602b", lw=2.0, label="Grue")
    axes.axhline(0.0, color="#9aa5ae", lw=0.8)
    axes.text(0.15, 0.3, "still water", color="#6b7780", fontsize=8)
    axes.set(xlabel="horizontal velocity under the crest (m/s)", ylabel="level over still water (m)")
    axes.set(xlim=(0.0, 13.0), ylim=(-30.0, 9.0))
    axes.grid(color="#e3e7eb")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(folder / "stretching.png", dpi=130)

    below, still, top = (
        {name: float(np.interp(level, *profile)) for name, profile in profiles.items()}
        for level in (-20.0, 0.0, crest)  # interp holds the value of a profile's own crest above it
    )
    extrapolated, constant, wheeler, second, grue = (
        [at[name] for at in (below, still, top)] for name in profiles
    )
    print("at the crest: " + "; ".join(f"{name} {u:.1f} m/s" for name, u in top.items()))
    assert abs(wheeler[2] / constant[1] - 1.0) < 1e-6  # Wheeler brings still water's value to the crest
    assert extrapolated[2] > 1.5 * second[2] > 1.5 * grue[2] > 1.5 * wheeler[2]  # at the crest
    assert abs(grue[2] / second[2] - 1.0) < 0.1  # the two nonlinear models agree there
    assert constant[1] > grue[1] > second[1] > wheeler[1]  # at still water
    assert grue[0] > second[0] > wheeler[0]  # below it Grue exceeds the second order, Wheeler falls short


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
