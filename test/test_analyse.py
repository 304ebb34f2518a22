"""`analyse` on bags that are complete, broken off, or still being written, and on folders of them."""

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest

from bag_tools import RECEIVED_NS, begin, rewrite, run_messages, write_run
from local_graph import short_case
from owt_bringup.analysis import analyse
from owt_bringup.bag_case import recorded_run
from owt_bringup.cli import main
from owt_campaign.pipeline import run_case
from owt_model.config import CaseConfig
from owt_model.errors import ComputationError, InputError
from owt_model.versions import versions
from owt_postproc.bag_source import BagSource
from owt_postproc.report import summary

pytestmark = [pytest.mark.timeout(180)]

BLOCKS = 12


def case() -> CaseConfig:
    """6 s in twelve blocks."""
    return short_case(time={"n": 60}, stream={"block": 5})


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("analyse") / "run", case())


@pytest.fixture(scope="module")
def wanted() -> dict[str, Any]:
    """Summary of the run in one process."""
    return json.loads(json.dumps(summary(run_case(case(), versions=versions()).report)))


def read(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return found


def test_the_summary_of_a_bag_is_that_of_the_run_in_one_process(bag: Path, wanted: dict[str, Any]) -> None:
    assert main(["analyse", str(bag)]) == 0
    assert read(bag) == wanted
    assert wanted["fatigue"]["complete"]
    # Negative control: another seed.
    other = case().model_copy(update={"sea_state": case().sea_state.model_copy(update={"seed": 4})})  # type: ignore[union-attr]
    assert summary(run_case(other).report)["fatigue"] != wanted["fatigue"]


def test_a_bag_is_read_while_it_is_written(
    tmp_path: Path, wanted: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    """By its later name; the results lie beside it, so that none of them end up in the finished bag."""
    messages = list(run_messages(case()))
    writer = begin(tmp_path / "run", case())
    latched = len(messages) - BLOCKS * ((len(messages) - 4) // BLOCKS)
    per_block = (len(messages) - latched) // BLOCKS
    counts = []
    for i, (label, at, data) in enumerate(messages):
        writer.write(label, data, log_time_ns=RECEIVED_NS + i, publish_time_ns=at)
        if i + 1 in (latched + 3 * per_block, latched + 8 * per_block):
            writer.flush()
            assert main(["analyse", str(tmp_path / "run")]) == 0
            counts.append(read(tmp_path / "run.partial")["fatigue"])
            assert not (writer.folder / "summary.json").exists()
            err = capsys.readouterr().err.splitlines()
            reached = 0.5 * (3 if len(counts) == 1 else 8) - 0.1
            assert err == [
                f"note: {tmp_path / 'run'} is not complete: it goes to {reached:.1f} s of 6 s",
                "note: cycles counted again: equal the recorded fatigue bit for bit",
            ]
    assert [found["samples"] for found in counts] == [5 * 14 + 1, 5 * 39 + 1]
    assert [found["complete"] for found in counts] == [False, False]
    assert counts[0]["max_damage"] < counts[1]["max_damage"] <= wanted["fatigue"]["max_damage"]
    writer.close()
    assert main(["analyse", str(tmp_path / "run")]) == 0
    assert read(tmp_path / "run") == wanted


def test_reading_while_a_thread_writes(tmp_path: Path) -> None:
    """Whatever moment it is opened at, what is read is whole blocks, from the first on."""
    writer, messages = begin(tmp_path / "run", case(), chunk_size=20_000), list(run_messages(case()))
    begun, done = threading.Event(), threading.Event()

    def write() -> None:
        for i, (label, at, data) in enumerate(messages):
            writer.write(label, data, log_time_ns=RECEIVED_NS + i, publish_time_ns=at)
            if i > 40:
                begun.set()
        writer.close()
        done.set()

    thread = threading.Thread(target=write)
    thread.start()
    begun.wait(30.0)
    reached = []
    while True:
        last = done.is_set()
        with BagSource(tmp_path / "run") as source:
            data = [(message.topic, message.data) for message in source.messages()]
        assert data == [(label, content) for label, _, content in messages[: len(data)]]
        reached.append(len(data))
        if last:
            break
    thread.join()
    assert reached == sorted(reached)
    assert reached[-1] == len(messages)


def test_a_recording_that_was_ended_early(tmp_path: Path) -> None:
    """By a signal, say: it has an index and a partial name; the results lie beside it, and say how far."""
    writer = begin(tmp_path / "run", case())
    for i, (label, at, data) in enumerate(list(run_messages(case()))[:60]):
        writer.write(label, data, log_time_ns=RECEIVED_NS + i, publish_time_ns=at)
    writer.seal()
    writer.abandon()
    data, folder, notes = analyse(tmp_path / "run")
    assert folder == tmp_path / "run.partial"
    assert not data.complete
    assert notes[0] == f"{tmp_path / 'run'} is not complete: it goes to 3.9 s of 6 s"
    _, folder, _ = analyse(writer.file)
    assert folder == writer.file.with_suffix("")


@pytest.mark.parametrize("share", [0.5, 0.9, 0.999])
def test_a_recording_that_was_cut_off(tmp_path: Path, bag: Path, share: float) -> None:
    """In the middle of a chunk too; the complete ones before it count."""
    small = rewrite(bag, tmp_path / "small", lambda *_: None, chunk_size=50_000)
    file = small / "small_0.mcap"
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    data, folder, notes = analyse(small)
    assert folder == tmp_path / "small.partial"
    assert "is not complete: it goes to" in notes[0]
    assert len(data.time) > 20
    # Negative control: the same cut is refused where a complete bag is asked for.
    from owt_postproc.bag_reader import read_messages

    with pytest.raises(InputError, match="it was not finished"):
        list(read_messages(small))


def test_a_damaged_chunk_is_a_gap(tmp_path: Path, bag: Path) -> None:
    """Complete or not: nothing is counted over it."""
    small = rewrite(bag, tmp_path / "small", lambda *_: None, chunk_size=50_000)
    file = small / "small_0.mcap"
    whole = bytearray(file.read_bytes())
    whole[len(whole) // 2] ^= 0xFF
    file.write_bytes(whole)
    with pytest.raises(InputError, match="cannot be read"):
        analyse(small)
    file.write_bytes(whole[:-20])
    with pytest.raises(ComputationError, match=r"sequence|block"):
        analyse(small)


@pytest.fixture
def several(tmp_path: Path, bag: Path) -> Iterator[Path]:
    """A folder with a complete bag, an unfinished one, a bad one and something else."""
    folder = tmp_path / "bags"
    rewrite(bag, folder / "good", lambda *_: None)

    def bad(kind: str, content: Any) -> None:
        if kind == "FatigueState" and content.sequence == 7:
            content.damage = content.damage * 1.01

    rewrite(bag, folder / "bad", bad)
    writer = begin(folder / "begun", case())
    for i, (label, at, data) in enumerate(list(run_messages(case()))[:60]):
        writer.write(label, data, log_time_ns=i, publish_time_ns=at)
    writer.flush()
    (folder / "notes").mkdir()
    (folder / "notes" / "letter.txt").write_text("dear")
    yield folder
    writer.abandon()


@pytest.mark.parametrize("output", [False, True], ids=["beside", "elsewhere"])
def test_a_folder_of_bags(
    several: Path, tmp_path: Path, output: bool, wanted: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["-o", str(tmp_path / "out")] if output else []
    assert main(["analyse", str(several), *arguments]) == 1
    out, err = capsys.readouterr()
    place = tmp_path / "out" if output else several
    assert [line.split(":")[0] for line in out.splitlines()] == [".begun.partial", "good", "all together"]
    assert read(place / "good") == wanted
    assert not read(place / "begun.partial")["fatigue"]["complete"]
    assert "error: bad: /owt/fatigue, block 7: damage [" in err
    assert err.splitlines()[-1] == "error: 1 of 3 bags failed: bad"
    assert not (place / "bad" / "summary.json").exists()
    # All together: the damage of each spot is added up, what failed is named.
    together = read(place)
    (group,) = together["groups"]
    assert [record["name"] for record in group["records"]] == [".begun.partial", "good"]
    assert list(together["failed"]) == ["bad"]
    assert group["max_damage"] > wanted["fatigue"]["max_damage"]
    parts = [
        pyarrow.parquet.read_table(place / name / "hot_spots.parquet") for name in ("begun.partial", "good")
    ]
    whole = pyarrow.parquet.read_table(place / "hot_spots.parquet")
    added = sum(part["damage"].to_numpy() for part in parts)
    np.testing.assert_allclose(
        whole["damage"].to_numpy(), added, rtol=1e-12
    )  # two terms, round-off of the sum
    page = (place / "report.html").read_text()
    assert "bad failed and is not counted" in page
    assert 'href="good/report.html"' in page


def test_a_folder_without_bags_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["analyse", str(tmp_path)]) == 1
    err = capsys.readouterr().err
    assert err.startswith("error: bag = ")
    assert "holds no MCAP file" in err
    assert err.count("\n") == 1


def test_the_load_of_a_topic_runs_again_from_the_bag(tmp_path: Path) -> None:
    """The case names a topic, which only a graph has: what was recorded takes its place."""
    file = tmp_path / "wind.csv"
    file.write_text("time_s,fx_n,my_nm\n0,1e5,-2e6\n2.3,3e5,1e6\n30,-1e5,0\n")
    series = case().model_copy(update={"wind": short_case(wind={"series": {"path": str(file)}}).wind})
    topic = case().model_copy(update={"wind": short_case(wind={"topic": {}}).wind})
    with begin(tmp_path / "run", topic) as writer:
        for i, (label, at, data) in enumerate(run_messages(series)):
            writer.write(label, data, log_time_ns=RECEIVED_NS + i, publish_time_ns=at)
    file.unlink()
    with pytest.raises(InputError, match="is read by the running graph only"):
        run_case(topic)
    with BagSource(tmp_path / "run") as source:
        recorded = recorded_run(source)
    again = run_case(recorded.case, tower_top=recorded.tower_top, keep_series=True)
    data, _, notes = analyse(rewrite(tmp_path / "run", tmp_path / "short"))
    assert any(note.endswith("equals what was recorded bit for bit") for note in notes)
    np.testing.assert_array_equal(again.report.stress_normal, data.stress_normal)
    np.testing.assert_array_equal(again.report.fatigue.damage, data.fatigue.damage)
    # Negative control: without the load the damage is another.
    assert not np.array_equal(run_case(case()).report.fatigue.damage, data.fatigue.damage)
