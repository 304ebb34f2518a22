"""Fatigue of the member ends as a stage: stress blocks in, running damage out, in constant memory.

Damage comes from the signed stress of the hot spots (:mod:`owt_postproc.core.hot_spots`). Von Mises stress is
unsigned, and rainflow on it loses range; it is counted for the thesis' measure, the sum of range times
count (chapter 5), and never turned into damage.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int, Int32

from owt_model.config import CaseConfig
from owt_model.contracts import FatigueBlock, StressBlock
from owt_model.errors import ComputationError, InputError
from owt_model.parallel import map_threads, thread_count
from owt_postproc.core.hot_spots import WALL, HotSpots
from owt_postproc.core.sn import SNCurve, sn_curve
from owt_postproc.kernels import fatigue as kernel

__all__ = [
    "FatigueModel",
    "FatigueResult",
    "FatigueState",
    "build_fatigue_model",
    "count_rows",
    "final",
    "initial_state",
    "step",
]

STREAM = "member_stress"
#: Range bins: 20 per decade from 0.01 MPa to 1000 MPa, and one on either side for what lies outside.
LOWEST_PA, BINS_PER_DECADE, DECADES = 1e4, 20, 5
N_BINS = BINS_PER_DECADE * DECADES + 2
DAMAGE, WEIGHTED, LARGEST = 0, 1, 2
CHANNELS = ("axial", "bending_y", "bending_z", "von_mises")
#: Samples that are turned into channels at a time, and values from which a second thread is worth its start.
CHUNK, WORTH_A_THREAD = 4096, 100_000
#: A curve that gives no damage.
NO_DAMAGE = (np.inf, 0.0, 3.0, 0.0, 3.0)


@dataclass(frozen=True)
class FatigueModel:
    """What the counting needs to know. Channels are the hot spots, then von Mises of the member ends.

    Attributes
    ----------
    curve : SNCurve
        Of the hot spots of tubular joints.
    wall_curve : SNCurve
        Of the walls elsewhere.
    scf : float
        Stress concentration factor on the nominal stress of walls, part of the hot spots' map.
    hot_spots : HotSpots
    dt : float
        Sampling interval of the stress in s.
    thickness_effect : bool
        Whether walls thicker than a curve's reference are weaker.
    """

    curve: SNCurve
    wall_curve: SNCurve
    scf: float
    hot_spots: HotSpots
    dt: float
    thickness_effect: bool = True

    @property
    def n_ends(self) -> int:
        """Member ends."""
        return self.hot_spots.n_ends

    @property
    def n_spots(self) -> int:
        """Hot spots."""
        return self.hot_spots.n_spots

    @property
    def n_channels(self) -> int:
        """Series that are counted."""
        return self.n_spots + self.n_ends

    @cached_property
    def coefficients(self) -> Float[np.ndarray, "channel 5"]:
        """S-N coefficients of each channel, thickness included; von Mises has a curve without damage."""
        spots = self.hot_spots
        curves = [self.wall_curve if side == WALL else self.curve for side in spots.side]
        thickness = spots.thickness_m if self.thickness_effect else np.zeros(self.n_spots)
        made = {
            (curve.name, wall): curve.coefficients_for(wall) if wall else curve.coefficients
            for curve, wall in zip(curves, thickness, strict=True)
        }
        rows = [made[curve.name, wall] for curve, wall in zip(curves, thickness, strict=True)]
        return np.array([*rows, *[NO_DAMAGE] * self.n_ends])

    @cached_property
    def terms(self) -> tuple[Int[np.ndarray, " edge"], Int[np.ndarray, " term"], Float[np.ndarray, " term"]]:
        """Terms of each channel: edges, rows of the stress of all ends, factors."""
        spots, n = self.hot_spots, self.n_ends
        row = spots.term_component * n + spots.term_end
        return (
            np.append(spots.start, spots.start[-1] + np.arange(1, n + 1)),
            np.append(row, len(CHANNELS) * n - n + np.arange(n)),
            np.append(spots.term_factor, np.ones(n)),
        )


@dataclass(frozen=True)
class FatigueState:
    """Where the counting stands; channels are the hot spots, then von Mises.

    Attributes
    ----------
    sequence : int
        Next block expected.
    samples : int
        Samples counted per channel.
    closed : bool
        True once the block marked last is counted.
    stack, depth, last
        Residues [channel, capacity], their lengths and the last samples [channel].
    totals : float array [channel, 3]
        Damage, sum of range x count in Pa, largest range in Pa, of the cycles closed so far.
    count : int array [channel]
        Half cycles closed so far.
    histogram : int array [channel, bin]
        The same per range bin.
    """

    sequence: int
    samples: int
    closed: bool
    stack: Float[np.ndarray, "channel capacity"]
    depth: Int[np.ndarray, " channel"]
    last: Float[np.ndarray, " channel"]
    totals: Float[np.ndarray, "channel 3"]
    count: Int[np.ndarray, " channel"]
    histogram: Int32[np.ndarray, "channel bin"]


@dataclass(frozen=True)
class FatigueResult:
    """Rainflow results of a record, the residue counted as half cycles.

    Attributes
    ----------
    curve, wall_curve : SNCurve
        Of the hot spots of tubular joints and of walls.
    hot_spots : HotSpots
        Where stress was counted.
    damage, cycles, max_range : float arrays [spot]
        Palmgren-Miner sum, cycles, and largest range in Pa of the hot-spot stress.
    total_stress, von_mises_cycles, von_mises_max_range : float arrays [end]
        Sum of range x count in Pa, cycles, and largest range in Pa of the von Mises stress.
    range_edge : float array [bin - 1]
        Inner edges of the range bins in Pa; the first and the last bin are open.
    histogram : float array [spot, bin]
        Cycles of the hot-spot stress per range bin.
    """

    curve: SNCurve
    wall_curve: SNCurve
    scf: float
    hot_spots: HotSpots
    samples: int
    duration_s: float
    damage: Float[np.ndarray, " spot"]
    cycles: Float[np.ndarray, " spot"]
    max_range: Float[np.ndarray, " spot"]
    total_stress: Float[np.ndarray, " end"]
    von_mises_cycles: Float[np.ndarray, " end"]
    von_mises_max_range: Float[np.ndarray, " end"]
    range_edge: Float[np.ndarray, " edge"]
    histogram: Float[np.ndarray, "spot bin"]

    @property
    def end_damage(self) -> Float[np.ndarray, " end"]:
        """Largest damage of each end's spots."""
        return self.hot_spots.largest(self.damage)

    @property
    def end_max_range(self) -> Float[np.ndarray, " end"]:
        """Largest range in Pa of each end's spots."""
        return self.hot_spots.largest(self.max_range)

    @property
    def worst_spot(self) -> Int[np.ndarray, " end"]:
        """Spot of largest damage of each end."""
        return self.hot_spots.worst(self.damage)

    @property
    def worst_end(self) -> int:
        """Member end of largest damage."""
        return int(self.hot_spots.end[np.argmax(self.damage)])


