"""What a site measures drives the graph: elevation and wrench that jitter, drop out and overtake."""

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point, PointStamped, Vector3, Wrench, WrenchStamped
from rclpy.node import Node
from std_msgs.msg import Header

from local_graph import LocalGraph, short_case
from owt_bringup.commands.demo import _domain_for_others
from owt_campaign.pipeline import prepare_case
from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_model.structure import case_structure
from owt_postproc.bag_reader import read_bag
from owt_ros import convert
from owt_ros.qos import qos_for
from owt_ros.topics import (
    MEASURED_ELEVATION,
    MEASURED_ELEVATION_USED,
    NODAL_LOADS,
    STRUCTURE,
    TOWER_TOP_LOAD,
    TOWER_TOP_WRENCH,
    WAVE,
    recorded,
)
from owt_wave_node.core.live import live_stage_from_record

pytestmark = [pytest.mark.graph, pytest.mark.timeout(150)]

SECOND = 1_000_000_000
#: Samples of the case and of the record, which goes on for the lag of 2 s.
N, RECORD = 120, 140
GAUGE = (12.0, 5.0)
DROP_OUT = (5.0, 6.5)


def case_of(rate: float = 10.0, wind: dict[str, Any] | None = None, **live: Any) -> CaseConfig:
    """12 s in six blocks, both inputs from outside."""
    wrench = {"missing": "hold", "max_gap_s": 0.5, "reorder_s": 0.4, "timeout_s": 20.0, **(wind or {})}
    given = {"place_m": list(GAUGE), "window_s": 30.0, "lag_s": 2.0, "hop_s": 2.0, "timeout_s": 20.0}
    return short_case(
        time={"n": N},
        stream={"block": 20, "rate": rate},
        morison={"discretisation_m": 4.0},
        live={**given, "missing": "interpolate", "max_gap_s": 0.5, "reorder_s": 0.4, **live},
        wind={"topic": wrench},
    )


def elevation_at(seconds: Any) -> Any:
    return 1.5 * np.sin(0.8 * np.asarray(seconds)) + 0.4 * np.sin(1.7 * np.asarray(seconds) + 1.0)


def stamps_of(seed: int, until: float = 15.0) -> np.ndarray:
    """Stamps in s of ten samples a second from 0 on, jittered, none in the drop-out."""
    rng = np.random.default_rng(seed)
    at = 0.1 * np.arange(round(until * 10)) + rng.uniform(-0.03, 0.03, round(until * 10))
    at[0] = 0.0
    return at[(at < DROP_OUT[0]) | (at > DROP_OUT[1])]


class Site:
    """Stands in for instruments outside: publishes both topics by wall time, each message late by chance."""

    def __init__(self, graph: LocalGraph) -> None:
        self.node = Node("site", context=graph.context, use_global_arguments=False)
        graph._executor.add_node(self.node)
        graph._stack.callback(self.node.destroy_node)
        self._gauge = self.node.create_publisher(
            PointStamped, MEASURED_ELEVATION.name, qos_for(MEASURED_ELEVATION)
        )
        self._rotor = self.node.create_publisher(
            WrenchStamped, TOWER_TOP_WRENCH.name, qos_for(TOWER_TOP_WRENCH)
        )
        self._due: list[tuple[float, Callable[[], None]]] = []
        self._began = 0.0

    def is_heard(self, *, gauge: bool = True, rotor: bool = True) -> bool:
        return self._gauge.get_subscription_count() == gauge and self._rotor.get_subscription_count() == rotor

    def elevation(
        self, seconds: float, value: float | None = None, place: tuple[float, float] = GAUGE
    ) -> None:
        z = float(elevation_at(seconds)) if value is None else value
        header = Header(stamp=convert.stamp(round(seconds * SECOND)))
        self._gauge.publish(PointStamped(header=header, point=Point(x=place[0], y=place[1], z=z)))

    def wrench(self, seconds: float, value: float | None = None) -> None:
        force = 1e5 * (1.0 + np.sin(seconds)) if value is None else value
        header = Header(stamp=convert.stamp(round(seconds * SECOND)))
        self._rotor.publish(WrenchStamped(header=header, wrench=Wrench(force=Vector3(x=float(force)))))

    def burst(self, send: Callable[[float], None], seconds: Iterable[float]) -> None:
        for at in seconds:
            send(float(at))

    def run(self, rate: float, *, late: float = 0.3, seed: int = 9, until: float = 15.0) -> None:
        """Publish from now on, each message up to `late` s of simulated time after its stamp."""
        rng = np.random.default_rng(seed)
        for number, send in enumerate((self.elevation, self.wrench)):
            for at in stamps_of(number, until):
                when = (at + rng.uniform(0.0, late)) / rate
                self._due.append((when, lambda send=send, at=float(at): send(at)))
        self._due.sort(key=lambda entry: entry[0])
        self._began = time.monotonic()
        self.node.create_timer(0.01, self._tick)

    def _tick(self) -> None:
        while self._due and time.monotonic() - self._began >= self._due[0][0]:
            self._due.pop(0)[1]()


