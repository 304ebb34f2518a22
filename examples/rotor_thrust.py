"""Thrust of a rotor in turbulent wind: ten minutes of wind and thrust, and the spectrum of the thrust.

A generic turbine of 4 MW and 130 m in a mean wind of 14 m/s, category B. The peaks at 3P and 6P come from
blades that pass through the same gusts again and again, the tower and the wind shear.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_structure_node.core.rotor_thrust import Rotor, RotorThrust, rotor_thrust
from owt_structure_node.core.rotor_wind import Wind, kaimal, rotor_spectrum, turbulence_at

DT = 0.1
#: First natural frequency of the OC4 jacket with its turbine in Hz.
FIRST_MODE = 0.38
INK, BLUE, RED = "#1c2733", "#2f6db3", "#c0392b"


def density(series: np.ndarray, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in Hz and variance density of a series, mean over parts with a Hann window."""
    n = series.size // parts
    window = np.hanning(n)
    half = np.fft.rfft((series - series.mean())[: n * parts].reshape(parts, n) * window)
    S = 2.0 * DT / float(window @ window) * np.mean(np.abs(half) ** 2, axis=0)
    return np.fft.rfftfreq(n, DT)[1:], S[1:]


def series(axes: np.ndarray, record: RotorThrust, n: int) -> None:
    t = DT * np.arange(n)
    axes[0].plot(t, record.wind[:n], color=BLUE, lw=0.6, label="over the blades")
    axes[0].plot(t, record.slow_wind[:n], color=INK, lw=1.4, label="slow wind")
    axes[0].set(ylabel="wind in m/s", title="wind over the rotor")
    axes[0].legend(loc="upper right", ncols=2, fontsize=8)
    axes[1].plot(t, record.thrust[:n] / 1e3, color=RED, lw=0.6)
    axes[1].set(xlabel="time in s", ylabel="thrust in kN", title="thrust", xlim=(0.0, t[-1]))
    axes[0].sharex(axes[1])


def spectrum(ax: plt.Axes, record: RotorThrust, rotor: Rotor, wind: Wind) -> None:
    f, S = density(record.thrust, 36)
    P, c = record.rotor_frequency, record.damping
    air = turbulence_at(wind, rotor.hub_height)
    g = np.geomspace(f[0], f[-1], 2000)
    ax.loglog(f, S, color=RED, lw=1.0, label="thrust")
    felt = rotor_spectrum(g, air, radius=rotor.radius, rotor_frequency=P)
    ax.loglog(g, c**2 * felt, color=INK, lw=1.2, label="c² times wind over the blades")
    ax.loglog(g, c**2 * kaimal(g, air), color=BLUE, lw=1.2, ls="--", label="c² times wind at a point")
    for at, name in ((P, "1P"), (3.0 * P, "3P"), (6.0 * P, "6P"), (FIRST_MODE, "first\nmode")):
        ax.axvline(at, color="#8a939b", lw=0.8, ls=":" if name == "1P" else "-", zorder=0)
        ax.text(at, 0.99, name, transform=ax.get_xaxis_transform(), ha="right", va="top", fontsize=8)
    ax.set(xlabel="frequency in Hz", ylabel="N²/Hz", title="variance density of the thrust", ylim=(1e6, 1e12))
    ax.legend(loc="lower left", fontsize=8)


def draw(record: RotorThrust, rotor: Rotor, wind: Wind, picture: Path) -> None:
    figure = plt.figure(figsize=(11.0, 5.2), layout="constrained")
    left, right = figure.subfigures(1, 2)
    series(left.subplots(2, 1), record, 6000)
    spectrum(right.subplots(), record, rotor, wind)
    figure.savefig(picture, dpi=130)


def main(folder: Path) -> None:
    rotor, wind = Rotor(), Wind(speed=14.0, turbulence="B", seed=1)
    record = rotor_thrust(rotor, wind, dt=DT, n=108_000)
    draw(record, rotor, wind, folder / "rotor_thrust.png")
    f, S = density(record.thrust, 36)
    P = record.rotor_frequency
    near_mode = np.median(S[(f > 0.3) & (f < 0.5)])
    found = {number: float(S[np.abs(f - number * P).argmin()] / near_mode) for number in (1, 3, 6)}
    print(f"thrust {record.thrust.mean() / 1e3:.0f} kN, standard deviation {record.thrust.std() / 1e3:.0f}")
    print("density over that near the first mode:", ", ".join(f"{k}P {v:.2g}" for k, v in found.items()))
    assert found[3] > 2.0 * found[6] > 100.0
    assert found[1] < 5.0


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
