"""Every hot spot of the OC4 jacket: stress, rainflow and damage, beside the libraries rainflow and fatpack.

``python -m benchmarks.fatigue`` runs the chain once; it is started for its memory.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.measure import Table, process, timing

#: Channels that the libraries count; all of them would take a minute.
SAMPLE = 12
#: Load samples in a block of a run, and of the whole record.
BLOCKS = (50, 6000)
#: Classes of fatpack, fine enough that its damage agrees to 1e-3.
CLASSES = 65536


def prepare() -> tuple[Any, Any, Any]:
    """Loads of 600 s of second-order waves on the OC4 jacket, and its stages of stress and of counting."""
    from owt_campaign.pipeline import prepare_case
    from owt_model.config import parse_case

    run = prepare_case(parse_case({"stream": {"block": BLOCKS[-1]}}))
    return run.wave.load_block(0), run.response, run.fatigue


def blocks_of(load: Any, size: int) -> list[Any]:
    """The loads in blocks of `size` samples."""
    count = len(load.nodal)
    return [
        replace(
            load, sequence=i, start=start, last=start + size >= count,
            nodal=load.nodal[start : start + size], fixed_end=load.fixed_end[start : start + size],
        )
        for i, start in enumerate(range(0, count, size))
    ]  # fmt: skip


def stresses(response: Any, blocks: list[Any]) -> list[Any]:
    """Stress blocks of the structure stage."""
    from owt_structure_node.core.stage import initial_state, step

    state, found = initial_state(response), []
    for block in blocks:
        state, out = step(response, state, block)
        found.append(out.stress)
    return found


def count(fatigue: Any, stress: list[Any]) -> Any:
    """Fatigue results of the counting stage."""
    from owt_postproc.core.stage import final, initial_state, step

    state = initial_state(fatigue)
    for block in stress:
        state, _ = step(fatigue, state, block)
    return final(fatigue, state)


def both(load: Any, response: Any, fatigue: Any, size: int) -> Any:
    """From loads to damage, block by block, as a run does."""
    from owt_postproc.core import stage as counting
    from owt_structure_node.core import stage as structure

    state, counted = structure.initial_state(response), counting.initial_state(fatigue)
    for block in blocks_of(load, size):
        state, out = structure.step(response, state, block)
        counted, _ = counting.step(fatigue, counted, out.stress)
    return counting.final(fatigue, counted)


def spot_series(fatigue: Any, stress: list[Any], spots: np.ndarray) -> np.ndarray:
    """Hot-spot stress in Pa of some spots [spot, sample]."""
    nominal = [np.concatenate([getattr(s, n) for s in stress]) for n in ("axial", "bending_y", "bending_z")]
    return np.array([fatigue.hot_spots.stress(spot, *nominal) for spot in spots])


# --- one channel, ours and theirs: ranges and counts, then damage -------------------------------------------


def damage(coefficients: np.ndarray, ranges: np.ndarray, counts: np.ndarray | float) -> float:
    """Palmgren-Miner sum on two slopes."""
    knee, inverse_1, m_1, inverse_2, m_2 = coefficients
    per_cycle = np.where(ranges >= knee, inverse_1 * ranges**m_1, inverse_2 * ranges**m_2)
    return float(np.sum(counts * per_cycle))


def by_ours(series: np.ndarray, coefficients: np.ndarray, *, closed: bool = False) -> float:
    """By this package, one channel at a time."""
    from owt_postproc import rainflow

    ranges, _, counts = rainflow(series, closed=closed)
    return damage(coefficients, ranges, counts)


def by_rainflow(series: np.ndarray, coefficients: np.ndarray) -> float:
    """By the library rainflow, whose counting is a generator of tuples."""
    import rainflow

    found = np.array([(r, c) for r, _, c, _, _ in rainflow.extract_cycles(series.tolist())])
    return damage(coefficients, found[:, 0], found[:, 1])


def by_fatpack(series: np.ndarray, coefficients: np.ndarray) -> float:
    """By the library fatpack, with its residue closed."""
    import fatpack

    return damage(coefficients, fatpack.find_rainflow_ranges(series, k=CLASSES), 1.0)


# --- the part -----------------------------------------------------------------------------------------------


def bench_fatigue(table: Table) -> None:
    """Wall and processor time and memory; the libraries on some channels."""
    load, response, fatigue = prepare()
    stress = {size: stresses(response, blocks_of(load, size)) for size in BLOCKS}
    result = count(fatigue, stress[BLOCKS[0]])
    n = fatigue.n_channels
    samples = sum(len(block.axial) for block in stress[BLOCKS[0]])

    spots = np.unique(np.linspace(0, fatigue.n_spots - 1, SAMPLE).astype(int))
    series = spot_series(fatigue, stress[BLOCKS[-1]], spots)
    pairs = list(zip(series, fatigue.coefficients[spots], strict=True))
    _check(result, spots, pairs)
    theirs = {
        name: timing(lambda library=library: [library(*pair) for pair in pairs], 2).wall / len(spots)
        for name, library in (("rainflow", by_rainflow), ("fatpack", by_fatpack))
    }
    ours = timing(lambda: [by_ours(*pair) for pair in pairs]).wall / len(spots)
    shown = f"{n:,} channels ({fatigue.n_spots:,} hot spots), {samples:,} samples"
    table.note("fatigue", "channels counted: hot spots, and von Mises of the member ends", n, "")
    for size in BLOCKS:
        beside = {f"{name}, {len(spots)} channels scaled up": s * n for name, s in theirs.items()}
        what = f"rainflow and damage, {shown}, blocks of {size * samples // BLOCKS[-1]}"
        counted = timing(partial(count, fatigue, stress[size]), 4)
        table.add("fatigue", what, counted, beside)
    for size in BLOCKS:
        whole = timing(partial(both, load, response, fatigue, size), 4)
        what = f"  with integration and stress recovery, blocks of {size * samples // BLOCKS[-1]}"
        table.add("fatigue", what, whole)
    table.note("fatigue", "one channel, rainflow and damage", 1e3 * ours, "ms")
    for name, seconds in theirs.items():
        table.note("fatigue", f"  {name} over that, one thread each", seconds / ours, "x")
    table.add(
        "fatigue",
        "  loads to damage as a process of its own",
        process([sys.executable, "-m", "benchmarks.fatigue"]),
    )


def _check(result: Any, spots: np.ndarray, pairs: list[Any]) -> None:
    """Damage of the stage is that of our function and of both libraries, to what their conventions allow."""
    for spot, pair in zip(spots, pairs, strict=True):
        staged = result.damage[spot]
        assert np.isclose(by_ours(*pair), staged, rtol=1e-9), "stage and function count differently"
        assert np.isclose(by_rainflow(*pair), staged, rtol=1e-9), "the library rainflow counts differently"
        closed = by_ours(*pair, closed=True)
        assert np.isclose(by_fatpack(*pair), closed, rtol=1e-3), "the library fatpack counts differently"


if __name__ == "__main__":
    both(*prepare(), BLOCKS[0])