def build_fatigue_model(case: CaseConfig, hot_spots: HotSpots) -> FatigueModel:
    """Prepare the counting of a case.

    Raises
    ------
    InputError
        If the S-N curve is unknown, or there are no member ends.
    """
    if hot_spots.n_ends < 1:
        raise InputError("n_ends", hot_spots.n_ends, "must be at least 1", "The structure has no members.")
    fatigue = case.fatigue
    curve = sn_curve(fatigue.sn_curve, fatigue.sn_file)
    wall = curve if fatigue.wall_sn_curve is None else sn_curve(fatigue.wall_sn_curve, fatigue.sn_file)
    return FatigueModel(curve, wall, fatigue.scf, hot_spots, case.structure.dt_s, fatigue.thickness_effect)


def initial_state(model: FatigueModel) -> FatigueState:
    """Nothing counted yet."""
    n = model.n_channels
    return FatigueState(
        sequence=0,
        samples=0,
        closed=False,
        stack=np.zeros((n, 32)),
        depth=np.zeros(n, dtype=np.int64),
        last=np.zeros(n),
        totals=np.zeros((n, 3)),
        count=np.zeros(n, dtype=np.int64),
        histogram=np.zeros((n, N_BINS), dtype=np.int32),
    )


def step(model: FatigueModel, state: FatigueState, stress: StressBlock) -> tuple[FatigueState, FatigueBlock]:
    """Count one block of stress.

    Returns
    -------
    state : FatigueState
        The old one stays as it was.
    block : FatigueBlock
        Results as if the stress ended with this block; `start` is the index of the last sample counted.

    Raises
    ------
    ComputationError
        If the block is not the next one, does not fit the model, or holds NaN or inf.
    """
    _check(model, state, stress)
    counted = state
    for begin in range(0, len(stress.axial), CHUNK):
        part = [getattr(stress, name)[begin : begin + CHUNK].T for name in CHANNELS]
        rows = np.empty((len(CHANNELS) * model.n_ends, part[0].shape[1]))
        for i, values in enumerate(part):
            rows[i * model.n_ends : (i + 1) * model.n_ends] = values
        counted = _count(model, counted, rows)
    samples = state.samples + len(stress.axial)
    new = replace(counted, sequence=state.sequence + 1, samples=samples, closed=stress.last)
    return new, _running(model, new, stress)


