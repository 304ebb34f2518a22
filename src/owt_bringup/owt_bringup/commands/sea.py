"""``owt sea``: statistics and regime of the sea of a case."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from owt_wave_node.core.sea_report import SeaReport

HELP = "statistics of the sea of a case, wave theory and load regime, with warnings"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("case", type=Path, metavar="CASE.json", help="case file")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="also write that object to a file")


def run(options: argparse.Namespace) -> int:
    """Print the report as a table or as JSON."""
    from owt_bringup.output import write_json
    from owt_bringup.results import print_table
    from owt_bringup.sea_notes import load_reported_case, print_warnings
    from owt_model.structure import case_structure

    case, source = load_reported_case(options.case)
    structure = case_structure(case.structure)
    from owt_wave_node.core.sea_report import sea_report

    report = sea_report(case, structure)
    data = report.as_dict()
    data["source"] = None if source is None else {"kind": source.source, **source.numbers}
    if options.output is not None:
        write_json(options.output, data)
    if options.json:
        print(json.dumps(data, allow_nan=False))
        return 0
    print_table(_rows(report))
    print()
    print("\n".join(_members(report)))
    print_warnings(case, structure)
    return 0


def _rows(report: SeaReport) -> list[tuple[str, str]]:
    """What a user wants to see of the sea."""
    regime = report.regime
    wave, largest = regime.wave, regime.largest
    regular = report.spectrum is None
    rows: list[tuple[str, str]] = []
    if report.spectrum is not None:
        s = report.spectrum
        moments = ", ".join(f"m{n} {s.m(n):.4g}" for n in range(-1, 5))
        rows += [
            ("significant wave height Hm0", f"{s.hm0_m:.3f} m"),
            ("periods Tp, Tm-10, Tm01, Tm02",
             f"{s.peak_period_s:.2f}, {s.tm10_s:.2f}, {s.tm01_s:.2f}, {s.tm02_s:.2f} s"),
            ("spectral moments, m2 Hz^n", moments),
            ("bandwidth nu, epsilon", f"{s.width:.3f}, {s.broadness:.3f}"),
        ]  # fmt: skip
    if report.first is not None:
        rows += [(f"record, first order: {label}", text) for label, text in _record(report.first)]
    kind = "record" if regular else "record, total"
    rows += [(f"{kind}: {label}", text) for label, text in _record(report.total)]
    rows += [(f"crest exceeded by {p:g} of the waves", _crests(row)) for p, row in report.crests.items()]
    rows += [
        (
            "regular wave" if regular else "wave of Hs and Tp",
            f"H {wave.height_m:.3g} m, T {wave.period_s:.3g} s, L {wave.length_m:.4g} m",
        ),
        (
            "depth d/L, Ursell number H L^2/d^3",
            f"{wave.relative_depth:.3f} ({wave.water}), {wave.ursell:.3g}",
        ),
        ("wave theory", wave.theory),
        ("breaking height (Miche, 0.78 d)", f"{wave.breaking_height_m:.3g} m"),
    ]
    if regular:
        return [*rows, ("steepness H/L", f"{wave.steepness:.4f}")]
    return [
        *rows,
        ("steepness H/L, 2 pi Hs/(g Tp^2)", f"{wave.steepness:.4f}, {regime.sea_steepness:.4f}"),
        (f"largest of {regime.n_waves:.0f} waves", f"H {largest.height_m:.3g} m: {largest.theory}"),
        (
            "cut-off used, sqrt(2 g/Hs)",
            f"{regime.cutoff_rad_s:.3f}, {regime.steepness_cutoff_rad_s:.3f} rad/s",
        ),
    ]


def _record(record: Any) -> list[tuple[str, str]]:
    """Rows of one record."""
    found = record.as_dict()
    text = {name: "-" if value is None else f"{value:z.3f}" for name, value in found.items()}
    return [
        ("mean, 4 std", f"{text['mean_m']}, {text['hm0_m']} m"),
        ("skewness, kurtosis", f"{text['skewness']}, {text['kurtosis']}"),
        ("H1/3, H1/10, Hmax", f"{text['h13_m']}, {text['h110_m']}, {text['hmax_m']} m"),
        ("Tz, highest crest", f"{text['tz_s']} s, {text['highest_crest_m']} m ({found['n_waves']} waves)"),
    ]


def _crests(row: dict[str, float | None]) -> str:
    """One exceedance: counted, and by each distribution."""
    counted = "too few waves to count" if row["counted_m"] is None else f"{row['counted_m']:.2f} m counted"
    models = ", ".join(
        f"{name} {row[f'{name.lower()}_m']:.2f}" for name in ("Rayleigh", "Tayfun", "Forristall")
    )
    return f"{counted}; {models} m"


def _members(report: SeaReport) -> list[str]:
    """The table of members, by diameter."""
    lines = ["diameter [m]  members  L/D    pi D/L  level [m]        KC             Re                 load"]
    for m in report.regime.members:
        levels = f"{m.level_m[0]:.1f} to {m.level_m[1]:.1f}"
        kc = f"{m.keulegan_carpenter[0]:.3g} to {m.keulegan_carpenter[1]:.2g}"
        re = f"{m.reynolds[0]:.2g} to {m.reynolds[1]:.2g}"
        lines.append(
            f"{m.diameter_m:<12.3f}  {m.count:<7d}  {m.length_over_diameter:<5.1f}  {m.diffraction:<6.3f}  "
            f"{levels:<15}  {kc:<13}  {re:<17}  {m.load}"
        )
    return lines