def started(graph: LocalGraph) -> Site:
    site = Site(graph)
    graph.start()
    graph.spin_until(site.is_heard)
    return site


def warnings_of(graph: LocalGraph, topic: str) -> list[dict[str, str]]:
    """Entries of the warnings about a topic."""
    every = [status for array in graph.diagnostics for status in array.status]
    return [
        {"message": status.message, **{v.key: v.value for v in status.values}}
        for status in every
        if status.level == b"\x01" and status.message.startswith(topic)
    ]


def in_drop_out(seed: int, n: int) -> np.ndarray:
    """Samples between the messages about the drop-out."""
    at, stamps = 0.1 * np.arange(n), stamps_of(seed)
    return (at > stamps[stamps < DROP_OUT[0]].max()) & (at < stamps[stamps > DROP_OUT[1]].min())


def test_both_inputs_drive_the_graph_in_real_time(domain: int, bag: Path) -> None:
    """What was made up is marked in the bag, and from the record there the loads come again, bit for bit."""
    case = case_of()
    with LocalGraph(domain, case, bag) as graph:
        site, began = started(graph), time.monotonic()
        site.run(10.0)
        graph.spin_until(graph.is_done)
        took = time.monotonic() - began
        graph.spin_for(0.2)
        said = {topic: warnings_of(graph, topic.label) for topic in (MEASURED_ELEVATION, TOWER_TOP_WRENCH)}
    assert took > 12.0 / 10.0, "no faster than what is measured"
    streams = read_bag(bag).streams
    used, top = streams[MEASURED_ELEVATION_USED.label], streams[TOWER_TOP_LOAD.label]
    for seed, found, n, topic in ((0, used, RECORD, MEASURED_ELEVATION), (1, top, N, TOWER_TOP_WRENCH)):
        np.testing.assert_array_equal(found["filled"][:, 0] != 0, in_drop_out(seed, n))
        assert {entry["kind"] for entry in said[topic]} == {"filled"}
        assert sum(int(entry["number"]) for entry in said[topic]) == in_drop_out(seed, n).sum()
        assert float(said[topic][0]["from_s"]) == pytest.approx(5.0, abs=0.11)
    seconds = 0.1 * np.arange(RECORD)
    line = np.interp(seconds, stamps_of(0), elevation_at(stamps_of(0)))
    # Stamps are whole ns.
    np.testing.assert_allclose(used["elevation"][:, 0], line, atol=1e-8)
    held = top["wrench"][:, 0][in_drop_out(1, N)]
    assert np.ptp(held) == 0.0 < held[0]
    recorded_warnings = [
        status.message
        for message in read_bag(bag).messages["/diagnostics"]
        for status in message["status"]
        if status.message.startswith("/owt/")
    ]
    assert len(recorded_warnings) == sum(map(len, said.values()))
    mesh = build_mesh(case_structure(case.structure))
    stage = live_stage_from_record(case, mesh, used["elevation"][:, 0])
    again = np.concatenate([stage.load_block(i).nodal for i in range(stage.n_blocks)])
    np.testing.assert_array_equal(streams[NODAL_LOADS.label]["nodal"], again.reshape(N, -1))
    other = live_stage_from_record(case, mesh, used["elevation"][:, 0] + 1e-3 * seconds)
    assert not np.array_equal(other.load_block(3).nodal, again[60:80])


