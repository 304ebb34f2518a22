"""Samples that come one by one: order, gaps, duplicates, what is made up, and what is said of it."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import ComputationError
from owt_model.live_samples import LiveRules, SampleBuffer

MS = 1_000_000
GRID = np.arange(40) * 100 * MS
#: Jittered stamps before the first sample and past the last, with a drop-out from 1.5 to 2.5 s.
RNG = np.random.default_rng(3)
STAMPS = np.arange(-1, 42) * 100 * MS + RNG.integers(-40 * MS, 40 * MS, 43)
STAMPS = STAMPS[(STAMPS < 1500 * MS) | (STAMPS > 2500 * MS)]
VALUES = RNG.standard_normal((STAMPS.size, 2))
BEFORE, AFTER = STAMPS[STAMPS < 1500 * MS].max(), STAMPS[STAMPS > 2500 * MS].min()
GAP = (GRID > BEFORE) & (GRID < AFTER)
LINE = np.stack([np.interp(GRID, STAMPS, column) for column in VALUES.T], axis=1)
HELD = VALUES[np.searchsorted(STAMPS, GRID, side="right") - 1]


def rules(missing="error", gap=0.3, reorder=0.0, step=False):
    return LiveRules.of(missing=missing, max_gap_s=gap, reorder_s=reorder, step=step)


def buffer(given=None, order=None):
    made = SampleBuffer("gauge", 2, given or rules())
    for i in range(STAMPS.size) if order is None else order:
        made.add(int(STAMPS[i]), VALUES[i])
    return made


def read(made, cut=8):
    parts = [made.take(GRID[i : i + cut]) for i in range(0, GRID.size, cut)]
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


@pytest.mark.parametrize("step", [False, True])
@pytest.mark.parametrize(
    ("missing", "inside"),
    [("hold", HELD), ("zero", 0.0 * HELD), ("interpolate", LINE)],
)
def test_a_gap_becomes_what_the_rule_says(missing, inside, step) -> None:
    """Against np.interp; only samples in the gap are marked, and one report names their span."""
    made = buffer(rules(missing, step=step))
    found, filled = read(made, cut=40)
    np.testing.assert_array_equal(filled, GAP)
    expected = np.where(GAP[:, None], inside, HELD if step else LINE)
    np.testing.assert_allclose(found, expected, atol=1e-12)  # round-off of one product, of values near 1
    others = [other for other in (HELD, LINE, 0.0 * HELD) if not np.array_equal(other, inside)]
    assert min(np.abs(found - other)[GAP].max() for other in others) > 0.1
    assert made.take_counts() == [("filled", GAP.sum(), GRID[GAP][0] / 1e9, GRID[GAP][-1] / 1e9)]
    assert made.take_counts() == []
    assert made.totals["filled"] == GAP.sum()


def test_a_gap_is_an_error_unless_asked_otherwise_and_none_without_a_limit() -> None:
    with pytest.raises(
        ComputationError, match=r"gauge: .* no message between 1\.\d+ s and 2\.\d+ s, more than"
    ):
        read(buffer())
    found, filled = read(buffer(rules(gap=None)))
    np.testing.assert_allclose(found, LINE, atol=1e-12)
    assert not filled.any()


@pytest.mark.parametrize("cut", [1, 7, 40])
def test_order_of_arrival_and_blocks_do_not_matter_within_the_allowance(cut) -> None:
    """Bit for bit, read as soon as it may; without the allowance late messages are lost and said to be."""
    order = np.argsort(STAMPS + RNG.integers(0, 500 * MS, STAMPS.size), kind="stable")
    assert (np.diff(order) < 0).sum() > 5
    whole, marks = read(buffer(rules("hold")), cut=40)

    def as_it_comes(reorder):
        made, parts = SampleBuffer("gauge", 2, rules("hold", reorder=reorder)), []
        for i in [*order, None]:
            if i is None:
                made.add(int(1e12), np.zeros(2))
            else:
                made.add(int(STAMPS[i]), VALUES[i])
            while len(parts) * cut < GRID.size:
                block = GRID[len(parts) * cut : (len(parts) + 1) * cut]
                if not made.reach(int(block[-1])):
                    break
                parts.append(made.take(block))
        return made, *(np.concatenate(column) for column in zip(*parts, strict=True))

    made, found, filled = as_it_comes(0.5)
    np.testing.assert_array_equal(found, whole)
    np.testing.assert_array_equal(filled, marks)
    assert made.totals["late"] == 0
    made, found, _ = as_it_comes(0.0)
    if cut < 40:  # one block waits for all messages anyway
        assert made.totals["late"] > 0
        assert "late" in [kind for kind, *_ in made.take_counts()]
        assert np.abs(found - whole).max() > 0.1


def test_what_cannot_be_a_sample_is_an_error_or_dropped_and_counted() -> None:
    for value, refusal, text in ((np.nan, "", "holds NaN or inf"), (1.0, "was elsewhere", "was elsewhere")):
        with pytest.raises(ComputationError, match=f"gauge at 7 s {text}"):
            buffer().add(7000 * MS, np.array([0.0, value]), refusal=refusal)
        made = buffer(rules("hold"))
        newest = made.newest_ns
        made.add(7000 * MS, np.array([0.0, value]), refusal=refusal)
        assert made.newest_ns == newest, "it does not say how far the messages have come"
        assert made.take_counts() == [("refused", 1, 7.0, 7.0)]


def test_a_second_message_of_a_time() -> None:
    made = buffer()
    made.add(int(STAMPS[3]), VALUES[3])
    made.add(int(STAMPS[5]), VALUES[5])
    assert made.take_counts() == [("repeated", 2, STAMPS[3] / 1e9, STAMPS[5] / 1e9)]
    with pytest.raises(ComputationError, match="comes twice, with different values"):
        made.add(int(STAMPS[3]), VALUES[4])
    held = buffer(rules("hold"))
    held.add(int(STAMPS[3]), VALUES[4])
    np.testing.assert_array_equal(read(held)[0], read(buffer(rules("hold")))[0])


def test_a_message_after_its_time() -> None:
    for missing in ("error", "hold"):
        made = SampleBuffer("gauge", 2, rules(missing))
        for time in (0, 200, 400):
            made.add(time * MS, np.ones(2))
        made.take(GRID[:3])
        made.add(300 * MS, np.ones(2))  # its time is still to come
        if missing == "error":
            with pytest.raises(
                ComputationError, match=r"at 0\.1 s comes after the load up to 0\.2 s was counted"
            ):
                made.add(100 * MS, np.ones(2))
        else:
            made.add(100 * MS, np.ones(2))
            assert made.take_counts() == [("late", 1, 0.1, 0.1)]


def test_nothing_comes() -> None:
    """Forced: held, or zero before anything has come; unforced that is an error whatever the rule."""
    for missing in ("hold", "zero", "interpolate"):
        made = SampleBuffer("gauge", 2, rules(missing))
        with pytest.raises(ComputationError, match=r"asked for 0 s to 0\.4 s, known is nothing"):
            made.take(GRID[:5])
        values, filled = made.take(GRID[:5], forced=True)
        assert filled.all()
        assert not values.any()
        made.add(520 * MS, np.full(2, 3.0))
        values, filled = made.take(GRID[5:10], forced=True)
        assert filled.all()
        np.testing.assert_array_equal(values[:, 0], 0.0 if missing == "zero" else 3.0)
        assert made.take_counts() == [("filled", 10, 0.0, 0.9)]
