"""What a campaign adds up and compares: nothing of other cases, nothing without a word."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from owt_bringup.cli import main
from owt_campaign.engine import evaluate_case
from owt_campaign.load_cases import case_of, read_load_cases
from owt_campaign.occurrence import read_rose
from owt_model.errors import InputError

SHORT = ("--duration", "20", "--reduction", "CB00", "--workers", "0")
HEAD = "hs_m,direction_deg,tp_s,probability\n"


def campaign(place: Path, table: str, *flags: str) -> tuple[int, dict, Path]:
    """Exit code, summary and folder of a campaign."""
    (place / "table.csv").write_text(table)
    code = main(["campaign", str(place / "table.csv"), "-o", str(place / "out"), *SHORT, *flags])
    return code, json.loads((place / "out" / "summary.json").read_text()), place / "out"


def results(folder: Path) -> xr.Dataset:
    with xr.open_dataset(folder / "results.nc", engine="h5netcdf") as data:
        return data.load()


def case_file(place: Path, factor: float) -> str:
    path = place / f"factor{factor:g}.json"
    path.write_text(json.dumps({"fatigue": {"design_fatigue_factor": factor}}))
    return str(path)


def test_a_resumed_campaign_takes_the_factor_that_is_asked_for(tmp_path: Path) -> None:
    """It changes no damage, so that the kept cases serve; the life is another one."""
    table = HEAD + "2,330,7,1\n"
    _, first, folder = campaign(tmp_path, table, "--seeds", "1")
    before = results(folder)
    flags = ("--seeds", "1", "--resume", "--case", case_file(tmp_path, 10.0))
    _, second, _ = campaign(tmp_path, table, *flags)
    assert (second["computed"], second["reused"], second["design_fatigue_factor"]) == (0, 1, 10.0)
    assert second["totals"]["2"]["life_years"] == pytest.approx(0.3 * first["totals"]["2"]["life_years"])
    np.testing.assert_allclose(results(folder).life_years, 0.3 * before.life_years, rtol=1e-12)
    assert json.loads(results(folder).attrs["case"])["fatigue"]["design_fatigue_factor"] == 10.0


def test_orders_are_compared_over_the_cases_that_both_finished(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second order raises the highest sea into the transition piece, the first does not."""
    code, summary, folder = campaign(
        tmp_path, HEAD + "2,330,7,0.6\n30,330,14,0.1\n", "--seeds", "1", "--order", "both"
    )
    assert code == 1
    assert [(failed["row"], failed["order"]) for failed in summary["failed"]] == [(2, 2)]
    covered = {order: total["probability_covered"] for order, total in summary["totals"].items()}
    assert covered == {"1": pytest.approx(0.7), "2": pytest.approx(0.6)}
    assert "order 2: the sea states that count have a probability of 0.6 together" in capsys.readouterr().err
    page = (folder / "report.html").read_text()
    assert "over the cases that both of them finished, with a probability of 0.6" in page
    data = results(folder)
    spot = int(np.argmax(data.damage_per_year.sel(order=2).values))
    ratio = {order: float(data.damage.sel(case=1, order=order)[0, spot]) for order in (1, 2)}
    assert f"{ratio[2] / ratio[1]:.3f}" in page
    totals = data.damage_per_year[:, spot]
    assert float(totals[1] / totals[0]) < 0.5 * ratio[2] / ratio[1]  # negative control: of all that finished


