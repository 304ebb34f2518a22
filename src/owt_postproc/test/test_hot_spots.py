"""Hot spots: chords and planes found, pure load paths exact, superposition by hand, axes of elements."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from owt_model.axes import rotation
from owt_model.errors import InputError
from owt_model.fatigue_config import Fatigue
from owt_model.frame import Frame, frame_of_mesh
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_postproc.core import efthymiou as eq
from owt_postproc.core.efthymiou import Shape
from owt_postproc.core.hot_spots import POINT_ANGLE_DEG, HotSpots, build_hot_spots
from owt_postproc.core.joints import find_joints
from tubular import (
    BRACE,
    CHORD,
    CHORDS,
    WALL_B,
    WALL_T,
    around,
    brace,
    end_of,
    frame_of,
    k_frame,
    response,
    shape,
    spots_of,
)


def test_t_joint_alone():
    frame = frame_of(CHORDS | {"B": brace(90.0)})
    made, p = spots_of(frame), shape(90.0)
    end = end_of(frame, "B")
    assert made.kind[end] == "T/Y"
    np.testing.assert_allclose(
        response(made, end, "chord", axial={end: 1.0}), around(eq.t6(p, 0.5), eq.t5(p, 0.5)), rtol=1e-12
    )
    np.testing.assert_allclose(
        response(made, end, "brace", axial={end: 1.0}), around(eq.t7(p, 0.5), eq.t3(p)), rtol=1e-12
    )
    assert made.thickness_m[made.end == end].tolist() == 8 * [WALL_T] + 8 * [WALL_B]
    assert "is the chord at J" in made.reason


def zeta(frame: Frame, first: str = "A", second: str = "B") -> float:
    """Gap of two braces over the chord's diameter, from feet and footprints."""
    found = find_joints(frame).connection
    a, b = found[end_of(frame, first)], found[end_of(frame, second)]
    foot = [0.5 * CHORD / math.tan(c.theta) * math.copysign(1.0, c.along) for c in (a, b)]
    print_ = [0.5 * c.diameter / math.sin(c.theta) for c in (a, b)]
    return (abs(foot[0] - foot[1]) - sum(print_)) / CHORD


def check_balanced(hot_spots: HotSpots, frame: Frame, factor: float, side: str, other: float) -> None:
    """Two axial forces that balance across the chord give `factor` all round brace A."""
    a, b = end_of(frame, "A"), end_of(frame, "B")
    found = response(hot_spots, a, side, axial={a: 1.0, b: other})
    np.testing.assert_allclose(found, factor, rtol=1e-10)


def test_balanced_k_joint_is_exact():
    frame = k_frame()
    made, p, q, z = spots_of(frame), shape(45.0), shape(60.0), zeta(frame)
    assert z > 0.0
    balance = -math.sin(p.theta) / math.sin(q.theta)
    check_balanced(made, frame, eq.k1(p, [q], z), "chord", balance)
    check_balanced(made, frame, eq.k2(p, [q], z, 0.0), "brace", balance)
    end = end_of(frame, "A")
    assert made.kind[end] == "K"
    # One brace alone is T/Y.
    np.testing.assert_allclose(
        response(made, end, "chord", axial={end: 1.0}), around(eq.t6(p, 0.5), eq.t5(p, 0.5)), rtol=1e-12
    )
    # Negative control: forces of one sign do not balance.
    with pytest.raises(AssertionError):
        check_balanced(made, frame, eq.k1(p, [q], z), "chord", -balance)


def test_axial_load_through_the_chord_is_exact():
    frame = frame_of(CHORDS | {"A": brace(60.0), "B": brace(60.0, 180.0, up=False)})
    made, p = spots_of(frame), shape(60.0)
    a, b = end_of(frame, "A"), end_of(frame, "B")
    assert made.kind[a] == "X"
    for side, crown, saddle in (("chord", eq.x2(p), eq.x1(p)), ("brace", eq.x4(p), eq.x3(p))):
        both = response(made, a, side, axial={a: 1.0, b: 1.0})
        np.testing.assert_allclose(both, around(crown, saddle), rtol=1e-12)
        # Negative control: pull and push across the chord is another path.
        assert not np.allclose(response(made, a, side, axial={a: 1.0, b: -1.0}), around(crown, saddle))
    alone = response(made, a, "chord", axial={a: 1.0})
    assert alone[2] == pytest.approx((1.0 - 0.26 * p.beta**3) * eq.t5(p, 0.5), rel=1e-12)


