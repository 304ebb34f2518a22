"""What a bag keeps of each message: everything, or what the rest can be computed from.

The default leaves out velocities and accelerations, energies by mode, fixed-end forces, and the stress of all
but the most used member ends; a bag holds what is needed to compute them again (``./owt analyse``).
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from rclpy.serialization import serialize_message

from owt_model.contracts import ReducedDescription
from owt_ros import topics
from owt_ros.topics import Topic
from owt_ros.wire import uint32s

__all__ = ["Selection", "most_used"]


def most_used(usage: Float[np.ndarray, " end"], count: int) -> Int[np.ndarray, " chosen"]:
    """Return the indices of the `count` member ends of largest expected stress, ascending.

    Of ends that are equal to round-off the earlier ones are taken, on every machine.
    """
    order = np.argsort(-np.round(usage / max(usage.max(initial=0.0), 1e-300), 9), kind="stable")
    return np.sort(order[:count])


class Selection:
    """What is kept of the messages of one run.

    Parameters
    ----------
    everything : bool
        Keep messages as they came.
    ends : int
        Member ends whose stress is kept otherwise.
    loads : bool
        Keep the loads whole in any case: where the case alone does not give them again.
    """

    def __init__(self, *, everything: bool, ends: int, loads: bool = False) -> None:
        self._everything, self._count = everything, ends
        self._ends: Int[np.ndarray, " chosen"] | None = None
        self._trim: dict[Topic, Callable[[Any], None]] = {
            topics.NODAL_LOADS: _without_fixed_ends,
            topics.MODAL_STATE: _without_rates,
            topics.MEMBER_STRESS: self._keep_ends,
            topics.ENERGY: _without_modes,
        }
        if loads:
            del self._trim[topics.NODAL_LOADS]

    def learn(self, model: ReducedDescription) -> None:
        """Choose the member ends; where nothing is known of their use, all."""
        if model.end_usage.size > self._count:
            self._ends = most_used(model.end_usage, self._count)

    def of(self, topic: Topic, cdr: bytes, message: Any) -> bytes:
        """Return what is kept of a message, given serialised and as an object, which is used up."""
        trim = None if self._everything else self._trim.get(topic)
        if trim is None:
            return cdr
        trim(message)
        return bytes(serialize_message(message))

    def _keep_ends(self, message: Any) -> None:
        if self._ends is None:
            return
        message.end = uint32s(self._ends)
        for name in ("axial", "bending_y", "bending_z", "von_mises"):
            setattr(message, name, _columns(getattr(message, name), int(message.samples), self._ends))


def _columns(values: Any, samples: int, columns: Int[np.ndarray, " chosen"]) -> array[float]:
    """Return some columns of a row-major message array [samples, channel]."""
    out = array("d")
    table = np.frombuffer(values, dtype=np.float64).reshape(samples, -1)
    out.frombytes(np.ascontiguousarray(table[:, columns]).data.cast("B"))
    return out


def _without_fixed_ends(message: Any) -> None:
    message.element, message.fixed_end = array("I"), array("d")


def _without_rates(message: Any) -> None:
    message.velocity = message.acceleration = array("d")


def _without_modes(message: Any) -> None:
    message.potential_mode = message.kinetic_mode = array("d")