def test_every_place_has_its_member_end_and_joint(tmp_path: Path) -> None:
    _, _, folder = campaign(tmp_path, HEAD + "2,330,7,1\n", "--seeds", "1")
    data = results(folder)
    for spot in data.hot_spot[:: len(data.hot_spot) // 50]:
        end = data.joint.sel(member=spot.hot_spot_member, end=spot.hot_spot_end).item()
        assert str(spot.values).startswith(f"{spot.hot_spot_member.item()}:{end} ")
    stress = pd.read_parquet(folder / "tables" / "total_stress_per_year.parquet").set_index("order").loc[2]
    for name, value in zip(stress.member_end, stress.total_stress_per_year_pa, strict=True):
        member, joint = name.split(":")
        there = data.total_stress_per_year.sel(order=2, member=member)
        assert there.where(data.joint.sel(member=member) == joint, drop=True).item() == value


def test_a_case_runs_again_by_its_own_seed(tmp_path: Path) -> None:
    """`sea_seed` of the results in a case file gives the numbers of the campaign."""
    _, _, folder = campaign(tmp_path, HEAD + "2,330,7,0.6\n6,300,9.5,0.3\n", "--seeds", "2")
    data = results(folder).sel(order=2)
    assert len(set(data.sea_seed.values.ravel().tolist())) == 4
    for case, row in enumerate(read_load_cases(tmp_path / "table.csv").rows, 1):
        given = json.loads(data.attrs["case"])
        again = evaluate_case(case_of(row, given, seed=int(data.sea_seed.sel(case=case, seed=2)), order=2))
        np.testing.assert_array_equal(again.fatigue.damage, data.damage.sel(case=case, seed=2))
        other = data.damage.sel(case=case, seed=1)  # negative control: another realisation
        assert not np.allclose(again.fatigue.damage, other, rtol=0.01, atol=0.0)


def test_the_error_by_the_seeds(tmp_path: Path) -> None:
    """Independent rows: variances of their means add up; one seed tells nothing."""
    table = HEAD + "2,330,7,0.6\n6,300,9.5,0.3\n"
    _, summary, folder = campaign(tmp_path, table, "--seeds", "3")
    data = results(folder).sel(order=2)
    variance = (data.probability**2 * data.damage.var("seed", ddof=1) / 3.0).sum("case")
    wanted = np.sqrt(variance) * 365.25 * 86400.0 / 20.0
    np.testing.assert_allclose(data.damage_error_per_year, wanted, rtol=1e-10)
    worst = int(np.argmax(data.damage_per_year.values))
    relative = float((data.damage_error_per_year / data.damage_per_year)[worst])
    assert summary["totals"]["2"]["relative_standard_error"] == pytest.approx(relative)
    assert f"standard error {relative:.1%}" in (folder / "report.html").read_text()
    written = pd.read_parquet(folder / "tables" / "totals.parquet")
    np.testing.assert_array_equal(written.damage_error_per_year, data.damage_error_per_year)
    _, alone, _ = campaign(tmp_path, table, "--seeds", "1", "--resume")
    assert alone["reused"] == 2
    assert alone["totals"]["2"]["relative_standard_error"] is None


def test_rows_without_probability_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The diagram that gives the assumed heights ends below 10 m."""
    code, summary, folder = campaign(
        tmp_path, "hs_m,direction_deg,tp_s\n1.75,330,7\n10.25,330,12\n", "--seeds", "1"
    )
    assert code == 0
    assert "count nothing: row 2" in capsys.readouterr().err
    assert "1 rows of the table have no probability" in (folder / "report.html").read_text()
    assert any("sqrt(2 g/Hs)" in warning["example"] for warning in summary["warnings"])


def test_a_table_of_such_rows_alone_gives_a_page(tmp_path: Path) -> None:
    code, summary, folder = campaign(tmp_path, "hs_m,direction_deg,tp_s\n10.25,330,12\n", "--seeds", "1")
    assert code == 0
    assert summary["totals"]["2"]["life_years"] is None
    assert "unlimited" in (folder / "report.html").read_text()


def test_results_are_those_of_the_model_asked_for(tmp_path: Path) -> None:
    """Whatever finished first: here the unreduced model, whose outcome is kept."""
    table, flags = HEAD + "2,330,7,1\n", ("--seeds", "1", "--errors-against", "full", "--duration", "5")
    _, _, folder = campaign(tmp_path, table, *flags)
    before = results(folder)
    assert before.attrs["reduction"] == "CB00"
    (folder / "cases" / f"{before.key.values.item()}.npz").unlink()
    _, summary, _ = campaign(tmp_path, table, *flags, "--resume")
    assert (summary["computed"], summary["reused"]) == (1, 1)
    xr.testing.assert_equal(before.drop_vars("stage_seconds"), results(folder).drop_vars("stage_seconds"))
    assert results(folder).attrs == before.attrs


def test_wheeler_goes_with_linear_waves_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = HEAD + "2,330,7,1\n"
    code, _, folder = campaign(tmp_path, table, "--seeds", "1", "--order", "1", "--stretching", "wheeler")
    assert code == 0
    assert json.loads(results(folder).attrs["case"])["wave"]["stretching"] == "wheeler"
    arguments = ["campaign", str(tmp_path / "table.csv"), "-o", str(tmp_path / "other"), *SHORT]
    assert main([*arguments, "--order", "both", "--stretching", "wheeler"]) == 1
    assert "refused at order 2" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize("directions", [(330, 330), (330, -30), (330, 690), (0, 360)])
def test_a_rose_has_each_direction_once(directions: tuple[int, int], tmp_path: Path) -> None:
    path = tmp_path / "rose.csv"
    path.write_text(f"direction_deg,share\n{directions[0]},0.5\n{directions[1]},0.5\n")
    with pytest.raises(InputError, match="direction_deg"):
        read_rose(path)
    path.write_text("direction_deg,share\n330,0.5\n300,0.5\n")
    assert read_rose(path).share.tolist() == [0.5, 0.5]
