"""What a replay publishes and when: selection, seek and clock; no ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from owt_bringup.bag_case import bag_structure
from owt_bringup.recompute import RESPONSE, Recomputation, leaves_out
from owt_model.contracts import Block
from owt_model.errors import InputError
from owt_postproc.bag_reader import PREFIX, decoded
from owt_postproc.bag_report import bag_case
from owt_postproc.bag_source import BagSource, RawMessage, RecordedTopic

__all__ = ["CLOCK", "ReplayPlan", "Window"]

CLOCK = "/clock"
#: Types that the response is computed from.
NEEDED = tuple(PREFIX + name for name in ("LoadBasis", "NodalLoads", "TowerTopLoad"))


@dataclass(frozen=True)
class Window:
    """Part of a bag in simulated time.

    Attributes
    ----------
    start : float
        Begin in s after the first message that is not latched, whatever topics are chosen.
    duration : float, optional
        Length in s; to the end by default.

    Raises
    ------
    InputError
        If one of them cannot be.
    """

    start: float = 0.0
    duration: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.start < float("inf"):
            raise InputError("start", self.start, "must be 0 s or more", "Leave it out for the whole bag.")
        if self.duration is not None and not 0.0 < self.duration < float("inf"):
            raise InputError("duration", self.duration, "must be more than 0 s", "Leave it out for the rest.")


class ReplayPlan:
    """The messages of a bag, one round after the other.

    Parameters
    ----------
    bag : BagSource
        Complete or not.
    topics : sequence of str, optional
        Names of those to publish; all by default.
    window : Window
        What part of the bag.
    clock_hz : float
        Ticks of a clock of its own per simulated second, in the place of the recorded one; 0 for that.
    serialize : callable, optional
        Writes a block as its message. If it is given, what the bag leaves out is computed again.

    Raises
    ------
    InputError
        If a topic is not in the bag, nothing lies in the window, or the bag is damaged.
    """

    def __init__(
        self,
        bag: BagSource,
        *,
        topics: Sequence[str] | None = None,
        window: Window | None = None,
        clock_hz: float = 0.0,
        serialize: Callable[[Block], bytes] | None = None,
    ) -> None:
        if not 0.0 <= clock_hz <= 1e6:
            raise InputError(
                "clock", clock_hz, "must lie in 0 to 1e6 Hz", "Leave it out for the recorded clock."
            )
        self._bag = bag
        self._clock_hz, self._window = clock_hz, window or Window()
        self._serialize = serialize if serialize is not None and leaves_out(bag) else None
        self.topics = self._select(topics)
        first = next(bag.messages([name for name, topic in bag.topics.items() if not topic.latched]), None)
        origin = 0 if first is None else first.publish_time_ns
        self.begin_ns = origin + round(self._window.start * 1e9)
        duration = self._window.duration
        self.end_ns = None if duration is None else self.begin_ns + round(duration * 1e9)
        latched = [name for name, topic in self.topics.items() if topic.latched]
        self._latched = [message for message in bag.messages(latched) if self._comes_first(message)]
        if self._window.start > 0.0 and next(self._stream(), None) is None:
            raise InputError(
                "start",
                self._window.start,
                "leaves no message of the topics in the window",
                "Give a smaller one, or a longer duration.",
            )

    def _select(self, topics: Sequence[str] | None) -> dict[str, RecordedTopic]:
        known = self._bag.topics
        for name in topics or ():
            if name not in known:
                raise InputError(
                    "topics",
                    name,
                    f"is not in the bag, which has {', '.join(sorted(known))}",
                    "Name some of them.",
                )
        return {
            name: topic
            for name, topic in known.items()
            if (topics is None or name in topics) and not (name == CLOCK and self.has_own_clock)
        }

    @property
    def has_own_clock(self) -> bool:
        """Whether there are ticks in the place of the recorded clock."""
        return self._clock_hz > 0.0

    @property
    def length_s(self) -> float:
        """Simulated time in s that a round takes; 0 where the bag does not say."""
        if self._window.duration is not None:
            return self._window.duration
        case = self._bag.files.case
        return max(bag_case(self._bag).time.duration_s - self._window.start, 0.0) if case else 0.0

    def _comes_first(self, message: RawMessage) -> bool:
        """Whether a message is a latched one that a subscriber knows when the window begins."""
        return self.topics[message.topic].latched and message.publish_time_ns <= self.begin_ns

    def _is_inside(self, message: RawMessage) -> bool:
        """Whether a message lies in the window; from the start of the bag on none is too early."""
        time_ns = message.publish_time_ns
        begun = self._window.start == 0.0 or time_ns >= self.begin_ns
        return begun and (self.end_ns is None or time_ns < self.end_ns)

    def round(self) -> Iterator[RawMessage]:
        """Yield what one round publishes, latched messages first; ticks of an own clock have no data."""
        return chain(self._latched, self._ticking(self._stream()) if self.has_own_clock else self._stream())

    def _stream(self) -> Iterator[RawMessage]:
        messages = (
            self._bag.messages(self.topics) if self._serialize is None else self._whole(self._serialize)
        )
        for message in messages:
            if not self._comes_first(message) and self._is_inside(message):
                yield message

    def _ticking(self, messages: Iterator[RawMessage]) -> Iterator[RawMessage]:
        tick = 0
        for message in messages:
            while (now := self.begin_ns + round(tick * 1e9 / self._clock_hz)) <= message.publish_time_ns:
                yield RawMessage(CLOCK, "rosgraph_msgs/msg/Clock", message.log_time_ns, now, b"")
                tick += 1
            yield message

    def _whole(self, serialize: Callable[[Block], bytes]) -> Iterator[RawMessage]:
        """Messages with all that the bag leaves out."""
        types = {*NEEDED, *RESPONSE, *(topic.type_name for topic in self.topics.values())}
        again = Recomputation(bag_structure(self._bag))
        for message, block in again(bag_case(self._bag), decoded(self._bag, types=types)):
            if message.topic not in self.topics:
                continue
            if message.type_name in (f"{PREFIX}NodalLoads", *RESPONSE) and block is not None:
                yield replace(message.raw, data=serialize(block))
            else:
                yield message.raw
