"""Parameters of the viewer."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["ViewerOptions"]


class ViewerOptions(BaseModel):
    """Parameters of the viewer besides the case, of which it takes the structure."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    colour: Literal["stress", "damage"] = Field("stress", description="what colours the members")
    exaggeration: float = Field(200.0, ge=0.0, le=1e5, description="what displacements are multiplied by")
    fps: float = Field(8.0, gt=0.0, le=30.0, description="pictures per second of wall time")
    grid_extent_m: float = Field(110.0, gt=0.0, le=1e4, description="side of the square of sea in m")
    grid_points: int = Field(41, ge=2, le=201, description="grid points along a side of that square")
    host: str = Field("127.0.0.1", description="address of the WebSocket server; 0.0.0.0 for all")
    port: int = Field(0, ge=0, le=65535, description="TCP port of the WebSocket server; 0 for none")
