"""The campaign's engine gives the numbers of the pipeline, with and without a shared model."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from owt_campaign.engine import (
    CLUSTERS,
    CaseOutcome,
    EnergyStatistics,
    cluster_basis,
    cluster_part,
    clusters,
    evaluate_case,
    join_cluster,
    model_key,
    prepare_model,
)
from owt_campaign.pipeline import CaseResult, run_case
from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError

#: Pieces of other lengths are other products of matrices, which round otherwise: 1e-16 of the largest term of
#: sums over modes, which cancel to a few parts in a thousand; the fifth power of a range takes it five times.
STRESS, DAMAGE, ENERGY = 1e-10, 1e-9, 1e-10


def a_case(**changes: Any) -> CaseConfig:
    data: dict[str, Any] = {
        "sea_state": {"hs_m": 6.0, "tp_s": 9.45, "seed": 3, "direction_deg": 200.0},
        "structure": {"model": "oc4-thesis", "reduction": "CB10M10"},
        "time": {"n": 400},
    }
    for name, value in changes.items():
        data[name] = {**data.get(name, {}), **value} if isinstance(value, dict) else value
    return parse_case(data)


def energies(result: CaseResult) -> EnergyStatistics:
    report = result.report
    potential = np.column_stack([report.potential, report.potential_substructure])
    kinetic = np.column_stack([report.kinetic, report.kinetic_substructure])
    return EnergyStatistics(
        ("total", *report.reduced.substructure_name),
        potential.mean(axis=0), potential.std(axis=0), kinetic.mean(axis=0), kinetic.std(axis=0),
    )  # fmt: skip


def check(found: CaseOutcome, wanted: CaseResult) -> None:
    ours, theirs = found.fatigue, wanted.report.fatigue
    np.testing.assert_array_equal(ours.cycles, theirs.cycles)
    np.testing.assert_array_equal(ours.histogram, theirs.histogram)
    np.testing.assert_array_equal(ours.von_mises_cycles, theirs.von_mises_cycles)
    assert ours.samples == theirs.samples
    assert theirs.damage.max() > 0.0
    np.testing.assert_allclose(ours.damage, theirs.damage, rtol=DAMAGE, atol=DAMAGE * theirs.damage.max())
    for name in ("max_range", "total_stress", "von_mises_max_range"):
        ours_, theirs_ = getattr(ours, name), getattr(theirs, name)
        np.testing.assert_allclose(ours_, theirs_, rtol=STRESS, atol=STRESS * theirs_.max())
    energy, reference = found.energy, energies(wanted)
    assert energy.part == reference.part
    for name in ("potential_mean", "potential_std", "kinetic_mean", "kinetic_std"):
        np.testing.assert_allclose(getattr(energy, name), getattr(reference, name), rtol=ENERGY)


@pytest.mark.parametrize(
    ("order", "reduction"), [(1, "CB10M10"), (2, "CB10M10"), (1, "CB00"), (2, "CB10+SIM"), (2, "full")]
)
def test_same_numbers(order: int, reduction: str) -> None:
    case = a_case(wave={"order": order}, structure={"reduction": reduction})
    wanted = run_case(case)
    check(evaluate_case(case), wanted)
    if reduction == "CB00":  # the check would notice another reduction
        with pytest.raises(AssertionError):
            check(evaluate_case(a_case(wave={"order": order})), wanted)
    if reduction == "CB10M10":  # and another sea
        with pytest.raises(AssertionError):
            check(evaluate_case(a_case(wave={"order": order}, sea_state={"seed": 4})), wanted)


def test_same_numbers_with_all_options() -> None:
    case = a_case(
        morison={"points": "gauss", "hydrodynamic_damping": True, "axial_cd": 0.1},
        structure={"damping": {"tower_top": [6.1e4, 6.1e4, 0.0, 0.0, 0.0, 0.0]}, "ramp_s": 10.0},
        wind={"thrust": {"speed_m_s": 12.0}},
        fatigue={"scf": 1.5},
        stream={"block": 7},
    )
    check(evaluate_case(case), run_case(case))


def test_record_of_several_windows() -> None:
    case = a_case(wave={"window": 200})
    check(evaluate_case(case), run_case(case))


def test_shared_model_changes_nothing() -> None:
    model = prepare_model(a_case())
    for changes in ({"sea_state": {"seed": 5}}, {"wave": {"order": 1}}, {"time": {"n": 300}}):
        case = a_case(**changes)
        alone, shared = evaluate_case(case), evaluate_case(case, model)
        np.testing.assert_array_equal(shared.fatigue.damage, alone.fatigue.damage)
        np.testing.assert_array_equal(shared.energy.kinetic_std, alone.energy.kinetic_std)


def test_model_of_another_structure_is_refused() -> None:
    model = prepare_model(a_case())
    for changes in (
        {"structure": {"reduction": "CB00"}}, {"water_depth_m": 49.0}, {"morison": {"cd": 0.7}},
        {"time": {"dt_s": 0.2}}, {"fatigue": {"scf": 2.0}},
    ):  # fmt: skip
        other = a_case(**changes)
        assert model_key(other) != model.key
        with pytest.raises(InputError, match="prepared for a case that differs"):
            evaluate_case(other, model)


def test_cluster_of_one_case_is_its_own_basis() -> None:
    case = a_case()
    model = prepare_model(case)
    alone = evaluate_case(case, model)
    shared = model.with_basis(case, cluster_basis([case], model))
    assert shared.response is not None
    together = evaluate_case(case, shared)
    # The scatter matrix knows the squares of singular values only: 1e-8 of the largest.
    np.testing.assert_allclose(together.fatigue.total_stress, alone.fatigue.total_stress, rtol=1e-6)
    np.testing.assert_allclose(together.energy.potential_std, alone.energy.potential_std, rtol=1e-6)


def test_cluster_serves_its_cases_better_than_a_stranger() -> None:
    cases = [a_case(sea_state={"direction_deg": d}) for d in (200.0, 270.0)]
    model = prepare_model(cases[0])
    full = evaluate_case(a_case(sea_state={"direction_deg": 270.0}, structure={"reduction": "full"}))

    def error(basis_of: list[CaseConfig]) -> float:
        shared = model.with_basis(cases[0], cluster_basis(basis_of, model))
        found = evaluate_case(cases[1], shared).energy.potential_std[1]
        return abs(float(found / full.energy.potential_std[1]) - 1.0)

    assert error(cases) < 0.5 * error(cases[:1])
    parts = [cluster_part(case) for case in cases]  # made apart, they are the same to the bit
    np.testing.assert_array_equal(join_cluster(parts).vectors, cluster_basis(cases, model).vectors)
    with pytest.raises(InputError, match="several structures"):
        join_cluster([parts[0], replace(parts[1], model_hash="other")])


def test_clusters_of_a_table() -> None:
    table = [
        a_case(sea_state={"hs_m": hs, "direction_deg": d}) for hs in (2.0, 4.0) for d in (0.0, 30.0, 60.0)
    ]
    assert CLUSTERS == ("spec", "dir", "hs", "tot")
    assert list(clusters(table, "dir").values()) == [[0, 3], [1, 4], [2, 5]]
    assert list(clusters(table, "hs").values()) == [[0, 1, 2], [3, 4, 5]]
    assert list(clusters(table, "tot").values()) == [[0, 1, 2, 3, 4, 5]]
    with pytest.raises(InputError, match="cluster"):
        clusters(table, "all")
    with pytest.raises(InputError, match="one or more"):
        cluster_basis([])


def test_kept_series() -> None:
    case = a_case(time={"n": 300})
    wanted = run_case(case, keep_series=True)
    end = wanted.mesh.end_name[5]
    names = ("elevation", "elevation_first", "tower_top", "coordinate", "potential", "kinetic_mode")
    kept = evaluate_case(case, keep=(*names, f"stress {end}", "force")).series
    series = wanted.series
    top = wanted.report.reduced.tower_top_coordinate
    np.testing.assert_array_equal(kept["elevation"], series["elevation.total"])
    np.testing.assert_array_equal(kept["elevation_first"], series["elevation.first_order"])
    np.testing.assert_allclose(kept["force"], wanted.report.wave_force, rtol=1e-9)
    coordinate = series["modal.displacement"]
    scale = np.abs(coordinate).max(axis=0)
    np.testing.assert_allclose(kept["coordinate"] / scale, coordinate / scale, atol=1e-10)
    np.testing.assert_allclose(kept["tower_top"], coordinate[:, top : top + 3], rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(kept["potential"], series["energy.potential"], rtol=1e-10)
    assert kept["kinetic_mode"].shape == series["energy.kinetic_mode"].shape
    stress = kept[f"stress {end}"]
    for i, name in enumerate(("axial", "bending_y", "bending_z", "von_mises")):
        expected = series[f"stress.{name}"][:, 5]
        np.testing.assert_allclose(stress[:, i], expected, atol=1e-10 * np.abs(expected).max())
    with pytest.raises(InputError, match="no series"):
        evaluate_case(case, keep=["stress nowhere"])