def test_kt_joint_with_equal_gaps_is_exact():
    frame = frame_of(CHORDS | {"A": brace(45.0), "B": brace(90.0), "D": brace(45.0, up=False)})
    made = spots_of(frame)
    a, b, d = (end_of(frame, name) for name in "ABD")
    assert made.kind[b] == "KT"
    p, q = shape(45.0), shape(90.0)
    gap = zeta(frame, "A", "B")
    # The outer braces balance each other across the central one (table B.8.4).
    across = 2.0 * gap + q.beta
    found = response(made, a, "chord", axial={a: 1.0, d: -1.0})
    np.testing.assert_allclose(found, eq.k1(p, [p], across), rtol=1e-10)
    # Both balance the central brace.
    share = -0.5 / math.sin(p.theta)
    found = response(made, b, "chord", axial={b: 1.0, a: share, d: share})
    np.testing.assert_allclose(found, eq.k1(q, [p], gap), rtol=1e-10)
    # Out-of-plane bending alike in all: KT2 at the central brace.
    near = eq.near(q, p, gap)
    power = (p.beta / q.beta) ** 2
    kt2 = eq.t10(q) * near ** (2.0 * power) + 2.0 * eq.carried(q, p, gap, p.beta)
    joints = find_joints(frame).connection
    stress = {end: out_of_plane(frame, end, joints[b].normal, joints[end]) for end in (a, b, d)}
    found = response(
        made, b, "chord",
        bending_y={end: s[0] for end, s in stress.items()},
        bending_z={end: s[1] for end, s in stress.items()},
    )  # fmt: skip
    assert found[2] == pytest.approx(kt2, rel=1e-10)
    assert found[6] == pytest.approx(-kt2, rel=1e-10)


