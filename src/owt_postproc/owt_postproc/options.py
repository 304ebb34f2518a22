"""Parameters of the postproc node besides the case."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from owt_model.config import CaseConfig
from owt_ros.options import NodeOptions
from owt_ros.selection import Selection

__all__ = ["PostprocOptions", "selection_of"]


class PostprocOptions(NodeOptions):
    """Parameters of the postproc node besides the case."""

    bag: str = Field("", description="folder to record into; it gets this name when it is complete")
    overwrite: bool = Field(False, description="replace an existing bag when the new one is complete")
    record: Literal["default", "all"] = Field(
        "default", description="what the bag keeps: what the rest is computed from, or everything"
    )
    record_ends: int = Field(
        8, ge=0, le=100_000, description="member ends, the most used, whose stress the default keeps"
    )


def selection_of(options: PostprocOptions, case: CaseConfig) -> Selection:
    """What the bag of a case keeps: loads of a live elevation whole, as the case alone does not give them."""
    everything, live = options.record == "all", case.live is not None
    return Selection(everything=everything, ends=options.record_ends, loads=live)
