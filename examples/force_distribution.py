"""Thesis figures 4.4 and 4.5: error and time against the number of elements, three force distributions.

A member of 10 m, submerged or through the surface, in one second-order sea of 600 s at 0.1 s. Errors are the
largest differences of force and moment (about the lower end) over the largest values; times are those of
kinematics and loads of the member. Here loads are compiled: what costs is the number of stations, not the
integration of the force. `./owt study interpolation` does the same over several seeds, beside the print.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt

from owt_campaign.studies.interpolation import COUNTS, PLACES, compute

STYLE = {"constant": ("#c8602b", "s"), "linear": ("#1f5f99", "o"), "quadratic": ("#3a7d44", "^")}


def main(folder: Path) -> None:
    found = compute(COUNTS, (4,), 6000, lambda done, total: None)
    figure, panels = plt.subplots(2, 2, figsize=(10, 7), layout="constrained", sharex=True)
    for column, place in enumerate(PLACES):
        for distribution, (colour, marker) in STYLE.items():
            runs = [found[place, distribution, count] for count in COUNTS]
            style = {"color": colour, "marker": marker, "ms": 5, "ls": "--" if marker == "o" else "-"}
            force, moment = ([getattr(run, what)[0] for run in runs] for what in ("force", "moment"))
            panels[0, column].loglog(COUNTS, force, label=f"{distribution}, force", **style)
            panels[0, column].loglog(COUNTS, moment, label=f"{distribution}, moment", alpha=0.45, **style)
            panels[1, column].loglog(COUNTS, [1e3 * run.seconds for run in runs], **style)
        panels[0, column].set(title=f"{place}: largest error over the largest value")
        panels[1, column].set(title=f"{place}: time (ms)", xlabel="elements in 10 m", xticks=COUNTS)
        panels[1, column].set_xticklabels(map(str, COUNTS))
        panels[1, column].set_yticks([1, 2, 5, 10, 20, 50], labels=["1", "2", "5", "10", "20", "50"])
        panels[1, column].minorticks_off()
    for panel in panels.flat:
        panel.grid(color="#e3e7eb", which="major")
        panel.spines[["top", "right"]].set_visible(False)
    panels[0, 0].legend(frameon=False, fontsize=8)
    figure.savefig(folder / "force_distribution.png", dpi=130)
    plt.close(figure)

    for place in PLACES:
        linear, quadratic = (found[place, name, 10].force[0] for name in ("linear", "quadratic"))
        print(f"{place}: with 10 elements linear is off by {linear:.1e}, quadratic by {quadratic:.1e}")
        assert quadratic < 0.05 * linear < 1e-3


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