def test_silence_is_filled_marked_and_reported_and_the_pace_kept(domain: int, bag: Path) -> None:
    """Both publishers end at 8 s; the wait comes once, not once per block."""
    case = case_of(wind={"missing": "zero", "timeout_s": 1.0}, missing="hold", timeout_s=1.0)
    with LocalGraph(domain, case, bag) as graph:
        site, began = started(graph), time.monotonic()
        site.run(10.0, until=8.05)
        graph.spin_until(graph.is_done)
        took = time.monotonic() - began
        graph.spin_for(0.2)
        said = warnings_of(graph, MEASURED_ELEVATION.label)[-1]["message"]
    assert "no message gives them, so they were made up (live.missing is hold)" in said
    # 1.4 s of record and two waits of 1 s, which may follow one another; the rest is a loaded machine.
    assert took < 1.4 + 2 * 1.3 + 6.0
    streams = read_bag(bag).streams
    used, top = streams[MEASURED_ELEVATION_USED.label], streams[TOWER_TOP_LOAD.label]
    assert used["filled"][82:].all()
    assert np.ptp(used["elevation"][82:]) == 0.0 != used["elevation"][82, 0]
    assert top["filled"][82:].all()
    assert not top["wrench"][82:].any()
    assert not used["filled"][:50].any()


@pytest.mark.parametrize("topic", [MEASURED_ELEVATION, TOWER_TOP_WRENCH], ids=lambda topic: topic.name)
def test_silence_is_an_error_where_the_case_says_so(domain: int, bag: Path, topic: Any) -> None:
    elevation = topic is MEASURED_ELEVATION
    strict = {"missing": "error", "timeout_s": 0.6}
    case = case_of(0.0, **({**strict} if elevation else {"wind": strict}))
    with LocalGraph(domain, case, bag) as graph:
        site = started(graph)
        other = site.wrench if elevation else site.elevation
        site.burst(other, np.arange(0.0, 15.0, 0.1))
        what = "block 0 of the record" if elevation else "block 0"
        key = "live" if elevation else "wind.topic"
        message = graph.error_of(WAVE if elevation else STRUCTURE)
    assert message.startswith(
        f"no message on {topic.label} reaches the end of {what} within 0.6 s: publish it"
    )
    assert message.endswith(f"{key}.timeout_s")
    assert not bag.exists()


def test_a_gap_is_an_error_where_the_case_says_so(domain: int, bag: Path) -> None:
    with LocalGraph(domain, case_of(0.0, missing="error"), bag) as graph:
        site = started(graph)
        site.burst(site.elevation, stamps_of(0))
        message = graph.error_of(WAVE)
    assert "measured elevation: asked for" in message
    assert "no message between 4.9" in message or "no message between 5" in message
    assert message.endswith("more than max_gap_s = 0.5")


def test_at_full_speed_a_silence_is_waited_for_block_by_block(domain: int, bag: Path) -> None:
    """Nobody publishes anything: every sample is made up, and still water has no loads."""
    case = case_of(0.0, wind={"missing": "hold", "timeout_s": 0.2}, missing="hold", timeout_s=0.2)
    with LocalGraph(domain, case, bag) as graph:
        started(graph)
        graph.spin_until(graph.is_done)
    streams = read_bag(bag).streams
    assert streams[MEASURED_ELEVATION_USED.label]["filled"].all()
    assert streams[TOWER_TOP_LOAD.label]["filled"].all()
    assert not streams[NODAL_LOADS.label]["nodal"].any()


