"""Kills nodes of running graphs at random times and looks at what is left.

``.venv/bin/python test/fault_trials.py --trials 20`` writes the raw log of docs/reliability.md; the tests
run a few trials. Nodes are watched, not managed: what they notice they notice by themselves.
"""

import argparse
import csv
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from lifecycle_msgs.msg import Transition
from owt_msgs.msg import NodeStatus
from rosbags.rosbag2 import Reader

sys.path.insert(0, str(Path(__file__).parent))

from local_graph import expected_bytes, node_processes, short_case
from owt_bringup.domain import own_domain
from owt_bringup.graph import node_environment
from owt_bringup.process import Child
from owt_bringup.supervisor import Supervisor
from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError
from owt_postproc.bag_recovery import recover_report
from owt_ros.lifecycle import CONFIGURED
from owt_ros.topics import POSTPROC, STRUCTURE, WAVE

PHASES = ("start", "configure", "run", "closing")
#: Seconds in which survivors must have noticed.
NOTICE_S = 2.0
DOCS = Path(__file__).parents[1] / "docs"


@dataclass(frozen=True)
class Trial:
    """What one trial showed; times in s.

    Attributes
    ----------
    killed_at : float
        After the first process was started.
    noticed : float
        From the kill to the moment when each survivor had failed or was done; -1 if they had not begun, where
        only the bring-up can notice, at once.
    bring_up : float
        From the kill to the moment when the bring-up, which would end the others now, noticed.
    said : str
        Last words of the survivors.
    recovered : int
        Messages in the recovered bag; -1 where no recording had begun.
    lost_samples : int
        Stress samples that had been counted, as far as the status said, and are not in the recovered bag.
    exact : bool
        Whether the recovered messages are, byte for byte, the first ones of the run in one process.
    survived : bool
        Noticed within two seconds, clean end of the survivors, and an exact bag.
    """

    number: int
    victim: str
    phase: str
    killed_at: float
    noticed: float
    bring_up: float
    said: str
    recovered: int
    lost_samples: int
    exact: bool
    survived: bool


def trial_case(seed: int) -> CaseConfig:
    """15 s of simulated time in 3 s, in blocks of 0.1 s of wall time."""
    return short_case(
        time={"n": 150},
        stream={"rate": 5.0, "block": 5},
        sea_state={"hs_m": 2.0, "tp_s": 8.0, "seed": seed},
    )


class Killer:
    """Kills one process when its time has come."""

    def __init__(self, child: Child) -> None:
        self._child = child
        self.due, self.at = float("inf"), 0.0

    def within(self, seconds: float) -> None:
        """Kill after this time."""
        self.due = time.monotonic() + seconds

    def look(self) -> None:
        """To be called often."""
        if not self.at and time.monotonic() >= self.due:
            os.kill(self._child.pid, signal.SIGKILL)
            self.at = time.monotonic()


def run_trial(number: int, victim: str, phase: str, folder: Path) -> Trial:
    """Run one graph and kill `victim` at a random time of `phase`."""
    rng, case, began = random.Random(1000 * number + 7), trial_case(number), time.monotonic()
    with own_domain() as domain, node_processes(case, folder, node_environment(domain, folder)) as children:
        watched = dict(children)
        killer = Killer(children[victim])
        with Supervisor(domain, watched, killer.look) as graph:
            if phase == "start":
                killer.within(rng.uniform(0.0, 2.0))
            try:
                _drive(graph, list(children), killer, phase, rng)
            except OwtError:  # the bring-up's own eye: a process has ended
                seen = time.monotonic() - killer.at
            watched.clear()  # from now on only listen
            survivors = [name for name in children if name != victim]
            noticed = _await(graph, survivors, killer)
            status = {name: graph.status[name] for name in children if name in graph.status}
        for child in children.values():
            child.signal(signal.SIGTERM)
        fine = (0, -signal.SIGTERM) if phase == "start" else (0,)  # not yet in its own hands
        clean = all(children[name].wait(5.0) and children[name].exit_code in fine for name in survivors)
    counted = status[POSTPROC].time_s if POSTPROC in status else 0.0
    recovered, samples, exact = _recover(folder, case)
    lost = max(0, round(counted / case.structure.dt_s) + 1 - samples) if counted else 0
    said = "; ".join(f"{n}: {status[n].message or 'done'}" for n in survivors if n in status)
    survived = min(noticed, seen) <= NOTICE_S and clean and exact
    return Trial(
        number, victim, phase, round(killer.at - began, 2), round(noticed, 2), round(seen, 2), said,
        recovered, lost, exact, survived,
    )  # fmt: skip


