"""The topics of the graph: who sends what to whom. Every other module takes names and types from here.

Names are relative, so that a graph can live in a namespace; in the root namespace they are those of the
documentation, ``/owt/model`` and so on.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, WrenchStamped
from owt_msgs.msg import (
    Credit,
    Energy,
    FatigueState,
    LoadBasis,
    MeasuredElevation,
    MemberStress,
    ModalState,
    ModelDescription,
    NodalLoads,
    NodeStatus,
    ReducedModel,
    SeaState,
    SurfaceElevation,
    TowerTopLoad,
)
from rosgraph_msgs.msg import Clock

from owt_model.config import CaseConfig

__all__ = [
    "CLOCK",
    "CREDIT",
    "DIAGNOSTICS",
    "ENERGY",
    "FATIGUE",
    "FATIGUE_SUMMARY",
    "FLUSH",
    "LOAD_BASIS",
    "MEASURED_ELEVATION",
    "MEASURED_ELEVATION_USED",
    "MEMBER_STRESS",
    "MODAL_STATE",
    "MODEL",
    "NODAL_LOADS",
    "POSTPROC",
    "RECORDED",
    "REDUCED_MODEL",
    "SEA_STATE",
    "STATUS",
    "STRUCTURE",
    "SURFACE_ELEVATION",
    "TOWER_TOP_LOAD",
    "TOWER_TOP_WRENCH",
    "VIEWER",
    "WAVE",
    "Kind",
    "Topic",
    "recorded",
]

WAVE = "wave_node"
STRUCTURE = "structure_node"
POSTPROC = "postproc_node"
#: Watches and is no part of the graph: nothing waits for it, nothing of it is recorded.
VIEWER = "viewer_node"


class Kind(Enum):
    """How a topic is transported."""

    LATCHED = "latched"  # one message, late joiners get it
    DATA = "data"  # a numbered stream under flow control
    EVENT = "event"  # small messages without flow control
    INPUT = "input"  # from outside the graph, without flow control; none is lost


@dataclass(frozen=True)
class Topic:
    """One topic of the graph.

    Attributes
    ----------
    producer : str
        Node that publishes it; empty where several do.
    consumers : tuple of str
        Nodes that must receive every message; on data topics they acknowledge each block.
    """

    name: str
    message: type[Any]
    kind: Kind
    producer: str = ""
    consumers: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name as documentation, credits and bags write it."""
        return f"/{self.name}"


MODEL = Topic("owt/model", ModelDescription, Kind.LATCHED, WAVE, (STRUCTURE, POSTPROC))
SEA_STATE = Topic("owt/sea_state", SeaState, Kind.LATCHED, WAVE, (POSTPROC,))
LOAD_BASIS = Topic("owt/load_basis", LoadBasis, Kind.LATCHED, WAVE, (STRUCTURE, POSTPROC))
REDUCED_MODEL = Topic("owt/reduced_model", ReducedModel, Kind.LATCHED, STRUCTURE, (POSTPROC,))
SURFACE_ELEVATION = Topic("owt/surface_elevation", SurfaceElevation, Kind.DATA, WAVE, (POSTPROC,))
NODAL_LOADS = Topic("owt/nodal_loads", NodalLoads, Kind.DATA, WAVE, (STRUCTURE, POSTPROC))
MODAL_STATE = Topic("owt/modal_state", ModalState, Kind.DATA, STRUCTURE, (POSTPROC,))
MEMBER_STRESS = Topic("owt/member_stress", MemberStress, Kind.DATA, STRUCTURE, (POSTPROC,))
ENERGY = Topic("owt/energy", Energy, Kind.DATA, STRUCTURE, (POSTPROC,))
#: Only of a case with a load at the tower top; the wrench comes from outside, where the case asks for it.
TOWER_TOP_LOAD = Topic("owt/tower_top_load", TowerTopLoad, Kind.DATA, STRUCTURE, (POSTPROC,))
TOWER_TOP_WRENCH = Topic("owt/tower_top_wrench", WrenchStamped, Kind.INPUT)
#: Only of a case with a live elevation: what a gauge outside sends, and the record that is made of it.
MEASURED_ELEVATION = Topic("owt/measured_elevation", PointStamped, Kind.INPUT)
MEASURED_ELEVATION_USED = Topic(
    "owt/measured_elevation_used", MeasuredElevation, Kind.DATA, WAVE, (POSTPROC,)
)
#: Nobody needs to acknowledge it: its producer records it itself.
FATIGUE = Topic("owt/fatigue", FatigueState, Kind.DATA, POSTPROC)
CLOCK = Topic("clock", Clock, Kind.EVENT, WAVE, (POSTPROC,))
DIAGNOSTICS = Topic("diagnostics", DiagnosticArray, Kind.EVENT)
#: Flow control and supervision: never recorded.
CREDIT = Topic("owt/credit", Credit, Kind.EVENT)
STATUS = Topic("owt/status", NodeStatus, Kind.LATCHED)

#: Services of the postproc node.
FATIGUE_SUMMARY, FLUSH = "owt/fatigue_summary", "owt/flush"

#: What the bag of every case holds: what is latched, each block in the order of the chain, marks.
RECORDED = (
    MODEL,
    SEA_STATE,
    LOAD_BASIS,
    REDUCED_MODEL,
    CLOCK,
    SURFACE_ELEVATION,
    NODAL_LOADS,
    MODAL_STATE,
    MEMBER_STRESS,
    ENERGY,
    FATIGUE,
    DIAGNOSTICS,
)


def recorded(case: CaseConfig) -> tuple[Topic, ...]:
    """Topics that the bag of a case holds, in the order of the bag."""
    found = list(RECORDED)
    if case.live is not None:
        found.insert(found.index(CLOCK), MEASURED_ELEVATION_USED)
    if case.wind is not None:
        found.insert(found.index(MODAL_STATE), TOWER_TOP_LOAD)
    return tuple(found)
