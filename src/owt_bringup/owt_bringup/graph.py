"""Runs the whole graph: three processes over DDS, configured, activated and watched, one bag at the end."""

from __future__ import annotations

import os
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lifecycle_msgs.msg import Transition

from owt_bringup.domain import full_namespace, own_domain, own_place
from owt_bringup.nodes import NODES
from owt_bringup.process import Child, find_executable, remove_shared_memory, shared_memory_of, stop_all
from owt_bringup.security import enclave_arguments
from owt_bringup.supervisor import Supervisor
from owt_bringup.transport import PROFILE_VARIABLE, shared_memory_profile
from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError
from owt_ros.parameters import parameter_yaml
from owt_ros.topics import POSTPROC
from owt_wave_node.sea_source import resolve_case

__all__ = ["GraphResult", "Timeouts", "node_environment", "run_graph"]


@dataclass(frozen=True)
class Timeouts:
    """Longest times in s.

    Attributes
    ----------
    start : float
        Until the processes can be reached.
    configure : float
        Until all nodes are configured; the wave node computes its record then.
    stall : float
        Without any progress of simulated time; the wall time of one block comes on top.
    """

    start: float = 60.0
    configure: float = 1800.0
    stall: float = 120.0


@dataclass(frozen=True)
class GraphResult:
    """What a run leaves.

    Attributes
    ----------
    bag : Path
        The complete bag; the nodes' logs lie in its folder ``log``.
    statistics : dict
        What the postproc node hands over: ``stress_samples``, ``largest_damage``, ``messages`` per topic.
    seconds : dict
        Wall time of ``start``, ``configure``, ``run`` and ``stop`` in s.
    """

    bag: Path
    statistics: dict[str, Any]
    seconds: dict[str, float]
    domain: int


def _stall(case: CaseConfig, limits: Timeouts) -> float:
    """Longest time in s without progress: blocks may be far apart, samples from outside awaited."""
    rate, block = case.stream.rate, case.stream.block * case.time.dt_s
    return limits.stall + case.outside_wait_s + (block / rate if rate > 0.0 else 0.0)


@contextmanager
def _signals(should_stop: Callable[[], None] | None) -> Iterator[Callable[[], None]]:
    """Turn SIGINT and SIGTERM into an exception at a place where it does no harm: the function yielded.

    A caller that brings its own function minds the signals itself.
    """
    if should_stop is not None:
        yield should_stop
        return
    received: list[signal.Signals] = []

    def check() -> None:
        if received and received[0] == signal.SIGINT:
            raise KeyboardInterrupt
        if received:
            raise OwtError(f"interrupted by {received[0].name}")

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {
        number: signal.signal(number, lambda n, _: received.append(signal.Signals(n))) for number in numbers
    }
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def node_environment(domain: int, folder: Path) -> dict[str, str]:
    """Environment of the nodes: that of this process, in a domain of their own, on this machine only.

    The number of BLAS threads is inherited: as the nodes cut time into the same blocks as the run in one
    process, equal settings give equal bits.
    """
    environment = {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
        "RCUTILS_COLORIZED_OUTPUT": "0",
        "RCUTILS_LOGGING_USE_STDOUT": "0",
    }
    profile = shared_memory_profile(len(NODES))
    if profile is not None and PROFILE_VARIABLE not in os.environ:
        path = folder / "fastdds.xml"
        path.write_text(profile, encoding="utf-8")
        environment[PROFILE_VARIABLE] = str(path)
    return environment


@contextmanager
def _environment_variable(name: str, value: str | None) -> Iterator[None]:
    """Set an environment variable of this process while the block lasts."""
    before = os.environ.get(name)
    if value is not None:
        os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = before


@contextmanager
def _work_folder(bag: Path) -> Iterator[Path]:
    """Make a folder beside the bag for parameter file and logs; drop it if nothing is in it worth keeping."""
    try:
        bag.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{bag.name}.run.", dir=bag.parent))
        folder.chmod(0o755)  # it becomes the bag's log folder
    except OSError as error:
        raise InputError(
            "bag", str(bag), f"cannot be written ({error.strerror})", "Choose a writable folder."
        ) from None
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _keep_logs(folder: Path, place: Path) -> None:
    """Copy parameter file and logs into `place`, if it is there."""
    if place.is_dir():
        with suppress(OSError, shutil.Error):  # a full disk has been reported already
            shutil.copytree(folder, place / "log", dirs_exist_ok=True)


