"""The base of the managed nodes: transitions, status, diagnostics, and errors as one line.

A subclass implements ``configure(case)`` and ``advance()``, and where it needs to ``release()``; it
raises :class:`OwtError` for what cannot be. The base turns that into a refused transition or, while
running, into an error status, a diagnostic and a deactivation.
"""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from owt_msgs.msg import Credit, NodeStatus
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from std_msgs.msg import Header

from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError, StreamError
from owt_ros.convert import stamp
from owt_ros.credits import Flow, flow_of
from owt_ros.options import RATE_SUFFIX, NodeOptions
from owt_ros.parameters import NodeParameters
from owt_ros.peers import Peers
from owt_ros.process import TOKEN_VARIABLE
from owt_ros.qos import qos_for
from owt_ros.streams import Inlet, Outlet
from owt_ros.topics import CREDIT, DIAGNOSTICS, STATUS, Topic
from owt_ros.transitions import ManagedNode

__all__ = ["ACTIVE", "CONFIGURED", "PAUSED", "STARTED", "StageNode"]

#: Messages of a status without an error: the state that the node has reached.
STARTED, CONFIGURED, ACTIVE, PAUSED = "started", "configured", "active", "paused"
#: Wall time in s between two reports of progress.
REPORT_S = 0.05
#: Timers run on wall time, also under ``use_sim_time``.
_WALL = Clock(clock_type=ClockType.STEADY_TIME)
_SUCCESS, _FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


def _kind_of(error: OwtError) -> int:
    """Kind of an error as the status names it."""
    if isinstance(error, InputError):
        return int(NodeStatus.INPUT)
    return int(NodeStatus.STREAM if isinstance(error, StreamError) else NodeStatus.NUMERICS)


