"""The basis that `auto` chooses is the same in one process and across the graph; notes cross as well."""

from __future__ import annotations

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message

from owt_campaign.pipeline import prepare_case, run_case
from owt_model.config import parse_case
from owt_ros import convert, decode
from owt_structure_node.core.stage import build_response_model

STRUCTURE = {"model": "oc4-thesis", "reduction": "auto", "tolerance": 0.01}
SHORT = {"time": {"n": 300}, "structure": STRUCTURE}


def test_the_graph_chooses_what_the_process_chooses() -> None:
    run = prepare_case(parse_case(SHORT))
    message = convert.load_basis_message(run.load_basis)
    message = deserialize_message(serialize_message(message), type(message))
    there = build_response_model(run.case, run.mesh, decode.to_load_basis(message)).description
    here = run.response.description
    assert here.reduction == there.reduction != "auto"
    np.testing.assert_array_equal(here.frequency_hz, there.frequency_hz)
    assert here.notes == there.notes
    assert here.notes[0].startswith(f"auto: {here.reduction} meets tolerance 0.01")
    back = convert.reduced_model_message(here)
    assert (
        decode.to_reduced_model(deserialize_message(serialize_message(back), type(back))).notes == here.notes
    )
    # Negative control: another tolerance is another basis.
    strict = parse_case(SHORT | {"structure": STRUCTURE | {"tolerance": 0.0005}})
    assert build_response_model(strict, run.mesh, run.load_basis).description.reduction != here.reduction


def test_loads_of_nothing_leave_the_modes() -> None:
    """Without drag and inertia no augmentation vectors remain: CB10M10 runs as CB10, and says so."""
    nothing = {"morison": {"cd": 0.0, "cm": 0.0}, "time": {"n": 200}}
    case = parse_case(nothing | {"structure": {"model": "oc4-thesis", "reduction": "CB10M10"}})
    reduced = run_case(case).report.reduced
    assert sum(name.startswith("CB.") for name in reduced.coordinate_name) == 10
    assert not any(name.startswith("MTA.") for name in reduced.coordinate_name)
    assert reduced.notes == ("CB10M10 has 0 of 10 augmentation vectors: the loads have 0 independent shapes",)
