"""Campaigns and what is in their way: files of others, files that changed places, nobody who works."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from owt_bringup.cli import main
from owt_campaign import dask_pool
from owt_campaign.dask_pool import DaskPool, WorkerLostError
from owt_campaign.store import ResultStore
from owt_model.errors import ComputationError, InputError

SHORT = ("--duration", "20", "--reduction", "CB00", "--seeds", "1", "--workers", "0")
TABLE = "hs_m,direction_deg,tp_s,probability\n2,330,7,0.6\n6,300,9.5,0.3\n"


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "table.csv"
    path.write_text(TABLE)
    return path


def campaign(table: Path, *flags: str) -> int:
    return main(["campaign", str(table), "-o", str(table.parent / "out"), *SHORT, *flags])


def test_results_that_changed_places_are_computed_again(table: Path) -> None:
    """Each fits its checksum, but is another case's."""
    assert campaign(table) == 0
    folder = table.parent / "out"
    before = json.loads((folder / "summary.json").read_text())["totals"]
    one, two = sorted((folder / "cases").glob("*.npz"))
    for suffix in (".npz", ".sha256"):
        a, b = one.with_suffix(suffix), two.with_suffix(suffix)
        (folder / "between").write_bytes(a.read_bytes())
        a.write_bytes(b.read_bytes())
        b.write_bytes((folder / "between").read_bytes())
    assert campaign(table, "--resume") == 0
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["computed"], summary["reused"], summary["distrusted"]) == (2, 0, 2)
    assert summary["totals"] == before
    assert campaign(table, "--resume") == 0  # negative control: in their places they are trusted
    assert json.loads((folder / "summary.json").read_text())["reused"] == 2


def test_nothing_is_removed_before_the_arguments_are_checked(
    table: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_pool, "CONNECT_TIMEOUT", 1.0)
    assert campaign(table) == 0
    folder = table.parent / "out"
    there = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for flags, says in (
        (("--workers", "-1"), "workers = -1"),
        (("--scheduler", "tcp://127.0.0.1:9"), "is not reached"),
        (("--scheduler", "nonsense"), "is no address"),
        (("--scheduler", "tcp://127.0.0.1"), "is no address"),
        (("--scheduler", "http://127.0.0.1:1"), "is no address"),
        (("--scheduler", ""), "is no address"),
    ):
        capsys.readouterr()
        assert campaign(table, *flags, "--overwrite") == 1
        err = capsys.readouterr().err
        assert says in err
        assert err.count("\n") == 1
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == there
    assert campaign(table, "--overwrite") == 0  # negative control: now it is computed anew
    assert json.loads((folder / "summary.json").read_text())["computed"] == 2


def test_files_of_others_stay(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = table.parent / "out"
    mine = [folder / "cases" / "mine.json", folder / "tables" / "mine.parquet", folder / "mine.txt"]
    for path in mine:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("mine")
    for flag in ("--resume", "--overwrite"):
        assert campaign(table, flag) == 1
        assert "no campaign.json" in capsys.readouterr().err
    for path in mine[:2]:
        path.unlink()
        path.parent.rmdir()
    assert campaign(table) == 0
    for path in mine:
        path.write_text("mine")
    inside = folder / "tables" / "table.csv"
    inside.write_text(TABLE)
    for flag in ("--resume", "--overwrite"):
        assert main(["campaign", str(inside), "-o", str(folder), *SHORT, flag]) == 0
        assert [path.read_text() for path in mine] == ["mine"] * 3
        assert inside.read_text() == TABLE
    assert json.loads((folder / "summary.json").read_text())["computed"] == 2  # of --overwrite


def test_a_checksum_without_the_name_is_not_enough(tmp_path: Path) -> None:
    store = ResultStore(tmp_path)
    store.put("a", b"result")
    line = (tmp_path / "a.sha256").read_text()
    assert line.endswith("  a.npz\n")
    (tmp_path / "a.sha256").write_text(line.replace("a.npz", "b.npz"))
    assert store.get("a") is None
    (tmp_path / "a.sha256").write_text(line)
    assert store.get("a") == b"result"


def test_a_call_that_kills_its_workers_harms_no_other() -> None:
    """Dask blames those that waited beside it too."""

    def poison() -> str:
        import os

        os.kill(os.getpid(), 9)
        return "never"

    def fine(number: int) -> int:
        return number

    calls = [(f"{i}", fine, (i,)) for i in range(6)]
    calls.insert(1, ("poison", poison, ()))
    with DaskPool(1) as pool:
        found = {done.job: done.result for done in pool.run(calls)}
    assert isinstance(found.pop("poison"), WorkerLostError)
    assert found == {f"{i}": i for i in range(6)}


def test_a_scheduler_without_workers_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr(dask_pool, "LOOK_EVERY", 0.1)
    monkeypatch.setattr(dask_pool, "PATIENCE", 0.5)
    empty = LocalCluster(
        n_workers=0, processes=False, host="127.0.0.1", protocol="tcp", dashboard_address=None
    )
    with empty, DaskPool(0, empty.scheduler_address) as pool:
        with pytest.raises(ComputationError, match=r"no worker for 0\.5 s"):
            list(pool.run([("job", abs, (-1,))]))
        empty.scale(1)
        assert [done.result for done in pool.run([("job", abs, (-1,))])] == [1]


def test_a_worker_without_the_code_is_an_error() -> None:
    def lacking() -> None:
        raise ModuleNotFoundError("No module named 'owt_model'")

    with DaskPool(1) as pool, pytest.raises(ComputationError, match="same version everywhere"):
        list(pool.run([("job", lacking, ())]))


def test_what_is_no_address_is_refused_at_once() -> None:
    for address in ("", "nonsense", "tcp://", "tcp://host", "http://host:1", "tcp://host:port"):
        with pytest.raises(InputError, match="is no address"):
            DaskPool(1, address).__enter__()