def count_rows(
    model: FatigueModel, state: FatigueState, rows: Float[np.ndarray, "row sample"]
) -> FatigueState:
    """Count the next samples of a record that comes in one process: one row per stress and end, time last.

    Parameters
    ----------
    model : FatigueModel
    state : FatigueState
        The old one stays as it was.
    rows : float array [4 end, sample]
        Axial, bending_y, bending_z and von Mises stress in Pa, each of all ends.

    Raises
    ------
    ComputationError
        If they do not fit the model, or hold NaN or inf.
    """
    if len(rows) != len(CHANNELS) * model.n_ends:
        raise ComputationError(
            f"stress rows: {len(rows)}, expected {len(CHANNELS)} for each of {model.n_ends} member ends."
        )
    # A sum is finite only if all its terms are; stress is far too small to overflow one.
    if not np.isfinite(rows.sum()):
        raise ComputationError(f"stress rows: NaN or inf after sample {state.samples}.")
    return replace(_count(model, state, rows), samples=state.samples + rows.shape[1])


def _count(model: FatigueModel, state: FatigueState, rows: Float[np.ndarray, "row sample"]) -> FatigueState:
    """Count samples of all ends, one row for each of their stresses, in a copy of the state."""
    capacity = state.stack.shape[1]
    while True:
        stack = np.zeros((model.n_channels, capacity))
        stack[:, : state.stack.shape[1]] = state.stack
        depth, last, totals = state.depth.copy(), state.last.copy(), state.totals.copy()
        count, histogram = state.count.copy(), state.histogram.copy()
        results = stack, depth, last, totals, count, histogram

        def part(channels: tuple[int, int], into: tuple[np.ndarray, ...] = results) -> int:
            fixed = (*model.terms, model.coefficients, LOWEST_PA, float(BINS_PER_DECADE))
            return int(kernel.count_block(rows, *channels, *fixed, *into))

        longest = max(map_threads(part, _shares(model.n_channels, rows.shape[1])))
        if longest <= capacity:
            return FatigueState(state.sequence, state.samples, state.closed, *results)
        capacity = max(2 * capacity, longest)


