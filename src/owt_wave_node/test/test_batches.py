"""Batches of members bound the memory, and change no bit of the loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_wave_node.core import assembly
from owt_wave_node.core.loads import LoadWindows, prepare_loads
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import build_sea_state


@pytest.fixture(scope="module")
def windows() -> LoadWindows:
    case = parse_case({"time": {"dt_s": 0.1, "n": 200}})
    sea = build_sea_state(case)
    return prepare_loads(case, build_mesh(load_structure("oc4")), sea, make_field(case, sea))


def test_batches_change_nothing(windows: LoadWindows, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = windows.window(0)
    monkeypatch.setattr(assembly, "PREPARED_BYTES", 2 * 8 * 200 * 50)  # 50 stations
    made = assembly._Assembly(
        windows.case, windows.hydro, windows.frame, windows.field, windows.lowest, windows.highest, True
    )
    assert len(made.batches()) > 10
    parts = windows.window(0)
    assert np.array_equal(parts.nodal, whole.nodal)
    assert np.array_equal(parts.end_rows, whole.end_rows)
    without = replace(windows, keep_ends=False).window(0)
    assert np.array_equal(without.nodal, whole.nodal)
    assert without.end_rows.size == without.element.size == 0
    monkeypatch.setattr(assembly._Assembly, "_add_joints", lambda *_: None)  # the wrong variant: no joints
    assert not np.array_equal(windows.window(0).nodal, whole.nodal)
