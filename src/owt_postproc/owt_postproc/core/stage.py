"""Fatigue of the member ends as a stage: stress blocks in, running damage out, in constant memory.

Damage comes from the signed normal stress at eight points round each member end,
sigma(theta) = SCF (axial + bending_y sin(theta) + bending_z cos(theta)), theta from element axis y
towards z. Von Mises stress is unsigned, and rainflow on it loses range; it is counted for the thesis'
measure, the sum of range times count (chapter 5), and never turned into damage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Int32

from owt_model.config import CaseConfig
from owt_model.contracts import FatigueBlock, StressBlock
from owt_model.errors import ComputationError, InputError
from owt_postproc.core.sn import SNCurve, sn_curve
from owt_postproc.kernels import fatigue as kernel

__all__ = [
    "POINT_ANGLE_DEG",
    "FatigueModel",
    "FatigueResult",
    "FatigueState",
    "build_fatigue_model",
    "final",
    "initial_state",
    "step",
]

STREAM = "member_stress"
N_POINTS = 8
#: Angles of the points round the section, from element axis y towards z, in degrees.
POINT_ANGLE_DEG = 360.0 / N_POINTS * np.arange(N_POINTS)
#: Range bins: 20 per decade from 0.01 MPa to 1000 MPa, and one on either side for what lies outside.
LOWEST_PA, BINS_PER_DECADE, DECADES = 1e4, 20, 5
N_BINS = BINS_PER_DECADE * DECADES + 2
DAMAGE, WEIGHTED, LARGEST = 0, 1, 2


@dataclass(frozen=True)
class FatigueModel:
    """What the counting needs to know.

    Attributes
    ----------
    curve : SNCurve
    scf : float
        Stress concentration factor on the nominal normal stress.
    n_ends : int
        Member ends.
    dt : float
        Sampling interval of the stress in s.
    """

    curve: SNCurve
    scf: float
    n_ends: int
    dt: float

    @property
    def sine(self) -> Float[np.ndarray, " point"]:
        """Sine of the point angles, exact at multiples of 90 degrees."""
        return np.asarray(np.sin(np.deg2rad(POINT_ANGLE_DEG)).round(15))

    @property
    def cosine(self) -> Float[np.ndarray, " point"]:
        """Cosine of the point angles, exact at multiples of 90 degrees."""
        return np.asarray(np.cos(np.deg2rad(POINT_ANGLE_DEG)).round(15))


@dataclass(frozen=True)
class FatigueState:
    """Where the counting stands; channels are the points, then von Mises.

    Attributes
    ----------
    sequence : int
        Next block expected.
    samples : int
        Samples counted per channel.
    closed : bool
        True once the block marked last is counted.
    stack, depth, last
        Residues [end, channel, capacity], their lengths and the last samples [end, channel].
    totals : float array [end, channel, 3]
        Damage, sum of range x count in Pa, largest range in Pa, of the cycles closed so far.
    count : int array [end, channel]
        Half cycles closed so far.
    histogram : int array [end, channel, bin]
        The same per range bin.
    """

    sequence: int
    samples: int
    closed: bool
    stack: Float[np.ndarray, "end channel capacity"]
    depth: Int[np.ndarray, "end channel"]
    last: Float[np.ndarray, "end channel"]
    totals: Float[np.ndarray, "end channel 3"]
    count: Int[np.ndarray, "end channel"]
    histogram: Int32[np.ndarray, "end channel bin"]


@dataclass(frozen=True)
class FatigueResult:
    """Rainflow results of a record, the residue counted as half cycles.

    Attributes
    ----------
    damage, cycles, max_range : float arrays [end, point]
        Palmgren-Miner sum, cycles, and largest range in Pa of the normal stress, SCF included.
    total_stress, von_mises_cycles, von_mises_max_range : float arrays [end]
        Sum of range x count in Pa, cycles, and largest range in Pa of the von Mises stress.
    range_edge : float array [bin - 1]
        Inner edges of the range bins in Pa; the first and the last bin are open.
    histogram : float array [end, point, bin]
        Cycles of the normal stress per range bin.
    """

    curve: SNCurve
    scf: float
    samples: int
    duration_s: float
    damage: Float[np.ndarray, "end point"]
    cycles: Float[np.ndarray, "end point"]
    max_range: Float[np.ndarray, "end point"]
    total_stress: Float[np.ndarray, " end"]
    von_mises_cycles: Float[np.ndarray, " end"]
    von_mises_max_range: Float[np.ndarray, " end"]
    range_edge: Float[np.ndarray, " edge"]
    histogram: Float[np.ndarray, "end point bin"]

    @property
    def worst_point(self) -> Int[np.ndarray, " end"]:
        """Point of largest damage of each end."""
        return np.asarray(np.argmax(self.damage, axis=1))

    @property
    def worst_end(self) -> int:
        """Member end of largest damage."""
        return int(np.argmax(self.damage.max(axis=1)))


def build_fatigue_model(case: CaseConfig, n_ends: int) -> FatigueModel:
    """Prepare the counting of a case.

    Raises
    ------
    InputError
        If the S-N curve is unknown, or there are no member ends.
    """
    if n_ends < 1:
        raise InputError("n_ends", n_ends, "must be at least 1", "The structure has no members.")
    return FatigueModel(
        sn_curve(case.fatigue.sn_curve, case.fatigue.sn_file), case.fatigue.scf, n_ends, case.structure.dt_s
    )


def initial_state(model: FatigueModel) -> FatigueState:
    """Nothing counted yet."""
    shape = (model.n_ends, N_POINTS + 1)
    return FatigueState(
        sequence=0,
        samples=0,
        closed=False,
        stack=np.zeros((*shape, 64)),
        depth=np.zeros(shape, dtype=np.int64),
        last=np.zeros(shape),
        totals=np.zeros((*shape, 3)),
        count=np.zeros(shape, dtype=np.int64),
        histogram=np.zeros((*shape, N_BINS), dtype=np.int32),
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
    capacity = state.stack.shape[2]
    while True:
        stack = np.zeros((*state.depth.shape, capacity))
        stack[:, :, : state.stack.shape[2]] = state.stack
        depth, last, totals = state.depth.copy(), state.last.copy(), state.totals.copy()
        count, histogram = state.count.copy(), state.histogram.copy()
        longest = kernel.count_block(
            stress.axial, stress.bending_y, stress.bending_z, stress.von_mises,
            model.sine, model.cosine, model.scf, model.curve.coefficients, LOWEST_PA, float(BINS_PER_DECADE),
            stack, depth, last, totals, count, histogram,
        )  # fmt: skip
        if longest <= capacity:
            break
        capacity = max(2 * capacity, longest)
    samples = state.samples + len(stress.axial)
    new = FatigueState(state.sequence + 1, samples, stress.last, stack, depth, last, totals, count, histogram)
    return new, _running(model, new, stress)


def final(model: FatigueModel, state: FatigueState) -> FatigueResult:
    """Results of what has been counted, with the residue as half cycles; the state stays as it is."""
    totals, count, histogram = _closed(model, state, state.histogram.copy())
    points = slice(0, N_POINTS)
    return FatigueResult(
        curve=model.curve,
        scf=model.scf,
        samples=state.samples,
        duration_s=max(state.samples - 1, 0) * model.dt,
        damage=totals[:, points, DAMAGE].copy(),
        cycles=0.5 * count[:, points],
        max_range=totals[:, points, LARGEST].copy(),
        total_stress=totals[:, N_POINTS, WEIGHTED].copy(),
        von_mises_cycles=0.5 * count[:, N_POINTS],
        von_mises_max_range=totals[:, N_POINTS, LARGEST].copy(),
        range_edge=LOWEST_PA * 10.0 ** (np.arange(N_BINS - 1) / BINS_PER_DECADE),
        histogram=0.5 * histogram[:, points],
    )


def _closed(
    model: FatigueModel, state: FatigueState, histogram: Int32[np.ndarray, "end channel bin"]
) -> tuple[
    Float[np.ndarray, "end channel 3"], Int[np.ndarray, "end channel"], Int32[np.ndarray, "end channel bin"]
]:
    """Totals, half cycles and histogram with the residue booked; `histogram` is changed in place."""
    totals, count = state.totals.copy(), state.count.copy()
    kernel.close_block(
        model.curve.coefficients, LOWEST_PA, float(BINS_PER_DECADE),
        state.stack, state.depth, state.last, totals, count, histogram,
    )  # fmt: skip
    return totals, count, histogram


def _running(model: FatigueModel, state: FatigueState, stress: StressBlock) -> FatigueBlock:
    no_bins = np.zeros((*state.depth.shape, 0), dtype=np.int32)
    totals, count, _ = _closed(model, state, no_bins)
    worst = np.argmax(totals[:, :N_POINTS, DAMAGE], axis=1)
    end = np.arange(model.n_ends)
    return FatigueBlock(
        sequence=stress.sequence,
        start=max(state.samples - 1, 0),
        dt=stress.dt,
        last=stress.last,
        samples_counted=state.samples,
        sn_curve=model.curve.name,
        cycles=0.5 * count[end, worst],
        damage=totals[end, worst, DAMAGE],
        total_stress=totals[:, N_POINTS, WEIGHTED].copy(),
        max_range=totals[:, :N_POINTS, LARGEST].max(axis=1),
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
    for name in ("axial", "bending_y", "bending_z", "von_mises"):
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
