"""Studies that compare wave models and reductions: a row of each computed again, and their parts."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from owt_campaign.studies.basis_errors import basis_errors
from owt_campaign.studies.beyond import load_factor
from owt_campaign.studies.cases import LINEAR, SECOND_ORDER, SEEDS
from owt_campaign.studies.modal_contribution import modal_contribution
from owt_campaign.studies.reduction_runs import table_errors
from owt_campaign.studies.registry import run_study
from owt_campaign.studies.sampling import heaviest, sampling, seed_scatter, table_variation, variation_of
from owt_campaign.studies.sea_table import Cell, cell_case, few_cells, load_case_table, occurrence
from owt_campaign.studies.store import Store
from owt_campaign.studies.stress_runs import Sea, StressRecord, StressRuns
from owt_campaign.studies.wave_comparison import energy_peaks
from owt_campaign.studies.wave_totals import TableRuns, run_table
from owt_model.config import CaseConfig
from owt_postproc.core.sn import sn_curve
from owt_postproc.core.stage import BINS_PER_DECADE, LOWEST_PA
from owt_wave_node.core.sea import build_sea_state

STUDY = Path(__file__).parents[1] / "docs" / "study"
NAMES = ("wave-comparison", "sensitivity", "reduction", "modal-contribution", "beyond")
HIGHEST = load_case_table()[-1]
#: Round-off of another machine's libraries in sums over a record.
ROUND_OFF = 1e-4


def silent(done: float, total: float) -> None:
    """Progress that nobody watches."""


def committed(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((STUDY / f"{name}.json").read_text())
    return found


@pytest.fixture(scope="module")
def runs() -> StressRuns:
    return StressRuns()


def kinetic(runs: StressRuns, wave: str, structure: str = "reference") -> np.ndarray:
    return runs.series(Sea(HIGHEST, 1, wave), ["kinetic"], structure)["kinetic"]


def test_wave_comparison(runs: StressRuns) -> None:
    """A sea state of the table, and the kinetic energy of the highest one, seed 1."""
    kept = committed("wave-comparison")
    cell = few_cells()[-1]
    row = next(r for r in kept["cells"] if r[:3] == [cell.hs_m, cell.from_deg, cell.tp_s])
    for wave, value in zip((LINEAR, SECOND_ORDER), row[3:], strict=True):
        record = runs.records(Sea(cell, 1, wave))["reference"]
        assert record.total_stress.mean() == pytest.approx(value, rel=ROUND_OFF)
    found = energy_peaks(kinetic(runs, LINEAR), kinetic(runs, SECOND_ORDER)).factor[10.0]
    factors = kept["kinetic_factor"][f"{LINEAR}, 4 omega_p"]["20 s"]
    assert found == pytest.approx(factors[0], rel=ROUND_OFF)
    assert found != pytest.approx(factors[1], rel=ROUND_OFF)  # negative control: another seed


def test_sensitivity(runs: StressRuns) -> None:
    kept = committed("sensitivity")["mean_kinetic_j"]
    found = kinetic(runs, SECOND_ORDER, "damping").mean()
    assert found == pytest.approx(kept["damping"][0], rel=ROUND_OFF)
    assert found != pytest.approx(kept["reference"][0], rel=0.1)


def test_reduction() -> None:
    """Errors of the models of a sea state's own loads."""
    kept = committed("reduction")["errors_percent"]["seed 1"]
    cell = few_cells()[-1]
    place = kept["cell"].index([cell.hs_m, cell.from_deg, cell.tp_s])
    found = table_errors([cell], {}, samples=6000, store=Store(), progress=silent)[1][cell]
    for name in ("CB00", "CB20", "CB10M10", "M20"):
        # An error of 1e-6 is a difference of energies known to 1e-11.
        assert 100.0 * found.mean[name] == pytest.approx(kept[name]["mean"][place], rel=2e-2)
        assert 100.0 * found.std[name] == pytest.approx(kept[name]["std"][place], rel=5e-2)
    # Of one sea state alone all clusters are its own loads.
    assert found.mean["M20 dir"] == pytest.approx(found.mean["M20"], rel=2e-2)
    assert found.mean["CB20"] > 10.0 * found.mean["M20"]


def test_modal_contribution(monkeypatch: pytest.MonkeyPatch) -> None:
    from owt_campaign.studies import modal_contribution as module

    monkeypatch.setattr(module, "SEAS", {"low": module.SEAS["low"]})
    monkeypatch.setattr(module, "range", lambda *ends: [1], raising=False)
    found = modal_contribution(full=True, progress=silent)["low"][0]
    kept = committed("modal-contribution")
    assert found.pov["as printed"][0] == pytest.approx(kept["first_vector"]["low"][0], rel=1e-4)
    np.testing.assert_allclose(found.mode, kept["mode_share"]["low"], atol=0.02)  # the mean of ten seeds
    assert found.mode.sum() == pytest.approx(1.0)