def _shares(channels: int, samples: int) -> list[tuple[int, int]]:
    """Ranges of channels, one for each thread that is worth it; results do not depend on their number."""
    n = max(1, min(thread_count(), channels * samples // WORTH_A_THREAD))
    edges = [channels * i // n for i in range(n + 1)]
    return list(itertools.pairwise(edges))


def final(model: FatigueModel, state: FatigueState) -> FatigueResult:
    """Results of what has been counted, with the residue as half cycles; the state stays as it is."""
    totals, count, histogram = _closed(model, state, state.histogram.copy())
    spots, ends = slice(0, model.n_spots), slice(model.n_spots, None)
    return FatigueResult(
        curve=model.curve,
        wall_curve=model.wall_curve,
        scf=model.scf,
        hot_spots=model.hot_spots,
        samples=state.samples,
        duration_s=max(state.samples - 1, 0) * model.dt,
        damage=totals[spots, DAMAGE].copy(),
        cycles=0.5 * count[spots],
        max_range=totals[spots, LARGEST].copy(),
        total_stress=totals[ends, WEIGHTED].copy(),
        von_mises_cycles=0.5 * count[ends],
        von_mises_max_range=totals[ends, LARGEST].copy(),
        range_edge=LOWEST_PA * 10.0 ** (np.arange(N_BINS - 1) / BINS_PER_DECADE),
        histogram=0.5 * histogram[spots],
    )


def _closed(
    model: FatigueModel, state: FatigueState, histogram: Int32[np.ndarray, "channel bin"]
) -> tuple[Float[np.ndarray, "channel 3"], Int[np.ndarray, " channel"], Int32[np.ndarray, "channel bin"]]:
    """Totals, half cycles and histogram with the residue booked; `histogram` is changed in place."""
    totals, count = state.totals.copy(), state.count.copy()
    kernel.close_block(
        0, model.n_channels, model.coefficients, LOWEST_PA, float(BINS_PER_DECADE),
        state.stack, state.depth, state.last, totals, count, histogram,
    )  # fmt: skip
    return totals, count, histogram


def _running(model: FatigueModel, state: FatigueState, stress: StressBlock) -> FatigueBlock:
    no_bins = np.zeros((model.n_channels, 0), dtype=np.int32)
    totals, count, _ = _closed(model, state, no_bins)
    spots, n = model.hot_spots, model.n_spots
    worst = spots.worst(totals[:n, DAMAGE])
    return FatigueBlock(
        sequence=stress.sequence,
        start=max(state.samples - 1, 0),
        dt=stress.dt,
        last=stress.last,
        samples_counted=state.samples,
        sn_curve=model.curve.name,
        cycles=0.5 * count[worst],
        damage=totals[worst, DAMAGE],
        total_stress=totals[n:, WEIGHTED].copy(),
        max_range=spots.largest(totals[:n, LARGEST]),
        side=spots.side_code[worst],
        angle_deg=spots.angle_deg[worst],
    )


def _check(model: FatigueModel, state: FatigueState, stress: StressBlock) -> None:
    """Refuse a block that is not the next one or not what the model expects."""
    at = f"{STREAM} sequence {stress.sequence}"
    if state.closed:
        raise ComputationError(f"{at}: arrived after the block marked last.")
    if stress.sequence != state.sequence:
        raise ComputationError(
            f"{at}: expected sequence {state.sequence}; a block was lost, repeated or reordered."
        )
    if stress.start != state.samples:
        raise ComputationError(f"{at}: starts at sample {stress.start}, expected {state.samples}.")
    if abs(stress.dt - model.dt) > 1e-12 * model.dt:
        raise ComputationError(f"{at}: sampled at {stress.dt} s, expected {model.dt} s.")
    for name in CHANNELS:
        values = getattr(stress, name)
        if values.shape != (len(stress.axial), model.n_ends):
            raise ComputationError(
                f"{at}: {name} has shape {values.shape}, expected ({len(stress.axial)}, {model.n_ends})."
            )
        if not np.isfinite(values).all():
            sample, end = np.argwhere(~np.isfinite(values))[0]
            raise ComputationError(
                f"{at}: {name} is {values[sample, end]} at sample {sample} of the block, member end {end}."
            )
