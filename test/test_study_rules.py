"""How studies judge: the rules that their pages state, and the members that chapter 5.2 looks at."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from owt_campaign.studies.eigen import EigenStudy, thesis_tables
from owt_campaign.studies.eigen_page import eigen_result
from owt_campaign.studies.focus import focus_members, splash_zone
from owt_campaign.studies.result import agreement
from owt_campaign.studies.wave_totals import Members
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure


@pytest.mark.parametrize(
    ("ours", "printed", "outcome"),
    [
        (2.0, (2.0, 3.0), "reproduced"),
        (3.7, (2.0, 3.0), "reproduced"),
        (3.8, (2.0, 3.0), "partly"),
        (6.1, (2.0, 3.0), "not"),
        (-2.5, (2.0, 3.0), "not"),
        (-16.0, (-20.0,), "reproduced"),
        (-11.0, (-20.0,), "partly"),
        (-9.0, (-20.0,), "not"),
        (20.0, (-20.0,), "not"),
        (44.5, (400.0,), "not"),
    ],
)
def test_a_number_beside_the_print(ours: float, printed: tuple[float, ...], outcome: str) -> None:
    assert agreement(ours, *printed) == outcome


def test_the_piece_half_way_down_stands_in_the_leg_of_the_heaviest() -> None:
    mesh = build_mesh(load_structure("oc4-thesis"))
    members = Members.of(mesh)
    place = {name: i for i, name in enumerate(members.name)}
    total = np.full(len(members.name), 0.1)
    total[[place["M001"], place["M002"], place["M017"], place["M025"]]] = 1.0, 0.8, 0.60, 0.61
    focus = focus_members(mesh, members, total)
    assert focus.heaviest == place["M001"]
    assert focus.half_way == place["M017"]  # not M025, which is heavier and in another leg
    assert focus.rival == place["M025"]
    assert (focus.rank, focus.rank_long) == (4, 2)
    assert focus.lead() == pytest.approx(0.60 / 0.61 - 1.0)
    total[place["M009"]] = 2.0  # the foot of the leg that M025 stands in
    assert focus_members(mesh, members, total).half_way == place["M025"]


def test_splash_zone_is_where_still_water_cuts_members() -> None:
    mesh = build_mesh(load_structure("oc4-thesis"))
    found = {name for name, cut in zip(mesh.member_name, splash_zone(mesh), strict=True) if cut}
    assert len(found) == 12
    assert {"M018", "M070"} <= found
    assert not {"M086", "M069", "M001"} & found


def test_eigen_verdict_follows_from_its_rows() -> None:
    """Printed values themselves are all reproduced; one column of another structure is not."""
    printed = thesis_tables()
    b3 = {**printed["table_B3"], "damping-modal": printed["table_B3"]["damping"]}
    match = {name: [(i, 1.0) for i in range(20)] for name in ("CB00", "CB20", "M20", "CB10M10")}
    same = EigenStudy(printed["table_B1"], match, printed["table_B2"], "EEBABEEABA", b3)
    right = eigen_result(same, printed)
    assert right.verdict.outcome == "reproduced"
    assert len(right.rows) == 20 * 5 + 10 + 3 * 2 * 20
    other = {**printed["table_B1"], "CB20": [1.1 * f for f in printed["table_B1"]["CB20"]]}
    wrong = eigen_result(dataclasses.replace(same, table_b1=other), printed)
    assert wrong.verdict.outcome == "partly"
    assert "20 do not" in wrong.verdict.why
    assert "Largest differences up to mode 10: full 0.0 %" in wrong.page
