"""Campaigns: one result whatever the workers, nothing lost and nothing trusted that should not be."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from owt_bringup.cli import main
from owt_campaign import dask_pool
from owt_campaign.dask_pool import ALLOWED_DEATHS, DaskPool, WorkerLostError
from owt_campaign.engine import CaseOutcome
from owt_campaign.result_file import decode_outcome, encode_outcome
from owt_campaign.runner import CaseRecord, run_cases
from owt_campaign.store import ResultStore
from owt_campaign.worker import compute_case
from owt_model.config import CaseConfig, parse_case
from owt_model.errors import ComputationError, InputError

ROOT = Path(__file__).parents[1]
TABLE = "hs_m,direction_deg,tp_s,probability\n2,330,7,0.6\n6,300,9.5,0.3\n"
SHORT = ("--duration", "20", "--reduction", "CB00", "--seeds", "2")


def a_case(seed: int, hs: float = 4.0, direction: float = 210.0, **structure: Any) -> CaseConfig:
    return parse_case({
        "sea_state": {"hs_m": hs, "tp_s": 9.0, "seed": seed, "direction_deg": direction},
        "wave": {"order": 1},
        "structure": {"reduction": "CB00", **structure},
        "time": {"n": 200},
    })  # fmt: skip


def outcomes(records: list[CaseRecord]) -> list[CaseOutcome]:
    found = [record.outcome for record in sorted(records, key=lambda record: record.index)]
    assert all(outcome is not None for outcome in found)
    return [outcome for outcome in found if outcome is not None]


def same(ours: list[CaseOutcome], theirs: list[CaseOutcome]) -> None:
    """To the last bit."""
    assert len(ours) == len(theirs)
    for a, b in zip(ours, theirs, strict=True):
        for name in ("damage", "cycles", "max_range", "total_stress", "histogram"):
            np.testing.assert_array_equal(getattr(a.fatigue, name), getattr(b.fatigue, name))
        for name in ("potential_mean", "potential_std", "kinetic_mean", "kinetic_std"):
            np.testing.assert_array_equal(getattr(a.energy, name), getattr(b.energy, name))


@pytest.fixture(scope="module")
def cases() -> list[CaseConfig]:
    return [a_case(1, reduction="CB00M10"), a_case(2, reduction="CB00M10"), a_case(1), a_case(1, hs=2.0)]


@pytest.fixture(scope="module")
def reference(cases: list[CaseConfig]) -> list[CaseOutcome]:
    return outcomes(list(run_cases(cases, workers=0)))


@pytest.mark.parametrize("workers", [1, 2])
def test_any_number_of_workers_gives_the_same_bits(
    workers: int, cases: list[CaseConfig], reference: list[CaseOutcome]
) -> None:
    told: list[str] = []
    found = outcomes(list(run_cases(cases, workers=workers, on_start=told.append)))
    same(found, reference)
    assert "http://127.0.0.1:" in told[0]
    with pytest.raises(AssertionError):
        same(found[::-1], reference)


def test_order_and_model_sharing_do_not_matter(cases: list[CaseConfig], reference: list[CaseOutcome]) -> None:
    same(outcomes(list(run_cases(cases[::-1], workers=0)))[::-1], reference)
    same(outcomes(list(run_cases(cases[1:2], workers=0))), reference[1:2])


def test_a_scheduler_of_ones_own(cases: list[CaseConfig], reference: list[CaseOutcome]) -> None:
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        host="127.0.0.1",
        protocol="tcp",
        dashboard_address=None,
    ) as one:
        same(outcomes(list(run_cases(cases, workers=0, scheduler=one.scheduler_address))), reference)


def test_a_scheduler_that_is_not_there_is_one_error() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dask_pool, "CONNECT_TIMEOUT", 1.0)
        for address in ("tcp://127.0.0.1:9", "nonsense://x", "tcp://"):
            with pytest.raises(InputError, match="scheduler"):
                list(run_cases([a_case(1)], workers=1, scheduler=address))


def test_clusters_share_load_vectors(cases: list[CaseConfig]) -> None:
    pair = [a_case(1, reduction="CB00M10"), a_case(1, hs=8.0, reduction="CB00M10")]
    own = outcomes(list(run_cases(pair, workers=0)))
    shared = list(run_cases(pair, workers=0, cluster="tot"))
    keys = {record.key for record in shared} | {record.key for record in run_cases(pair, workers=0)}
    assert len(keys) == 4  # other load vectors are another result
    ratio = outcomes(shared)[1].fatigue.total_stress.sum() / own[1].fatigue.total_stress.sum()
    assert 0.9 < ratio < 1.1
    assert ratio != 1.0
    alone = outcomes(list(run_cases(pair[1:], workers=0, cluster="tot")))
    with pytest.raises(AssertionError):
        same(alone, outcomes(shared)[1:])  # which cases are in the cluster counts


def test_a_failing_case_stops_no_other(tmp_path: Path) -> None:
    deck = tmp_path / "missing.yaml"
    unknown = parse_case(a_case(1).model_dump(mode="json") | {"fatigue": {"sn_curve": "nonsense"}})
    mixed = [a_case(1, model=str(deck)), unknown, a_case(1)]
    records = sorted(run_cases(mixed, workers=0), key=lambda record: record.index)
    assert [record.status for record in records] == ["failed", "failed", "done"]
    assert str(deck) in records[0].message
    assert "nonsense" in records[1].message
    assert records[0].outcome is None


def test_dead_workers_are_replaced_and_their_work_repeated(tmp_path: Path) -> None:
    """One call kills its first worker, one kills every worker, others live on."""
    mark = tmp_path / "died"

    def once(path: str) -> str:
        import os
        from pathlib import Path

        if not Path(path).exists():
            Path(path).touch()
            os.kill(os.getpid(), 9)
        return "again"

    def always() -> str:
        import os

        os.kill(os.getpid(), 9)
        return "never"

    def fine() -> str:
        return "fine"

    with DaskPool(1) as pool:
        found = {done.job: done.result for done in pool.run([("once", once, (str(mark),))])}
        found |= {done.job: done.result for done in pool.run([("always", always, ())])}
        found |= {done.job: done.result for done in pool.run([("fine", fine, ())])}
    assert found["once"] == "again"
    assert isinstance(found["always"], WorkerLostError)
    assert f"{ALLOWED_DEATHS + 1} workers died" in str(found["always"])
    assert found["fine"] == "fine"


def test_workers_import_before_their_first_case() -> None:
    """What a case imports is not paid by the first one, while the other workers wait."""

    def loaded(name: str) -> bool:
        import sys

        return name in sys.modules

    with DaskPool(1) as pool:
        calls = [(name, loaded, (name,)) for name in (dask_pool.CASE_MODULE, "owt_viewer")]
        found = {done.job: done.result for done in pool.run(calls)}
    assert found == {compute_case.__module__: True, "owt_viewer": False}


def test_results_are_read_as_they_were_written(reference: list[CaseOutcome]) -> None:
    data = encode_outcome(reference[0])
    again = decode_outcome(data)
    same([again], reference[:1])
    assert encode_outcome(again) == data
    assert again.fatigue.hot_spots.name == reference[0].fatigue.hot_spots.name
    assert again.case == reference[0].case
    for bad in (b"", b"PK", data[:-200]):
        with pytest.raises(ComputationError):
            decode_outcome(bad)


def test_a_store_trusts_nothing_without_its_checksum(tmp_path: Path) -> None:
    store = ResultStore(tmp_path / "cases")
    store.put("a", b"result")
    assert store.get("a") == b"result"
    assert store.get("b") is None
    store.path("a").write_bytes(b"resulT")
    assert store.get("a") is None
    assert store.distrusted == ["a"]
    store.put("a", b"result")
    (tmp_path / "cases" / "a.sha256").unlink()
    assert store.get("a") is None


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("table") / "table.csv"
    path.write_text(TABLE)
    return path


@pytest.fixture(scope="module")
def finished(table: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign that nothing disturbed, of both orders."""
    folder = tmp_path_factory.mktemp("campaign") / "done"
    assert main(["campaign", str(table), "-o", str(folder), *SHORT, "--order", "both", "--workers", "0"]) == 0
    return folder