def test_beyond(runs: StressRuns) -> None:
    """Damage of the worst hot spot in a sea state."""
    kept = committed("beyond")
    cell = few_cells()[-1]
    spot = runs.model("reference").fatigue.hot_spots.name.index(kept["worst_hot_spot"])
    for wave in (LINEAR, SECOND_ORDER):
        value = next(
            r[3] for r in kept["cell_damage"][wave] if r[:3] == [cell.hs_m, cell.from_deg, cell.tp_s]
        )
        damage = runs.records(Sea(cell, 1, wave))["reference"].damage
        assert damage[spot] == pytest.approx(value, rel=ROUND_OFF)
    low = runs.records(Sea(few_cells()[0], 1))["reference"].damage[spot]
    assert low != pytest.approx(value, rel=0.1)  # negative control: another sea state


def test_errors_at_single_places(runs: StressRuns) -> None:
    """What the energy hides: one of the sea states of the page, against the unreduced model."""
    kept = committed("beyond")["basis_errors"]
    found = basis_errors(runs, [HIGHEST], silent, ("CB10M10", "CB20M40"))
    for name, errors in found.items():
        for key, value in vars(errors).items():
            assert value <= kept[name][key] * (1.0 + 1e-2), (name, key)  # the page has the largest of four
    small, large = found["CB10M10"], found["CB20M40"]
    assert large.stress < 0.5 * small.stress
    assert small.stress > 10.0 * small.energy
    assert max(value / kept["CB10M10"][key] for key, value in vars(small).items()) > 0.99


def test_runs_are_the_same_whoever_computes_them() -> None:
    """Bit by bit, and in the order of the plan."""
    plan = [(seed, SECOND_ORDER, few_cells()[:2], ("reference", "damping")) for seed in (1, 2)]
    here, there = (run_table(200, plan, silent, workers=workers) for workers in (0, 2))
    assert list(here) == list(there) == ["reference", "damping"]
    for structure, runs in here.items():
        assert list(runs.records) == list(there[structure].records)
        for key, cells in runs.records.items():
            others = there[structure].records[key]
            assert list(cells) == list(others)
            for cell, record in cells.items():
                for name, value in vars(record).items():
                    np.testing.assert_array_equal(value, getattr(others[cell], name))
    one, two = (next(iter(here["reference"].records[seed, SECOND_ORDER].values())) for seed in (1, 2))
    assert (one.total_stress != two.total_stress).all()  # negative control: another seed


@pytest.mark.parametrize("name", NAMES)
def test_reduced_version(name: str) -> None:
    """Runs, draws its figures, and says that it is reduced."""
    found = run_study(name)
    assert "Reduced version" in found.page
    assert found.rows
    for key, draw in found.figures.items():
        assert found.picture(key) in found.page
        assert draw().axes


def test_occurrences_are_probabilities() -> None:
    cells = load_case_table()
    for weights in ("assumed", "published", "alike"):
        assert occurrence(cells, weights).sum() == pytest.approx(1.0)
    published = occurrence(cells, "published")
    assert {cell.from_deg for cell, p in zip(cells, published, strict=True) if p > 0.0} == {330.0}


def test_load_factor_is_a_root_of_the_damage_ratio() -> None:
    """Of one slope the factor is ratio^(1/m), whatever the ranges; with two it lies between."""
    rng = np.random.default_rng(1)
    half_cycles = np.zeros(102)
    half_cycles[60:90] = rng.integers(1, 1000, 30)
    curve = sn_curve("T_cathodic_protection").coefficients
    single = np.array([curve[0], curve[3], curve[4], curve[3], curve[4]])
    assert load_factor(half_cycles, single, 1.3) == pytest.approx(1.3 ** (1.0 / curve[4]), rel=1e-6)
    both = load_factor(half_cycles, curve, 1.3)
    assert 1.3 ** (1.0 / curve[4]) <= both <= 1.3 ** (1.0 / curve[2])
    # Negative control: the factor is one on stress, not on damage.
    assert load_factor(half_cycles, single, 1.3) != pytest.approx(1.3, rel=0.1)
    assert curve[0] < LOWEST_PA * 10.0 ** (88.5 / BINS_PER_DECADE)  # both slopes are met


def cells_with_damage(draw: Callable[[int], np.ndarray]) -> dict[Cell, np.ndarray]:
    return {cell: draw(i) for i, cell in enumerate(load_case_table())}


def test_seed_scatter_finds_the_scatter_it_is_given() -> None:
    rng, n = np.random.default_rng(2), 3
    found = seed_scatter(cells_with_damage(lambda i: rng.normal(1.0, 0.2, n)))
    assert found.seeds == n
    assert found.pooled == pytest.approx(0.2, rel=0.15)
    share = occurrence(load_case_table())
    expected = 1.96 * 0.2 * np.sqrt((share**2).sum() / n)
    assert found.half_width == pytest.approx(expected, rel=0.25)
    # Negative control: twice the scatter is not found to be the same.
    other = seed_scatter(cells_with_damage(lambda i: rng.normal(1.0, 0.4, n)))
    assert other.pooled > 1.5 * found.pooled


