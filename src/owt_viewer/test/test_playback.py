"""Which block is shown, and which instant of it."""

from owt_ros.topics import MEMBER_STRESS, MODAL_STATE
from owt_ros.wire import Head
from owt_viewer.playback import Pairing, Playhead

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


def test_blocks_at_some_rate_are_played_through() -> None:
    wall = Wall()
    play = Playhead(wall)
    assert play.time_ns == 0
    for rate in (1.0, 4.0):
        for block in range(4):
            play.arrive(block * 5 * S, block * 5 * S + round(4.98 * S))
            assert play.time_ns == block * 5 * S
            wall.now += 2.0 / rate
            expected = block * 5 + (2.0 if block else 2.0 / rate)  # the first block's speed is not known
            assert abs(play.time_ns - expected * S) < S * 1e-6
            wall.now += 3.0 / rate
        assert play.time_ns <= 19.98 * S
        play.arrive(0, S)  # another run
        assert play.speed == 1.0


def test_it_stays_at_the_end_of_the_last_block() -> None:
    wall = Wall()
    play = Playhead(wall)
    play.arrive(0, 3 * S)
    wall.now += 60.0
    assert play.time_ns == 3 * S


def test_a_run_at_full_speed_shows_the_newest() -> None:
    wall = Wall()
    play = Playhead(wall)
    for block in range(50):
        play.arrive(block * 5 * S, block * 5 * S + round(4.98 * S))
        wall.now += 0.08
        assert play.time_ns >= block * 5 * S
    assert play.speed > 50.0