class StageNode(ManagedNode):
    """One stage of the chain as a managed node.

    Parameters
    ----------
    **kwargs
        Passed to rclpy's node, e.g. ``context``.
    """

    ROLE: ClassVar[str] = ""
    OPTIONS: ClassVar[type[NodeOptions]] = NodeOptions

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(self.ROLE, automatically_declare_parameters_from_overrides=True, **kwargs)
        self.settings = NodeParameters(self, self.OPTIONS)
        self.options = self.OPTIONS()
        self.time_ns = 0
        self.active = False
        self.flow, self._outside_s = Flow(), 0.0
        self._failed = False
        self._broken = ""
        self._last_status = NodeStatus(node=self.ROLE)
        self._outlets: list[Outlet] = []
        self._inlets: list[Inlet] = []
        self._backlog: list[tuple[Callable[[Any], None], Any]] = []
        self._ticks: list[Timer] = []
        self._served: list[Service[Any, Any]] = []
        self._starting: Timer | None = None
        self._credit_in: Subscription[Credit] | None = None
        self._credit_out: Any = None
        self._peers: Peers | None = None
        self._waiting_since = self._reported = 0.0
        self._rate_from = (0.0, 0)
        self._status = self.create_publisher(NodeStatus, STATUS.name, qos_for(STATUS))
        if token := os.environ.get(TOKEN_VARIABLE):
            self._publish_status(NodeStatus.RUNNING, STARTED, token)
        self._diagnostics = self.create_publisher(DiagnosticArray, DIAGNOSTICS.name, qos_for(DIAGNOSTICS))

    # --- what a subclass implements ---------------------------------------------------------------

    def configure(self, case: CaseConfig) -> None:
        """Build the stage, make outlets and inlets."""
        raise NotImplementedError

    def announce(self) -> None:
        """Publish what is latched; called when the node becomes active."""

    def advance(self) -> None:
        """Do what inputs and credits allow; called whenever one of them may have changed."""

    def release(self) -> None:
        """Drop what `configure` built."""

    # --- what a subclass uses ---------------------------------------------------------------------

    def outlet(self, topic: Topic) -> Outlet:
        """Publish `topic`."""
        outlet = Outlet(self, topic, flow=self.flow, stall_s=self.options.stall_s + self._outside_s)
        self._outlets.append(outlet)
        return outlet

    def inlet(self, topic: Topic, handler: Callable[..., None], *, raw: bool = False) -> Inlet:
        """Subscribe to `topic`; `handler` may raise :class:`OwtError`."""
        inlet = Inlet(
            self,
            topic,
            handler,
            receive=partial(self._receive, topic.producer),
            acknowledge=self._credit_out,
            consumer=self.ROLE,
            flow=self.flow,
            raw=raw,
        )
        self._inlets.append(inlet)
        return inlet

    def serve(self, kind: type[Any], name: str, answer: Callable[[Any, Any], Any]) -> None:
        """Offer a service from now until the node is cleaned up."""
        self._served.append(self.create_service(kind, name, answer))

    def every(self, period_s: float, callback: Callable[[], None]) -> None:
        """Call `callback` every `period_s` seconds of wall time while the node is active."""
        self._ticks.append(self._timer(period_s, callback))

    def _timer(self, period_s: float, callback: Callable[[], None]) -> Timer:
        return self.create_timer(period_s, lambda: self._guarded(callback), clock=_WALL)

    def report(self, *, time_ns: int | None = None, done: str | None = None) -> None:
        """Publish how far the node is; `done` is its result when it has finished."""
        self.time_ns = self.time_ns if time_ns is None else time_ns
        now = time.monotonic()
        if done is None and now - self._reported < REPORT_S:
            return
        self._reported = now
        code = NodeStatus.RUNNING if done is None else NodeStatus.DONE
        self._publish_status(code, ACTIVE if done is None else "", done or "")
        if done is not None:
            self.diagnose(DiagnosticStatus.OK, "done")

    def diagnose(self, level: bytes, message: str, *, suffix: str = "", **values: Any) -> DiagnosticArray:
        """Publish a diagnostic and return it; its stamp is simulated time."""
        entries = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        status = DiagnosticStatus(
            level=level, name=f"{self.ROLE}{suffix}", message=message, hardware_id="owt", values=entries
        )
        array = DiagnosticArray(header=Header(stamp=stamp(self.time_ns)), status=[status])
        self._diagnostics.publish(array)
        return array

    def fail(self, message: str, kind: int = NodeStatus.STREAM) -> None:
        """Report an error once, and stop working until the next cleanup."""
        if self._failed:
            return
        self._failed = True
        message = " ".join(message.split())
        self.get_logger().error(message)
        self.diagnose(DiagnosticStatus.ERROR, message)  # first: the bring-up ends the recording on the status
        self._publish_status(NodeStatus.ERROR, message, "", kind)
        if self.active:
            self._broken = message
            self.trigger_deactivate()

    def refuse(self, reason: str) -> None:
        """Say why a transition is refused; what the node does, or has done, goes on."""
        super().refuse(reason)
        self.diagnose(DiagnosticStatus.WARN, reason)
        last = self._last_status
        if last.code != NodeStatus.ERROR:  # the message of an error stays
            self._publish_status(last.code, reason, last.result)

    # --- inputs and credits -----------------------------------------------------------------------

    def _guarded(self, call: Callable[..., None], *arguments: Any) -> None:
        """Run `call`; any error becomes the node's error status."""
        try:
            call(*arguments)
        except OwtError as error:
            self.fail(str(error), _kind_of(error))
        except Exception as error:
            self.get_logger().error(traceback.format_exc())
            self.fail(f"internal error: {type(error).__name__}: {error}")

    def _receive(self, producer: str, handle: Callable[[Any], None], message: Any) -> None:
        """Take a message: now if active, on activation otherwise."""
        self._hear(producer)
        if self._failed:
            return
        if self.active and not self._backlog:
            self._guarded(handle, message)
        else:
            self._backlog.append((handle, message))

    def _start(self) -> None:
        """Catch up with what arrived before activation, and wait for the consumers."""
        while self._backlog and not self._failed:
            self._guarded(*self._backlog.pop(0))
        missing = {name: outlet.topic.label for outlet in self._outlets for name in outlet.missing}
        if self._failed or (missing and time.monotonic() - self._waiting_since < self.options.wait_s):
            return
        if missing:
            lost = ", ".join(f"{name} (for {label})" for name, label in missing.items())
            raise StreamError(f"no subscription of {lost} within {self.options.wait_s:g} s: start it first")
        self._stop_starting()
        self.advance()

    def _stop_starting(self) -> None:
        if self._starting is not None:
            self.destroy_timer(self._starting)
            self._starting = None

    def _hear(self, peer: str) -> None:
        if self._peers is not None and peer:
            self._peers.hear(peer)

    def _on_credit(self, message: Any) -> None:
        self._hear(message.consumer if message.consumer != self.ROLE else "")
        for outlet in self._outlets:
            if outlet.topic.label == message.topic:
                outlet.credit.acknowledge(message.consumer, int(message.sequence))
        if self.active:
            self._guarded(self.advance)

    def _on_loss(self, peer: str) -> None:
        """Fail if a node that died or left still has to send or to acknowledge something."""
        if self.active and (loss := self._loss(peer)):
            self.fail(loss)

    def _loss(self, peer: str) -> str:
        """Say what is missing without a peer; empty if nothing is."""
        owing = [inlet.topic.label for inlet in self._inlets if inlet.is_owed_by(peer)]
        owing += [outlet.topic.label for outlet in self._outlets if peer in outlet.owed_to]
        return f"{peer} died or left before the end of {', '.join(owing)}" if owing else ""

    def _check_losses(self, peers: Iterable[str]) -> None:
        """Raise :class:`StreamError` if something is missing without one of `peers`."""
        for peer in peers:
            if loss := self._loss(peer):
                raise StreamError(loss)

    def _publish_rate(self) -> None:
        now, (then, reached) = time.monotonic(), self._rate_from
        speed = (self.time_ns - reached) * 1e-9 / max(now - then, 1e-9)
        self._rate_from = now, self.time_ns
        blocks = {outlet.topic.label: outlet.credit.sent for outlet in self._outlets if outlet.credit.sent}
        blocks |= {inlet.topic.label: inlet.guard.received for inlet in self._inlets if inlet.guard.received}
        values = {"simulated seconds per second": f"{speed:.3g}", **blocks}
        self._check_losses(self._peers.unseen if self._peers else ())
        for outlet in self._outlets:
            if stall := outlet.stall:
                raise StreamError(stall)
        late = "; ".join(filter(None, (outlet.lateness for outlet in self._outlets)))
        level = DiagnosticStatus.WARN if late else DiagnosticStatus.OK
        self.diagnose(level, f"late: {late}" if late else "running", suffix=RATE_SUFFIX, **values)
        if late:
            self.get_logger().warning(f"late: {late}", throttle_duration_sec=10.0)

    def _publish_status(self, code: int, message: str, result: str, kind: int = 0) -> None:
        self._last_status = NodeStatus(
            node=self.ROLE, code=code, message=message, kind=kind, time_s=self.time_ns * 1e-9, result=result
        )
        self._status.publish(self._last_status)

    # --- transitions ------------------------------------------------------------------------------

    def _transition(self, work: Callable[[], None]) -> TransitionCallbackReturn:
        self._failed = False
        self._guarded(work)
        return _FAILURE if self._failed else _SUCCESS

    def _configure(self) -> None:
        case, self.options = self.settings.read()
        self.flow, self._outside_s = flow_of(case), case.outside_wait_s
        self.time_ns = 0
        self._credit_out = self.create_publisher(Credit, CREDIT.name, qos_for(CREDIT))
        self._credit_in = self.create_subscription(Credit, CREDIT.name, self._on_credit, qos_for(CREDIT))
        self.configure(case)
        if self.options.lease_s > 0.0:
            topics = (*(inlet.topic for inlet in self._inlets), *(outlet.topic for outlet in self._outlets))
            others = {name for topic in topics for name in (topic.producer, *topic.consumers)}
            self._peers = Peers(
                self,
                self.ROLE,
                sorted(others - {self.ROLE, ""}),
                lease_s=self.options.lease_s,
                on_loss=self._on_loss,
            )

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters and build."""
        result = self._transition(self._configure)
        if result == _SUCCESS:
            self._publish_status(NodeStatus.RUNNING, CONFIGURED, "")
        else:
            self._drop()
        return result

    def _activate(self) -> None:
        if self._broken:
            raise StreamError(f"the run broke off ({self._broken}): clean up and configure before another")
        self._waiting_since = time.monotonic()
        self._rate_from = self._waiting_since, self.time_ns
        self._reported = 0.0
        # A peer may have died since this node was configured, when nothing was owed yet.
        self._check_losses(self._peers.lost if self._peers else ())
        self.announce()
        self.report()
        self.diagnose(DiagnosticStatus.OK, "active")
        self._starting = self._timer(0.02, self._start)
        self.every(1.0, self._publish_rate)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Publish what is latched, and start as soon as the consumers are there."""
        super().on_activate(state)
        result = self._transition(self._activate)
        if result == _SUCCESS:
            self.active = True
        else:
            self.on_deactivate(state)
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop working; what arrives from now on is kept for the next activation."""
        if self.active and not self._failed and self._last_status.code == NodeStatus.RUNNING:
            self._publish_status(NodeStatus.RUNNING, PAUSED, "")
        self.active = False
        self._stop_starting()
        for timer in self._ticks:
            self.destroy_timer(timer)
        self._ticks.clear()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Drop everything that configure made."""
        self._drop()
        return _SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End, from any state."""
        self.active = False
        self.on_deactivate(state)
        self._drop()
        return _SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Back to the unconfigured state after a transition that broke."""
        return self.on_shutdown(state)

    def _drop(self) -> None:
        self._guarded(self.release)
        self._broken = ""
        for outlet in self._outlets:
            self.destroy_lifecycle_publisher(outlet.publisher)
        for inlet in self._inlets:
            self.destroy_subscription(inlet.subscription)
        for service in self._served:
            self.destroy_service(service)
        if self._peers is not None:
            self._peers.close()
            self._peers = None
        if self._credit_in is not None:
            self.destroy_subscription(self._credit_in)
            self.destroy_publisher(self._credit_out)
        self._credit_in = self._credit_out = None
        for kept in (self._outlets, self._inlets, self._backlog, self._served):
            kept.clear()

    def close(self) -> None:
        """Release everything, from any state."""
        self.active = False
        self._drop()