def invented_runs(damage: Callable[[int, Cell], list[float]]) -> TableRuns:
    """Runs of second order of which only the damage of the hot spots is filled."""

    def record(values: list[float]) -> StressRecord:
        return StressRecord(
            np.zeros(1), np.zeros((1, 1)), np.zeros(5), np.array(values), np.zeros((1, 1), dtype=int)
        )

    cells = load_case_table()
    return TableRuns(
        {(seed, SECOND_ORDER): {cell: record(damage(seed, cell)) for cell in cells} for seed in SEEDS}
    )


def test_sea_states_drawn_in_proportion_to_the_damage_need_one() -> None:
    """Weights that are the damage give it with any draw; others need more."""
    runs = invented_runs(lambda seed, cell: [cell.hs_m**3, cell.tp_s**9, seed * cell.hs_m**3])
    needed = sampling(runs, 0, np.array([0, 1, 2]))
    cubic = needed["probability x Hs^3"]
    assert (cubic.draws, cubic.largest, cubic.seeds) == (pytest.approx(0.0, abs=1e-6), 1, (1, 1))
    assert cubic.joints[0] == 1  # of three joints two grow as the weights do
    assert cubic.joints[1] > 20  # the other does not
    assert needed["probability x regression"].draws == pytest.approx(0.0, abs=1e-6)
    assert needed["probability"].draws > 100.0


def test_what_all_sea_states_share_does_not_average_out() -> None:
    """Independent scatter of 20 % all but vanishes in the table's damage, shared scatter stays."""
    rng = np.random.default_rng(3)
    spots = 200
    common = {seed: rng.normal(1.0, 0.2, spots) for seed in SEEDS}
    own = invented_runs(lambda seed, cell: rng.normal(1.0, 0.2, spots).tolist())
    shared = invented_runs(lambda seed, cell: common[seed].tolist())
    expected = 0.2 * np.sqrt((occurrence(load_case_table()) ** 2).sum())

    def seen(runs: TableRuns) -> float:
        return float(np.sqrt(np.mean([variation_of(runs, spot) ** 2 for spot in range(spots)])))

    assert seen(own) == pytest.approx(expected, rel=0.2)
    assert table_variation(own).mean() == pytest.approx(expected, rel=0.1)
    assert seen(shared) == pytest.approx(0.2, rel=0.2)
    assert table_variation(shared).mean() == pytest.approx(
        expected, rel=0.2
    )  # which takes them for independent


def test_the_heaviest_sea_states() -> None:
    damage = {cell: cell.hs_m**4 for cell in load_case_table()}
    share = dict(zip(damage, occurrence(list(damage)), strict=True))
    parts = [share[cell] * damage[cell] for cell in heaviest(damage, 10)]
    assert parts == sorted((share[cell] * damage[cell] for cell in damage), reverse=True)[:10]


def test_sea_states_have_phases_of_their_own() -> None:
    """Elevations of neighbouring sea states are alike with shared phases only."""

    def alike(*, shared_phases: bool) -> float:
        one, two = (
            surface(cell_case(cell, samples=3000, shared_phases=shared_phases))
            for cell in load_case_table()
            if cell.from_deg == 330.0 and 4.0 < cell.hs_m < 5.0
        )
        return float(np.corrcoef(one, two)[0, 1])

    assert alike(shared_phases=True) > 0.5
    assert abs(alike(shared_phases=False)) < 0.2


def surface(case: CaseConfig) -> np.ndarray:
    """First-order elevation at the origin."""
    sea, t = build_sea_state(case), 0.1 * np.arange(case.time.n)
    return np.asarray(np.cos(np.outer(t, sea.omega_rad_s) - sea.phase_rad) @ sea.amplitude_m)


def test_energy_factor_is_that_of_the_window() -> None:
    t = 0.1 * np.arange(6000)
    linear = np.exp(-(((t - 300.0) / 5.0) ** 2))
    found = energy_peaks(linear, np.where(np.abs(t - 300.0) < 30.0, 2.0, 7.0) * linear)
    assert found.factor[10.0] == pytest.approx(2.0)
    assert found.time_s == pytest.approx(300.0)
    assert energy_peaks(linear, linear[::-1] * 0.0 + 1.0).factor[10.0] != pytest.approx(2.0)


def test_store_keeps_runs_and_trusts_no_damaged_one(tmp_path: Path) -> None:
    store, calls = Store(tmp_path), []

    def compute() -> dict[str, np.ndarray]:
        calls.append(1)
        return {"value": np.arange(3.0)}

    for _ in range(2):
        np.testing.assert_array_equal(store.run(["a", 1], compute)["value"], np.arange(3.0))
    assert len(calls) == 1
    store.run(["a", 2], compute)
    assert len(calls) == 2
    for path in tmp_path.iterdir():
        path.write_bytes(path.read_bytes()[:40])
    store.run(["a", 1], compute)
    assert len(calls) == 3
