"""The WebSocket server that Foxglove and Lichtblick connect to, through the foxglove-sdk library."""

from __future__ import annotations

import json

import foxglove
from foxglove import Capability, Channel, Context, Schema

from owt_model.errors import InputError
from owt_ros import schema
from owt_viewer.cdr import marker_array

__all__ = ["LiveServer"]

_MARKERS = "visualization_msgs/msg/MarkerArray"
#: The small numbers that plots take, all of them numbers; those not known yet are left out.
_NUMBERS = ("time_s", "elevation_m", "largest_stress_mpa", "largest_damage", "log10_largest_damage")


class LiveServer:
    """Serves the picture as the same ROS message that goes over DDS, and a few numbers as JSON.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        TCP port.

    Raises
    ------
    InputError
        If nothing can listen there.
    """

    def __init__(self, host: str, port: int) -> None:
        context = self._context = Context()  # the channels do not keep it alive
        ros = Schema(name=_MARKERS, encoding="ros2msg", data=schema.definition(_MARKERS).encode())
        numbers = {"type": "object", "properties": {name: {"type": "number"} for name in _NUMBERS}}
        named = Schema(name="owt/Live", encoding="jsonschema", data=json.dumps(numbers).encode())
        self._markers = Channel("/owt/markers", schema=ros, message_encoding="cdr", context=context)
        self._numbers = Channel("/owt/live", schema=named, message_encoding="json", context=context)
        try:
            self._server = foxglove.start_server(
                name="owt",
                host=host,
                port=port,
                capabilities=[Capability.Time],
                context=context,
                message_backlog_size=16,  # a slow client sees fewer pictures, not older ones
            )
        except (OSError, RuntimeError, ValueError) as error:
            raise InputError(
                "port", port, f"cannot be served on {host} ({error})", "Choose another."
            ) from None

        self.send(marker_array([], 0), {"time_s": 0.0}, 0)  # a channel is offered from its first message on

    @property
    def port(self) -> int:
        """TCP port."""
        return int(self._server.port)

    @property
    def is_watched(self) -> bool:
        """Whether a client is interested in the picture or the numbers."""
        return self._markers.has_sinks() or self._numbers.has_sinks()

    def send(self, markers: bytes, numbers: dict[str, float], time_ns: int) -> None:
        """Send a picture and its numbers, stamped in simulated time."""
        self._server.broadcast_time(time_ns)
        self._markers.log(markers, log_time=time_ns)
        self._numbers.log(json.dumps(numbers, allow_nan=False).encode(), log_time=time_ns)

    def stop(self) -> None:
        """Close all connections."""
        self._server.stop()
