"""Hot spots: chords and planes found, pure load paths exact, superposition by hand, axes of elements."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from owt_model.axes import rotation
from owt_model.config import parse_case
from owt_model.contracts import StressBlock
from owt_model.errors import InputError
from owt_model.fatigue_config import Fatigue
from owt_model.frame import Frame, frame_of_mesh
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_postproc.core import efthymiou as eq
from owt_postproc.core.efthymiou import Shape
from owt_postproc.core.hot_spots import POINT_ANGLE_DEG, HotSpots, build_hot_spots
from owt_postproc.core.joints import find_joints
from owt_postproc.core.sn import sn_curve
from owt_postproc.core.stage import build_fatigue_model, final, initial_state, step

#: No floor under the factors, no nominal stress of the chord: what the equations say, and nothing else.
BARE = {"scf_minimum": 0.0, "chord_effect": "length", "chord_fixity": 0.5}
CHORD, WALL_T, BRACE, WALL_B = 1.0, 0.04, 0.5, 0.02


def frame_of(
    lines: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]],
    size: dict[str, tuple[float, float]] | None = None,
) -> Frame:
    """Members between points; those whose name begins with C are chords."""
    places = list(dict.fromkeys(tuple(p) for line in lines.values() for p in line))
    node = np.array([[places.index(p) for p in line] for line in lines.values()])
    default = {name: (CHORD, WALL_T) if name.startswith("C") else (BRACE, WALL_B) for name in lines}
    walls = np.array([(default | (size or {}))[name] for name in lines])
    return Frame(
        node_name=tuple("J" if p == (0.0, 0.0, 0.0) else f"N{i}" for i, p in enumerate(places)),
        node_position=np.array(places),
        node_tied=np.zeros(len(places), dtype=bool),
        member_name=tuple(lines),
        member_node=node,
        end_diameter=np.repeat(walls[:, 0], 2),
        end_thickness=np.repeat(walls[:, 1], 2),
    )


O = (0.0, 0.0, 0.0)
CHORDS = {"C1": ((0.0, 0.0, -20.0), O), "C2": (O, (0.0, 0.0, 20.0))}


def brace(theta_deg: float, azimuth_deg: float = 0.0, *, up: bool = True, length: float = 10.0):
    """Brace from the joint at an angle to the upright chord."""
    s, a = math.radians(theta_deg), math.radians(azimuth_deg)
    z = math.cos(s) if up else -math.cos(s)
    return O, (
        length * math.sin(s) * math.cos(a),
        length * math.sin(s) * math.sin(a),
        length * z,
    )


def shape(theta_deg: float, alpha: float = 80.0) -> Shape:
    return Shape(BRACE / CHORD, CHORD / (2 * WALL_T), WALL_B / WALL_T, math.radians(theta_deg), alpha)


def spots_of(frame: Frame, **choices) -> HotSpots:
    return build_hot_spots(frame, Fatigue.model_validate({**BARE, **choices}))


def end_of(frame: Frame, member: str, joint: str = "J") -> int:
    return frame.end_name.index(f"{member}:{joint}")


def response(hot_spots: HotSpots, end: int, side: str, **stress: dict[int, float]) -> np.ndarray:
    """Stress at the eight points of a side under constant nominal stress of some ends."""
    given = {name: np.zeros((1, hot_spots.n_ends)) for name in ("axial", "bending_y", "bending_z")}
    for name, values in stress.items():
        for at, value in values.items():
            given[name][0, at] = value
    chosen = [i for i in range(hot_spots.n_spots) if hot_spots.end[i] == end and hot_spots.side[i] == side]
    return np.array([hot_spots.stress(i, **given)[0] for i in chosen])


def around(crown: float, saddle: float) -> np.ndarray:
    angle = np.radians(POINT_ANGLE_DEG)
    return crown * np.cos(angle) ** 2 + saddle * np.sin(angle) ** 2


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


def k_frame() -> Frame:
    return frame_of(CHORDS | {"A": brace(45.0), "B": brace(60.0, up=False)})


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


# --- counting -----------------------------------------------------------------------------------------------


def sine_damage(case: dict, frame: Frame, amplitude: dict[str, float], cycles: int = 20) -> tuple:
    """Result of a sine in some channels of every end of the brace."""
    parsed = parse_case(case)
    made = build_hot_spots(frame, parsed.fatigue)
    model = build_fatigue_model(parsed, made)
    wave = np.sin(2 * np.pi * np.arange(cycles * 40 + 1) / 40)
    given = {
        name: np.zeros((len(wave), made.n_ends)) for name in ("axial", "bending_y", "bending_z", "von_mises")
    }
    end = end_of(frame, "B")
    for name, value in amplitude.items():
        given[name][:, end] = value * wave
    given["von_mises"] = np.abs(given["axial"]) + np.hypot(given["bending_y"], given["bending_z"])
    state, _ = step(model, initial_state(model), StressBlock(0, 0, model.dt, True, **given))
    return final(model, state), made, end


def test_damage_of_a_sine_in_closed_form_and_scaling():
    """19.5 cycles of 2 x SCF x amplitude, and half a cycle of half the range at either end: 19.5 + 2^-m.

    c times the stress is c^m times the damage on one slope.
    """
    frame = frame_of(CHORDS | {"B": brace(90.0)})
    case = {"fatigue": {"sn_curve": "D_air", "chord_effect": "length", "chord_fixity": 0.5}}
    one, made, end = sine_damage(case, frame, {"axial": 20e6})
    saddle = made.name.index("B:J chord 90")
    scf = eq.t5(shape(90.0), 0.5)
    curve = sn_curve("D_air")
    stress_range = 2.0 * 20.0 * scf
    factor = (WALL_T / curve.reference_thickness_m) ** curve.thickness_exponent
    cycles = 10.0 ** curve.log10_a[0] * (stress_range * factor) ** -curve.m[0]
    assert one.damage[saddle] == pytest.approx((19.5 + 2.0 ** -curve.m[0]) / cycles, rel=1e-9)
    assert int(one.worst_spot[end]) == int(np.argmax(one.damage))
    two, _, _ = sine_damage(case, frame, {"axial": 40e6})
    assert two.damage[saddle] == pytest.approx(one.damage[saddle] * 2.0 ** curve.m[0], rel=1e-9)


def test_thin_walls_have_no_thickness_effect():
    """Below the reference thickness a wall counts as the reference; thicker ones are weaker."""
    curve = sn_curve("D_air")
    thin, thick = curve.reference_thickness_m * 0.5, curve.reference_thickness_m * 2.0
    found = {}
    for wall in (thin, curve.reference_thickness_m, thick):
        frame = frame_of({"B": (O, (0.0, 0.0, 10.0))}, {"B": (BRACE, wall)})
        for effect in (True, False):
            case = {"fatigue": {"sn_curve": "D_air", "hot_spots": "nominal", "thickness_effect": effect}}
            result, _, _ = sine_damage(case, frame, {"axial": 100e6})
            found[wall, effect] = result.damage.max()
    assert found[thin, True] == found[thin, False] == found[curve.reference_thickness_m, True]
    ratio = found[thick, True] / found[thick, False]
    assert ratio == pytest.approx(2.0 ** (curve.thickness_exponent * curve.m[0]), rel=1e-9)


@pytest.mark.parametrize(("amplitude", "slope", "ratio"), [(100e6, 3.0, 0.25), (5e6, 5.0, 0.07)])
def test_unsigned_stress_loses_damage(amplitude, slope, ratio):
    """Alternating bending: the unsigned stress has half the range at twice the rate, 2 (1/2)^m of the damage.

    The acceptance value for m = 5, 0.07, is 2/32 = 0.0625 rounded up: the tolerance covers it.
    """
    frame = frame_of(CHORDS | {"B": brace(90.0)})
    case = {"fatigue": {"sn_curve": "D_air", "hot_spots": "nominal", "thickness_effect": False}}
    signed, made, end = sine_damage(case, frame, {"bending_z": amplitude}, cycles=200)
    wave = amplitude * np.sin(2 * np.pi * np.arange(200 * 40 + 1) / 40)
    model = build_fatigue_model(parse_case(case), made)
    zero = np.zeros((len(wave), made.n_ends))
    folded = zero.copy()
    folded[:, end] = np.abs(wave)
    block = StressBlock(0, 0, model.dt, True, folded, zero, zero, folded)
    unsigned = final(model, step(model, initial_state(model), block)[0])
    found = unsigned.damage.max() / signed.damage.max()
    assert found == pytest.approx(2.0 * 0.5**slope, rel=0.02)
    assert found == pytest.approx(ratio, abs=0.01)


def random_blocks(n_ends: int, cuts: list[int]) -> list[StressBlock]:
    rng = np.random.default_rng(3)
    series = [np.cumsum(rng.normal(size=(900, n_ends)), axis=0) * 1e6 for _ in range(3)]
    series.append(np.abs(series[0]))
    edges = [0, *cuts, 900]
    return [
        StressBlock(i, a, 0.02, b == 900, *(np.ascontiguousarray(x[a:b]) for x in series))
        for i, (a, b) in enumerate(pairwise(edges))
    ]


@pytest.mark.parametrize("threads", ["1", "2", "5"])
@pytest.mark.parametrize("cuts", [[1, 400], list(range(7, 900, 7))])
def test_splits_and_threads_change_no_bit(monkeypatch, threads, cuts):
    frame = k_frame()
    model = build_fatigue_model(parse_case({}), build_hot_spots(frame, Fatigue()))
    whole, _ = step(model, initial_state(model), random_blocks(frame.n_ends, [])[0])
    monkeypatch.setenv("OWT_THREADS", threads)
    monkeypatch.setattr("owt_postproc.core.stage.WORTH_A_THREAD", 1)
    state = initial_state(model)
    for block in random_blocks(frame.n_ends, cuts):
        state, running = step(model, state, block)
    one, two = final(model, whole), final(model, state)
    for name in ("damage", "cycles", "max_range", "histogram", "total_stress"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    np.testing.assert_array_equal(running.damage, two.end_damage)
    worst = two.worst_spot
    assert [("wall", "chord", "brace")[i] for i in running.side] == [two.hot_spots.side[i] for i in worst]


def test_stress_of_a_spot_is_what_is_counted():
    frame = k_frame()
    model = build_fatigue_model(parse_case({}), build_hot_spots(frame, Fatigue()))
    (block,) = random_blocks(frame.n_ends, [])
    result = final(model, step(model, initial_state(model), block)[0])
    for spot in (0, 20, result.hot_spots.n_spots - 1, int(np.argmax(result.damage))):
        series = result.hot_spots.stress(spot, block.axial, block.bending_y, block.bending_z)
        assert result.max_range[spot] == pytest.approx(np.ptp(series), rel=1e-12)
