"""Managed nodes that say why they refuse a transition.

rclpy answers a transition that the state does not allow with a bare "no": nothing for an unknown label, two
numbers in the log otherwise, an exception for a second shutdown. Here the caller reads the node, its state,
what was asked and what is possible.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lifecycle_msgs.msg import State, Transition
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

__all__ = ["ManagedNode"]

_NAMES = {
    Transition.TRANSITION_CONFIGURE: "configure",
    Transition.TRANSITION_CLEANUP: "cleanup",
    Transition.TRANSITION_ACTIVATE: "activate",
    Transition.TRANSITION_DEACTIVATE: "deactivate",
    Transition.TRANSITION_UNCONFIGURED_SHUTDOWN: "shutdown from unconfigured",
    Transition.TRANSITION_INACTIVE_SHUTDOWN: "shutdown from inactive",
    Transition.TRANSITION_ACTIVE_SHUTDOWN: "shutdown from active",
}
_SHUTDOWN = {
    State.PRIMARY_STATE_UNCONFIGURED: Transition.TRANSITION_UNCONFIGURED_SHUTDOWN,
    State.PRIMARY_STATE_INACTIVE: Transition.TRANSITION_INACTIVE_SHUTDOWN,
    State.PRIMARY_STATE_ACTIVE: Transition.TRANSITION_ACTIVE_SHUTDOWN,
}


class ManagedNode(LifecycleNode):
    """A managed node whose refusals have a reason.

    Parameters
    ----------
    *args, **kwargs
        Passed to rclpy's node.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._answer_change = self._service_change_state.callback
        self._service_change_state.callback = self._on_change_state

    def refuse(self, reason: str) -> None:
        """Tell the world why a transition was refused."""
        self.get_logger().error(reason)

    def _refused(self, name: str, possible: Callable[[int, str], bool]) -> bool:
        """Refuse the transition `name` if none of those possible now is the one asked for."""
        known = [(entry[0], entry[1]) for entry in self._state_machine.available_transitions]
        if any(possible(number, label) for number, label in known):
            return False
        choice = ", ".join(label for _, label in known) or "nothing"
        state = self._state_machine.current_state[1]
        self.refuse(f"{self.get_name()} is {state}: {name} is not possible, but {choice}")
        return True

    def _on_change_state(self, request: Any, response: Any) -> Any:
        number, label = int(request.transition.id), str(request.transition.label)
        name = label or _NAMES.get(number, f"transition {number}")
        # as in rclpy, a label counts more than a number
        if self._refused(name, lambda n, text: text == label if label else n == number):
            response.success = False
            return response
        return self._answer_change(request, response)

    def _trigger(
        self, number: int, change: Callable[[], TransitionCallbackReturn]
    ) -> TransitionCallbackReturn:
        refused = self._refused(_NAMES[number].split()[0], lambda n, _: n == number)
        return TransitionCallbackReturn.ERROR if refused else change()

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Configure, or say why not."""
        return self._trigger(Transition.TRANSITION_CONFIGURE, super().trigger_configure)

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Clean up, or say why not."""
        return self._trigger(Transition.TRANSITION_CLEANUP, super().trigger_cleanup)

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Activate, or say why not."""
        return self._trigger(Transition.TRANSITION_ACTIVATE, super().trigger_activate)

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Deactivate, or say why not."""
        return self._trigger(Transition.TRANSITION_DEACTIVATE, super().trigger_deactivate)

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Shut down from any state but the last, or say why not."""
        number = _SHUTDOWN.get(self._state_machine.current_state[0], Transition.TRANSITION_ACTIVE_SHUTDOWN)
        return self._trigger(number, super().trigger_shutdown)
