"""Short-crested seas: cases with listed directions, stretching, limits, blocks of coefficients."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from owt_wave_node.core import directional, directional_sea, lines
from owt_wave_node.core.directional import DirectionalField
from owt_wave_node.core.field import Field, Prepared
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.loads import MARGIN, SAFETY, surface_range
from owt_wave_node.core.profile import first_order_profile
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import Frame, build_sea_state, waves
from owt_wave_node.core.wheeler import WheelerField
from owt_wave_node.core.window import Windowed
from owt_wave_node.kernels import directional as kernel
from proofs.crossing import ANGLE, MULTIPLE, BothSums, crossing, off_grid
from proofs.directional import PLACE

POINTS = [[3.0, -7.0, -2.0], [-8.0, 4.0, -27.0], [0.0, 0.0, 2.5], [2.0, 2.0, -50.0]]
SEAS = pytest.mark.parametrize("sea", [crossing(), off_grid()], ids=["grid", "off grid"])


def difference(got: np.ndarray, expected: np.ndarray) -> float:
    return float(np.abs(got - expected).max() / np.abs(expected).max())


@SEAS
def test_case_with_directions(sea, listed) -> None:
    """The whole path from a case against both sums in the axes of the case itself."""
    direction = [(a + 210.0) % 360.0 for a in ANGLE]
    case = listed(
        sea.omega,
        np.abs(sea.amplitude),
        -np.angle(sea.amplitude),
        direction=direction,
        time={"dt_s": sea.dt, "n": sea.n},
        points_m=POINTS,
    )
    got = wave_kinematics(case)
    sums = BothSums(replace(sea, angle=np.deg2rad(direction)))
    place = np.array(POINTS)
    first, second = sums.first(place), sums.second(place)
    eta1, eta2 = sums.elevation(place)
    assert difference(got.eta1.T, eta1) < 1e-11
    assert difference(got.eta2.T, eta2) < 1e-11
    for name, part in (("velocity", slice(0, 3)), ("acceleration", slice(3, 6))):
        assert difference(getattr(got, name).transpose(1, 2, 0), (first + second)[:, part]) < 1e-11
        assert difference(getattr(got, f"{name}2").transpose(1, 2, 0), second[:, part]) < 1e-11
    assert np.array_equal(got.wet, place[:, 2] <= got.eta1 + got.eta2)
    assert np.ptp(np.count_nonzero(got.wet, axis=0)) > 0
    wrong = BothSums(replace(sea, angle=np.deg2rad(direction)), coming_from=True)
    assert (
        difference(got.velocity.transpose(1, 2, 0), (wrong.first(place) + wrong.second(place))[:, :3]) > 0.1
    )


def test_components_of_one_frequency_and_direction_may_be_listed_twice(listed) -> None:
    once = listed([0.7, 0.9], [1.0, 0.5], [0.1, 0.2], direction=[10.0, 70.0], points_m=POINTS)
    split = listed(
        [0.9, 0.7, 0.7], [0.5, 0.25, 0.75], [0.2, 0.1, 0.1], direction=[70.0, -350.0, 10.0], points_m=POINTS
    )
    one, other = wave_kinematics(once), wave_kinematics(split)
    assert difference(one.velocity, other.velocity) < 1e-12
    assert difference(one.eta2, other.eta2) < 1e-12


@SEAS
def test_two_components_in_one_place_add(sea) -> None:
    """A field does not ask that components differ: halves of one count as one, set-down included."""
    twice = {name: np.repeat(getattr(sea, name), 2) for name in ("omega", "wavenumber", "angle")}
    halves = replace(
        sea, **twice, amplitude=np.repeat(sea.amplitude, 2) * np.tile([0.3, 0.7], sea.omega.size)
    )
    one, other = DirectionalField(halves), DirectionalField(sea)
    # The set-down of a pair of equal components is in the pair's steady elevation.
    expected = other.elevation(PLACE)[1]
    assert difference(one.second(PLACE), other.second(PLACE)) < 1e-12
    assert difference(one.elevation(PLACE)[1], expected) < 1e-12


@SEAS
def test_stretching(sea) -> None:
    """Constant keeps the value of still water, none continues the profile, either order."""
    above, zero = np.array([[4.0, 1.0, 1.5]]), np.array([[4.0, 1.0, 0.0]])
    constant = component_field(replace(sea, stretching="constant"))
    for part in ("first", "second"):
        assert difference(getattr(constant, part)(above), getattr(constant, part)(zero)) < 1e-14
    none, taylor = (component_field(replace(sea, stretching=s)) for s in ("none", "taylor"))
    assert difference(none.first(above), taylor.first(above)) > 1e-3
    # The second-order potential at 1.5 m above still water: Taylor's series about it, by extrapolation in z.
    z = np.linspace(-2.0, 0.0, 17)
    below = none.second(np.column_stack([np.full_like(z, 4.0), np.ones_like(z), z]))
    fit = np.polynomial.chebyshev.chebfit(z + 1.0, below.reshape(z.size, -1), 10)
    expected = np.polynomial.chebyshev.chebval(1.3, fit).reshape(below.shape[1:])
    assert difference(none.second(np.array([[4.0, 1.0, 0.3]]))[0], expected) < 1e-6


def test_wheeler_stretches_all_directions() -> None:
    """The linear field at z' = (z - eta) / (1 + eta / d), sample by sample."""
    sea = replace(crossing(), order=1, stretching="wheeler", depth=50.0)
    field = component_field(sea)
    assert isinstance(field, WheelerField)
    place = np.array([[3.0, -7.0, -4.0]])
    eta = field.elevation(place)[0][0]
    level = np.minimum((place[0, 2] - eta) / (1.0 + eta / sea.depth), 0.0)
    linear = BothSums(sea)
    got = field.first(place)[0]
    for i in (0, 37, 181):
        if level[i] < 0.0:
            at = np.array([[3.0, -7.0, level[i]]])
            assert difference(got[:, i], linear.first(at)[0, :, i]) < 1e-11
    assert np.abs(got[1]).max() > 0.1
    assert difference(field.prepare(place).kinematics(np.array([0]))[0], got) == 0.0


