"""A picture as the serialised ``visualization_msgs/MarkerArray``.

One message object for each of twenty thousand points would cost more than everything else the viewer does;
points and colours lie in the serialised message as arrays of doubles and floats, so they are written as such
(XCDR1, little endian). A test reads the bytes with rclpy.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from owt_viewer.core.scene import Item

__all__ = ["FRAME", "KINDS", "marker_array"]

#: Name of the global axes: x, y horizontal, z up from still water.
FRAME = "owt"
#: Marker types LINE_LIST, TRIANGLE_LIST and TEXT_VIEW_FACING.
KINDS = {"lines": 5, "triangles": 11, "text": 9}
_ADD, _DELETE_ALL = 0, 3
_ENCAPSULATION = b"\0\1\0\0"


class _Writer:
    """Bytes with the alignment of CDR, which counts from the end of the encapsulation."""

    def __init__(self) -> None:
        self.data = bytearray()

    def align(self, size: int) -> None:
        self.data += bytes(-len(self.data) % size)

    def pack(self, code: str, *values: Any) -> None:
        """Append values of one type."""
        self.align(struct.calcsize(code))
        self.data += struct.pack(f"<{len(values)}{code}", *values)

    def text(self, text: str) -> None:
        """Append a string."""
        encoded = text.encode() + b"\0"
        self.pack("I", len(encoded))
        self.data += encoded

    def rows(self, values: Any, dtype: str) -> None:
        """Append a sequence of points or colours: the number of rows, then the numbers."""
        self.pack("I", len(values))
        if len(values):
            self.align(np.dtype(dtype).itemsize)
            self.data += np.ascontiguousarray(values, dtype=dtype).tobytes()


def marker_array(items: Sequence[Item], time_ns: int, *, afresh: bool = False) -> bytes:
    """Serialise a picture.

    Parameters
    ----------
    items : sequence of Item
        What to draw.
    time_ns : int
        Simulated time in ns.
    afresh : bool
        Whether everything drawn before goes.
    """
    writer = _Writer()
    writer.pack("I", len(items) + afresh)
    if afresh:
        empty = np.zeros((0, 3))
        _marker(writer, Item("", 0, "lines", 0.0, empty, np.zeros((0, 4))), time_ns, _DELETE_ALL)
    for item in items:
        _marker(writer, item, time_ns, _ADD)
    return _ENCAPSULATION + bytes(writer.data)


def _marker(writer: _Writer, item: Item, time_ns: int, action: int) -> None:
    """Append one Marker, field by field as its definition lists them."""
    is_text = item.kind == "text"
    place = item.points[0] if is_text else np.zeros(3)
    size = item.size
    scale = {"lines": (size, 0.0, 0.0), "triangles": (1.0, 1.0, 1.0), "text": (0.0, 0.0, size)}[item.kind]
    writer.pack("i", time_ns // 1_000_000_000)
    writer.pack("I", time_ns % 1_000_000_000)
    writer.text(FRAME)
    writer.text(item.group)
    writer.pack("i", item.number, KINDS[item.kind], action)
    writer.pack("d", *place, 0.0, 0.0, 0.0, 1.0, *scale)
    writer.pack("f", *(item.colours[0] if is_text else (1.0, 1.0, 1.0, 1.0)))
    writer.pack("i", 0, 0)  # lifetime: for ever
    writer.pack("B", False)  # frame_locked
    writer.rows(item.points[:0] if is_text else item.points, "<f8")
    writer.rows(item.colours[:0] if is_text else item.colours, "<f4")
    writer.text("")  # texture_resource
    writer.pack("i", 0, 0)  # texture: stamp, frame_id, format, data
    writer.text("")
    writer.text("")
    writer.pack("I", 0, 0)  # no data, no uv_coordinates
    writer.text(item.text)
    writer.text("")  # mesh_resource
    writer.text("")  # mesh_file: filename, data
    writer.pack("I", 0)
    writer.pack("B", False)  # mesh_use_embedded_materials
