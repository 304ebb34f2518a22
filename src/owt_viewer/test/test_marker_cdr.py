"""The bytes of a picture are the MarkerArray that rclpy's classes make of it."""

import numpy as np
import pytest
from geometry_msgs.msg import Point, Vector3
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from owt_ros.convert import stamp
from owt_viewer.cdr import FRAME, KINDS, marker_array
from owt_viewer.core.scene import Item

TIME_NS = 12_345_678_901


def picture() -> list[Item]:
    random = np.random.default_rng(4)

    def colours(n: int) -> np.ndarray:
        return random.random((n, 4)).astype(np.float32).astype(np.float64)  # as the message holds them

    return [
        Item("structure", 2, "lines", 1.2, random.normal(size=(6, 3)), colours(6)),
        Item("sea", 0, "triangles", 1.0, random.normal(size=(9, 3)), colours(9)),
        Item("label", 1, "text", 3.0, random.normal(size=(1, 3)), colours(1), "t = 1 s, ± 2"),
        Item("sea", 1, "triangles", 1.0, random.normal(size=(3, 3)), colours(3)),
    ]


def marker(item: Item) -> Marker:
    """The same, by rclpy's classes."""
    found = Marker(header=Header(stamp=stamp(TIME_NS), frame_id=FRAME), ns=item.group, id=item.number)
    found.type, found.text = KINDS[item.kind], item.text
    found.color = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
    points = [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in item.points]
    colours = [ColorRGBA(**dict(zip("rgba", map(float, row), strict=True))) for row in item.colours]
    if item.kind == "text":
        found.pose.position, found.color = points[0], colours[0]
        found.scale = Vector3(x=0.0, y=0.0, z=item.size)
    else:
        found.points, found.colors = points, colours
        lines = item.kind == "lines"
        found.scale = Vector3(x=item.size, y=0.0, z=0.0) if lines else Vector3(x=1.0, y=1.0, z=1.0)
    return found


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4])
def test_rclpy_reads_what_it_would_have_written(n: int) -> None:
    """Field by field, and as many bytes: what rclpy leaves between aligned fields is not defined."""
    items = picture()[:n]
    expected = MarkerArray(markers=[marker(item) for item in items])
    cdr = marker_array(items, TIME_NS)
    assert deserialize_message(cdr, MarkerArray) == expected
    assert len(cdr) == len(serialize_message(expected))


def test_a_wrong_float_would_be_seen() -> None:
    items = picture()
    expected = MarkerArray(markers=[marker(item) for item in items])
    items[0].points[3, 1] += 1e-9
    assert deserialize_message(marker_array(items, TIME_NS), MarkerArray) != expected


def test_afresh_removes_what_was_there() -> None:
    first, *others = deserialize_message(marker_array(picture(), TIME_NS, afresh=True), MarkerArray).markers
    assert (first.action, len(others)) == (Marker.DELETEALL, 4)
    assert all(entry.action == Marker.ADD for entry in others)
    assert tuple(KINDS.values()) == (Marker.LINE_LIST, Marker.TRIANGLE_LIST, Marker.TEXT_VIEW_FACING)