def run_graph(
    case: CaseConfig,
    bag: Path,
    *,
    overwrite: bool = False,
    record: str = "default",
    progress: Callable[[float, float], None] | None = None,
    timeouts: Timeouts | None = None,
    domain_id: int | None = None,
    namespace: str = "",
    on_start: Callable[[dict[str, Child]], None] | None = None,
    should_stop: Callable[[], None] | None = None,
) -> GraphResult:
    """Run one case as a ROS 2 graph and record it.

    Parameters
    ----------
    case : CaseConfig
        What to run.
    bag : Path
        Folder to record into; it appears under this name when it is complete. A failed run keeps
        ``.NAME.partial`` beside it, with the nodes' logs.
    overwrite : bool
        Replace an existing bag.
    record : str
        "default" or "all": what the bag keeps (:class:`owt_ros.selection.Selection`).
    progress : callable, optional
        Called with the simulated time reached and the duration, in s.
    timeouts : Timeouts, optional
        Longest times.
    domain_id : int, optional
        ROS domain; a free one by default.
    namespace : str
        Of all nodes, services and topics. The bag and its messages are those of a graph without one.
    on_start : callable, optional
        Called with the processes, by node name, once they run.
    should_stop : callable, optional
        Called often; what it raises ends the run. By default SIGINT and SIGTERM do.

    Raises
    ------
    OwtError
        In one line: which node failed and why. The other nodes are stopped by then.
    KeyboardInterrupt
        On SIGINT, after everything was stopped.
    """
    case = resolve_case(case)  # the bag's case must run again without the file of its sea
    bag, limits, namespace = Path(bag).absolute(), timeouts or Timeouts(), full_namespace(namespace)
    if bag.exists() and not overwrite:
        raise InputError("bag", str(bag), "exists already", "Choose another name or remove it.")
    programs = {node.name: find_executable(node.package, node.name) for node in NODES}
    children: dict[str, Child] = {}
    shared: set[Path] = set()
    began = {"start": time.monotonic()}
    with (
        own_domain(domain_id) as domain,
        own_place("graph", domain, namespace),
        _work_folder(bag) as folder,
        _signals(should_stop) as check,
    ):
        parameters = folder / "parameters.yaml"
        options = {POSTPROC: {"bag": str(bag), "overwrite": overwrite, "record": record}}
        parameters.write_text(parameter_yaml(case, options), encoding="utf-8")
        arguments = ["--ros-args", "--disable-external-lib-logs", "--params-file", str(parameters)]
        arguments += [] if namespace == "/" else ["--remap", f"__ns:={namespace}"]
        environment = node_environment(domain, folder)
        try:
            for name, program in programs.items():
                log = folder / f"{name}.log"
                children[name] = Child(
                    name, [str(program), *arguments, *enclave_arguments(name)], log, environment
                )
            if on_start is not None:
                on_start(children)
            with (
                _environment_variable(PROFILE_VARIABLE, environment.get(PROFILE_VARIABLE)),
                Supervisor(domain, children, check, namespace) as graph,
            ):
                graph.await_services(limits.start)
                began["configure"] = time.monotonic()
                graph.change_states(list(children), Transition.TRANSITION_CONFIGURE, limits.configure)
                began["run"] = time.monotonic()
                shared |= {file for child in children.values() for file in shared_memory_of(child.pid)}
                for name in children:
                    graph.change_states([name], Transition.TRANSITION_ACTIVATE, limits.start)
                statistics = graph.watch(progress, case.time.duration_s, _stall(case, limits))
            began["stop"] = time.monotonic()
            stop_all(children.values())
        except BaseException:
            stop_all(children.values())
            _keep_logs(folder, bag.parent / f".{bag.name}.partial")
            raise
        finally:
            remove_shared_memory(shared)
        _keep_logs(folder, bag)
    moments = [*began.values(), time.monotonic()]
    seconds = {name: moments[i + 1] - moments[i] for i, name in enumerate(began)}
    return GraphResult(bag, statistics, seconds, domain)
