"""Damage, load factors, error estimates, sampling and seeds as a page."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from owt_campaign.studies.beyond import HEAVIEST, MANY_SEEDS, Beyond, beyond_study, estimate_quality
from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, rows_table, table
from owt_campaign.studies.sampling import RELEVANT, pilots, proxies
from owt_campaign.studies.sea_table import occurrence
from owt_campaign.studies.stress_runs import REDUCTION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["NAME", "result", "run"]

NAME = "beyond"
_TITLE = "Beyond the thesis: damage, load factors, error estimates, sampling, seeds (chapter 7.3)"
_HEAD = """\
What the thesis recommends in chapter 7.3, from the runs of the [wave comparison](wave-comparison.md) and
of the [reduction](reduction.md). Damage is the Palmgren-Miner sum of the hot-spot stress (Efthymiou's
factors, DNV-RP-C203 curve T in seawater with cathodic protection), sea states by their probability with
the assumed wave rose. Second order: Taylor expansion; linear: constant extrapolation unless another one
is named; cut-off 4 omega_p."""
#: Joints that the table shows, and seconds of a year.
SHOWN, YEAR_S = 12, 3.15576e7


def run(*, full: bool, progress: Progress) -> StudyResult:
    """Run the study."""
    return result(beyond_study(full=full, progress=progress), full=full)


def result(found: Beyond, *, full: bool) -> StudyResult:
    """Put what is asked and what is found side by side."""
    rows = [*_damage_rows(found), *_estimate_rows(found), *_sampling_rows(found), *_seed_rows(found)]
    return StudyResult(
        name=NAME,
        title=_TITLE,
        sections=_sections(found, rows),
        rows=rows,
        verdict=_verdict(found),
        full=full,
        figures={"joints": partial(_joints_figure, found), "sampling": partial(_sampling_figure, found)},
        data={
            "joints": [vars(joint) for joint in found.joints],
            "sea_states_needed": {name: vars(of) for name, of in found.sampling.items()},
            "variation_of_the_heaviest": dict(found.variation),
            "joint_half_width": found.joint_half_width.tolist(),
            "worst_hot_spot": found.joints[0].spot,
            "cell_damage": {
                wave: [
                    [cell.hs_m, cell.from_deg, cell.tp_s, float(f"{damage:.6g}")]
                    for cell, damage in found.cell_damage(1, wave).items()
                ]
                for wave in (LINEAR, SECOND_ORDER)
            },
            "estimate": estimate_quality(found.errors),
            "basis_errors": {name: vars(errors) for name, errors in found.basis.items()},
            "runs": found.table.counts,
        },
    )


def _percent(ratio: float | np.floating[Any]) -> float:
    """Increase in percent."""
    return 100.0 * (float(ratio) - 1.0)


def _stress_increase(found: Beyond, seed: int | None = None) -> float:
    """Mean increase of the total stress over the members in percent."""
    return 100.0 * (float(np.nanmean(found.table.ratio(seed))) - 1.0)


def _damage_rows(found: Beyond) -> list[Row]:
    some = found.relevant()
    factor = [joint.factor for joint in some]
    worst = found.joints[0]
    stress = [_stress_increase(found, seed) for seed in found.table.seeds(LINEAR)]
    return [
        Row("increase of the total stress by the second order, mean of the members", "7.3.1", None,
            _stress_increase(found), "%", (min(stress), max(stress))),
        Row(f"increase of the damage, mean of {len(some)} joints' worst hot spots", "7.3.1", None,
            _percent(np.mean([joint.ratio for joint in some])), "%",
            (_percent(np.mean([j.spread[0] for j in some])), _percent(np.mean([j.spread[1] for j in some])))),
        Row(f"increase of the damage at the worst hot spot, {worst.spot}", "7.3.1", None,
            _percent(worst.ratio), "%", (_percent(worst.spread[0]), _percent(worst.spread[1]))),
        Row("load factor on linear waves, worst hot spot", "7.3.2", None,
            worst.factor, "", worst.factor_spread),
        Row("the same, smallest and largest of the joints", "7.3.2", None,
            f"{min(factor):.3f} to {max(factor):.3f}"),
    ]  # fmt: skip


def _estimate_rows(found: Beyond) -> list[Row]:
    quality, rows = estimate_quality(found.errors), []
    for name, values in quality.items():
        words = "a relation to the response error would be more interesting"
        rows.append(
            Row(f"true over estimated error of the mean energy, {name}, median and largest", "7.3.2", words,
                f"{values['median ratio']:.2f}, {values['largest ratio']:.2f}; estimate not exceeded in "
                f"{values['covered']:.0%}")
        )  # fmt: skip
    return rows


def _best(found: Beyond) -> str:
    """Weights whose largest sea states give the damage of the joints with the fewest runs."""
    return min(found.sampling, key=lambda name: found.sampling[name].joints)


def _sampling_rows(found: Beyond) -> list[Row]:
    best, total = _best(found), len(found.cell_damage())
    needed = found.sampling[best]
    return [
        Row(f"sea states for the damage within 5 %, those of largest {best}, worst hot spot", "7.3.1", None,
            float(needed.largest), f"of {total}", needed.seeds),
        Row("the same, joints, median and most", "7.3.1", None,
            f"{needed.joints[0]:.0f}, {needed.joints[1]}"),
        Row("draws for the same, sea states drawn by probability, worst hot spot", "7.3.1", None,
            float(np.ceil(found.sampling["probability"].draws))),
        Row("sea states of largest contribution that hold 95 % of the damage", "7.3.1", None,
            f"{_holding(found)} of {total}"),
    ]  # fmt: skip


def _seed_rows(found: Beyond) -> list[Row]:
    s, variation = found.scatter, found.variation
    return [
        Row("damage of one record from seed to seed, coefficient of variation", "4.4.1", None, s.pooled),
        Row(f"95 % interval, {len(s.variation)} sea states with {s.seeds} seeds, bootstrap", "4.4.1",
            "three seeds improve statistical stability", f"+-{s.half_width:.1%}"),
        Row("seeds per sea state for the table's damage within 5 %", "4.4.1", None,
            float(np.ceil(s.needed_table))),
        Row(f"the same interval at the worst hot spots of {len(found.joint_half_width)} joints, median and "
            "largest", "4.4.1", None,
            f"+-{np.median(found.joint_half_width):.1%}, {found.joint_half_width.max():.1%}"),
        Row(f"damage of the {HEAVIEST} heaviest sea states together, coefficient of variation", "4.4.1", None,
            variation["own"]),
        Row("the same, all sea states with the phases of their seed", "4.4.1", None, variation["shared"]),
        Row("seeds for a single sea state's damage within 5 %", "4.4.1", None, float(np.ceil(s.needed_cell))),
    ]  # fmt: skip


def _parts(found: Beyond) -> tuple[list[Any], np.ndarray]:
    damage = found.cell_damage()
    part = occurrence(list(damage)) * np.array(list(damage.values()))
    return list(damage), part / part.sum()


def _holding(found: Beyond) -> int:
    _, part = _parts(found)
    return int(np.searchsorted(np.cumsum(np.sort(part)[::-1]), 0.95)) + 1


def _joint_table(found: Beyond) -> str:
    lines = [
        [j.name, f"{j.level:.0f}", j.kind, j.spot, f"{j.damage * YEAR_S / 600.0:.2g}",
         f"{100.0 * (j.ratio - 1.0):+.1f} ({100.0 * (j.spread[0] - 1.0):+.1f} to "
         f"{100.0 * (j.spread[1] - 1.0):+.1f})",
         f"{j.factor:.3f} ({j.factor_spread[0]:.3f} to {j.factor_spread[1]:.3f})"]
        for j in found.joints[:SHOWN]
    ]  # fmt: skip
    head = [
        "joint",
        "z [m]",
        "class",
        "worst hot spot",
        "damage a year",
        "damage of the second order [%]",
        "load factor",
    ]
    return table(head, lines)


def _linear_table(found: Beyond) -> str:
    """Increase of the damage and load factor over each linear model."""
    lines = []
    for wave in found.by_linear:
        joints = found.relevant(wave)
        worst = joints[0]
        ratio, factor = (np.array([getattr(joint, of) for joint in joints]) for of in ("ratio", "factor"))
        lines.append(
            [wave, f"{_percent(worst.ratio):+.1f} ({_percent(worst.spread[0]):+.1f} to "
             f"{_percent(worst.spread[1]):+.1f})", f"{worst.factor:.3f}", f"{_percent(ratio.mean()):+.1f}",
             f"{_percent(ratio.min()):+.1f} to {_percent(ratio.max()):+.1f}",
             f"{factor.min():.3f} to {factor.max():.3f}"]
        )  # fmt: skip
    head = ["linear model", "worst hot spot [%]", "load factor", "mean of the joints [%]", "joints [%]",
            "load factors"]  # fmt: skip
    return table(head, lines)


def _sampling_table(found: Beyond) -> str:
    lines = [
        [name, f"{np.ceil(of.draws):.0f}", str(of.largest), f"{of.seeds[0]} to {of.seeds[1]}",
         f"{of.joints[0]:.0f}", str(of.joints[1])]
        for name, of in found.sampling.items()
    ]  # fmt: skip
    head = ["chosen by", "draws", "largest weights", "single seeds", "median of the joints", "most"]
    return table(head, lines)


def _estimate_table(found: Beyond) -> str:
    lines = []
    for name, values in estimate_quality(found.errors).items():
        left = values.get("median ratio, energy left out")
        lines.append(
            [name, f"{100.0 * values['largest true error']:.2g} %", f"{values['covered']:.0%}",
             f"{values['median ratio']:.2f}", f"{values['largest ratio']:.2f}",
             "-" if left is None else f"{left:.3f}"]
        )  # fmt: skip
    head = [
        "basis",
        "largest true error",
        "covered",
        "median ratio",
        "largest ratio",
        "median ratio to the energy left out",
    ]
    return table(head, lines)


def _basis_section(found: Beyond) -> str:
    """Stress and damage by reduced models."""
    lines = [
        [name, *(f"{100.0 * value:.2g}" for value in vars(errors).values())]
        for name, errors in found.basis.items()
    ]
    head = ["basis", "energy", "stress, largest", "median", "its ratio", "damage, largest", "its ratio",
            "most damaged spot"]  # fmt: skip
    cells = ", ".join(f"{cell.hs_m:g} m from {cell.from_deg:g} degrees" for cell in found.basis_cells)
    return (
        "## What the error of the energy hides\n\nThesis chapter 6 judges reduced models by the energy of "
        "the whole turbine. Errors against the unreduced model in percent, with load vectors of each run's "
        f"own loads, the largest one over the sea states (Hs {cells}), linear and second order: mean "
        "potential energy; total stress of a member end, largest and median of the ends, and its ratio "
        "second order over linear; damage of a joint's worst hot spot, its ratio, and damage of the most "
        "damaged spot. Bending of single braces under the waves on them adds next to nothing to the energy, "
        f"but it is what some hot spots live on.\n\n{table(head, lines)}\n\nThis page and the "
        f"wave comparison use {REDUCTION}."
    )


def _sections(found: Beyond, rows: list[Row]) -> list[str]:
    return [
        _HEAD,
        f"Runs: {found.table.described}.",
        "## What is asked and what is found\n\n" + rows_table(rows),
        "## Damage of second-order over linear waves\n\nAt each joint the hot spot of most damage; range: "
        "single seeds. The load factor multiplies the stress of the linear waves so that they give the "
        "damage of the second order (counted ranges, both slopes of the S-N curve).\n\n"
        + _joint_table(found),
        f"![damage ratio and load factor over the joints]({NAME}-joints.png)",
        f"Over each linear model, the {len(found.relevant())} of {len(found.joints)} joints that have more "
        f"than {RELEVANT:.0%} of the largest damage:\n\n" + _linear_table(found),
        "## Error estimate against the truth\n\nError of the mean potential energy as estimated from the "
        "loads alone ([error estimate](../error_estimate.md)) against the true one, all runs of the "
        "reduction study; ratios are true / estimated. The last column takes the share of the loads' energy "
        "that the load vectors leave out (1 - sum of the proper orthogonal values), which chapter 7.3.2 "
        "suggests, as the estimate.\n\n" + _estimate_table(found),
        "## How few sea states\n\n*Draws*: sea states drawn with these weights, for an error below 5 % with "
        "95 % confidence at the worst hot spot (each may be drawn more than once). *Largest weights*: the "
        "sea states of largest weight are run, the damage of the others is added in proportion to the "
        "weights; how many are needed until the error stays below 5 %, at the worst hot spot by the mean of "
        f"the seeds and by single ones, and at those of the {len(found.relevant())} joints above. The "
        "regression of the damage of the worst hot spot on Hs and Tp is fitted to "
        f"{len(pilots(len(found.cell_damage())))} of them, whose runs come on top.\n\n"
        f"{_sampling_table(found)}\n\nRandom draws are more than the table has sea states, so that running "
        "a part of it is the better way. Which weights are best is told by the answer only, and a number "
        f"that suffices for one hot spot does not for another. Knowing the answer, {_holding(found)} sea "
        "states hold 95 % of the damage of the worst hot spot.",
        f"![contributions of the sea states]({NAME}-sampling.png)",
        _basis_section(found),
        _seed_section(found),
    ]


def _seed_section(found: Beyond) -> str:
    s, variation = found.scatter, found.variation
    return (
        f"## Seeds\n\nDamage of one record at the worst hot spot scatters by {s.pooled:.0%} "
        "(coefficient of variation, sea states by their share of the damage; median "
        f"{np.median(s.variation):.0%}, largest {s.variation.max():.0%}). Bootstrap over the seeds: with "
        f"{s.seeds} seeds of {len(s.variation)} sea states the 95 % interval of their damage is "
        f"+-{s.half_width:.1%}; {np.ceil(s.needed_table):.0f} seeds of each make it +-5 %. One sea state "
        f"alone needs {np.ceil(s.needed_cell):.0f}.\n\nThat holds since every sea state has random phases "
        "of its own. With the same phases in all sea states of a seed their records are large or small "
        f"together, neighbours most of all: the damage of the {HEAVIEST} sea states of largest contribution "
        f"together varies by {variation['shared']:.0%} from seed to seed instead of {variation['own']:.0%} "
        f"({MANY_SEEDS} seeds), and more sea states do not average it out. Campaigns and studies give each "
        "sea state its own.\n\nThe worst hot spot lives on many sea states, others on "
        f"few: at the worst ones of {len(found.joint_half_width)} joints the interval is "
        f"+-{np.median(found.joint_half_width):.1%} in the median and {found.joint_half_width.max():.1%} at "
        "most (variances of the sea states added up)."
    )


def _verdict(found: Beyond) -> Verdict:
    some, best = found.relevant(), _best(found)
    quality = estimate_quality(found.errors)
    covered = np.mean([values["covered"] for values in quality.values()])
    over = {wave.removeprefix("linear, "): joints[0] for wave, joints in found.by_linear.items()}
    expected = [wave for wave, joint in over.items() if joint.factor > 1.0]
    outcome: Outcome = "not" if not expected else "partly" if len(expected) < len(over) else "reproduced"
    needed = found.sampling[best]
    why = (
        "Of all this the thesis prints the expectation only that linear waves underestimate (7.3.2). The "
        "second order changes the damage of the worst hot spot by "
        + ", ".join(f"{_percent(joint.ratio):+.1f} % over {wave}" for wave, joint in over.items())
        + " (load factors "
        + ", ".join(f"{joint.factor:.3f}" for joint in over.values())
        + f"), that of {len(some)} joints over constant by "
        f"{_percent(np.mean([joint.ratio for joint in some])):+.1f} % on average (stress: "
        f"{_stress_increase(found):+.1f} %): the underestimation is "
        + (f"there with {' and '.join(expected)}" if expected else "not there")
        + (" only" if 0 < len(expected) < len(over) else "")
        + ". The error estimate is not exceeded in "
        f"{covered:.0%} of the runs. The {needed.largest} sea states of largest {best} give the damage of "
        f"the worst hot spot within 5 %, {needed.joints[0]:.0f} that of half of the joints, "
        f"{needed.joints[1]} that of all; drawing them at random takes more draws than the table has sea "
        f"states. {np.ceil(found.scatter.needed_table):.0f} seeds per sea state give the table's damage "
        f"within 5 % at the worst hot spot (half of the joints: {np.median(found.joint_half_width):.0%} with "
        f"{found.scatter.seeds}) if each sea state has phases of its own. With phases that all "
        f"share, the {HEAVIEST} heaviest together scatter by {found.variation['shared']:.0%} instead of "
        f"{found.variation['own']:.0%}, and more sea states do not help."
    )
    return Verdict(outcome, why)


def _joints_figure(found: Beyond) -> Figure:
    from owt_campaign.studies.plotting import BLUE, INK, ORANGE, canvas

    figure, panels = canvas(1, 2, (9.0, 3.8), share_y=True)
    level = [joint.level for joint in found.joints]
    panels[0, 0].plot(
        [100.0 * (j.ratio - 1.0) for j in found.joints], level, ls="", marker="o", ms=4, color=BLUE
    )
    panels[0, 0].set(xlabel="damage, second order over linear [%]", ylabel="z of the joint [m]")
    panels[0, 1].plot([j.factor for j in found.joints], level, ls="", marker="o", ms=4, color=ORANGE)
    panels[0, 1].set(xlabel="load factor on linear waves")
    panels[0, 0].axvline(0.0, color=INK, lw=0.8)
    panels[0, 1].axvline(1.0, color=INK, lw=0.8)
    return figure


def _sampling_figure(found: Beyond) -> Figure:
    from owt_campaign.studies.plotting import BLUE, COLOURS, INK, canvas

    figure, panels = canvas(1, 2, (9.5, 3.4))
    cells, part = _parts(found)
    panels[0, 0].scatter(
        [c.hs_m for c in cells], [c.tp_s for c in cells], s=2000.0 * part, color=BLUE, alpha=0.5
    )
    for percent in (1, 3, 10):
        panels[0, 0].scatter([], [], s=20.0 * percent, color=BLUE, alpha=0.5, label=f"{percent} %")
    panels[0, 0].legend(title="of the damage", loc="lower right")
    panels[0, 0].set(xlabel="Hs [m]", ylabel="Tp [s]", title="share of the damage (area)")
    damage = found.cell_damage()
    for colour, (name, weight) in zip(COLOURS, proxies(damage).items(), strict=False):
        order = np.argsort(weight)[::-1]
        estimate = np.cumsum(part[order]) / np.cumsum(weight[order])
        panels[0, 1].plot(np.arange(1, len(order) + 1), estimate, color=colour, lw=1.0, label=name)
    panels[0, 1].axhspan(0.95, 1.05, color=INK, alpha=0.1, lw=0)
    panels[0, 1].set(
        xlabel="sea states of largest weight that are run",
        ylabel="estimated damage, over the true one",
        ylim=(0.0, 2.5),
    )
    panels[0, 1].legend()
    return figure
