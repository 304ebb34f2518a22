"""What a bag alone says of its case: the case itself, and what came into the run from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.contracts import Block, MeasuredBlock, WrenchBlock
from owt_model.errors import ComputationError, InputError
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import Structure, case_structure
from owt_model.structure_text import structure_from_text
from owt_postproc.bag_reader import PREFIX, decoded, to_block
from owt_postproc.bag_report import bag_case
from owt_postproc.bag_source import BagSource
from owt_ros.decode import to_reduced_model
from owt_structure_node.core.tower_top import TowerTopLoad
from owt_structure_node.wind_source import tower_top_load

__all__ = [
    "RecordedRun",
    "bag_structure",
    "comes_from_outside",
    "damping_load",
    "other_structure",
    "recorded_run",
]


@dataclass(frozen=True)
class RecordedRun:
    """A case that a bag gives again.

    Attributes
    ----------
    tower_top : TowerTopLoad, optional
        In the place of the file or the topic that brought it; None where the case alone gives it.
    measured : float array [time], optional
        Elevation in m that came live, as it was used; None of another case.
    structure : Structure, optional
        As it was; None of a bag that does not hold it.
    notes : tuple of str
        What has changed since.
    """

    case: CaseConfig
    tower_top: TowerTopLoad | None = None
    measured: Float[np.ndarray, " time"] | None = None
    structure: Structure | None = None
    notes: tuple[str, ...] = ()


def bag_structure(bag: BagSource) -> Structure | None:
    """Return the structure that a bag was made with; None of one that does not hold it.

    Raises
    ------
    InputError
        If this version cannot read it.
    """
    text = bag.files.attachments.get("structure.yaml")
    return None if text is None else structure_from_text(text.decode(), source="structure.yaml in the bag")


def comes_from_outside(case: CaseConfig) -> bool:
    """Tell whether a file or a topic brings the load at the tower top."""
    return case.wind is not None and case.wind.thrust is None


def damping_load(case: CaseConfig, mesh: Mesh) -> TowerTopLoad | None:
    """Load at the tower top of which only the damping matters: its file, if any, may be gone."""
    return TowerTopLoad(None) if comes_from_outside(case) else tower_top_load(case, mesh)


def other_structure(case: CaseConfig, mesh: Mesh, model_hash: str) -> tuple[str, ...]:
    """Say in one line that a bag was made with another structure than `mesh`; nothing if it was not."""
    own = mesh.structure.content_hash
    if own == model_hash:
        return ()
    return (
        f"the structure {case.structure.model} ({own[:12]}) is not the one that the bag was made with "
        f"({model_hash[:12]}): its file was changed, or is described anew by this version",
    )


def recorded_run(bag: BagSource) -> RecordedRun:
    """Return the case of a bag and what was recorded of its inputs.

    Raises
    ------
    InputError
        If the bag is damaged, holds no case, or lacks what came from outside.
    ComputationError
        If what came from outside has a gap.
    """
    case, structure = bag_case(bag), bag_structure(bag)
    outside = comes_from_outside(case)
    types = ["ModelDescription", *(("ReducedModel", "TowerTopLoad") if outside else ())]
    types += [] if case.live is None else ["MeasuredElevation"]
    wind: tuple[str, ...] = ()
    changed: tuple[str, ...] = ()
    blocks: list[WrenchBlock] = []
    measured: list[MeasuredBlock] = []
    for message in decoded(bag, types=[PREFIX + name for name in types]):
        block = to_block(message)
        if isinstance(block, WrenchBlock):
            blocks.append(block)
        elif isinstance(block, MeasuredBlock):
            measured.append(block)
        elif message.type_name == f"{PREFIX}ReducedModel":
            notes = to_reduced_model(message.content).notes
            wind = tuple(note for note in notes if note.startswith("wind: "))
        else:
            mesh = build_mesh(case_structure(case.structure, structure))
            changed = other_structure(case, mesh, message.content.model_hash)
            if not outside and case.live is None:
                break
    return RecordedRun(
        case,
        TowerTopLoad(_joined(bag, "wrench", blocks), notes=wind) if outside else None,
        None if case.live is None else _joined(bag, "elevation", measured),
        structure,
        changed,
    )


def _joined(bag: BagSource, name: str, blocks: Sequence[Block]) -> np.ndarray:
    """Join what came from outside, block by block."""
    topic = {"wrench": "/owt/tower_top_load", "elevation": "/owt/measured_elevation_used"}[name]
    if not blocks:
        raise InputError(
            "bag", str(bag.path), f"holds nothing on {topic}", "The recording ended before its first block."
        )
    for expected, block in enumerate(blocks):
        if block.sequence != expected:
            raise ComputationError(
                f"{topic}: block {block.sequence} follows block {expected - 1}; the recording has a gap."
            )
    return np.concatenate([getattr(block, name) for block in blocks])
