"""Routes to the same field: compressed pairs, windows of a record, components off any grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from owt_model.config import parse_case
from owt_wave_node.core import loads as loads_module
from owt_wave_node.core.compressed import CompressedField
from owt_wave_node.core.compression import CompressedSea
from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.field import Field, GridField
from owt_wave_node.core.grid import FrequencyGrid, frequency_grid
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Waves, build_sea_state, waves
from owt_wave_node.core.window import Bell, window_of
from proofs.cases import oc4, relative
from proofs.registry import Proof

#: Points at the edges of the jacket and far from it, at the surface, at the bed, and above still water.
PLACE = np.array(
    [[0.0, 0, 0], [14.0, 0, -3.0], [-14.0, 0, -20.0], [5.0, 0, -49.0], [-12.0, 0, 4.0], [311.0, 0, -1.0]]
)
ARRAYS = ("first", "second")


@cache
def long_sea() -> tuple[Waves, FrequencyGrid]:
    """Hs 6 m, Tp 10 s over 800 s: 310 components, 48,000 pairs."""
    sea = waves(build_sea_state(parse_case({"time": {"dt_s": 0.1, "n": 8000}})))
    grid = frequency_grid(sea.omega, dt=sea.dt, n=sea.n, order=2)
    assert grid is not None
    return sea, grid


def signals(field: Field) -> list[np.ndarray]:
    """Both orders of elevation, then of velocities and accelerations, at all points."""
    parts = [*field.elevation(PLACE), field.first(PLACE), field.second(PLACE)]
    return [part.reshape(len(PLACE), -1, field.n) for part in parts]


def difference(got: list[np.ndarray], expected: list[np.ndarray]) -> float:
    """Largest difference of a signal over its own largest value."""
    return max(
        float(np.max(np.abs(a - b).max(axis=-1) / np.abs(b).max(axis=-1)))
        for a, b in zip(got, expected, strict=True)
    )


@cache
def all_pairs() -> list[np.ndarray]:
    return signals(GridField(*long_sea()))


def compression(nodes: int | None) -> float:
    return difference(signals(CompressedField(CompressedSea(*long_sea(), nodes=nodes))), all_pairs())


def windows(variant: tuple[Bell | None, int]) -> float:
    """Windows of 2300 samples: their kernel, and samples by which they start late."""
    bell, late = variant
    sea = CompressedSea(*long_sea()) if bell is None else CompressedSea(*long_sea(), bell=bell)
    worst = 0.0
    for start in (0, 2600, 5700):
        part = CompressedField(sea).window(start + late, 2300)
        expected = [whole[..., start : start + 2300] for whole in all_pairs()]
        worst = max(worst, difference(signals(part), expected))
    return worst


@cache
def scattered() -> tuple[Waves, list[np.ndarray]]:
    """Twelve components of random frequencies over 300 s."""
    rng = np.random.default_rng(7)
    omega = np.sort(rng.uniform(0.35, 2.0, 12))
    case = parse_case(
        {
            "components": {
                "omega_rad_s": omega.tolist(),
                "amplitude_m": rng.uniform(0.1, 0.5, 12).tolist(),
                "phase_rad": rng.uniform(0.0, 6.28, 12).tolist(),
            },
            "time": {"dt_s": 0.2, "n": 1500},
        }
    )
    sea = waves(build_sea_state(case))
    return sea, signals(DirectField(sea))


def off_grid(make: Callable[[Waves], Field]) -> float:
    sea, expected = scattered()
    return difference(signals(make(sea)), expected)


def spread(sea: Waves) -> Field:
    return CompressedField(CompressedSea(sea, None))


def rounded(sea: Waves) -> Field:
    """Frequencies moved to the nearest multiple of 2 pi / (1000 records)."""
    spacing = 2.0 * np.pi / (1000 * sea.n * sea.dt)
    return spread(replace(sea, omega=spacing * np.round(sea.omega / spacing)))


def no_rate(sea: Waves) -> Field:
    """Derivatives of the window left in the accelerations."""
    compressed = CompressedSea(sea, None)
    assert compressed.record.rate is not None
    compressed.record = replace(compressed.record, rate=0.0 * compressed.record.rate)
    return CompressedField(compressed)


@cache
def jacket_case(window: int | None) -> np.ndarray:
    case = parse_case({"time": {"dt_s": 0.1, "n": 900}, "wave": {"window": window}})
    return loads_module.jacket_loads(case, oc4()).history.nodal


def load_windows(cut: Callable[[int, int], tuple[int, int]]) -> float:
    """Nodal loads of three windows of 300 samples, `cut` from the record, against those of the whole."""
    case = parse_case({"time": {"dt_s": 0.1, "n": 900}, "wave": {"window": 300}})
    sea = build_sea_state(case)
    prepared = loads_module.prepare_loads(case, oc4(), sea, make_field(case, sea))
    assert len(prepared) == 3
    nodal = []
    for i in range(3):
        start, count = cut(300 * i, 300)
        part = replace(prepared, field=window_of(prepared.field, start, count), length=count)
        nodal.append(part.window(0).nodal)
    return relative(np.concatenate(nodal, axis=2), jacket_case(None))


PROOFS = (
    Proof(
        key="compressed-pairs",
        claim="pairs compressed in wave number give both orders of elevation and kinematics",
        against="the sum over all pairs, 800 s, 310 components, six points",
        error=compression,
        right=None,
        wrong={"three quarters of the nodes": 48},
        allowed=1e-8,
        reason="polynomials are 1e-9 of the largest factor off; a signal is a tenth of its amplitudes' sum",
    ),
    Proof(
        key="windows-of-a-record",
        claim="windows of 2300 samples give the record that they are cut from",
        against="the sum over all pairs, the whole record transformed",
        error=windows,
        right=(None, 0),
        wrong={
            "lines spread over 16 bins instead of 20": (Bell(16, 1.15), 0),
            "windows one sample late": (None, 1),
        },
        allowed=1e-8,
        reason="a spread line is 4e-9 of its amplitude off at the ends of a window",
    ),
    Proof(
        key="off-grid-by-fft",
        claim="components off any frequency grid, spread and transformed, are exact",
        against="direct sums over twelve components of random frequencies and their pairs",
        error=off_grid,
        right=spread,
        wrong={
            "frequencies rounded to thousandths of a bin": rounded,
            "window's rate of change left in the accelerations": no_rate,
        },
        allowed=1e-10,
        reason="kernel and polynomials are 2e-13 and 1e-12 off, in units of the sum of the amplitudes",
    ),
    Proof(
        key="loads-window-by-window",
        claim="nodal loads of the jacket computed in three windows are those of the record",
        against="the record of 90 s in one piece, all pairs",
        error=load_windows,
        right=lambda start, count: (start, count),
        wrong={"windows one sample late": lambda start, count: (min(start + 1, 600), count)},
        allowed=1e-8,
        reason="kinematics 4e-9 off at the ends of a window, doubled by the drag",
    ),
)
