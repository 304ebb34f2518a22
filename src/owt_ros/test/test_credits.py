"""Flow control and stream guards: pure bookkeeping."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from owt_model.config import parse_case
from owt_model.errors import ComputationError, InputError
from owt_ros.credits import CreditWindow, Flow, StreamGuard, flow_of
from owt_ros.pace import Pace


def flow(window: int) -> Flow:
    """Flow at full speed."""
    return Flow(window, window)


def test_in_real_time_nobody_waits_and_who_is_late_is_known() -> None:
    case = parse_case({"stream": {"rate": 2.0, "block": 10, "window": 3, "late_s": 2.2}})
    assert flow_of(case) == Flow(3, 8, waits=False, every=1)
    credit = CreditWindow(flow_of(case), ["a", "b"])  # a block lasts 0.5 s of wall time: five are kept
    credit.send(0)
    credit.acknowledge("a", 0)
    assert not credit.is_open, "b may not have been discovered yet"
    credit.acknowledge("b", 0)
    lateness = []
    for sequence in range(1, 13):
        assert credit.is_open
        credit.send(sequence)
        credit.acknowledge("a", sequence)
        lateness.append((credit.behind, credit.lost))
    assert credit.slowest == "b"
    assert lateness[:4] == [(0, 0), (0, 0), (0, 0), (1, 0)]
    assert lateness[7:9] == [(5, 0), (6, 1)]
    credit.acknowledge("b", 12)
    assert (credit.behind, credit.lost) == (0, 0)


def test_short_blocks_in_real_time_are_acknowledged_some_at_a_time() -> None:
    case = parse_case({"stream": {"rate": 1.0, "block": 1, "late_s": 10.0}, "time": {"dt_s": 0.01}})
    assert flow_of(case) == Flow(40, 1040, waits=False, every=20)


def test_at_full_speed_the_window_holds_the_producer() -> None:
    assert flow_of(parse_case({"stream": {"window": 3}})) == Flow(3, 3)
    credit = CreditWindow(flow(3), ["a"])
    for sequence in range(3):
        credit.send(sequence)
    assert not credit.is_open


def test_window_closes_and_opens() -> None:
    credit = CreditWindow(flow(2), ["a", "b"])
    credit.send(0)
    credit.send(1)
    assert not credit.is_open
    with pytest.raises(ComputationError, match="2 blocks are in flight"):
        credit.send(2)
    assert credit.acknowledge("a", 1)
    assert not credit.is_open, "the slowest consumer counts"
    assert credit.slowest == "b"
    assert credit.acknowledge("b", 0)
    assert credit.is_open
    assert credit.in_flight == 1
    credit.send(2)


def test_what_is_no_news_changes_nothing() -> None:
    credit = CreditWindow(flow(4), ["a"])
    for i in range(3):
        credit.send(i)
    assert credit.acknowledge("a", 1)
    assert not credit.acknowledge("a", 1), "repeated"
    assert not credit.acknowledge("a", 0), "older"
    assert not credit.acknowledge("a", 3), "never sent"
    assert not credit.acknowledge("stranger", 2)
    assert credit.in_flight == 1


def test_without_consumers_it_is_always_open() -> None:
    credit = CreditWindow(flow(1), [])
    for i in range(5):
        credit.send(i)
    assert credit.is_open


def test_sequence_must_be_the_next() -> None:
    with pytest.raises(ComputationError, match="the next one is 0"):
        CreditWindow(flow(2), []).send(1)
    with pytest.raises(InputError, match=r"stream\.window"):
        CreditWindow(flow(0), [])


@given(window=st.integers(1, 5), steps=st.lists(st.sampled_from(["send", "a", "b"]), max_size=60))
def test_never_more_than_a_window_in_flight(window: int, steps: list[str]) -> None:
    credit, seen = CreditWindow(flow(window), ["a", "b"]), {"a": 0, "b": 0}
    for action in steps:
        if action == "send":
            if credit.is_open:
                credit.send(credit.sent)
        elif seen[action] < credit.sent:
            credit.acknowledge(action, seen[action])
            seen[action] += 1
        assert credit.in_flight == credit.sent - min(seen.values())
        assert credit.in_flight <= window


def _fed(*blocks: tuple[int, bool]) -> StreamGuard:
    guard = StreamGuard("/owt/energy")
    for sequence, last in blocks:
        guard.check(sequence=sequence, time_ns=10 * sequence, end_ns=10 * sequence + 10, last=last)
    return guard


def test_a_whole_stream_passes() -> None:
    guard = _fed((0, False), (1, False), (2, True))
    assert guard.finished
    assert guard.received == 3


@pytest.mark.parametrize(
    ("blocks", "message"),
    [
        ([(0, False), (2, False)], r"/owt/energy: block 2 arrived, 1 was expected: gap of 1"),
        ([(3, False)], "gap of 3"),
        ([(0, False), (0, False)], "duplicate or out of order"),
        ([(0, False), (1, False), (0, False)], "duplicate or out of order"),
        ([(0, True), (1, False)], "after the block marked last"),
    ],
)
def test_gaps_duplicates_and_reordering_are_errors(blocks: list[tuple[int, bool]], message: str) -> None:
    with pytest.raises(ComputationError, match=message):
        _fed(*blocks)


def test_a_jump_of_the_clock_is_an_error() -> None:
    guard = _fed((0, False))
    with pytest.raises(ComputationError, match="the clock jumped"):
        guard.check(sequence=1, time_ns=11, end_ns=20, last=False)


def test_pace() -> None:
    now = 100.0
    pace = Pace(2.0, lambda: now)
    assert pace.is_due(0), "the first block sets the origin"
    assert not pace.is_due(1_000_000_000)
    now = 100.5
    assert pace.is_due(1_000_000_000)
    assert not pace.is_due(1_100_000_000)
    assert pace.period_s(5.0) == 2.5
    assert Pace(0.0, lambda: now).is_due(10**15)
