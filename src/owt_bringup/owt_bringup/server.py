"""The bring-up as a node for an operator: the action ``RunSeaState``, one goal at a time, and case checks."""

from __future__ import annotations

import os
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import Any

from owt_msgs.action import RunSeaState
from owt_msgs.msg import NodeStatus
from owt_msgs.srv import CheckCase
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

from owt_bringup.domain import own_place
from owt_bringup.goals import CancelledError, Outcome, Speed, check_case, run_goal
from owt_bringup.security import ACTION, CHECK_CASE, SERVER, enclave_arguments
from owt_model.errors import OwtError
from owt_ros.process import run
from owt_ros.qos import qos_for
from owt_ros.topics import STATUS

__all__ = ["BringupNode", "main", "serve"]

#: Longest time in s between two feedbacks while the stream moves, at full speed.
FEEDBACK_S = 0.1
#: Longest time in s for a goal to end after a signal: that of nodes that must be killed, and some.
_END_S = 6.0
#: Time in s that the answer to a client has to leave.
_ANSWER_S = 0.3
#: The goal takes one thread; cancelling, questions and checks need others.
_THREADS = 4


class BringupNode(Node):
    """Serves the action and the case check.

    Parameters
    ----------
    **kwargs
        Passed to rclpy's node.

    Raises
    ------
    InputError
        If another server is in the same namespace of the ROS domain.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(SERVER, **kwargs)
        self.domain, self.namespace = int(self.context.get_domain_id()), self.get_namespace()
        self._place = ExitStack()
        self._place.enter_context(own_place("server", self.domain, self.namespace))
        self._stopping = False
        self._accepting, self._bag = threading.Lock(), ""
        self._idle = threading.Event()
        self._idle.set()
        self._status = self.create_publisher(NodeStatus, STATUS.name, qos_for(STATUS))
        group = ReentrantCallbackGroup()
        self._server = ActionServer(
            self,
            RunSeaState,
            ACTION,
            execute_callback=self._execute,
            goal_callback=self._on_goal,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=group,
        )
        self.create_service(CheckCase, CHECK_CASE, self._on_check, callback_group=group)
        self._say("idle")
        place = self.namespace.rstrip("/")
        self.get_logger().info(f"ready: {place}/{ACTION} and {place}/{CHECK_CASE}, ROS domain {self.domain}")

    def _say(self, message: str) -> None:
        """Publish what the server does; latched."""
        self._status.publish(NodeStatus(node=SERVER, code=NodeStatus.RUNNING, message=message))

    # --- goals ------------------------------------------------------------------------------------

    def _on_goal(self, goal: RunSeaState.Goal) -> GoalResponse:
        """Accept one goal at a time."""
        with self._accepting:
            if self._idle.is_set() and not self._stopping:
                self._idle.clear()
                self._bag = goal.bag
                return GoalResponse.ACCEPT
        why = "the server ends" if self._stopping else f"a run into {self._bag} is under way"
        reason = f"goal for {goal.bag or 'no bag'} rejected: {why}; wait for its end or cancel it"
        self.get_logger().warning(reason)
        self._say(reason)
        return GoalResponse.REJECT

    def _execute(self, handle: Any) -> RunSeaState.Result:
        """Run one goal; called in a thread of its own."""
        self._say(f"running {handle.request.bag}")
        try:
            outcome = self._outcome(handle)
            self._end(handle, outcome)
        finally:
            self._idle.set()
        return RunSeaState.Result(
            status=outcome.status,
            message=outcome.message,
            bag=outcome.bag,
            statistics_json=outcome.statistics_json,
        )

    def _outcome(self, handle: Any) -> Outcome:
        try:
            return run_goal(
                handle.request,
                domain=self.domain,
                namespace=self.namespace,
                progress=_Feedback(handle).on_progress,
                should_stop=partial(self._check_stop, handle),
            )
        except Exception as error:
            self.get_logger().error(traceback.format_exc())
            return Outcome(RunSeaState.Result.STREAM_ERROR, _internal(error), "", "")

    def _check_stop(self, handle: Any) -> None:
        if self._stopping:
            raise CancelledError("the server was told to end")
        if handle.is_cancel_requested:
            raise CancelledError("cancelled")

    def _end(self, handle: Any, outcome: Outcome) -> None:
        """Give the goal its final state, and report it."""
        if outcome.status == RunSeaState.Result.SUCCEEDED:
            handle.succeed()
        elif outcome.status == RunSeaState.Result.CANCELLED and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        what = f"{outcome.bag or 'no bag'}: {outcome.message or 'complete'}"
        if outcome.status in (RunSeaState.Result.SUCCEEDED, RunSeaState.Result.CANCELLED):
            self.get_logger().info(what)
        else:
            self.get_logger().error(what)
        self._say(f"idle; last goal: {what}")

    # --- questions --------------------------------------------------------------------------------

    def _on_check(self, request: CheckCase.Request, response: CheckCase.Response) -> CheckCase.Response:
        """Answer whether a case would run."""
        try:
            case, response.warnings = check_case(request.case_json)
            response.case_json = case.model_dump_json()
            response.accepted = True
        except OwtError as error:
            response.message = " ".join(str(error).split())
        except Exception as error:
            self.get_logger().error(traceback.format_exc())
            response.message = _internal(error)
        return response

    def close(self) -> None:
        """End the goal under way, and leave the place to others."""
        self._stopping = True
        if not self._idle.is_set():
            self._spin_until(self._idle.is_set, _END_S)
            # rclpy hands the answer to the executor when the goal has ended, and does not say when it left
            self._spin_until(lambda: False, _ANSWER_S)
        self._place.close()

    def _spin_until(self, ready: Callable[[], bool], seconds: float) -> None:
        deadline = time.monotonic() + seconds
        while self.executor is not None and not ready() and time.monotonic() < deadline:
            self.executor.spin_once(timeout_sec=0.05)


def _internal(error: Exception) -> str:
    return f"internal error: {type(error).__name__}: {' '.join(str(error).split())}"


class _Feedback:
    """Sends the progress of one goal, not more often than anybody can read."""

    def __init__(self, handle: Any) -> None:
        self._handle, self._speed, self._sent = handle, Speed(), 0.0

    def on_progress(self, reached: float, duration: float) -> None:
        now, speed = time.monotonic(), self._speed.at(reached)
        if now - self._sent < FEEDBACK_S and reached < duration:
            return
        self._sent = now
        self._handle.publish_feedback(
            RunSeaState.Feedback(time_s=float(reached), duration_s=float(duration), speed=float(speed))
        )


def serve(arguments: list[str] | None = None) -> int:
    """Serve until SIGINT or SIGTERM; return the exit code.

    Parameters
    ----------
    arguments : list of str, optional
        Command line with ``--ros-args``; that of the process by default.
    """
    # as run_graph does for the nodes: one range for the server and what it starts
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    arguments = list(sys.argv if arguments is None else arguments)
    if "--enclave" not in arguments and (secured := enclave_arguments(SERVER)):
        arguments += ["--ros-args", *secured]
    return run(BringupNode, arguments, make_executor=lambda: MultiThreadedExecutor(num_threads=_THREADS))


def main() -> int:
    """Run the node."""
    return serve()


if __name__ == "__main__":
    sys.exit(main())
