"""Report of a campaign: one page that needs nothing but a browser."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
from jaxtyping import Float

from owt_campaign.campaign import RESULTS, CampaignResult
from owt_campaign.campaign_figures import (
    NAMES,
    by_direction,
    by_sea_state,
    exceedance_of_orders,
    orders_compared,
)
from owt_campaign.totals import YEAR_S, OrderTotals
from owt_model.mesh import Mesh
from owt_postproc.figures_jacket import jacket
from owt_postproc.plot_style import Figure
from owt_postproc.report import ends_table
from owt_postproc.report_data import mesh_geometry
from owt_postproc.report_html import Cell, facts, figure, page, power_cell, table, text, tiles, write_page
from owt_postproc.report_measures import DesignLife, power
from owt_postproc.report_usage import Usage, usage_of

__all__ = ["write_report"]

REPORT = "report.html"
#: Rows of a table that appear on paper.
PRINTED = 30


def write_report(result: CampaignResult, folder: Path, warnings: Sequence[str] = ()) -> Path | None:
    """Write the page of a campaign; None if it has no outcome.

    Parameters
    ----------
    result : CampaignResult
        The campaign.
    folder : Path
        Where its results are.
    warnings : sequence of str
        What else the reader has to know.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    if result.sample is None or result.mesh is None or not result.totals:
        (folder / REPORT).unlink(missing_ok=True)
        return None
    return write_page(_Report(result, result.mesh, folder, warnings).page(), folder / REPORT)


class _Report:
    """What the parts of the page share."""

    def __init__(self, result: CampaignResult, mesh: Mesh, folder: Path, warnings: Sequence[str]) -> None:
        assert result.sample is not None  # of write_report
        self.result, self.mesh, self.sample, self.warnings = result, mesh, result.sample, warnings
        self.order = max(result.totals)
        self.total = result.totals[self.order]
        fatigue = self.sample.case.fatigue
        self.design = DesignLife(fatigue.design_life_years, fatigue.design_fatigue_factor)
        self.usage = _yearly_usage(self.sample.fatigue, mesh, self.total)
        self.spot = self.usage.most_used
        self.spot_name = self.usage.spot_name[self.spot]
        self.both = set(result.compared) == {1, 2}
        self.spread = _seed_spread(folder / RESULTS, result, self.order, self.spot)

    def page(self) -> str:
        """The page as text."""
        plan, figures = self.result.plan, self._figures()
        by_key = {shown.key: figure(shown) for shown in figures}
        pair = [f'<section class="pair">{by_key["sea-states"]}{by_key["directions"]}</section>']
        if "orders" in by_key:
            pair.append(f'<section class="pair">{by_key["orders"]}{by_key["exceedance"]}</section>')
        else:
            pair.append(by_key["exceedance"])
        body = [
            self._warnings(),
            tiles(self._head()),
            f"<h2>Damage over the structure, {NAMES[self.order]}</h2>",
            '<p class="note">Sums of a year: the mean over the seeds of each sea state, by its probability. '
            "The damage of each hot spot is added up before the largest of an end is looked for.</p>",
            by_key["jacket"],
            "<h2>What contributes</h2>",
            *pair,
            "<h3>Sea states</h3>",
            self._sea_states(),
            "<h3>Member ends</h3>",
            ends_table(self.usage, self.design),
            self._failed(),
            "<h2>Campaign</h2>",
            facts(self._facts()),
        ]
        name = Path(plan.table.name).name
        subtitle = f"{self.mesh.structure.name}, {self.sample.reduction}, {len(plan.table.rows)} sea states"
        return page(
            f"Campaign {name}",
            f"{subtitle} · structure {self.mesh.structure.content_hash[:16]}",
            body,
            figures,
        )

    def _figures(self) -> list[Figure]:
        plan, shown = self.result.plan, self.result.compared if self.both else self.result.totals
        level = self.mesh.node_position[self.mesh.member_node.ravel(), 2]
        found = [
            jacket(self.usage, mesh_geometry(self.mesh), self.design),
            by_sea_state(plan.table, self.total, self.spot, self.spot_name),
            by_direction(plan.table, shown, self.spot, self.spot_name),
            exceedance_of_orders(shown, self.spot, self.spot_name, self.usage.range_edge),
        ]
        if self.both:
            stretching = self.sample.case.wave.stretching
            found.append(
                orders_compared(shown, self.usage.worst_spot, self.usage.end_name, level, stretching)
            )
        return found

    def _warnings(self) -> str:
        result, lines = self.result, []
        if result.plan.occurrence.assumed:
            lines.append(f"The probabilities are an assumption. {result.plan.occurrence.source}")
        if result.failed:
            lines.append(
                f"{len(result.failed)} cases failed and are not counted; they are listed below. Of a sea "
                "state that lacks some seeds the mean of the others counts; high seas fail first"
            )
            if self.both and any(
                result.compared[o].covered < total.covered for o, total in result.totals.items()
            ):
                lines.append(
                    "Second order is compared with linear waves over the cases that both of them finished, "
                    f"with a probability of {self.result.compared[2].covered:.4g} together"
                )
        if self.total.covered < 1.0 - 1e-6:
            lines.append(
                f"The sea states that count have a probability of {self.total.covered:.4g} together, not 1"
            )
        without = len(result.plan.occurrence.without)
        if without:
            lines.append(f"{without} rows of the table have no probability and count nothing")
        lines.extend(self.warnings)
        items = "".join(f"<li>{text(line)}</li>" for line in lines)
        return f'<div class="warning" role="alert"><ul>{items}</ul></div>' if lines else ""

    def _head(self) -> list[tuple[str, str]]:
        rows = [
            ("most damaged hot spot", self.spot_name),
            (
                f"its damage in a year, {NAMES[self.order]}{self._error()}",
                power(float(self.total.damage_per_year[self.spot])),
            ),
            (f"its life, design fatigue factor {self.design.factor:g}", _years(self._life(self.total))),
        ]
        if self.both:
            first, second = (float(self.result.compared[o].damage_per_year[self.spot]) for o in (1, 2))
            ratio = second / first if first else np.nan
            rows.append(("its damage, second order over linear", f"{ratio:.3f}"))
        cases = self.result.computed + self.result.reused
        return [*rows, ("cases finished, failed", f"{cases}, {len(self.result.failed)}")]  # fmt: skip

    def _error(self) -> str:
        relative = self.total.relative_error(self.spot)
        return f" (standard error {relative:.1%}, by the seeds)" if np.isfinite(relative) else ""

    def _life(self, total: OrderTotals) -> float:
        return float(total.life_years(self.design.factor)[self.spot])

    def _sea_states(self) -> str:
        plan, totals = self.result.plan, self.result.totals
        whole = float(self.total.damage_per_year[self.spot])
        both = set(totals) == {1, 2}
        rows: list[list[Any]] = []
        for i, row in enumerate(plan.table.rows):
            damage = float(self.total.row_damage_per_year[i, self.spot])
            first = float(totals[1].row_damage_per_year[i, self.spot]) if both else 0.0
            rows.append([
                row.row, row.hs_m, row.tp_s, row.direction_deg, float(plan.occurrence.probability[i]),
                power_cell(damage), 100.0 * damage / whole if whole else 0.0,
                *([_number(damage / first if first else np.nan)] if both else []),
                _number(100.0 * self.spread[i]),
            ])  # fmt: skip
        rows.sort(key=lambda row: -row[6])
        head = [
            "row", "Hs, m", "Tp, s", "from, °", "probability", "damage in a year", "share, %",
            *(["second order / linear"] if both else []), "spread over seeds, %",
        ]  # fmt: skip
        caption = (
            f"At {self.spot_name}. Spread: standard deviation of the damage over the seeds, over their mean."
        )
        return table("sea-states", head, rows, caption=caption, printed=PRINTED)

    def _failed(self) -> str:
        failed = self.result.failed
        if not failed:
            return ""
        plan = self.result.plan
        rows = [[plan.name(place), message] for place, message in failed.items()]
        return "<h3>Cases that failed</h3>" + table(
            "failed", ["case", "why"], rows, caption="Not counted.", printed=PRINTED
        )

    def _facts(self) -> list[tuple[str, Any]]:
        result, plan, case = self.result, self.result.plan, self.sample.case
        rows: list[tuple[str, Any]] = [
            ("load-case table", plan.table.name),
            ("probability", plan.occurrence.source),
            ("seeds", ", ".join(map(str, plan.seeds))),
            ("wave orders", ", ".join(NAMES[order] for order in plan.orders)),
            ("stretching", case.wave.stretching),
            ("duration of each case", f"{case.time.duration_s:g} s"),
            ("structure, reduction", f"{self.mesh.structure.name}, {self.sample.reduction}"),
            ("S-N curve", self.sample.fatigue.curve.name),
            ("cases", f"{result.computed} computed, {result.reused} reused, {len(result.failed)} failed"),
        ]
        if result.seconds:
            rows.append(("time per case in its worker", f"{np.mean(result.seconds):.2f} s"))
            rows.append(("largest memory of a worker", f"{max(result.peak_memory_mib):.0f} MiB"))
        return rows


