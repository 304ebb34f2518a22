"""Parameters of the postproc node besides the case."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from owt_ros.options import NodeOptions

__all__ = ["PostprocOptions"]


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
