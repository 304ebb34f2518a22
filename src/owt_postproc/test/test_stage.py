"""The fatigue stage: streaming equals batch, errors name where they are, the closed form of one stress."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.contracts import StressBlock
from owt_model.errors import ComputationError, InputError
from owt_model.frame import Frame
from owt_postproc.core.hot_spots import POINT_ANGLE_DEG, HotSpots, wall_spots
from owt_postproc.core.rainflow import rainflow
from owt_postproc.core.sn import miner_damage
from owt_postproc.core.stage import FatigueModel, build_fatigue_model, final, initial_state, step

ENDS, N, DT = 11, 1500, 0.02
CASE = parse_case({"fatigue": {"sn_curve": "D_air", "scf": 1.7}})


@pytest.fixture(scope="module")
def stress():
    rng = np.random.default_rng(5)
    axial, y, z = (np.cumsum(rng.normal(size=(N, ENDS)), axis=0) * 1e6 for _ in range(3))
    return axial, y, z, np.abs(axial) + np.hypot(y, z)


def spots(ends: int, scf: float = 1.0) -> HotSpots:
    """Eight points at each of some ends, as of a bar's: an odd end is left out."""
    members = (ends + 1) // 2
    node = np.arange(2 * members).reshape(-1, 2)
    place = np.stack([node.ravel(), np.zeros(2 * members), np.zeros(2 * members)], axis=1) * 1.0
    names, walls = tuple(f"J{i}" for i in node.ravel()), np.full(2 * members, 0.02)
    tied, tubes = np.zeros(2 * members, dtype=bool), tuple(f"M{m}" for m in range(members))
    made = wall_spots(Frame(names, place, tied, tubes, node, 40.0 * walls, walls), scf)
    n = 8 * ends
    return replace(
        made, name=made.name[:n], end=made.end[:n], side=made.side[:n], angle_deg=made.angle_deg[:n],
        thickness_m=made.thickness_m[:n], scf=made.scf[:n], kind=made.kind[:ends], reason=made.reason[:ends],
        start=made.start[: n + 1], term_end=made.term_end[: 3 * n],
        term_component=made.term_component[: 3 * n], term_factor=made.term_factor[: 3 * n],
    )  # fmt: skip


def model_of(case, ends: int) -> FatigueModel:
    return build_fatigue_model(case, spots(ends, case.fatigue.scf))


def blocks(stress, cuts):
    edges = [0, *cuts, len(stress[0])]
    return [
        StressBlock(i, a, DT, b == edges[-1], *(np.ascontiguousarray(x[a:b]) for x in stress))
        for i, (a, b) in enumerate(pairwise(edges))
    ]


def count(stress, cuts, case=CASE):
    model = model_of(case, stress[0].shape[1])
    state, last = initial_state(model), None
    for block in blocks(stress, cuts):
        state, last = step(model, state, block)
    return final(model, state), last


def separately(stress, cuts):
    """Wrong: every block counted by itself."""
    results = [count([x[a:b] for x in stress], [])[0] for a, b in zip([0, *cuts], [*cuts, N], strict=True)]
    return replace(
        results[0],
        damage=sum(r.damage for r in results),
        total_stress=sum(r.total_stress for r in results),
        cycles=sum(r.cycles for r in results),
        histogram=sum(r.histogram for r in results),
    )