def _drive(graph: Supervisor, names: list[str], killer: Killer, phase: str, rng: random.Random) -> None:
    """Bring the graph up as far as it comes, and kill on the way; always ends with an error."""
    graph.await_services(30.0)
    if phase == "configure":
        killer.within(rng.uniform(0.0, 1.0))
    graph.change_states(names, Transition.TRANSITION_CONFIGURE, 30.0)
    if phase == "run":
        killer.within(rng.uniform(0.0, 3.0))
    for name in names:
        graph.change_states([name], Transition.TRANSITION_ACTIVATE, 30.0)
    if phase == "closing":
        graph.spin_until(lambda: graph.status[WAVE].time_s > 14.0, 30.0, "no end")
        killer.within(rng.uniform(0.0, 0.4))
    graph.spin_until(lambda: False, 30.0, "nobody noticed")


def _await(graph: Supervisor, survivors: list[str], killer: Killer) -> float:
    """Wait until all survivors that had begun have failed or are done; return how long that took."""
    ended = (NodeStatus.ERROR, NodeStatus.DONE)
    begun = [n for n in survivors if n in graph.status and graph.status[n].message != CONFIGURED]
    if not begun:
        return -1.0
    with suppress(OwtError):
        graph.spin_until(lambda: all(graph.status[n].code in ended for n in begun), 10.0, "silent")
    return time.monotonic() - killer.at


def _recover(folder: Path, case: CaseConfig) -> tuple[int, int, bool]:
    """Recover what was recorded: messages, stress samples, and whether they begin the reference."""
    bag = folder / "bag"
    if not bag.exists() and not (folder / ".bag.partial").exists():
        return -1, 0, True
    try:
        count = recover_report(bag, folder / "recovered").messages
    except InputError:  # killed before its first message was on the disk
        return 0, 0, True
    found: dict[str, list[bytes]] = {}
    with Reader(folder / "recovered") as reader:
        for connection, _, raw in reader.messages():
            found.setdefault(connection.topic, []).append(bytes(raw))
    wanted = expected_bytes(case)
    exact = all(found.get(label, []) == whole[: len(found.get(label, []))] for label, whole in wanted.items())
    blocks = len(found.get("/owt/member_stress", []))
    substeps = case.substeps
    return count, max(0, substeps * (case.stream.block * blocks - 1) + 1) if blocks else 0, exact


def run_trials(count: int, first: int = 0) -> Iterator[Trial]:
    """Run trials: every node in every phase, then anew."""
    plan = [(victim, phase) for phase in PHASES for victim in (WAVE, STRUCTURE, POSTPROC)]
    for i in range(first, first + count):
        victim, phase = plan[(5 * i) % len(plan)]
        with tempfile.TemporaryDirectory() as folder:
            yield run_trial(i, victim, phase, Path(folder))


def main() -> int:
    """Run trials and write the raw log."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("-o", "--output", type=Path, default=DOCS / "reliability_trials.csv")
    options = parser.parse_args()
    with options.output.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(Trial)])
        writer.writeheader()
        for trial in run_trials(options.trials):
            writer.writerow(asdict(trial))
            stream.flush()
            print(trial, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
