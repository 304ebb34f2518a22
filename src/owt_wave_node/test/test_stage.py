"""The wave stage: blocks of elevation and loads, and the basis of the loads."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError
from owt_wave_node.core.hydro_mesh import case_hydro_mesh
from owt_wave_node.core.loads import HELD_BYTES, jacket_loads, window_length
from owt_wave_node.core.stage import WaveStage, build_wave_stage


@pytest.fixture(scope="module")
def case():
    return parse_case(
        {
            "time": {"dt_s": 0.1, "n": 130},
            "gauges_m": [[0.0, 0.0], [10.0, -5.0]],
            "sea_state": {"hs_m": 4.0, "tp_s": 8.0},
        }
    )


@pytest.fixture(scope="module")
def stage(case, oc4) -> WaveStage:
    return build_wave_stage(case, oc4)


def test_blocks_tile_the_record(stage: WaveStage, case, oc4) -> None:
    loads = [stage.load_block(i) for i in range(stage.n_blocks)]
    elevations = [stage.elevation_block(i) for i in range(stage.n_blocks)]
    for blocks in (loads, elevations):
        assert [b.sequence for b in blocks] == [0, 1, 2]
        assert [b.start for b in blocks] == [0, 50, 100]
        assert [b.last for b in blocks] == [False, False, True]
        assert {b.dt for b in blocks} == {0.1}
    whole = jacket_loads(case, oc4).history
    nodal = np.concatenate([b.nodal for b in loads])
    assert np.array_equal(nodal, whole.nodal.transpose(2, 0, 1))
    fixed = np.concatenate([b.fixed_end for b in loads])
    assert fixed.shape == (130, whole.element.size, 12)
    assert not np.any(fixed[:, :, [0, 3, 6, 9]])  # no axial force, no torsion
    assert np.array_equal(fixed[:, :, [1, 5, 7, 11, 2, 4, 8, 10]], -whole.end_rows.transpose(2, 0, 1))
    assert set(loads[0].element.tolist()) <= set(oc4.end_element.tolist())
    assert loads[0].model_hash == oc4.structure.content_hash
    total = np.concatenate([b.total for b in elevations])
    assert total.shape == (130, 2)
    first = np.concatenate([b.first_order for b in elevations])
    assert np.abs(total - first).max() > 1e-3
    with pytest.raises(IndexError):
        stage.load_block(3)


def test_block_arrays_are_contiguous(stage: WaveStage) -> None:
    load, elevation = stage.load_block(2), stage.elevation_block(2)
    for array in (load.nodal, load.fixed_end, elevation.total, elevation.first_order):
        assert array.flags.c_contiguous
        assert array.shape[0] == 30


def test_fixed_end_forces_oppose_the_loads(stage: WaveStage, oc4) -> None:
    """Loads on a joint of one member are minus that member's fixed-end forces in global axes."""
    block = stage.load_block(0)
    hydro = stage.windows.hydro
    checked = 0
    for row, e in enumerate(block.element):
        member = oc4.element_member[e]
        for side, node in enumerate(oc4.element_node[e]):
            if oc4.member_element[member, side] != e or np.count_nonzero(oc4.member_node == node) != 1:
                continue
            axes = hydro.element_axes[int(np.flatnonzero(hydro.element == e)[0])]
            local = -block.fixed_end[:, row, 6 * side : 6 * side + 3] @ axes
            at = int(np.flatnonzero(block.node == node)[0])
            assert local == pytest.approx(block.nodal[:, at, :3], abs=1e-6)
            checked += 1
    assert checked >= 4  # the piles end at the sea bed


def test_basis_of_the_loads(stage: WaveStage) -> None:
    basis = stage.load_basis(5)
    assert basis.vectors.shape == (5, stage.windows.hydro.node.size, 6)
    flat = basis.vectors.reshape(5, -1)
    assert np.abs(flat @ flat.T - np.eye(5)).max() < 1e-9
    assert basis.snapshots == 130
    assert stage.load_basis(0).vectors.shape[0] == 0


def test_same_seed_same_numbers(case, oc4, stage: WaveStage) -> None:
    again = build_wave_stage(case, oc4)
    assert np.array_equal(again.history().nodal, stage.history().nodal)
    other = case.model_copy(update={"sea_state": case.sea_state.model_copy(update={"seed": 2})})
    one, another = stage.elevation_block(0), build_wave_stage(other, oc4).elevation_block(0)
    assert not np.allclose(another.total, one.total)