def check_same(a, b):
    for name in ("damage", "cycles", "max_range", "total_stress", "histogram", "von_mises_max_range"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def hot_spot(stress, end, point, scf):
    angle = np.deg2rad(POINT_ANGLE_DEG[point])
    axial, y, z, _ = (x[:, end] for x in stress)
    return scf * (axial + y * np.sin(angle) + z * np.cos(angle))


@pytest.mark.parametrize(
    "cuts", [[1], [700], list(range(1, N)), [3, 5, 1000, 1001], list(range(250, N, 250))]
)
def test_any_split_gives_the_same_bits(stress, cuts):
    check_same(count(stress, [])[0], count(stress, cuts)[0])


def test_split_check_would_notice_a_lost_residue(stress):
    with pytest.raises(AssertionError):
        check_same(count(stress, [])[0], separately(stress, [700]))


def test_equals_rainflow_and_miner_on_the_hot_spot(stress):
    result, _ = count(stress, [333, 666])
    for end in range(ENDS):
        for point in range(8):
            ranges, _, counts = rainflow(hot_spot(stress, end, point, 1.7))
            assert result.damage[8 * end + point] == pytest.approx(
                miner_damage(result.curve, ranges, counts), rel=1e-9
            )
            assert result.cycles[8 * end + point] == counts.sum()
            assert result.max_range[8 * end + point] == pytest.approx(ranges.max(), rel=1e-12)
            assert result.histogram[8 * end + point].sum() == counts.sum()
        ranges, _, counts = rainflow(stress[3][:, end])
        assert result.total_stress[end] == pytest.approx(np.sum(ranges * counts), rel=1e-12)
        assert result.total_stress[end] == pytest.approx(
            0.5 * np.abs(np.diff(stress[3][:, end])).sum(), rel=1e-9
        )


def test_histogram_puts_ranges_between_their_edges(stress):
    result, _ = count(stress, [])
    ranges, _, counts = rainflow(hot_spot(stress, 2, 3, 1.7))
    edges = np.concatenate([[0.0], result.range_edge, [np.inf]])
    expected, _ = np.histogram(ranges, edges, weights=counts)
    np.testing.assert_allclose(result.histogram[8 * 2 + 3], expected)


def test_running_block_is_the_result_so_far(stress):
    model = model_of(CASE, ENDS)
    state = initial_state(model)
    for block in blocks(stress, [100, 900]):
        state, running = step(model, state, block)
        so_far = final(model, state)
        np.testing.assert_array_equal(running.damage, so_far.damage.reshape(ENDS, 8).max(axis=1))
        np.testing.assert_array_equal(running.damage, so_far.end_damage)
        np.testing.assert_array_equal(running.cycles, so_far.cycles[so_far.worst_spot])
        np.testing.assert_array_equal(running.angle_deg, model.hot_spots.angle_deg[so_far.worst_spot])
        np.testing.assert_array_equal(running.total_stress, so_far.total_stress)
        np.testing.assert_array_equal(running.max_range, so_far.max_range.reshape(ENDS, 8).max(axis=1))
        assert running.samples_counted == state.samples == block.start + len(block.axial)
        assert running.time_ns == round((running.samples_counted - 1) * DT * 1e9)
        assert running.last == block.last
        assert running.sequence == block.sequence


def test_states_are_not_changed(stress):
    model = model_of(CASE, ENDS)
    first, second = blocks(stress, [800])
    middle, _ = step(model, initial_state(model), first)
    kept = {name: np.array(value, copy=True) for name, value in vars(middle).items()}
    end, _ = step(model, middle, second)
    final(model, middle)
    for name, value in kept.items():
        np.testing.assert_array_equal(value, getattr(middle, name))
    again, _ = step(model, middle, second)
    check_same(final(model, end), final(model, again))


def test_residue_may_grow_beyond_its_first_room():
    t = np.arange(4000)
    decaying = (np.cos(np.pi * t / 2.0) * np.exp(-t / 3000.0) * 1e8)[:, None]
    series = [decaying, 0 * decaying, 0 * decaying, np.abs(decaying)]
    case = parse_case({})
    result, _ = count(series, [10, 1200, 2500], case)
    ranges, _, counts = rainflow(decaying[:, 0])
    assert np.count_nonzero(counts == 0.5) > 1000
    assert result.damage[0] == pytest.approx(miner_damage(result.curve, ranges, counts), rel=1e-9)


def test_nothing_happens_to_constant_stress():
    constant = [np.full((50, 2), 1e6)] * 4
    result, running = count(constant, [20])
    assert not result.damage.any()
    assert not result.total_stress.any()
    assert not running.cycles.any()


def test_unknown_curve_and_no_ends():
    with pytest.raises(InputError, match=r"fatigue\.sn_curve"):
        model_of(parse_case({"fatigue": {"sn_curve": "Z"}}), 1)
    with pytest.raises(InputError, match="n_ends"):
        model_of(CaseConfig(), 0)


def broken(block, **changes):
    return replace(block, **changes)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sequence": 2}, "sequence 2: expected sequence 1; a block was lost"),
        ({"sequence": 0}, "sequence 0: expected sequence 1"),
        ({"start": 901}, "starts at sample 901, expected 800"),
        ({"dt": 0.04}, "sampled at 0.04 s, expected 0.02 s"),
    ],
)
def test_gap_is_an_error(stress, change, message):
    model = model_of(CASE, ENDS)
    first, second = blocks(stress, [800])
    state, _ = step(model, initial_state(model), first)
    with pytest.raises(ComputationError, match=f"member_stress .*{message}"):
        step(model, state, broken(second, **change))


@pytest.mark.parametrize("name", ["axial", "bending_y", "bending_z", "von_mises"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_not_finite_names_stream_sequence_and_sample(stress, name, bad):
    model = model_of(CASE, ENDS)
    first, second = blocks(stress, [800])
    values = getattr(second, name).copy()
    values[17, 4] = bad
    state, _ = step(model, initial_state(model), first)
    with pytest.raises(ComputationError, match=f"member_stress sequence 1: {name} is .* sample 17 .* end 4"):
        step(model, state, broken(second, **{name: values}))


def test_block_after_the_last_is_an_error(stress):
    model = model_of(CASE, ENDS)
    (only,) = blocks(stress, [])
    state, _ = step(model, initial_state(model), only)
    with pytest.raises(ComputationError, match="after the block marked last"):
        step(model, state, broken(only, sequence=1, start=N))


def test_wrong_number_of_ends(stress):
    model = model_of(CASE, ENDS + 1)
    with pytest.raises(ComputationError, match=r"axial has shape \(1500, 11\), expected \(1500, 12\)"):
        step(model, initial_state(model), blocks(stress, [])[0])
