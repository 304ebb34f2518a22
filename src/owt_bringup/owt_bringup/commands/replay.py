"""``owt replay``: a recorded bag on its topics."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from owt_model.errors import InputError

HELP = "publish the messages of a bag on their topics, paced by simulated time"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("bag", type=Path, metavar="BAG", help="bag folder, finished or not; of any ROS 2 system")
    add(
        "--rate",
        type=float,
        default=1.0,
        metavar="R",
        help="simulated seconds per second; 0 for as fast as reliable subscribers take them (default 1)",
    )
    add(
        "--start",
        type=float,
        default=0.0,
        metavar="S",
        help="begin S seconds after the first message; latched topics are published first in any case",
    )
    add("--duration", type=float, default=None, metavar="S", help="end S seconds after the begin")
    add("--loop", action="store_true", help="begin anew at the end, until Ctrl-C")
    add("--topics", nargs="+", default=None, metavar="TOPIC", help="only these topics")
    add(
        "--clock",
        type=float,
        default=0.0,
        metavar="HZ",
        help="a clock of HZ ticks per simulated second, in the place of the recorded /clock",
    )
    add("--recompute", action="store_true", help="publish whole messages where the bag leaves something out")
    add("--namespace", default="", metavar="NAME", help="publish NAME/owt/model and so on")
    add(
        "--domain",
        type=int,
        default=None,
        metavar="N",
        help="ROS domain (default: that of ROS_DOMAIN_ID, or 0)",
    )
    add("--wait", type=float, default=None, metavar="S",
        help="wait up to S seconds for a subscriber to one of the topics")  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Publish the bag."""
    for name, largest in (("rate", 1e6), ("wait", 1e6)):
        value = getattr(options, name)
        if value is not None and not 0.0 <= value <= largest:
            raise InputError(name, value, f"must lie in 0 to {largest:g}", "See ./owt replay --help.")
    if options.domain is not None and not 0 <= options.domain <= 232:
        raise InputError("domain", options.domain, "must lie in 0 to 232", "Leave it out for ROS_DOMAIN_ID.")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    from owt_bringup.output import ProgressBar
    from owt_bringup.replay import Player, response_message, stop_on_signals
    from owt_bringup.replay_plan import ReplayPlan, Window
    from owt_bringup.transport import quick_acknowledgements
    from owt_postproc.bag_source import BagSource

    bar = ProgressBar("replay")
    with BagSource(options.bag) as bag, quick_acknowledgements() as quick:
        plan = ReplayPlan(
            bag,
            topics=options.topics,
            window=Window(options.start, options.duration),
            clock_hz=options.clock,
            serialize=response_message if options.recompute else None,
        )
        length = plan.length_s

        def show(time_ns: int) -> None:
            if length > 0.0:
                bar.callback(max(time_ns - plan.begin_ns, 0) * 1e-9, length)

        with (
            stop_on_signals() as stop,
            Player(plan, stop, namespace=options.namespace, domain_id=options.domain, quick=quick) as player,
        ):
            if options.wait is not None:
                player.wait_for_subscriber(options.wait)
            complete = player.play(options.rate, rounds=None if options.loop else 1, progress=show)
    bar.close()
    print(f"{player.published} messages on {len(plan.topics)} topics")
    if complete or options.loop:
        return 0
    print("error: interrupted", file=sys.stderr)
    return 130
