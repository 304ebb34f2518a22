"""The newest messages of the streams: kept as they came, read when a picture is due."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from functools import cached_property

from rclpy.serialization import deserialize_message

from owt_model.contracts import ElevationBlock, FatigueBlock, ModalBlock, StressBlock
from owt_ros import decode, topics
from owt_ros.topics import Topic
from owt_ros.wire import indices, peek_head
from owt_viewer.playback import KEPT, Pairing, Playhead

__all__ = ["WATCHED", "Feed", "Moment"]

#: Streams that make a picture.
WATCHED = (topics.MODAL_STATE, topics.MEMBER_STRESS, topics.SURFACE_ELEVATION, topics.FATIGUE)
#: Blocks of elevation kept: the waves may be ahead of the response by the blocks in flight.
_ELEVATIONS = 64


@dataclass(frozen=True)
class Moment:
    """What is known of one instant.

    Attributes
    ----------
    time_ns : int
        Simulated time in ns.
    modal, stress : ModalBlock, StressBlock, optional
        Blocks that hold this time.
    stress_end : list of int
        Numbers of the member ends that the stress is given for; empty for all.
    fatigue : FatigueBlock, optional
        The newest damage.
    elevation_m : float, optional
        At the first gauge.
    """

    time_ns: int
    modal: ModalBlock | None = None
    stress: StressBlock | None = None
    stress_end: list[int] = field(default_factory=list)
    fatigue: FatigueBlock | None = None
    elevation_m: float | None = None


@dataclass(frozen=True)
class _Pair:
    """Response and stress of the same samples, as they came; read once, when they are shown."""

    start_ns: int
    cdr: dict[Topic, bytes]

    @cached_property
    def blocks(self) -> tuple[ModalBlock, StressBlock, list[int]]:
        modal, stress = (
            deserialize_message(self.cdr[topic], topic.message)
            for topic in (topics.MODAL_STATE, topics.MEMBER_STRESS)
        )
        modal.velocity = modal.acceleration = modal.displacement  # not shown, and left out of some recordings
        return decode.to_modal(modal), decode.to_stress(stress), indices(stress.end).tolist()


class Feed:
    """Takes serialised messages of :data:`WATCHED`, and gives the moment that is due."""

    def __init__(self) -> None:
        self._pairing, self._playhead = Pairing(), Playhead()
        self._pairs: deque[_Pair] = deque(maxlen=KEPT)
        self._unread_fatigue = b""
        self._elevation: deque[ElevationBlock] = deque(maxlen=_ELEVATIONS)
        self._fatigue: FatigueBlock | None = None

    @property
    def time_ns(self) -> int:
        """Simulated time in ns that is due."""
        return self._playhead.time_ns

    def take(self, topic: Topic, cdr: bytes) -> None:
        """Keep a message.

        Raises
        ------
        ComputationError
            If it is no block of a stream.
        """
        if topic is topics.FATIGUE:
            self._unread_fatigue = cdr
        elif topic is topics.SURFACE_ELEVATION:
            self._elevation.append(decode.to_elevation(deserialize_message(cdr, topic.message)))
        else:
            head = peek_head(cdr, topic.label)
            pair = self._pairing.offer(topic, head, cdr)
            if pair is not None:
                if self._playhead.arrive(head.time_ns, head.end_ns - round(head.dt * 1e9)):
                    self._pairs.clear()
                self._pairs.append(_Pair(head.time_ns, pair))

    def moment(self) -> Moment:
        """Read what has come, and return what is due.

        Raises
        ------
        ComputationError
            If a message does not hold what it says.
        """
        if self._unread_fatigue:
            message = deserialize_message(self._unread_fatigue, topics.FATIGUE.message)
            self._unread_fatigue = b""
            self._fatigue = decode.to_fatigue(message, dt=1.0)  # damage alone is shown, no time of it
        time_ns = self.time_ns
        elevation = self._elevation_at(time_ns)
        if not self._pairs:
            return Moment(time_ns, fatigue=self._fatigue, elevation_m=elevation)
        shown = next((pair for pair in reversed(self._pairs) if pair.start_ns <= time_ns), self._pairs[0])
        modal, stress, stress_end = shown.blocks
        return Moment(time_ns, modal, stress, stress_end, self._fatigue, elevation)

    def _elevation_at(self, time_ns: int) -> float | None:
        """Elevation at the first gauge, of the sample nearest to a time; None where no block reaches it."""
        for block in self._elevation:
            row = round((time_ns - block.time_ns) * 1e-9 / block.dt)
            if 0 <= row < len(block.total) and len(block.gauge):
                return float(block.total[row, 0])
        return None