@SEAS
def test_shaped_takes_the_profiles_of_a_level(sea) -> None:
    field = component_field(replace(sea, order=1))
    profile = first_order_profile(
        field.wavenumber, PLACE[:, 2].copy(), water_depth=sea.depth, stretching="taylor"
    )
    assert difference(field.shaped(PLACE, *profile), field.first(PLACE)) < 1e-14
    assert not field.second(PLACE).any()
    assert not field.elevation(PLACE)[1].any()


@SEAS
def test_blocks_of_coefficients_change_nothing(sea, monkeypatch) -> None:
    """Coefficients that are held, and coefficients made on demand for one point at a time."""
    index = np.array([3, 0, 3])

    def total(field: Field) -> tuple[Prepared, np.ndarray]:
        prepared = field.prepare(PLACE)
        return prepared, prepared.kinematics(index)

    held, expected = total(DirectionalField(sea))
    monkeypatch.setattr(directional, "HELD_BYTES", 1)
    monkeypatch.setattr(directional_sea, "TASK_BYTES", 1)
    made, got = total(DirectionalField(sea))
    assert type(made) is not type(held)
    assert np.array_equal(got, expected)
    field = DirectionalField(sea)
    assert difference((field.first(PLACE) + field.second(PLACE))[index], expected) < 1e-13


@pytest.mark.parametrize("few", [10**6, 0], ids=["summed", "spread"])
@SEAS
def test_windows_are_parts_of_the_record(sea, few: int, monkeypatch) -> None:
    """By direct sums and by spreading; one after the other with coefficients kept, all of them or few."""
    whole = DirectionalField(sea)
    eta, first, second = whole.elevation(PLACE), whole.first(PLACE), whole.second(PLACE)
    monkeypatch.setattr(lines, "FEW", few)
    for kept in (2**29, 3000):
        monkeypatch.setattr(directional, "KEPT_BYTES", kept)
        field = DirectionalField(sea)
        for start, count in ((0, 77), (77, 77), (201, 99)):
            part, cut = field.window(start, count), slice(start, start + count)
            assert isinstance(field, Windowed)
            assert part.n == count
            for _ in range(2):
                for got, expected in zip(part.elevation(PLACE), eta, strict=True):
                    assert difference(got, expected[:, cut]) < 1e-11
                total = part.prepare(PLACE).kinematics(np.array([2, 0]))
                assert difference(total, (first + second)[[2, 0]][..., cut]) < 1e-11
            assert difference(part.second(PLACE), second[..., cut]) < 1e-11
        assert (
            difference(part.second(PLACE), second[..., 200:299]) > 1e-3
        )  # the wrong variant: a sample early