def test_what_comes_too_late_twice_or_from_elsewhere_is_dropped_and_reported(domain: int, bag: Path) -> None:
    with LocalGraph(domain, case_of(0.0, missing="hold"), bag) as graph:
        heard = graph.listen([TOWER_TOP_LOAD, MEASURED_ELEVATION_USED])
        site = started(graph)
        site.burst(site.elevation, [0.0, 0.2, 0.1])  # sorted in
        site.elevation(0.2, 9.0)  # twice
        site.elevation(0.3, 9.0, (12.0, 5.002))  # elsewhere
        site.elevation(0.3, np.nan)
        site.burst(site.elevation, np.arange(0.3, 15.0, 0.1))
        site.burst(site.wrench, np.arange(0.0, 2.5, 0.1))
        graph.spin_until(lambda: len(heard[TOWER_TOP_LOAD.label]) == 1)
        site.wrench(0.55, 9e9)  # counted already
        site.elevation(1.05, 9.0)
        site.burst(site.wrench, np.arange(2.5, 13.0, 0.1))
        graph.spin_until(graph.is_done)
        graph.spin_until(lambda: len(warnings_of(graph, MEASURED_ELEVATION.label)) >= 3)
        gauge = warnings_of(graph, MEASURED_ELEVATION.label)
        (rotor,) = warnings_of(graph, TOWER_TOP_WRENCH.label)
    counts = {entry["kind"]: (entry["total"], entry["from_s"], entry["to_s"]) for entry in gauge}
    assert counts == {
        "repeated": ("1", "0.2", "0.2"),
        "refused": ("2", "0.3", "0.3"),
        "late": ("1", "1.05", "1.05"),
    }
    assert rotor["message"] == (
        "/owt/tower_top_wrench: 1 messages from 0.55 to 0.55 s: their time was counted before they came, so "
        "they were dropped"
    )
    streams = read_bag(bag).streams
    seconds = 0.1 * np.arange(RECORD)
    np.testing.assert_allclose(
        streams[MEASURED_ELEVATION_USED.label]["elevation"][:, 0], elevation_at(seconds), atol=1e-8
    )
    assert streams[TOWER_TOP_LOAD.label]["wrench"].max() < 3e5


def test_a_message_that_is_too_late_is_an_error_where_a_missing_one_is(domain: int, bag: Path) -> None:
    with LocalGraph(domain, case_of(0.0, wind={"missing": "error", "max_gap_s": 5.0}), bag) as graph:
        heard = graph.listen([TOWER_TOP_LOAD])
        site = started(graph)
        site.burst(site.elevation, np.arange(0.0, 15.0, 0.1))
        site.burst(site.wrench, [0.0, 1.5, 1.0, 2.4])
        graph.spin_until(lambda: len(heard[TOWER_TOP_LOAD.label]) == 1)
        site.wrench(0.5)
        message = graph.error_of(STRUCTURE)
    assert message == "tower-top wrench at 0.5 s comes after the load up to 1.9 s was counted"


def test_without_the_graph_a_live_case_needs_its_record() -> None:
    case = short_case(time={"n": N}, live={"window_s": 30.0, "lag_s": 2.0, "hop_s": 2.0})
    with pytest.raises(
        InputError, match=r"live = 'given': is read by the running graph only\. Use \./owt demo"
    ):
        prepare_case(case)
    run = prepare_case(case, measured=elevation_at(0.1 * np.arange(RECORD)))
    assert run.wave.load_block(0).nodal.any()
    assert MEASURED_ELEVATION_USED in recorded(case)
    assert MEASURED_ELEVATION_USED not in recorded(short_case())


def test_the_demo_runs_where_others_publish(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    assert _domain_for_others(short_case(), "") is None
    assert _domain_for_others(short_case(live={}), "") == 42
    assert "waiting for /owt/measured_elevation in ROS domain 42" in capsys.readouterr().err
    assert _domain_for_others(case_of(), "") == 42
    assert "/owt/measured_elevation and /owt/tower_top_wrench" in capsys.readouterr().err
