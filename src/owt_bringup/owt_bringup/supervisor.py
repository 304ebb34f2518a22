"""The bring-up's eye on the graph: changes lifecycle states and watches status and processes."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, NoReturn, Self

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from owt_msgs.msg import NodeStatus
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from owt_bringup.process import Child
from owt_bringup.security import BRINGUP, enclave_arguments
from owt_model.errors import OwtError, StreamError
from owt_ros.lifecycle import ACTIVE, CONFIGURED, PAUSED, STARTED
from owt_ros.qos import qos_for
from owt_ros.topics import POSTPROC, STATUS

__all__ = ["NodeError", "Supervisor"]

RCLError = rclpy_implementation.RCLError

_LABELS = {
    Transition.TRANSITION_CONFIGURE: CONFIGURED,
    Transition.TRANSITION_ACTIVATE: ACTIVE,
    Transition.TRANSITION_CLEANUP: "cleaned up",
}
#: Seconds for which the reason of a refused transition is awaited.
_REASON_S = 2.0
#: Seconds for which the graph remembers a process that was killed, and a little more.
_FORGET_S = 25.0


class NodeError(OwtError):
    """What a node reported.

    Parameters
    ----------
    message : str
        One line with the name of the node.
    kind : int
        ``NodeStatus.INPUT``, ``STREAM`` or ``NUMERICS``.
    """

    def __init__(self, message: str, kind: int) -> None:
        self.kind = kind
        super().__init__(message)


class Supervisor:
    """Drives one graph; a context manager.

    Parameters
    ----------
    domain : int
        ROS domain of the graph.
    children : mapping of str to Child
        Processes by node name.
    should_stop : callable
        Raises when the user wants to stop; called often.
    namespace : str
        Of the graph, e.g. "/north".
    """

    def __init__(
        self,
        domain: int,
        children: Mapping[str, Child],
        should_stop: Callable[[], None],
        namespace: str = "/",
    ) -> None:
        self._children, self._should_stop, self._namespace = children, should_stop, namespace
        self._place = f"ROS domain {domain}, namespace {namespace}"
        self.status: dict[str, NodeStatus] = {}
        self._tokens: set[str] = set()
        self._context = Context()
        secured = enclave_arguments(BRINGUP)
        try:
            rclpy.init(
                args=["--ros-args", *secured] if secured else [],
                context=self._context,
                domain_id=domain,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            self._node = Node(BRINGUP, context=self._context, namespace=namespace, use_global_arguments=False)
        except RCLError as error:  # no keystore, or a middleware without security
            raise StreamError(f"ROS 2 does not start: {' '.join(str(error).split())}") from None
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        profile = qos_for(STATUS)
        profile.depth = 100
        self._node.create_subscription(NodeStatus, STATUS.name, self._on_status, profile)
        self._change = {
            name: self._node.create_client(ChangeState, f"{name}/change_state") for name in children
        }

    def _on_status(self, message: Any) -> None:
        if message.message == STARTED:
            self._tokens.add(message.result)
        else:
            self.status[message.node] = message

    def check(self) -> None:
        """Raise :class:`OwtError` for a node that failed or ended."""
        self._should_stop()
        for child in self._children.values():
            if child.exit_code is not None:
                raise StreamError(child.describe_end())
        for name, status in self.status.items():
            if status.code == NodeStatus.ERROR and name in self._children:
                raise NodeError(f"{name}: {status.message}", int(status.kind))

    def spin_until(self, ready: Callable[[], bool], seconds: float, what: str | Callable[[], str]) -> None:
        """Work until `ready()`.

        Raises
        ------
        OwtError
            If a node fails, a process ends, or it takes longer than `seconds`: "WHAT within SECONDS s".
        """
        deadline = time.monotonic() + seconds
        while not ready():
            self.check()
            if time.monotonic() > deadline:
                raise StreamError(f"{what if isinstance(what, str) else what()} within {seconds:g} s")
            self._executor.spin_once(timeout_sec=0.05)

    def await_services(self, seconds: float) -> None:
        """Wait until every node can be asked to change its state, and is the only one of its name.

        Raises
        ------
        OwtError
            If one is not reached within `seconds`, or nodes of another graph stay.
        """

        def missing() -> list[str]:
            silent = {name for name, child in self._children.items() if child.token not in self._tokens}
            return [n for n, client in self._change.items() if n in silent or not client.service_is_ready()]

        self.spin_until(
            lambda: not missing(), seconds, lambda: f"{', '.join(missing())} could not be reached"
        )
        # a killed process stays in the graph for a while
        self.spin_until(
            lambda: not self._doubles(),
            _FORGET_S,
            lambda: f"{self._describe_doubles()}; the other one did not leave",
        )

    def _doubles(self) -> list[str]:
        """Nodes of this graph whose name is taken by another one, too."""
        found = self._node.get_node_names_and_namespaces()
        return [name for name in self._change if found.count((name, self._namespace)) > 1]

    def _describe_doubles(self) -> str:
        return (
            f"two nodes are named {', '.join(self._doubles())} in {self._place}: end the other graph or give "
            "one of them a namespace"
        )

    def change_states(self, names: Sequence[str], transition: int, seconds: float) -> None:
        """Ask nodes to change their state and wait for all of them.

        Raises
        ------
        OwtError
            If one refuses, with its reason, or does not answer.
        """
        request = ChangeState.Request(transition=Transition(id=transition))
        futures = {name: self._change[name].call_async(request) for name in names}

        def silent() -> list[str]:
            """Nodes that neither answered nor reported the new state: an answer can get lost in DDS."""
            return [
                name
                for name, future in futures.items()
                if not future.done() and not self._is_reported(name, transition)
            ]

        self.spin_until(
            lambda: not silent(), seconds, lambda: f"{', '.join(silent())} not {_LABELS[transition]}"
        )
        for name, future in futures.items():
            if future.done() and not future.result().success:
                self._give_reason(name, f"{name} did not become {_LABELS[transition]}")

    def _give_reason(self, name: str, refusal: str) -> NoReturn:
        """Raise the reason that a node gives for its refusal."""

        def reason() -> str:
            status = self.status.get(name)
            return "" if status is None or status.message in (*_LABELS.values(), PAUSED) else status.message

        self.spin_until(lambda: bool(reason()), _REASON_S, f"{refusal} and gave no reason")
        self.check()
        raise StreamError(f"{refusal}: {reason()}")

    def _is_reported(self, name: str, transition: int) -> bool:
        status = self.status.get(name)
        return status is not None and status.message == _LABELS[transition]

    def watch(
        self, progress: Callable[[float, float], None] | None, duration: float, stall: float
    ) -> dict[str, Any]:
        """Follow the run to its end and return the result of the postproc node.

        Parameters
        ----------
        progress : callable, optional
            Called with the simulated time reached and `duration`, in s.
        duration : float
            Length of the record in s.
        stall : float
            Longest time in s without any progress.
        """
        reached, since = -1.0, time.monotonic()
        looked = since
        while True:
            status = self.status.get(POSTPROC)
            if status is not None and status.code == NodeStatus.DONE:
                return _result(status.result)
            self.check()
            now = sum(entry.time_s for entry in self.status.values())
            if now > reached:
                reached, since = now, time.monotonic()
                if progress is not None and status is not None:
                    progress(min(status.time_s, duration), duration)
            elif any(entry.message == PAUSED for entry in self.status.values()):
                since = time.monotonic()
            elif time.monotonic() - since > stall:
                raise StreamError(f"no progress for {stall:g} s: {self._stand()}")
            if time.monotonic() - looked > 1.0:
                looked = time.monotonic()
                if self._doubles():
                    raise StreamError(self._describe_doubles())
            self._executor.spin_once(timeout_sec=0.1)

    def _stand(self) -> str:
        """Say in one line how far each node is."""
        return ", ".join(
            f"{name} at {self.status[name].time_s:.1f} s" if name in self.status else f"{name} silent"
            for name in self._children
        )

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the graph."""
        self._executor.shutdown(timeout_sec=1.0)
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)
        del self._executor, self._node, self._change, self._context  # left with the last reference


def _result(text: str) -> dict[str, Any]:
    """Read what the postproc node hands over."""
    try:
        return dict(json.loads(text))
    except (ValueError, TypeError):
        raise OwtError(
            f"{POSTPROC} is done, with a result that cannot be read: {text[:60]!r}; does somebody else "
            f"publish on {STATUS.label}?"
        ) from None
