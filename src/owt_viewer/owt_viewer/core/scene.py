"""The picture at one instant: thick lines of the structure, triangles of the sea, a legend and labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_viewer.core.colours import Scale, sea_colours
from owt_viewer.core.sea import SeaSurface

__all__ = ["Item", "Skeleton", "label_items", "legend_items", "sea_item", "structure_items"]

#: Height of letters in m.
_LETTER = 3.2
#: Segments and width in m of the bar of colours, and how far to the side of the structure it stands.
_BAR_SEGMENTS, _BAR_WIDTH, _BAR_DISTANCE = 40, 2.0, 32.0
_WHITE = np.array([[0.96, 0.97, 0.98, 1.0]])


@dataclass(frozen=True)
class Item:
    """One thing to draw.

    Attributes
    ----------
    group, number : str, int
        What it is, and which of those.
    kind : str
        ``lines`` (pairs of points), ``triangles`` (three points each) or ``text``.
    size : float
        Width of lines or height of letters in m.
    points : float array [point, 3]
        In m; one point for a text.
    colours : float array [point, 4]
        Red, green, blue, opacity.
    text : str
        What a text says.
    """

    group: str
    number: int
    kind: str
    size: float
    points: Float[np.ndarray, "point 3"]
    colours: Float[np.ndarray, "point 4"]
    text: str = ""


@dataclass(frozen=True)
class Skeleton:
    """The structure as segments, one for each element.

    Attributes
    ----------
    node : float array [node, 3]
        Undeformed position in m.
    segment : int array [segment, 2]
        Nodes of each.
    width : float array [segment]
        Diameter in m.
    end : int array [segment, 2]
        Member ends that the values at both nodes lie between; -1 where the segment has no values.
    place : float array [segment, 2]
        How far along the member, 0 at its first end to 1 at its last, both nodes lie.
    """

    node: Float[np.ndarray, "node 3"]
    segment: Int[np.ndarray, "segment 2"]
    width: Float[np.ndarray, " segment"]
    end: Int[np.ndarray, "segment 2"]
    place: Float[np.ndarray, "segment 2"]

    @classmethod
    def of(
        cls,
        *,
        node: Float[np.ndarray, "node 3"],
        segment: Int[np.ndarray, "segment 2"],
        member: Int[np.ndarray, " segment"],
        member_node: Int[np.ndarray, "member 2"],
        member_end: Int[np.ndarray, "member 2"],
        width: Float[np.ndarray, " segment"],
    ) -> Skeleton:
        """Find where each segment lies on its member.

        Parameters
        ----------
        node, segment, width
            As the attributes.
        member : int array [segment]
            Member of each segment, -1 for the tower.
        member_node : int array [member, 2]
            First and last node of each member.
        member_end : int array [member, 2]
            Numbers of its ends in the stress messages.
        """
        of_member = member >= 0
        first, last = node[member_node[member]].transpose(1, 0, 2)  # of the last member where there is none
        along = last - first
        offset = node[segment] - first[:, None]
        place = np.einsum("sec,sc->se", offset, along) / np.maximum((along**2).sum(axis=1), 1e-300)[:, None]
        end = np.where(of_member[:, None], member_end[member], -1)
        return cls(node, segment, width, end, np.clip(np.where(of_member[:, None], place, 0.0), 0.0, 1.0))

    def values(
        self, value: Float[np.ndarray, " end"], known: Bool[np.ndarray, " end"]
    ) -> tuple[Float[np.ndarray, "segment 2"], Bool[np.ndarray, "segment 2"]]:
        """Values at both nodes of each segment, linear between the member's ends, and where there are any."""
        ends = value[self.end]
        between = ends[:, :1] + self.place * (ends[:, 1:] - ends[:, :1])
        there = (self.end >= 0).all(axis=1) & known[self.end].all(axis=1)
        return np.where(there[:, None], between, 0.0), np.repeat(there[:, None], 2, axis=1)


def structure_items(
    skeleton: Skeleton,
    displacement: Float[np.ndarray, "node 3"],
    exaggeration: float,
    scale: Scale,
    value: Float[np.ndarray, " end"],
    known: Bool[np.ndarray, " end"],
) -> list[Item]:
    """Draw the deformed structure, one item for each diameter.

    Parameters
    ----------
    skeleton : Skeleton
        Undeformed.
    displacement : float array [node, 3]
        In m.
    exaggeration : float
        What the displacement is multiplied by.
    scale : Scale
        Of the colours.
    value : float array [end]
        Stress in Pa or damage at each member end.
    known : bool array [end]
        Which of them are known.
    """
    points = (skeleton.node + exaggeration * displacement)[skeleton.segment]
    at_nodes, there = skeleton.values(value, known)
    colours = scale.colours(at_nodes.reshape(-1), there.reshape(-1)).reshape(-1, 2, 4)
    widths, kind = np.unique(np.round(skeleton.width, 1), return_inverse=True)
    return [
        Item(
            "structure",
            i,
            "lines",
            float(width),
            points[chosen].reshape(-1, 3),
            colours[chosen].reshape(-1, 4),
        )
        for i, width in enumerate(widths)
        for chosen in [kind == i]
    ]


def sea_item(sea: SeaSurface, time_s: float) -> Item:
    """Draw the surface at time `time_s`."""
    points = sea.points(time_s)
    colours = sea_colours(points[:, 2], sea.amplitude)
    return Item("sea", 0, "triangles", 1.0, points[sea.triangles], colours[sea.triangles])


def legend_items(scale: Scale, low_z: float, high_z: float) -> list[Item]:
    """Draw the bar of colours with its numbers and unit, upright beside the structure.

    Parameters
    ----------
    scale : Scale
        What is shown.
    low_z, high_z : float
        Levels in m between which it stands.
    """
    foot = np.array([-_BAR_DISTANCE, 0.0, low_z])
    up = np.array([0.0, 0.0, high_z - low_z])
    stop = np.repeat(np.linspace(0.0, 1.0, _BAR_SEGMENTS + 1), 2)[1:-1]
    colours = scale.colours(scale.value(stop), np.ones(len(stop), dtype=bool))
    items = [Item("legend", 0, "lines", _BAR_WIDTH, foot + stop[:, None] * up, colours)]
    aside = np.array([-3.5, 0.0, 0.0])
    for share, text in scale.ticks:
        items.append(_text("legend", len(items), foot + share * up + aside, text))
    unit = "" if scale.unit == "-" else f" [{scale.unit}]"
    above = np.array([0.0, 0.0, 2.0 * _LETTER])
    items.append(_text("legend", len(items), foot + up + above, f"{scale.quantity}{unit}"))
    return items


def label_items(top: Float[np.ndarray, " 3"], lines: list[str]) -> list[Item]:
    """Write `lines` above point `top`."""
    up = np.array([0.0, 0.0, 1.5 * _LETTER])
    n = len(lines)
    return [_text("label", i, top + (n - i + 0.5) * up, line) for i, line in enumerate(lines)]


def _text(group: str, number: int, place: Float[np.ndarray, " 3"], text: str) -> Item:
    return Item(group, number, "text", _LETTER, place[None], _WHITE, text)
