"""Pieces that figures of several studies share: the jacket seen from one side, bars over the height."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from owt_campaign.studies.plotting import FAINT, ORANGE, frame
from owt_campaign.studies.wave_totals import Members
from owt_model.mesh import Mesh

__all__ = ["jacket", "levels"]


def jacket(panel: Axes, mesh: Mesh, marked: Mapping[str, int]) -> None:
    """Draw the jacket seen along y, with some members marked by a label."""
    ends = mesh.node_position[mesh.member_node][:, :, [0, 2]]
    frame(panel, list(ends), colour=FAINT, width=0.7)
    for label, m in marked.items():
        frame(panel, [ends[m]], colour=ORANGE, width=2.4)
        panel.annotate(
            label, ends[m].mean(axis=0), xytext=(9, 0), textcoords="offset points", color=ORANGE, fontsize=9
        )
    panel.axhline(0.0, color=FAINT, lw=0.6, ls=":")


def levels(
    panel: Axes,
    members: Members,
    value: Float[np.ndarray, " member"],
    colour: str,
    label: str = "",
    marker: str = "o",
) -> None:
    """One point per member over the level of its middle; legs filled, braces open."""
    for which, face in ((members.leg | members.pile, colour), (~(members.leg | members.pile), "none")):
        panel.plot(
            value[which], members.level[which], ls="", marker=marker, ms=3.5, mec=colour, mfc=face, mew=0.8,
            label=label if face != "none" else "",
        )  # fmt: skip
    panel.set_ylabel("z of the middle [m]")
