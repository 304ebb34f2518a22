"""Windows of a record and compressed pairs: what the proofs of the routes leave open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import ComputationError
from owt_wave_node.core import compression
from owt_wave_node.core.compressed import AutoField, CompressedField
from owt_wave_node.core.compression import CompressedSea
from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.field import Field, GridField
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.regular import RegularField
from owt_wave_node.core.route import component_field, make_field
from owt_wave_node.core.sea import Waves, build_sea_state, waves
from owt_wave_node.core.wheeler import WheelerField
from owt_wave_node.core.window import FINE, QUICK, Bell, SlicedField, good_length, spread_window, window_of

PLACE = np.array([[0.0, 0, 0], [9.0, 0, -4.0], [-7.0, 0, -45.0], [3.0, 0, 2.5]])


def case_of(**given: object) -> CaseConfig:
    return parse_case({"time": {"dt_s": 0.2, "n": 1200}} | given)


def sea_of(**given: object) -> Waves:
    return waves(build_sea_state(case_of(**given)))


def parts(field: Field, place: np.ndarray = PLACE) -> list[np.ndarray]:
    first, second = field.elevation(place)
    total = field.prepare(place).kinematics(np.arange(len(place)))
    assert np.allclose(total, field.first(place) + field.second(place), rtol=0.0, atol=1e-9)
    return [first, second, total]


def error(got: list[np.ndarray], expected: list[np.ndarray], rows: slice = slice(None)) -> float:
    return max(
        float(np.abs(a - b[..., rows]).max() / np.abs(b).max()) for a, b in zip(got, expected, strict=True)
    )


def test_kernels_are_as_good_as_said() -> None:
    assert FINE.error < 1e-12
    assert QUICK.error < 1e-8
    # Negative control: the measure sees a kernel that is too narrow, and it is refused.
    assert 1e-4 < Bell(4, 1.15).error < 1.0
    with pytest.raises(ComputationError, match="over 4 bins"):
        spread_window(start=0, count=500, dt=0.1, top=5.0, bell=Bell(4, 1.15))


def test_lengths_of_transforms() -> None:
    for least in (1, 16, 17, 5175, 6900, 100_003):
        length = good_length(least)
        assert least <= length <= 1.25 * least + 16
        assert length % 16 == 0
        while any(length % p == 0 for p in (2, 3, 5)):
            length //= next(p for p in (2, 3, 5) if length % p == 0)
        assert length == 1


@pytest.mark.parametrize(("start", "count"), [(0, 64), (333, 500), (1130, 70)])
@pytest.mark.parametrize(
    "given",
    [
        {},
        {"wave": {"order": 1}},
        {"wave": {"stretching": "none"}},
        {"wave": {"stretching": "constant"}},
        {"time": {"dt_s": 1.0, "n": 1200}},  # the second order lies above the Nyquist frequency
    ],
)
def test_windows_of_compressed_pairs(given: dict[str, object], start: int, count: int) -> None:
    sea = sea_of(**given)
    grid = frequency_grid(sea.omega, dt=sea.dt, n=sea.n, order=sea.order)
    assert grid is not None
    whole = parts(GridField(sea, grid))
    compressed = CompressedField(CompressedSea(sea, grid))
    window = compressed.window(start, count)
    got = [a if b.any() else b[..., start : start + count] for a, b in zip(parts(window), whole, strict=True)]
    whole = [b if b.any() else b + 1.0 for b in whole]
    got = [a if a.any() else a + 1.0 for a in got]
    assert error(got, whole, slice(start, start + count)) < 1e-8
    # A window of a window is a window of the record.
    again = window.window(10, 40)
    assert error(again.prepare(PLACE).kinematics(np.arange(4))[None], got[2][..., 10:50][None]) < 1e-8


def test_error_estimate_is_of_the_size_of_the_error() -> None:
    sea = sea_of()
    grid = frequency_grid(sea.omega, dt=sea.dt, n=sea.n, order=2)
    assert grid is not None
    exact = GridField(sea, grid).second(PLACE)

    ratios = []
    for nodes in range(30, 61, 6):
        field = CompressedField(CompressedSea(sea, grid, nodes=nodes))
        try:
            off = float(
                np.max(np.std(field.second(PLACE)[:, 0] - exact[:, 0], axis=1) / exact[:, 0].std(axis=1))
            )
        except ComputationError:
            continue  # refused
        ratios.append(off / field.error_estimate)
    assert len(ratios) >= 2
    assert max(ratios) < 3.0  # the estimate takes every pair at its worst, so it is rarely below the error


def test_a_compression_that_is_not_accurate_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    sea = sea_of()
    grid = frequency_grid(sea.omega, dt=sea.dt, n=sea.n, order=2)
    field = CompressedField(CompressedSea(sea, grid, nodes=18))
    with pytest.raises(ComputationError, match="18 wave numbers"):
        field.elevation(PLACE)
    monkeypatch.setattr(compression, "MAX_ERROR", 10.0)
    field.elevation(PLACE)


def test_auto_sums_a_stretch_that_is_refused_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Auto looks at the first stretch of x only; elsewhere, and in windows, the exact field steps in."""
    sea = replace(sea_of(), n=1200)
    made = compression._compress

    def refuse(of: CompressedSea, middle: float) -> compression.Pairs:
        if middle != 0.0:
            raise ComputationError("not accurate here")
        return made(of, middle)

    monkeypatch.setattr(compression, "_compress", refuse)
    field, exact = component_field(sea, "windows"), component_field(sea, "exact")
    assert isinstance(field, AutoField)
    near = PLACE * [0.0, 1.0, 1.0]
    far = near + np.array([1e4, 0.0, 0.0])
    for place, allowed in ((near, 1e-8), (far, 1e-12)):
        assert error(parts(field, place), parts(exact, place)) < allowed
        cut = parts(field.window(100, 200), place)
        assert error(cut, parts(exact, place), slice(100, 300)) < 1e-8
    with pytest.raises(ComputationError, match="not accurate"):
        component_field(sea, "compressed").elevation(far)