def results(folder: Path) -> xr.Dataset:
    with xr.open_dataset(folder / "results.nc", engine="h5netcdf") as data:
        return data.load()


def test_the_page_names_the_linear_waves(finished: Path) -> None:
    """Second order over linear hangs on what is done above still water."""
    page = (finished / "report.html").read_text()
    assert "(wave.stretching): taylor" in page
    assert "wheeler" not in page


def test_what_the_dataset_holds(finished: Path, table: Path) -> None:
    data = results(finished)
    assert dict(data.sizes) | {"case": 2, "seed": 2, "order": 2} == dict(data.sizes)
    assert data.damage.dims == ("case", "seed", "order", "hot_spot")
    assert data.damage.attrs["units"] == "1"
    assert data.total_stress.dims == ("case", "seed", "order", "member", "end")
    assert data.total_stress.attrs["units"] == "Pa"
    assert not data.damage.isnull().any()
    assert (data.status == 0).all()
    assert data.attrs["occurrence_assumed"] == 0
    assert data.probability.values.tolist() == [0.6, 0.3]
    assert {"version_owt", "model_hash", "sn_curve", "case"} <= set(data.attrs)
    np.testing.assert_array_equal(data.histogram.sum("bin"), data.cycles)
    # Damage of a year: the mean of the seeds, by probability, and by the records that a year holds.
    per_year = (data.damage.mean("seed") * data.probability).sum("case") * 365.25 * 86400.0 / 20.0
    np.testing.assert_allclose(data.damage_per_year, per_year.transpose("order", "hot_spot"), rtol=1e-12)
    np.testing.assert_allclose(data.life_years * 3.0 * data.damage_per_year, 1.0, rtol=1e-12)
    # The spot of a member end that is worst in one sea state is not always that of another.
    largest_first = (
        (data.damage.mean("seed").max("hot_spot") * data.probability).sum("case") * 365.25 * 86400.0 / 20.0
    )
    assert (per_year.max("hot_spot") <= largest_first).all()


