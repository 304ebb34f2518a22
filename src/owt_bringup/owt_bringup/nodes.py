"""The nodes of the graph, in the order in which they are configured: consumers first."""

from __future__ import annotations

from dataclasses import dataclass

from owt_ros.topics import POSTPROC, STRUCTURE, WAVE

__all__ = ["NODES", "NodeSpec"]


@dataclass(frozen=True)
class NodeSpec:
    """One executable of the graph; node and executable have the same name."""

    name: str
    package: str


NODES = (
    NodeSpec(POSTPROC, "owt_postproc"),
    NodeSpec(STRUCTURE, "owt_structure_node"),
    NodeSpec(WAVE, "owt_wave_node"),
)