def _number(value: float) -> Cell:
    """A number that may be missing."""
    return Cell(f"{value:.3g}", float(value)) if np.isfinite(value) else Cell("–", 0.0)


def _years(years: float) -> str:
    if not np.isfinite(years):
        return "unlimited"
    return f"{years:.3g} years" if years < 999.5 else f"{power(years)} years"


def _yearly_usage(fatigue: Any, mesh: Mesh, total: OrderTotals) -> Usage:
    """What a year of the campaign does to each spot."""
    return replace(
        usage_of(fatigue, mesh.end_name),
        damage=total.damage_per_year,
        cycles=total.cycles_per_year.sum(axis=1),
        max_range=total.max_range,
        histogram=total.cycles_per_year,
        total_stress=total.total_stress_per_year,
        von_mises_cycles=total.von_mises_cycles_per_year,
        duration_s=YEAR_S,
    )


def _seed_spread(path: Path, result: CampaignResult, order: int, spot: int) -> Float[np.ndarray, " row"]:
    """Standard deviation over mean of the damage of a spot over the seeds of each row; NaN below two."""
    plan = result.plan
    with h5netcdf.File(path, "r") as file:
        damage = np.asarray(file["damage"][:, :, plan.orders.index(order), spot])
        done = np.asarray(file["status"][:, :, plan.orders.index(order)]) == 0
    spread = np.full(len(damage), np.nan)
    for row, (values, there) in enumerate(zip(damage, done, strict=True)):
        if there.sum() > 1 and values[there].mean() > 0.0:
            spread[row] = values[there].std(ddof=1) / values[there].mean()
    return spread