def test_what_the_tables_hold(finished: Path) -> None:
    data = results(finished)
    cases = pd.read_parquet(finished / "tables" / "cases.parquet")
    assert len(cases) == 8
    assert set(cases.status) == {"done"}
    damage = pd.read_parquet(finished / "tables" / "damage.parquet")
    one = damage[(damage.case == 2) & (damage.seed == 1) & (damage.order == 2)]
    np.testing.assert_array_equal(one.damage, data.damage.sel(case=2, seed=1, order=2))
    ranges = pd.read_parquet(finished / "tables" / "stress_ranges.parquet")
    per_year = (data.cycles.mean("seed") * data.probability).sum() * 365.25 * 86400.0 / 20.0
    assert ranges.cycles_per_year.sum() == pytest.approx(float(per_year), rel=1e-12)
    totals = pd.read_parquet(finished / "tables" / "totals.parquet")
    np.testing.assert_array_equal(
        totals[totals.order == 1].damage_per_year, data.damage_per_year.sel(order=1)
    )


def test_summary_and_existing_folders(
    finished: Path, table: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    summary = json.loads((finished / "summary.json").read_text())
    assert (summary["computed"], summary["reused"], summary["failed"]) == (8, 0, [])
    arguments = ["campaign", str(table), "-o", str(finished), *SHORT, "--order", "both", "--workers", "0"]
    assert main(arguments) == 1
    assert "holds a campaign already" in capsys.readouterr().err
    before = results(finished)
    assert main([*arguments, "--resume"]) == 0
    summary = json.loads((finished / "summary.json").read_text())
    assert (summary["computed"], summary["reused"]) == (0, 8)
    xr.testing.assert_equal(before, results(finished))


def test_other_cases_are_not_reused(finished: Path, table: Path) -> None:
    arguments = ["campaign", str(table), "-o", str(finished), *SHORT, "--workers", "0", "--resume"]
    assert main([*arguments, "--gamma", "2.0"]) == 0
    summary = json.loads((finished / "summary.json").read_text())
    assert (summary["computed"], summary["reused"]) == (4, 0)
    assert main([*arguments, "--order", "both"]) == 0
    assert json.loads((finished / "summary.json").read_text())["reused"] == 8


def test_a_refused_row_fails_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "table.csv"
    table.write_text("hs_m,direction_deg,tp_s\n2,330,7\n6,300,3\nx,0,9\n40,0,20\n")
    folder = tmp_path / "out"
    arguments = ["--duration", "20", "--reduction", "CB00", "--seeds", "1", "--workers", "0"]
    assert main(["campaign", str(table), "-o", str(folder), *arguments]) == 1
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["computed"] == 1
    assert [failed["row"] for failed in summary["failed"]] == [2, 3, 4]
    assert summary["occurrence_assumed"]
    err = capsys.readouterr().err
    assert "ASSUMED" in err
    assert "row 2 (Hs 6 m, Tp 3 s" in err
    data = results(folder)
    assert data.status.values.ravel().tolist() == [0, 1, 1, 1]
    assert "steepness" in str(data.message.values[1, 0, 0])
    assert data.damage.isnull().all("hot_spot").values.ravel().tolist() == [False, True, True, True]


def test_errors_against_the_full_model(tmp_path: Path) -> None:
    folder, table = tmp_path / "out", tmp_path / "table.csv"
    table.write_text("hs_m,direction_deg,tp_s\n6,300,9.5\n")
    arguments = [
        "--duration",
        "5",
        "--reduction",
        "CB10M10",
        "--seeds",
        "1",
        "--workers",
        "0",
        "--order",
        "1",
    ]
    assert main(["campaign", str(table), "-o", str(folder), *arguments, "--errors-against", "full"]) == 0
    data = results(folder)
    assert json.loads((folder / "summary.json").read_text())["computed"] == 2
    assert float(np.abs(data.potential_mean_error.sel(part="total")).max()) < 0.05
    assert float(np.abs(data.potential_mean_error).max()) > 0.0
    errors = pd.read_parquet(folder / "tables" / "errors_member_end.parquet")
    np.testing.assert_array_equal(errors.total_stress_error, data.total_stress_error.values.ravel())


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--seeds", "0"], "seeds = 0"),
        (["--workers", "-1"], "workers = -1"),
        (["--resume", "--overwrite"], "--resume"),
        (["--duration", "0.05"], "duration"),
        (["--rose", "missing.csv"], "wave rose"),
    ],
)
def test_bad_arguments_are_one_line(
    flags: list[str], says: str, table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["campaign", str(table), "-o", str(tmp_path / "out"), *flags]) == 1
    err = capsys.readouterr().err
    assert err.startswith("error: ")
    assert says in err
    assert err.count("\n") == 1


