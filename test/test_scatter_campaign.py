"""A scatter diagram through a campaign: every cell that occurs runs, by its occurrences."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from owt_bringup.cli import main

#: Five cells occur; the waves of the last one, Hs 8.5 m with Tp 3.5 s, are too steep to exist.
SCATTER = """\
# Occurrences, mean wave direction 330 deg.
hm0_min_m,hm0_max_m,tp_3.5s,tp_6.5s,tp_9.5s,tp_12.5s
1,2,0,60,30,0
4,5,0,0,8,1
8,9,1,0,0,0
"""
CELLS = [(1.5, 6.5, 0.60), (1.5, 9.5, 0.30), (4.5, 9.5, 0.08), (4.5, 12.5, 0.01), (8.5, 3.5, 0.01)]
SHORT = ("--duration", "20", "--reduction", "CB00", "--seeds", "1", "--order", "both")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign over the diagram, on two workers; one cell cannot run."""
    place = tmp_path_factory.mktemp("scatter")
    diagram = place / "scatter.csv"
    diagram.write_text(SCATTER)
    assert main(["campaign", str(diagram), "-o", str(place / "out"), *SHORT, "--workers", "2"]) == 1
    return place / "out"


def results(folder: Path) -> xr.Dataset:
    with xr.open_dataset(folder / "results.nc", engine="h5netcdf") as data:
        return data.load()


def test_every_cell_that_occurs_runs(folder: Path) -> None:
    data = results(folder)
    found = zip(data.hs_m.values, data.tp_s.values, data.probability.values, strict=True)
    np.testing.assert_allclose(list(found), CELLS, rtol=1e-12)
    assert set(data.direction_deg.values) == {330.0}
    assert data.attrs["occurrence_assumed"] == 0  # it is in the diagram
    assert data.status.values.tolist() == [[[0, 0]]] * 4 + [[[1, 1]]]
    assert "steepness" in str(data.message.values[4, 0, 0])


def test_damage_is_added_up_by_occurrence(folder: Path) -> None:
    data, summary = results(folder), json.loads((folder / "summary.json").read_text())
    done = data.isel(case=slice(0, 4), seed=0)
    per_record = (done.damage * done.probability).sum("case")
    per_year = per_record * 365.25 * 86400.0 / 20.0
    np.testing.assert_allclose(data.damage_per_year, per_year.transpose("order", "hot_spot"), rtol=1e-12)
    assert summary["computed"] == 8
    assert len(summary["failed"]) == 2
    for order in ("1", "2"):
        assert summary["totals"][order]["probability_covered"] == pytest.approx(0.99)
    # Negative control: cells that count alike give another damage.
    alike = done.damage.mean("case") * 365.25 * 86400.0 / 20.0
    assert not np.allclose(data.damage_per_year, alike.transpose("order", "hot_spot"), rtol=0.5)


def test_cells_are_those_of_the_full_table(folder: Path, tmp_path: Path) -> None:
    """`owt table --method full` and a campaign over it give the same numbers, bit by bit."""
    diagram, table = folder.parent / "scatter.csv", tmp_path / "table.csv"
    assert main(["table", str(diagram), "--method", "full", "-o", str(table)]) == 0
    assert main(["campaign", str(table), "-o", str(tmp_path / "out"), *SHORT, "--workers", "0"]) == 1
    ours, theirs = results(folder), results(tmp_path / "out")
    np.testing.assert_array_equal(ours.damage_per_year, theirs.damage_per_year)
    np.testing.assert_array_equal(ours.damage, theirs.damage)
