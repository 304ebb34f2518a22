"""Rows of the wave comparison: each statement of thesis chapter 5.2 beside what this code finds."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.focus import HALF_WAY, SHORT, splash_zone
from owt_campaign.studies.result import Outcome, Row, agreement
from owt_campaign.studies.wave_comparison import WaveComparison

__all__ = ["CUTOFF", "PRINTED_FACTOR", "percent", "wave_rows"]

CUTOFF = "4 omega_p"
#: Factor on the kinetic energy, and on the time.
PRINTED_FACTOR, PRINTED_TIME = 2.73, 200.0 / 110.0
#: Total stress of two members that count as alike, relative.
TIE = 0.01


def wave_rows(found: WaveComparison) -> list[Row]:
    """All rows of the page."""
    rows = [*_size_rows(found), *_place_rows(found), *_leg_rows(found), *_range_rows(found)]
    return [*rows, *_spectrum_rows(found), *_energy_rows(found), _time_row(found)]


def percent(ratio: float) -> float:
    """Increase in percent."""
    return 100.0 * (float(ratio) - 1.0)


def _seed_spread(found: WaveComparison, measure: Any) -> tuple[float, float]:
    """Lowest and highest over the seeds of what `measure` makes of the ratios of one of them."""
    values = [measure(found.table.ratio(seed)) for seed in found.table.seeds(LINEAR)]
    return min(values), max(values)


def _size_rows(found: WaveComparison) -> list[Row]:
    """By how much the second order raises the stress."""
    ratio = found.table.ratio()
    legs = found.members.leg & ~np.isnan(ratio)

    def of_legs(values: Float[np.ndarray, " member"]) -> float:
        return percent(np.median(values[legs]))

    def largest(values: Float[np.ndarray, " member"]) -> float:
        return percent(np.nanmax(values))

    def smallest(values: Float[np.ndarray, " member"]) -> float:
        return percent(np.nanmin(values))

    asked = (
        ("increase of the legs, median", "5.2, figure 5.1c", "2 to 3", (2.0, 3.0), of_legs),
        ("largest increase of a member", "5.4", 6.0, (6.0,), largest),
        ("smallest increase of a member", "5.4", 1.0, (1.0,), smallest),
    )
    return [
        Row(what, where, printed, measure(ratio), "%", _seed_spread(found, measure),
            agreement(measure(ratio), *limits))
        for what, where, printed, limits, measure in asked
    ]  # fmt: skip


def _place_rows(found: WaveComparison) -> list[Row]:
    """Where the increase is largest."""
    members, ratio, surface = found.members, found.table.ratio(), splash_zone(found.mesh)
    most = int(np.nanargmax(ratio))
    minor = float(found.focus.total[most])

    def medians(values: Float[np.ndarray, " member"]) -> tuple[float, float]:
        return percent(np.nanmedian(values[surface])), percent(np.nanmedian(values[~surface]))

    there, elsewhere = medians(ratio)
    brace = not (members.leg[most] or members.pile[most])
    return [
        Row("member of the largest increase", "5.2, figure 5.1c", "one of the cross bracings",
            members.kind(most), verdict="reproduced" if brace else "not"),
        Row("increase of the members that pass through still water, median", "5.4",
            "most pronounced in the splash zone", there, "%",
            _seed_spread(found, lambda values: medians(values)[0]),
            "reproduced" if surface[most] else "partly" if there > max(elsewhere, 0.0) else "not"),
        Row("increase of all others, median", "5.4", None, elsewhere, "%",
            _seed_spread(found, lambda values: medians(values)[1])),
        Row("total stress of the member of the largest increase, over the largest", "5.2",
            "only a minor contribution", minor, verdict="reproduced" if minor < 0.5 else "not"),
    ]  # fmt: skip


def _leg_rows(found: WaveComparison) -> list[Row]:
    """The heaviest members: focus members 3 and 2."""
    members, focus = found.members, found.focus
    foot = members.leg[focus.heaviest] and members.level[focus.heaviest] < HALF_WAY[0]
    second: Outcome = "reproduced" if focus.rank == 2 else "partly" if focus.lead() > -TIE else "not"
    words = (
        f"{members.kind(focus.half_way)}, number {focus.rank} of all members, {focus.rank_long} of those "
        f"of {SHORT:g} m and more; {focus.total[focus.half_way]:.4f} of the largest "
        f"({members.kind(focus.rival)}: {focus.total[focus.rival]:.4f})"
    )
    return [
        Row("heaviest loaded member", "5.2, figure 5.1a", "the bottom part of one of the legs",
            members.kind(focus.heaviest), verdict="reproduced" if foot else "not"),
        Row("heaviest piece half way down the same leg", "5.2, figure 5.1a",
            "the second heaviest loaded member", words, verdict=second),
    ]  # fmt: skip


def _range_rows(found: WaveComparison) -> list[Row]:
    """Figure 5.2: where in the ranges the difference lies."""
    total = found.table.total(SECOND_ORDER)
    place = int(np.argmax(total[[found.mesh.end_name.index(name) for name in found.leg_end_name]]))

    def more(seeds: list[int], low: int, high: int) -> float:
        two, one = (
            np.mean([found.table.total(w, s, part="leg_ranges")[place, low:high].sum() for s in seeds])
            for w in (SECOND_ORDER, LINEAR)
        )
        return percent(two / one) if one > 0.0 else 0.0  # none to compare with, in short records

    seeds = found.table.seeds(LINEAR)
    rows = []
    for low, high in ((0, 20), (60, 80)):
        each = [more([seed], low, high) for seed in seeds]
        name = f"cycles of {low / 100:g} to {high / 100:g} MPa at {found.leg_end_name[place]}, more by"
        rows.append((name, more(seeds, low, high), (min(each), max(each))))
    pronounced = abs(rows[0][1]) > abs(rows[1][1])
    verdict: Outcome = "reproduced" if pronounced and rows[0][1] > 0.0 else "not"
    words = ("the difference is most pronounced here", "ambivalent")
    return [
        Row(name, "5.2, figure 5.2", word, value, "%", spread, verdict)
        for (name, value, spread), word in zip(rows, words, strict=True)
    ]


def _spectrum_rows(found: WaveComparison) -> list[Row]:
    words = {
        4.5: "a large response round the first two modes, some round modes 3 and 4",
        9.1: "a minor response round the first two modes",
        14.5: "none round the eigenfrequencies",
    }
    rows = []
    for tp, printed in words.items():
        first, third = found.band_share(tp).values()
        fits = {4.5: first > 0.2 and third > 0.005, 9.1: 0.005 < first < 0.3, 14.5: first < 0.03}[tp]
        rows.append(
            Row(f"variance of the stress in focus member 2 at modes 1, 2 and at 3, 4, Tp {tp:g} s",
                "5.2, figure 5.3", printed, f"{first:.1%} and {third:.2%}",
                verdict="reproduced" if fits else "partly")
        )  # fmt: skip
    return rows


def _energy_rows(found: WaveComparison) -> list[Row]:
    factor = [peak.factor[10.0] for peak in found.peaks[LINEAR, CUTOFF]]
    value = float(np.mean(factor))
    low, high = min(factor), max(factor)
    seen = low <= PRINTED_FACTOR <= high
    verdict: Outcome = "reproduced" if seen else agreement(value, PRINTED_FACTOR)
    return [
        Row("kinetic energy of the highest sea state, second order over linear, 20 s round the largest",
            "5.2, figure 5.4", PRINTED_FACTOR, value, "", (low, high), verdict)
    ]  # fmt: skip


def _time_row(found: WaveComparison) -> Row:
    """Another program on another machine: never more than partly."""
    ours = found.seconds[SECOND_ORDER] / found.seconds[LINEAR]
    verdict: Outcome = "not" if agreement(ours, PRINTED_TIME) == "not" else "partly"
    return Row(
        "time of waves and loads, second order over linear", "5.3, table 5.1", PRINTED_TIME, ours,
        verdict=verdict,
    )  # fmt: skip