def cut(n: int = 520, **wave: object) -> CaseConfig:
    return parse_case({"time": {"dt_s": 0.1, "n": n}, "sea_state": {"hs_m": 4.0, "tp_s": 8.0}, "wave": wave})


@pytest.fixture(scope="module")
def windowed(oc4) -> WaveStage:
    return build_wave_stage(cut(window=130), oc4)


@pytest.fixture(scope="module")
def whole(oc4) -> WaveStage:
    return build_wave_stage(cut(), oc4)


def test_length_of_windows(oc4) -> None:
    def lengths(case: CaseConfig) -> tuple[int, int]:
        hydro = case_hydro_mesh(case, oc4, lowest=-3.0)
        length = window_length(case, hydro)
        held = 8 * length * (6 * hydro.node.size + 8 * np.intersect1d(oc4.end_element, hydro.element).size)
        return length, held

    assert lengths(cut(6000))[0] == 6000
    for n in (6001, 18000, 108_000, 1_000_000):
        length, held = lengths(cut(n))
        assert length % 50 == 0
        assert length <= 6000
        assert held <= HELD_BYTES
        assert held > 0.8 * HELD_BYTES or -(-n // length) <= 2
    assert lengths(cut(520, window=520))[0] == 520
    assert lengths(cut(520, window=130))[0] == 150  # in equal parts, rounded to the stream's blocks
    assert lengths(cut(520, window=64))[0] == 100


def test_windows_and_the_whole_record_agree(windowed: WaveStage, whole: WaveStage) -> None:
    assert len(windowed.windows) == 4
    assert len(whole.windows) == 1
    assert windowed.error_estimate < 1e-8
    assert whole.error_estimate == 0.0
    scale = np.abs(whole.history().nodal).max()
    assert windowed.n_blocks == whole.n_blocks == 11
    for i in range(11):
        one, other = windowed.load_block(i), whole.load_block(i)
        assert (one.start, one.last, one.sequence) == (other.start, other.last, other.sequence)
        assert np.abs(one.nodal - other.nodal).max() < 1e-8 * scale
        assert np.abs(one.fixed_end - other.fixed_end).max() < 1e-8 * np.abs(whole.history().end_rows).max()
        assert np.abs(windowed.elevation_block(i).total - whole.elevation_block(i).total).max() < 1e-7
        # Negative control: the next block is another one.
        if i < 9:
            assert np.abs(one.nodal - whole.load_block(i + 1).nodal).max() > 1e-3 * scale


def test_blocks_in_any_order_are_the_same_bits(windowed: WaveStage, oc4) -> None:
    again = build_wave_stage(cut(window=130), oc4)
    again.load_basis(3)
    for i in (10, 0, 5, 4, 5):
        assert np.array_equal(again.load_block(i).nodal, windowed.load_block(i).nodal)
        assert np.array_equal(again.elevation_block(i).total, windowed.elevation_block(i).total)


def test_basis_of_windows_is_that_of_the_record(windowed: WaveStage, whole: WaveStage) -> None:
    one, other = windowed.load_basis(4), whole.load_basis(4)
    assert one.snapshots == other.snapshots == 520
    assert np.abs(one.singular_values / other.singular_values - 1.0).max() < 1e-7
    assert (
        np.abs(one.vectors - other.vectors).max() < 1e-6
    )  # shapes are apart by a tenth, loads agree to 1e-8
    assert np.abs(one.mean - other.mean).max() < 1e-8 * np.abs(whole.history().nodal).max()


def test_the_surface_of_all_windows_is_looked_at(oc4) -> None:
    """A crest in the last window is refused before the first block."""
    period = 9.0
    listed = {"omega_rad_s": [2 * np.pi / period, 1.01 * 2 * np.pi / period], "amplitude_m": [9.0, 9.0]}
    late = {"components": listed | {"phase_rad": [0.0, np.pi]}, "wave": {"order": 1, "window": 100}}
    short = parse_case(late | {"time": {"dt_s": 0.5, "n": 60}})  # waves cancel at first
    assert len(build_wave_stage(short, oc4).windows) == 1
    with pytest.raises(InputError, match="raises the surface"):
        build_wave_stage(parse_case(late | {"time": {"dt_s": 0.5, "n": 900}}), oc4)
