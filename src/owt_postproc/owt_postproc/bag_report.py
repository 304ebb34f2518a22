"""Report data and fatigue results from a recorded bag: the stages of a run, fed with what was recorded."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from owt_model.config import parse_case
from owt_model.contracts import ReducedDescription, StressBlock, sea_facts
from owt_model.errors import InputError
from owt_postproc.bag_reader import PREFIX, BagMessage, read_files, read_messages, to_block
from owt_postproc.core.stage import (
    FatigueModel,
    FatigueState,
    build_fatigue_model,
    final,
    initial_state,
    step,
)
from owt_postproc.report_data import Geometry, ReportCollector, ReportData
from owt_ros.decode import to_reduced_model

__all__ = ["bag_report"]

TYPES = tuple(
    PREFIX + name
    for name in (
        "ModelDescription",
        "SeaState",
        "ReducedModel",
        "SurfaceElevation",
        "NodalLoads",
        "ModalState",
        "MemberStress",
        "Energy",
    )
)


def bag_report(bag: str | Path, *, versions: Mapping[str, str] | None = None) -> ReportData:
    """Read a bag and count its stress; needs the case attached to it as ``case.json``.

    Parameters
    ----------
    bag : path
        Bag folder.
    versions : mapping, optional
        Replaces those in the bag's metadata record ``versions``.

    Raises
    ------
    InputError
        If the bag is not readable, or lacks the case or the model.
    ComputationError
        If a stream in it has a gap or is not finite.
    """
    files = read_files(bag)
    if not files.case:
        raise InputError("bag", str(bag), "holds no case", "Record it with the bring-up of this project.")
    case = parse_case(files.case, source="case.json in the bag")
    reduced: ReducedDescription | None = None
    collector: ReportCollector | None = None
    model: FatigueModel | None = None
    state: FatigueState | None = None
    geometry, sea = None, dict[str, Any]()
    waiting: list[BagMessage] = []
    for message in read_messages(bag, types=TYPES):
        kind = message.type_name.removeprefix(PREFIX)
        if kind == "ModelDescription":
            geometry = _geometry(message.content)
        elif kind == "SeaState":
            sea = {name: _plain(value) for name, value in sea_facts(message.content).items()}
        elif kind == "ReducedModel":
            reduced = to_reduced_model(message.content)
            collector = ReportCollector(reduced.tower_top_coordinate)
            model = build_fatigue_model(case, len(reduced.end_name))
            state = initial_state(model)
        else:
            waiting.append(message)
        if collector is None or model is None or state is None:
            continue
        for ready in waiting:
            block = to_block(ready)
            if block is None:
                continue
            collector.add(block)
            if isinstance(block, StressBlock):
                state, _ = step(model, state, block)
        waiting.clear()
    if collector is None or model is None or state is None or reduced is None:
        raise InputError(
            "bag", str(bag), "holds no reduced model", "The recording ended before its first block."
        )
    return collector.finish(
        case=case.model_dump(mode="json"),
        reduced=reduced,
        fatigue=final(model, state),
        geometry=geometry,
        sea_state=sea,
        versions=files.metadata.get("versions", {}) if versions is None else versions,
    )


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _geometry(content: Any) -> Geometry:
    members = len(content.member_name)
    elements = content.element_node.reshape(-1, 2).astype(np.int64)
    return Geometry(
        node=content.node_position_m.reshape(-1, 3),
        member_node=content.member_node.reshape(-1, 2).astype(np.int64),
        tower_node=elements[np.asarray(content.element_member) >= members],
    )
