"""``owt campaign``: a load-case table or a scatter diagram on Dask."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from owt_model.errors import InputError

if TYPE_CHECKING:
    from owt_campaign.plan import CampaignPlan

HELP = "a load-case table or scatter diagram: every sea state, seed and wave order, on Dask"
ORDERS = {"1": (1,), "2": (2,), "both": (1, 2)}
CLUSTERS = ("spec", "dir", "hs", "tot")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from owt_bringup.case_flags import add_case_flags

    parser.add_argument(
        "table", type=Path, metavar="TABLE.csv",
        help="load-case table with columns hs_m, direction_deg, tp_s, or scatter diagram: every cell runs",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="folder to write into"
    )
    parser.add_argument(
        "--seeds", type=int, default=3, metavar="N", help="seeds of each sea state (default 3)"
    )
    parser.add_argument(
        "--workers", type=int, metavar="N",
        help="processes on this machine; 0 for none but this (default: one per processor)",
    )  # fmt: skip
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="Dask scheduler to use instead, tcp://HOST:PORT"
    )
    parser.add_argument("--resume", action="store_true", help="go on with the campaign in DIR")
    parser.add_argument("--overwrite", action="store_true", help="remove the campaign in DIR first")
    parser.add_argument(
        "--clustering", choices=CLUSTERS, default="spec",
        help="cases that share load vectors: none, those of a direction, of a height, or all (default spec)",
    )  # fmt: skip
    parser.add_argument(
        "--errors-against",
        choices=("full",),
        help="also run the unreduced model, for the errors of the reduced one",
    )
    parser.add_argument(
        "--rose", type=Path, metavar="ROSE.csv",
        help="wave rose for the probabilities of a table (default: its column probability or occurrence; "
        "without one an assumed rose)",
    )  # fmt: skip
    add_case_flags(parser, without=("hs", "tp", "direction", "order", "rate"))
    parser.add_argument(
        "--order",
        dest="orders",
        choices=tuple(ORDERS),
        help="order of the waves (default 2, or the case file's)",
    )


def _plan(options: argparse.Namespace) -> CampaignPlan:
    """The cases that the command line asks for."""
    from owt_bringup.case_flags import case_from_flags
    from owt_campaign.load_cases import read_load_cases
    from owt_campaign.occurrence import read_rose, table_occurrence
    from owt_campaign.plan import make_plan
    from owt_campaign.scatter import build_table, is_scatter, read_scatter

    if options.orders is not None:  # Wheeler's stretching, for one, goes with one of them only
        options.order = max(ORDERS[options.orders])
    case = case_from_flags(options)
    if case.sea_state is None or case.live is not None:
        raise InputError(
            "--case",
            str(options.case),
            "must leave the sea to the table",
            "Give a case file with sea_state or none.",
        )
    scatter = is_scatter(options.table)
    table = build_table(read_scatter(options.table), "full") if scatter else read_load_cases(options.table)
    rose = None if options.rose is None else read_rose(options.rose)
    orders = (case.wave.order,) if options.orders is None else ORDERS[options.orders]
    return make_plan(
        table,
        table_occurrence(table, rose),
        case.model_dump(mode="json", exclude_unset=True),
        seeds=options.seeds,
        orders=orders,
        against_full=options.errors_against is not None,
    )


def run(options: argparse.Namespace) -> int:
    """Run the campaign and write its results."""
    from owt_bringup.campaign_output import CampaignProgress, print_outcome, summary, warning_lines
    from owt_bringup.output import write_json
    from owt_campaign.campaign import campaign_folder, run_campaign
    from owt_campaign.campaign_report import write_report
    from owt_campaign.runner import check_workers
    from owt_model.versions import versions

    workers = len(os.sched_getaffinity(0)) if options.workers is None else options.workers
    plan = _plan(options)
    check_workers(workers, options.scheduler)
    with campaign_folder(options.output, resume=options.resume, overwrite=options.overwrite) as folder:
        arguments = {
            key: value for key, value in sorted(vars(options).items()) if key not in ("run", "command")
        }
        write_json(folder / "campaign.json", {"arguments": {k: _plain(v) for k, v in arguments.items()}})
        with CampaignProgress(len(plan.cases)) as progress:
            result = run_campaign(
                plan,
                folder,
                workers=workers,
                scheduler=options.scheduler,
                cluster=options.clustering,
                attributes={f"version_{name}": text for name, text in versions().items()},
                on_start=progress.started,
                on_done=progress.done,
            )
        numbers = summary(result, progress.elapsed)
        write_json(folder / "summary.json", numbers)
        write_report(result, folder, warning_lines(numbers))
        print_outcome(result, numbers, folder)
    return 1 if result.failed else 0


def _plain(value: object) -> object:
    return str(value) if isinstance(value, Path) else value
