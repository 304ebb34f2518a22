"""Which block is shown, and which instant of it."""

from itertools import pairwise

import pytest

from owt_ros.topics import MEMBER_STRESS, MODAL_STATE
from owt_ros.wire import Head
from owt_viewer.playback import KEPT, Pairing, Playhead

S = 1_000_000_000


class Wall:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def head(sequence: int) -> Head:
    return Head(sequence * 5 * S, sequence, 0.02, 250, False)


def test_only_blocks_of_the_same_samples_make_a_pair() -> None:
    pairing = Pairing()
    assert pairing.offer(MODAL_STATE, head(0), b"m0") is None
    assert pairing.offer(MODAL_STATE, head(1), b"m1") is None, "the stress of block 0 was lost"
    assert pairing.offer(MEMBER_STRESS, head(2), b"s2") is None
    assert pairing.offer(MODAL_STATE, head(2), b"m2") == {MODAL_STATE: b"m2", MEMBER_STRESS: b"s2"}
    assert pairing.offer(MODAL_STATE, head(2), b"m2") is None, "a pair is given once"


def played(rate: float, bunch: int, blocks: int = 12) -> tuple[list[tuple[float, float]], Playhead]:
    """Wall and simulated time of pictures, ten a second, of blocks of 5 s that come `bunch` at a time."""
    wall = Wall()
    play, seen = Playhead(wall), []
    for first in range(0, blocks, bunch):
        for block in range(first, first + bunch):
            play.arrive(block * 5 * S, block * 5 * S + round(4.98 * S))
        for _ in range(round(50 * bunch / rate)):
            wall.now += 0.1
            seen.append((wall.now - 100.0, play.time_ns / S))
    return seen, play


@pytest.mark.parametrize("rate", [0.5, 1.0, 5.0])
def test_blocks_at_some_rate_are_played_through(rate: float) -> None:
    seen, play = played(rate, 1)
    late = [(wall, time) for wall, time in seen if wall > 5.0 / rate]  # the speed of the first is not known
    assert all(abs(time - rate * wall) < 5.0 for wall, time in late)
    steps = [b[1] - a[1] for a, b in pairwise(late)]
    assert min(steps) >= 0.0
    assert max(steps) < 0.25 * rate
    assert play.speed == pytest.approx(rate)


def test_blocks_that_come_in_bunches_are_played_through() -> None:
    seen, _ = played(1.0, 2)
    seen = [entry for entry in seen if entry[0] > 10.0]  # one bunch alone looks like a run at full speed
    steps = [b[1] - a[1] for a, b in pairwise(seen)]
    assert min(steps) >= 0.0
    assert sum(0.0 < step < 0.3 for step in steps) > 0.7 * len(steps), "mostly in motion, without leaps"


def test_another_run_begins_at_its_start() -> None:
    _, play = played(1.0, 1)
    assert not play.arrive(60 * S, 64 * S)
    assert play.arrive(0, S)
    assert (play.time_ns, play.speed) == (0, 1.0)


def test_it_stays_at_the_end_of_the_last_block() -> None:
    wall = Wall()
    play = Playhead(wall)
    assert play.time_ns == 0
    play.arrive(0, 3 * S)
    wall.now += 60.0
    assert play.time_ns == 3 * S


def test_a_run_at_full_speed_shows_one_of_the_newest() -> None:
    wall = Wall()
    play = Playhead(wall)
    for block in range(50):
        play.arrive(block * 5 * S, block * 5 * S + round(4.98 * S))
        assert play.time_ns >= (block - KEPT + 1) * 5 * S
        wall.now += 0.08
    assert play.speed > 50.0
