"""``owt report``: the same as ``owt analyse``, by its older name."""

from __future__ import annotations

from owt_bringup.commands.analyse import add_arguments, run

__all__ = ["HELP", "add_arguments", "run"]

HELP = "the same as analyse"
