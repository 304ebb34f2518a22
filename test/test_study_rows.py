"""One row of each study computed again: the committed result is that of the code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from owt_campaign.engine import evaluate_case, prepare_model
from owt_campaign.studies import interpolation, load_case_table, load_vectors, usfos, wind
from owt_campaign.studies.cases import LINEAR, SECOND_ORDER, study_case
from owt_campaign.studies.registry import run_study
from owt_campaign.studies.sea_table import load_case_table as table_cells
from owt_campaign.studies.total_stress import total_stress
from owt_model.errors import InputError

STUDY = Path(__file__).parents[1] / "docs" / "study"
#: Round-off of another machine's libraries in a ratio of sums over a record.
ROUND_OFF = 1e-4


def silent(done: float, total: float) -> None:
    """Progress that nobody watches."""


def committed(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((STUDY / f"{name}.json").read_text())
    return found


def test_interpolation() -> None:
    """Errors with 10 elements, seed 1; the time is no number to hold."""
    found = interpolation.compute((10,), (1,), 6000, silent)
    rows = {(r["place"], r["distribution"], r["elements"]): r for r in committed("interpolation")["runs"]}
    for key, entry in found.items():
        assert entry.force[0] == pytest.approx(rows[key]["force_error"][0], rel=ROUND_OFF)
        assert entry.moment[0] == pytest.approx(rows[key]["moment_error"][0], rel=ROUND_OFF)
    linear, quadratic = (found["splash zone", name, 10].force[0] for name in ("linear", "quadratic"))
    assert quadratic < 0.1 * linear  # negative control: the distributions are not each other


def test_usfos() -> None:
    found, rows = usfos.compute(usfos.STEPS), committed("usfos")["rows"]
    assert found.fine.max() * 1e-6 == pytest.approx(rows[0]["ours"], rel=ROUND_OFF)
    assert 100.0 * found.off("moving") == pytest.approx(rows[3]["ours"], rel=ROUND_OFF)
    assert 100.0 * found.off("midpoint") == pytest.approx(rows[4]["ours"], rel=ROUND_OFF)
    assert found.roughness("midpoint") > 20.0 * found.roughness("moving")


def test_load_case_table() -> None:
    """Second order over linear at the weighted Tp of Hs 7.5 m, table D.1, seed 1."""
    models = load_case_table.structures(("D.1",))
    kept = {
        (r["table"], r["hs_m"], r["wave"], r["cutoff"], r["seed"]): r
        for r in committed("load-case-table")["mean_total_stress_pa"]
    }
    for wave in (LINEAR, SECOND_ORDER):
        first = next(load_case_table.runs(7.5, wave, "4 omega_p", 1))
        stress = load_case_table.mean_stress(first, models)["D.1"]
        assert stress == pytest.approx(kept["D.1", 7.5, wave, "4 omega_p", 1]["ref"], rel=ROUND_OFF)
        assert stress != pytest.approx(kept["D.1", 7.5, wave, "4 omega_p", 2]["ref"], rel=10.0 * ROUND_OFF)


def test_every_specific_period_of_the_print_is_there() -> None:
    """Table 4.4: weighted Tp from its occurrences, within 0.01 s of the print."""
    for hs, count in ((1.5, 20), (7.5, 5)):
        every = list(load_case_table.runs(hs, SECOND_ORDER, "4 omega_p", 1))
        assert [run.kind for run in every] == ["ref"] + ["spec"] * count
        weights, periods = (np.array([getattr(r, k) for r in every[1:]]) for k in ("weight", "tp"))
        assert weights @ periods / weights.sum() == pytest.approx(every[0].tp, abs=0.01)
        assert len({run.case.sea_state.seed for run in every}) == count + 1


def test_total_stress_is_that_of_the_count() -> None:
    """Half the total variation is the sum of range times count, on a structure of another stiffness too."""
    short = {"duration_s": 60.0, "reduction": "CB10"}
    case = study_case(6.0, 10.0, **short)
    models = {
        name: prepare_model(study_case(6.0, 10.0, structure=name, **short))
        for name in ("reference", "frequency")
    }
    found = total_stress(case, models)
    for name, stress in found.items():
        counted = evaluate_case(study_case(6.0, 10.0, structure=name, **short), models[name])
        np.testing.assert_allclose(stress, counted.fatigue.total_stress, rtol=1e-6, atol=1e-3)
    assert found["frequency"].mean() > 1.2 * found["reference"].mean()


def test_total_stress_needs_load_vectors() -> None:
    case = study_case(6.0, 10.0, duration_s=60.0)
    with pytest.raises(InputError, match="no response of its own"):
        total_stress(case, {"reference": prepare_model(case)})


def test_wind() -> None:
    """The low sea state of figure 6.7, seed 1: errors with and without wind."""
    cell = next(c for c in table_cells() if (c.hs_m, c.from_deg) == wind.SEAS["low"])
    study = wind.wind_study([cell], (1,), 6000, silent)
    kept = {
        (r["model"], r["loading"]): r
        for r in committed("wind")["errors"]
        if (r["hs_m"], r["from_deg"], r["seed"]) == (cell.hs_m, cell.from_deg, 1)
    }
    for (_, _, model, loading), error in study.error.items():
        # An error of 1e-8 is a difference of numbers that are known to 1e-11.
        assert error[1] == pytest.approx(kept[model, loading]["std"], rel=1e-2, abs=1e-9)
    assert kept["M20", "W-W"]["std"] != pytest.approx(kept["M20", "W-O"]["std"], rel=0.1)


def test_load_vectors() -> None:
    """The steep regular wave of 2.5 m."""
    found = load_vectors.needs(("stream function",), (2.5,), (1,), silent)["stream function", 2.5, 1]
    kept = next(
        n
        for n in committed("load-vectors")["needs"]
        if (n["wave"], n["height_m"]) == ("stream function", 2.5)
    )
    assert {str(share): n for share, n in found.by_share.items()} == kept["by_share"]
    named = {f"{base}nn {tolerance:g}": n for (base, tolerance), n in found.by_energy.items()}
    assert named == kept["by_energy"]
    assert found.first == pytest.approx(kept["first_share"], rel=1e-3)


def test_vectors_of_the_sea_on_a_regular_wave() -> None:
    wave = ("stream function", 17.0)
    found = load_vectors.borrowed([wave], silent)[wave]
    kept = next(n for n in committed("load-vectors")["borrowed"] if (n["wave"], n["height_m"]) == wave)
    for count, error in kept["error"].items():
        assert found[int(count)] == pytest.approx(error, rel=5e-2)
    assert found[30] > 1e-4 > load_vectors.needs(wave[:1], wave[1:], (1,), silent)[(*wave, 1)].error[6]


def test_enough_vectors_are_those_whose_larger_counts_do_too() -> None:
    error = {0: 9.0, 5: 0.9, 10: 1.1, 20: 0.8, 30: 0.5}
    assert load_vectors.enough(error, 1.0) == 20  # not 5, whose next does not
    assert load_vectors.enough(error, 2.0) == 5
    assert load_vectors.enough(error | {30: 1.2}, 1.0) is None


@pytest.mark.parametrize("name", ["usfos", "interpolation", "load-case-table", "wind", "load-vectors"])
def test_reduced_version_runs_to_its_verdict(name: str) -> None:
    """What `./owt study NAME` shows without --full, its figures drawn."""
    result = run_study(name)
    assert "Reduced version" in result.page
    assert result.verdict.why in result.page
    for draw in result.figures.values():
        assert draw().axes