def out_of_plane(frame: Frame, end: int, side: np.ndarray, connection) -> tuple[float, float]:
    """bending_y and bending_z of an end that has unit stress at the saddle on a given side."""
    normal = connection.normal if connection.normal @ side > 0.0 else -connection.normal
    first, last = frame.node_position[frame.member_node[end // 2]]
    _, y, z = rotation(first, last)
    return float(normal @ z), float(normal @ y)


def test_unbalanced_out_of_plane_bending_of_a_k_joint_is_exact():
    frame = k_frame()
    made, p, q, z = spots_of(frame), shape(45.0), shape(60.0), zeta(k_frame())
    joints = find_joints(frame).connection
    a, b = end_of(frame, "A"), end_of(frame, "B")
    stress = {end: out_of_plane(frame, end, joints[a].normal, joints[end]) for end in (a, b)}
    k4 = eq.t10(p) * eq.near(p, q, z) + eq.carried(p, q, z, p.beta)
    found = response(
        made, a, "brace",
        bending_y={end: s[0] for end, s in stress.items()},
        bending_z={end: s[1] for end, s in stress.items()},
    )  # fmt: skip
    assert found[2] == pytest.approx(k4 * eq.brace_of_out_of_plane(p), rel=1e-10)


def dnv(ac, ax, mip, mop, x, y, z):
    """Sigma 1 to 8 of DNV-RP-C203, 3.3.2, as printed; numbered against the direction of the angle here."""
    h, r = 0.5, 0.5 * math.sqrt(2.0)
    return [
        ac * x + mip * y,
        h * (ac + ax) * x + r * mip * y - r * mop * z,
        ax * x - mop * z,
        h * (ac + ax) * x - r * mip * y - r * mop * z,
        ac * x - mip * y,
        h * (ac + ax) * x - r * mip * y + r * mop * z,
        ax * x + mop * z,
        h * (ac + ax) * x + r * mip * y + r * mop * z,
    ]


def test_superposition_by_hand():
    """Factors 2, 5, 3, 4; 10 MPa axial, 20 in-plane and 30 out-of-plane: 80 at the toe, 170 at 90 degrees."""
    own = {"axial_crown": 2.0, "axial_saddle": 5.0, "in_plane": 3.0, "out_of_plane": 4.0}
    frame = frame_of(CHORDS | {"B": brace(60.0)})
    made = spots_of(frame, joints={"J": {"scf": {"chord": own, "brace": own}}})
    end = end_of(frame, "B")
    connection = find_joints(frame).connection[end]
    _, y, z = rotation(*frame.node_position[frame.member_node[end // 2]])
    # The signed nominal stress of the fibre in direction n is by (n z) + bz (n y).
    vector = 20.0 * connection.crown + 30.0 * connection.normal
    found = response(
        made, end, "chord", axial={end: 10.0}, bending_y={end: vector @ z}, bending_z={end: vector @ y}
    )
    wanted = dnv(2.0, 5.0, 3.0, 4.0, 10.0, 20.0, -30.0)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)
    assert found[0] == pytest.approx(80.0)
    assert found[2] == pytest.approx(170.0)
    # Negative control: bending the other way out of plane.
    assert not np.allclose(found, dnv(2.0, 5.0, 3.0, 4.0, 10.0, 20.0, 30.0))


@pytest.mark.parametrize("theta", [35.0, 60.0, 90.0])
@pytest.mark.parametrize("seed", range(3))
def test_orientation_of_members_changes_nothing(theta, seed):
    """A structure turned in space, members from their other end: the same physical state, the same stress."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    force, moment = 7.0, rng.standard_normal(3)
    results = []
    for reverse, how in ((False, np.eye(3)), (True, np.eye(3)), (False, turn), (True, turn)):
        lines = CHORDS | {"B": brace(theta, 20.0)}
        if reverse:
            lines["B"] = lines["B"][::-1]
        frame = frame_of(lines)
        frame = replace(frame, node_position=frame.node_position @ how.T)
        made, end = spots_of(frame), end_of(frame, "B")
        start, stop = frame.node_position[frame.member_node[end // 2]]
        x, y, z = rotation(start, stop)
        # The stress of a fibre follows its place by a vector across the brace that turns with the structure.
        out = frame.outwards(end) / np.linalg.norm(frame.outwards(end))
        gradient = how @ moment
        gradient = gradient - (gradient @ out) * out
        found = response(
            made,
            end,
            "chord",
            axial={end: force},
            bending_y={end: gradient @ z},
            bending_z={end: gradient @ y},
        )
        results.append(found)
        assert abs(x @ out) == pytest.approx(1.0)
    for other in results[1:]:
        # Square to the chord, toe and heel are a matter of order: points run the same way from either.
        same = np.allclose(other, results[0], rtol=1e-9)
        turned = theta == 90.0 and np.allclose(np.roll(other, 4), results[0], rtol=1e-9)
        assert same or turned
    assert not np.allclose(np.roll(results[0], 1), results[0])


def test_crossing_braces_of_one_size_stand_on_each_other():
    lines = {
        "B1": brace(45.0), "B2": brace(45.0, up=False), "B3": brace(45.0, 180.0),
        "B4": brace(45.0, 180.0, up=False),
    }  # fmt: skip
    frame = frame_of(lines)
    found = find_joints(frame).connection
    ends = [end_of(frame, name) for name in lines]
    assert sorted(found) == sorted(ends)
    assert found[ends[0]].chord == (ends[1], ends[2])
    assert found[ends[1]].chord == (ends[0], ends[3])
    made = spots_of(frame)
    assert {made.kind[end] for end in ends} == {"X"}
    # A thicker pair, or the case, says which runs through.
    thick = frame_of(lines, {"B1": (BRACE, 0.03), "B4": (BRACE, 0.03)})
    assert sorted(find_joints(thick).connection) == [ends[1], ends[2]]
    choice = Fatigue.model_validate({"joints": {"J": {"chord": ("B2", "B3")}}}).joints
    assert sorted(find_joints(frame, choice).connection) == [ends[0], ends[3]]


def test_ends_without_a_connection_say_why():
    tied = frame_of(CHORDS | {"B": brace(90.0)})
    tied.node_tied[tied.node_name.index("J")] = True
    assert find_joints(tied).reason[end_of(tied, "B")] == "J is part of a rigid body"
    equal = frame_of({"B1": brace(90.0), "B2": brace(90.0, 90.0)})
    assert (
        find_joints(equal).reason[end_of(equal, "B1")].startswith("no member at J runs through or is larger")
    )
    assert "no other member ends at" in " ".join(find_joints(equal).reason)
    with pytest.raises(InputError, match=r"fatigue\.joints\.J99"):
        spots_of(equal, joints={"J99": {"gap_m": 0.1}})
    with pytest.raises(InputError, match="does not end at J"):
        spots_of(equal, joints={"J": {"chord": ("M7",)}})


def test_range_is_reported_clamped_or_refused():
    thin = frame_of(CHORDS | {"B": brace(90.0)}, {"C1": (CHORD, 0.01), "C2": (CHORD, 0.01)})
    end = end_of(thin, "B")
    reported = spots_of(thin, chord_effect="frame")
    assert any(
        "gamma of 1 brace ends in T/Y joints" in note and "limit 32" in note for note in reported.notes
    )
    p = Shape(0.5, 50.0, 2.0, math.pi / 2, 12.0)
    assert reported.scf[reported.end == end][0, 1] == pytest.approx(eq.t5(p, 0.5))
    clamped = spots_of(thin, scf_range="clamp", chord_effect="frame")
    limit = Shape(0.5, 32.0, 1.0, math.pi / 2, 12.0)
    assert clamped.scf[clamped.end == end][0, 1] == pytest.approx(eq.t5(limit, 0.5))
    larger = spots_of(thin, scf_range="larger", chord_effect="frame")
    assert (larger.scf[larger.end == end][:, :4] >= reported.scf[reported.end == end][:, :4]).all()
    with pytest.raises(InputError, match=r"fatigue\.scf_range = 'refuse, gamma = 50 at B:J'"):
        spots_of(thin, scf_range="refuse")
    inside = spots_of(frame_of(CHORDS | {"B": brace(90.0)}), chord_effect="frame")
    assert not any("range" in note for note in inside.notes)


def test_nominal_stress_of_the_chord_counts_at_its_crowns():
    frame = frame_of(CHORDS | {"B": brace(60.0)})
    made = spots_of(frame, chord_effect="frame")
    end, chord = end_of(frame, "B"), [end_of(frame, "C1"), end_of(frame, "C2")]
    pull = response(made, end, "chord", axial=dict.fromkeys(chord, 1.0))
    np.testing.assert_allclose(pull, 1.25 * np.cos(np.radians(POINT_ANGLE_DEG)) ** 2, atol=1e-14)
    assert not response(made, end, "brace", axial=dict.fromkeys(chord, 1.0)).any()
    # Bending that pulls the side of the brace; the other way gives the other sign.
    stress = {}
    for c in chord:
        _, y, z = rotation(*frame.node_position[frame.member_node[c // 2]])
        stress[c] = (np.array([1.0, 0.0, 0.0]) @ z, np.array([1.0, 0.0, 0.0]) @ y)
    bent = response(
        made, end, "chord",
        bending_y={c: s[0] for c, s in stress.items()}, bending_z={c: s[1] for c, s in stress.items()},
    )  # fmt: skip
    np.testing.assert_allclose(bent, pull, atol=1e-14)


def test_own_factors_replace_those_of_the_joint():
    frame = k_frame()
    a, b = end_of(frame, "A"), end_of(frame, "B")
    made = spots_of(frame, joints={"A:J": {"scf": {"chord": {"axial_saddle": 9.0}}}})
    p = shape(45.0)
    saddle = response(made, a, "chord", axial={a: 1.0, b: 1.0})[2]
    assert saddle == pytest.approx(9.0)
    alone = response(made, a, "chord", axial={a: 1.0})
    assert alone[0] == pytest.approx(eq.t6(p, 0.5))
    assert response(made, b, "chord", axial={b: 1.0})[2] == pytest.approx(eq.t5(shape(60.0), 0.5))


def test_oc4_has_its_joints():
    frame = frame_of_mesh(build_mesh(load_structure("oc4-thesis")))
    made = build_hot_spots(frame, Fatigue())
    kinds = {kind: made.kind.count(kind) for kind in set(made.kind)}
    assert kinds == {"X": 64, "K": 48, "T/Y": 24, "": 80}
    assert made.n_spots == 136 * 16 + 80 * 8
    assert np.array_equal(np.sort(made.end), made.end)
    # Four legs and four sides alike: an end and its image have the same factors.
    factors = {tuple(np.round(np.nan_to_num(row), 3)) for row in made.scf[made.scf[:, 0] > 0]}
    assert len(factors) < 40