def test_steady_flow_vanishes_as_frequencies_meet() -> None:
    """The flow at the difference frequency falls with it; the steady elevation of the pair stays."""
    flow, height = [], []
    for gap in (2e-2, 1e-2, 5e-3):
        omega = np.array([0.7, 0.7 + gap])
        case = replace(
            crossing(), omega=omega, wavenumber=omega**2 / 9.81, angle=np.array([0.0, 1.0]), depth=400.0,
            amplitude=np.ones(2, dtype=complex), dt=1.0, n=2,
        )  # fmt: skip
        both, plus = (DirectionalField(replace(case, amplitude=a * case.amplitude)) for a in (1.0, 1j))
        place = np.array([[20.0, 5.0, -10.0]])
        flow.append(0.5 * (both.second(place) + plus.second(place))[0, :, 0])
        height.append(0.5 * (both.elevation(place)[1] + plus.elevation(place)[1])[0, 0])
    size = [np.abs(q).max() for q in flow]
    assert np.log2(size[0] / size[1]) == pytest.approx(1.0, abs=0.15)
    assert np.log2(size[1] / size[2]) == pytest.approx(1.0, abs=0.15)
    assert min(abs(h) for h in height) > 0.1 * max(abs(h) for h in height) > 0.0


def test_deep_water_does_not_overflow() -> None:
    sea = replace(crossing(), depth=4000.0)
    sea = replace(sea, wavenumber=sea.omega**2 / 9.81)
    field = DirectionalField(sea)
    place = np.array([[1.0, 2.0, -4000.0], [1.0, 2.0, -3000.0], [1.0, 2.0, 0.0], [1.0, 2.0, 20.0]])
    assert np.isfinite(field.second(place)).all()
    assert np.abs(field.second(place)[0, 2]).max() < 1e-12 * np.abs(field.second(place)[2]).max()


@pytest.mark.parametrize("few", [10**6, 0], ids=["summed", "spread"])
def test_lines_against_the_sum(few: int, monkeypatch) -> None:
    monkeypatch.setattr(lines, "FEW", few)
    rng = np.random.default_rng(2)
    frequency = np.sort(rng.uniform(0.0, 3.0, 30))
    for start, count in ((0, 2), (0, 77), (11, 100)):
        route = lines.listed_lines(frequency, dt=0.3, start=start, count=count)
        y = rng.normal(size=(2, 3, 30)) + 1j * rng.normal(size=(2, 3, 30))
        both = np.concatenate([y, 1j * frequency * y], axis=1)
        phasor = np.exp(1j * np.outer(frequency, 0.3 * np.arange(start, start + count)))
        got = route.series(route.load(y), np.array([1, 0]), channels=6)
        assert difference(got, (both @ phasor).real[[1, 0]]) < 1e-11
        assert difference(route.series(route.load(y), np.array([1]), channels=3), got[:1, :3]) < 1e-12


def test_heading_of_listed_directions_is_no_choice(listed) -> None:
    """The frame follows the mean direction; the answer in global axes does not."""
    direction = [float(a) for a in ANGLE]
    sea = crossing()
    case = listed(
        sea.omega, np.abs(sea.amplitude), -np.angle(sea.amplitude), direction=direction,
        time={"dt_s": 0.2, "n": 300}, points_m=POINTS,
    )  # fmt: skip
    state = build_sea_state(case)
    frame, field = Frame(state.direction_deg), component_field(waves(state))
    got = field.second(frame.place(np.array(POINTS)))[:, :3].transpose(2, 0, 1)
    assert difference(got @ frame.axes, wave_kinematics(case).velocity2) < 1e-13
    assert len(MULTIPLE) == field.wavenumber.size


def test_range_of_the_surface_covers_the_area() -> None:
    """Loads take from it which segments stay dry: along a line through the middle it is too small."""
    field = component_field(crossing())
    corners = np.array([[x, y, 0.0] for x in (-12.0, 12.0) for y in (-9.0, 9.0)])
    low, high = surface_range(field, corners, 20.0)
    rng = np.random.default_rng(1)
    place = np.column_stack([rng.uniform(-12.0, 12.0, 200), rng.uniform(-9.0, 9.0, 200), np.zeros(200)])
    eta = np.add(*field.elevation(place))
    assert SAFETY * low - MARGIN < eta.min()
    assert eta.max() < SAFETY * high + MARGIN
    middle = np.add(*field.elevation(np.column_stack([np.linspace(-12.0, 12.0, 30), np.zeros((30, 2))])))
    assert eta.max() > SAFETY * middle.max() + MARGIN  # the wrong variant: the heading only


def test_exponential_of_a_row() -> None:
    x = np.concatenate([np.linspace(-700.0, 300.0, 20001), [0.0, -1e-300, -1e-9]])
    out = np.empty_like(x)
    kernel._exponential(x, np.empty_like(x), np.empty(x.size, dtype=np.int64), out)
    assert np.abs(out / np.exp(x) - 1.0).max() < 1e-15  # a few units in the last place
