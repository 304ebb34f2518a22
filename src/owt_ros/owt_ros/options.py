"""Parameters of every node besides the case, and which diagnostics belong in a bag."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from pydantic import BaseModel, ConfigDict, Field

__all__ = ["RATE_SUFFIX", "NodeOptions", "is_mark"]

#: Ends the name of diagnostics that hold wall time; they are not recorded.
RATE_SUFFIX = ": rate"


class NodeOptions(BaseModel):
    """Parameters of a node besides the case."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    lease_s: float = Field(
        1.5, ge=0.0, le=60.0, description="time in s until the death of a peer is noticed; 0 for never"
    )
    wait_s: float = Field(
        30.0, gt=0.0, le=3600.0, description="longest wait in s for the subscriptions of consumers"
    )
    stall_s: float = Field(
        120.0, gt=0.0, le=86400.0, description="longest wait in s for a consumer's acknowledgement"
    )


def is_mark(diagnostic: Any, *, but_of: tuple[str, ...]) -> bool:
    """Tell whether a diagnostic says that something went wrong, but for some nodes, at a simulated time.

    Those that hold wall time say nothing of the data.
    """
    return any(
        status.level != DiagnosticStatus.OK
        and not status.name.endswith(RATE_SUFFIX)
        and not status.name.startswith(but_of)
        for status in diagnostic.status
    )