def test_resume_after_kill(table: Path, tmp_path: Path) -> None:
    """Kill -9 of the whole campaign; a damaged result is computed again, the others are not."""
    folder = tmp_path / "out"
    flags = ["--duration", "40", "--reduction", "CB00", "--seeds", "4", "--order", "1", "--workers", "0"]
    command = [sys.executable, "-m", "owt_bringup.cli", "campaign", str(table), "-o", str(folder), *flags]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 120.0
    while len(list((folder / "cases").glob("*.sha256"))) < 3:
        assert process.poll() is None, "the campaign ended before it was killed"
        assert time.monotonic() < deadline
        time.sleep(0.01)  # between looks at the folder
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    left = sorted((folder / "cases").glob("*.sha256"))
    assert 3 <= len(left) < 8
    assert not (folder / "summary.json").exists()
    damaged = left[0].with_suffix(".npz")
    data = bytearray(damaged.read_bytes())
    data[len(data) // 2] ^= 1
    damaged.write_bytes(data)
    (folder / "cases" / ".half.npz.partial").write_bytes(b"what a killed process leaves")

    assert main(["campaign", str(table), "-o", str(folder), *flags, "--resume"]) == 0
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["reused"], summary["computed"]) == (len(left) - 1, 8 - len(left) + 1)
    assert summary["distrusted"] == 1
    assert not list((folder / "cases").glob("*.partial"))

    whole = tmp_path / "whole"
    assert main(["campaign", str(table), "-o", str(whole), *flags]) == 0
    ours, theirs = results(folder), results(whole)
    xr.testing.assert_equal(ours.drop_vars("stage_seconds"), theirs.drop_vars("stage_seconds"))
