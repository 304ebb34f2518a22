"""What the field must be, whatever its numbers: derivatives, continuity, routes, grids, headings."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_wave_node.core.compressed import CompressedField
from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.field import GridField
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import Waves, build_sea_state, waves
from proofs import crossing, directional

X, Z = np.array([0.0, 3.7, -8.0]), np.array([-1.0, -27.0, 1.5])
PLACE = np.column_stack([X, np.zeros(3), Z])
DT, N = 0.1, 6000


@pytest.fixture(scope="module")
def sea(recorded) -> Waves:
    return waves(build_sea_state(recorded("A")))


@pytest.fixture(scope="module")
def field(sea: Waves) -> GridField:
    made = component_field(sea)
    assert isinstance(made, GridField)
    return made


def at(x, z) -> np.ndarray:
    """Places in wave axes from distances along the waves and levels."""
    x, z = np.broadcast_arrays(x, z)
    return np.column_stack([x, np.zeros(len(x)), z]).astype(float)


def difference(a, b) -> float:
    return float(np.abs(a - b).max() / np.abs(a).max())


def test_complex_profiles_turn_the_phase(sea: Waves, field: GridField) -> None:
    """A factor exp(-i k dx) moves the point by dx, in both routes."""
    dx = 3.0
    ones = np.ones((3, sea.wavenumber.size))
    moved = PLACE + np.array([dx, 0.0, 0.0])
    for route in (field, DirectField(sea)):
        turn = np.exp(-1j * dx * route.wavenumber) * ones
        got, expected = route.shaped(PLACE, turn, 2.0 * turn), route.shaped(moved, ones, 2.0 * ones)
        assert difference(expected, got) < 1e-11
        assert difference(expected, route.shaped(PLACE, turn.conj(), 2.0 * turn.conj())) > 1e-2


def test_gaps_between_components_change_nothing(recorded, reference, listed) -> None:
    """A sea with gaps takes the scattered sums; zero amplitudes in the gaps must not matter."""
    d = reference["A"]
    keep = np.arange(len(d["a"])) % 3 != 1
    gaps = waves(build_sea_state(listed(d["omega"][keep], d["a"][keep], d["phi"][keep])))
    scattered = component_field(gaps)
    assert isinstance(scattered, GridField)
    assert not scattered.dense
    filled = Waves(
        d["omega"],
        d["k"].copy(),
        0.0 * d["k"],
        d["a"] * keep * np.exp(-1j * d["phi"]),
        50.0,
        9.81,
        2,
        "taylor",
        DT,
        N,
    )
    dense = component_field(filled)
    assert isinstance(dense, GridField)
    assert dense.dense
    assert difference(dense.second(PLACE), scattered.second(PLACE)) < 1e-12
    assert difference(dense.elevation(PLACE)[1], scattered.elevation(PLACE)[1]) < 1e-12


def test_a_short_window_of_a_long_record(recorded) -> None:
    """Components of 600 s asked for 30 s: the grid is extended and the window is that of the record."""
    points = [[1.0, 0.0, -3.0], [0.0, 0.0, 1.0]]
    long = wave_kinematics(recorded("A", points_m=points))
    short = wave_kinematics(recorded("A", points_m=points, time={"dt_s": 0.1, "n": 300}))
    for name in ("eta1", "eta2", "velocity", "acceleration", "velocity2", "acceleration2"):
        assert difference(getattr(long, name)[:300], getattr(short, name)) < 1e-12, name
    assert np.array_equal(short.wet, long.wet[:300])


def test_grid_is_the_smallest() -> None:
    base = 2.0 * np.pi / 60.0
    cases = {1: [1.0, 5.0], 2: [1.5, 5.0], 20: [1.05, 3.0], 6: [1.5, 7.0 / 3.0]}
    for periods, multiples in cases.items():
        grid = frequency_grid(base * np.array(multiples), dt=0.1, n=600, order=2)
        assert grid is not None
        assert grid.length == periods * 600
        assert grid.bins.tolist() == pytest.approx([m * periods for m in multiples])
    assert frequency_grid(base * np.array([1.0, np.pi]), dt=0.1, n=600, order=2) is None
    # Half the samples per wave that the second order needs: twice the length, subsampled.
    grid = frequency_grid(base * np.array([150.0]), dt=0.1, n=600, order=2)
    assert grid is not None
    assert (grid.oversampling, grid.length) == (2, 1200)


def test_components_off_the_grid(reference, listed) -> None:
    """Frequencies off any grid join the gridded answer continuously, spread on a grid or summed directly."""
    d = reference["A"]
    keep = slice(40, 80)
    points = [[2.0, 0.0, -4.0]]
    on = wave_kinematics(listed(d["omega"][keep], d["a"][keep], d["phi"][keep], points_m=points))
    shift = 1.0 + 1e-9 * np.sqrt(np.arange(40) + 2.0)
    case = listed(d["omega"][keep] * shift, d["a"][keep], d["phi"][keep], points_m=points)
    sea = waves(build_sea_state(case))
    assert isinstance(component_field(sea), CompressedField)
    assert isinstance(component_field(sea, "direct"), DirectField)
    off = wave_kinematics(case)
    summed = wave_kinematics(
        case.model_copy(update={"wave": case.wave.model_copy(update={"route": "direct"})})
    )
    for name in ("eta1", "eta2", "velocity2", "acceleration2"):
        assert difference(getattr(on, name), getattr(off, name)) < 2e-5, name
        assert difference(getattr(summed, name), getattr(off, name)) < 1e-10, name
        assert difference(getattr(on, name), getattr(off, name)) > 1e-10, name  # the shift is seen


def test_order_one_has_no_second_order(recorded) -> None:
    k = wave_kinematics(recorded("A", wave={"order": 1, "stretching": "taylor"}, points_m=[[0.0, 0.0, -9.0]]))
    assert not np.any(k.eta2)
    assert not np.any(k.velocity2)
    assert not np.any(k.acceleration2)
    assert k.wet.all()


def test_flat_sea(listed) -> None:
    k = wave_kinematics(listed([0.5], [0.0], [0.0], points_m=[[0.0, 0.0, -1.0], [0.0, 0.0, 0.5]]))
    assert not np.any(k.velocity)
    assert k.wet[:, 0].all()
    assert not k.wet[:, 1].any()


def test_deep_water_does_not_overflow(listed) -> None:
    """k d up to 4000: the scaled factors of the single summation agree with the direct sum."""
    omega = 2.0 * np.pi / 60.0 * np.arange(8, 61)
    case = listed(
        omega, np.full(53, 0.02), np.sqrt(np.arange(53.0)), water_depth_m=1000.0, time={"dt_s": 0.1, "n": 600}
    )
    sea = waves(build_sea_state(case))
    field = component_field(sea)
    assert isinstance(field, GridField)
    assert len(field._blocks) > 10
    x, z = np.array([0.0, 5.0, 3.0]), np.array([-1.0, -60.0, -400.0])
    second = field.second(at(x, z))
    assert np.isfinite(field.second(at(x, z - 590.0))).all()
    direct = DirectField(sea).second(at(x, z))
    for p in range(3):
        assert difference(direct[p], second[p]) < 1e-9


def test_points_are_needed(recorded) -> None:
    with pytest.raises(InputError, match=r"points_m = None: is missing"):
        wave_kinematics(recorded("A"))


def test_profile_without_end_is_refused(recorded) -> None:
    case = recorded("C", points_m=[[0.0, 0.0, 80.0]], wave={"order": 2, "stretching": "none"})
    with pytest.raises(InputError, match=r"wave\.stretching = 'none'"):
        wave_kinematics(case)


def test_repeated_frequencies_between_gaps_are_not_consecutive() -> None:
    """As many components as there are bins from the first to the last, some bins twice and some left out."""
    multiple = [10, 10, 14, 14, 15, 18, 18, 19, 19, 19, 20]
    waves = crossing.sea(multiple, np.linspace(-140.0, 130.0, len(multiple)).tolist(), depth=6.0)
    assert multiple[-1] - multiple[0] == len(multiple) - 1
    assert directional.different(component_field(waves), crossing.BothSums(waves)) < 1e-11


@pytest.mark.parametrize(("count", "n", "depth"), [(3, 164, 50.0), (2, 145, 400.0), (30, 400, 400.0)])
def test_any_components_have_a_route(count: int, n: int, depth: float, listed) -> None:
    """Components off any grid, second order that all but vanishes at depth: refused only where asked for."""
    omega = 1.7 + np.sqrt(2.0) * 0.05 * np.arange(count) ** 0.9
    case = listed(
        omega,
        np.full(count, 0.1),
        np.arange(count) * 1.3,
        water_depth_m=depth,
        time={"dt_s": 0.1, "n": n},
        points_m=[[0.0, 0.0, -3.0], [400.0, 0.0, -depth]],
    )
    got = wave_kinematics(case)
    direct = wave_kinematics(
        case.model_copy(update={"wave": case.wave.model_copy(update={"route": "direct"})})
    )
    for name in ("eta1", "eta2", "velocity", "acceleration", "velocity2", "acceleration2"):
        assert difference(getattr(direct, name), getattr(got, name)) < 1e-10, name


def test_many_short_crested_components_off_any_grid() -> None:
    """So many pairs that their frequencies are spread over a grid of their own."""
    multiple = 5.0 + 0.37 * np.sqrt(2.0) * np.arange(40)
    waves = crossing.sea(multiple.tolist(), np.linspace(-140.0, 130.0, 40).tolist(), depth=20.0)
    assert directional.different(component_field(waves), crossing.BothSums(waves)) < 1e-10