def test_choice_of_route() -> None:
    sea = sea_of()
    assert isinstance(component_field(sea), GridField)
    assert isinstance(component_field(sea, "direct"), DirectField)
    assert isinstance(component_field(sea, "compressed"), CompressedField)
    assert isinstance(component_field(replace(sea, n=12000)), CompressedField)
    assert isinstance(component_field(replace(sea, n=12000), "exact"), GridField)
    assert isinstance(component_field(replace(sea, omega=sea.omega * np.pi)), CompressedField)
    assert isinstance(component_field(replace(sea, omega=sea.omega * np.pi), "exact"), DirectField)
    for window, kind in ((None, GridField), (1200, GridField), (600, CompressedField)):
        case = case_of(wave={"window": window})
        assert isinstance(make_field(case, build_sea_state(case)), kind)
    # Waves of 1 m on 5000 m of water: too many nodes, so the pairs are summed as they are, or it is said.
    deep = replace(sea, depth=5000.0, wavenumber=sea.wavenumber * 100.0)
    assert isinstance(component_field(deep, "windows"), GridField)
    with pytest.raises(ComputationError, match="too short"):
        component_field(deep, "compressed")


def test_windows_of_every_field() -> None:
    """A field cut from the record, by itself or by computing the whole."""
    listed = {"omega_rad_s": [0.61, 0.83, 1.27], "amplitude_m": [1.0, 0.7, 0.3], "phase_rad": [0.0, 1.0, 2.0]}
    regular = case_of(regular={"height_m": 6.0, "period_s": 9.0, "theory": "stokes"})
    shift = slice(313, 613)
    fields: list[Field] = [
        DirectField(sea_of(components=listed)),
        component_field(sea_of(components=listed, wave={"order": 1, "stretching": "wheeler"})),
        component_field(sea_of()),
        RegularField(regular, build_sea_state(regular)),
        make_field(
            spread := case_of(components=listed | {"direction_deg": [0.0, 20.0, -15.0]}),
            build_sea_state(spread),
        ),
    ]
    kinds = []
    for field in fields:
        window = window_of(field, 313, 300)
        kinds.append(type(window))
        assert window.n == 300
        first, second = field.elevation(PLACE)
        part = window.elevation(PLACE)
        assert np.abs(part[0] - first[:, shift]).max() < 1e-8
        assert np.abs(part[1] - second[:, shift]).max() < 1e-8
        whole = field.prepare(PLACE).kinematics(np.arange(4))
        assert np.abs(window.prepare(PLACE).kinematics(np.arange(4)) - whole[..., shift]).max() < 1e-7
        # Negative control: one sample later is another thing.
        assert np.abs(window.prepare(PLACE).kinematics(np.arange(4)) - whole[..., 314:614]).max() > 1e-3
        assert window_of(field, 0, field.n) is field
    assert kinds[:3] == [DirectField, WheelerField, SlicedField]
