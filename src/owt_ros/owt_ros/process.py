"""A node as a process: signals, the loop, and a clean end.

SIGINT and SIGTERM set a flag that the loop looks at; they interrupt nothing but a computation that was
marked as interruptible, so that no message and no file is ever left half written. One call of compiled
code is never interrupted: the signal waits for its end. A process that does not end within
:data:`GRACE_S` after that is ended by the kernel. A process started by the bring-up ends when its parent
does, however that happens.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from owt_model.errors import OwtError

__all__ = ["PARENT_VARIABLE", "TOKEN_VARIABLE", "Interrupted", "Stop", "interruptible", "run", "stop"]

#: Environment variable with the process id of the bring-up.
PARENT_VARIABLE = "OWT_PARENT_PID"
#: Environment variable with a word by which the bring-up knows its own nodes from others of their name.
TOKEN_VARIABLE = "OWT_NODE_TOKEN"
#: Seconds after a signal until the kernel ends a process that hangs.
GRACE_S = 8.0
_PR_SET_PDEATHSIG = 1


class Interrupted(BaseException):
    """A signal arrived during an interruptible computation."""


class Stop:
    """Whether this process was asked to stop."""

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self._interruptible = False

    def install(self) -> None:
        """Take SIGINT and SIGTERM over."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def _on_signal(self, number: int, _frame: Any) -> None:
        self.signal = signal.Signals(number)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, GRACE_S)
        if self._interruptible:
            raise Interrupted

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let a signal end the computation inside, which must leave nothing half done."""
        self._interruptible = True
        try:
            yield
        finally:
            self._interruptible = False


#: The one of this process.
stop = Stop()
interruptible = stop.interruptible


class StoppableNode(Protocol):
    """What :func:`run` needs of a node."""

    def close(self) -> None:
        """Release everything, from any state."""

    def destroy_node(self) -> None:
        """Leave the graph."""


def _follow_parent() -> None:
    """Ask the kernel for SIGTERM when the bring-up dies, and stop at once if it has died already."""
    parent = os.environ.get(PARENT_VARIABLE)
    if parent is None:
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    if os.getppid() != int(parent):
        stop.signal = signal.SIGTERM


def run(
    make_node: Callable[[], Any],
    arguments: list[str] | None = None,
    *,
    make_executor: Callable[[], Executor] = SingleThreadedExecutor,
) -> int:
    """Run one node until SIGINT or SIGTERM; return the exit code.

    Parameters
    ----------
    make_node : callable
        Makes the node, a :class:`StoppableNode`, in the default context.
    arguments : list of str, optional
        Command line; that of the process by default.
    make_executor : callable
        Makes what calls the node back.
    """
    stop.install()
    _follow_parent()
    code, node, executor = 0, None, None
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        executor = make_executor()
        node = make_node()
        executor.add_node(node)
        gc.freeze()  # what lives as long as the node is not searched for cycles again and again
        while stop.signal is None:
            executor.spin_once(timeout_sec=0.1)
    except (Interrupted, ExternalShutdownException):
        pass
    except Exception as error:  # the last line of stderr says why the process ended
        kind = "" if isinstance(error, OwtError) else f"{type(error).__name__}: "
        print(f"error: {kind}{' '.join(str(error).split())}", file=sys.stderr)
        code = 1
    finally:
        if node is not None and executor is not None:
            node.close()
            executor.shutdown(timeout_sec=1.0)
            node.destroy_node()
        rclpy.try_shutdown()
        gc.unfreeze()  # else the context is never collected, and its shared memory outlives the process
    return code
