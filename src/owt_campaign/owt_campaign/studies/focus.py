"""Members that thesis chapter 5.2 looks at: the heaviest, half way down its leg, in the splash zone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from owt_campaign.studies.wave_totals import Members
from owt_model.mesh import Mesh

__all__ = ["HALF_WAY", "SHORT", "Focus", "focus_members", "splash_zone"]

#: Members shorter than this in m are stubs of the legs, most of them at their feet.
SHORT = 2.0
#: z in m between which the middle of a leg's piece lies half way down.
HALF_WAY = (-30.0, -5.0)


@dataclass(frozen=True)
class Focus:
    """Members by number, from the total stress of the second order.

    Attributes
    ----------
    heaviest : int
        Of all members: focus member 3 of the thesis if it is the foot of a leg.
    half_way : int
        Heaviest piece half way down the leg that has the heaviest piece of all: focus member 2.
    rank : int
        Of that piece among all members, from 1.
    rank_long : int
        Of it among those of at least 2 m.
    rival : int
        Heaviest other member of at least 2 m.
    total : float array [member]
        Total stress of all members over the largest.
    """

    heaviest: int
    half_way: int
    rank: int
    rank_long: int
    rival: int
    total: Float[np.ndarray, " member"]

    def lead(self) -> float:
        """Total stress of the piece half way down over that of its rival, less one."""
        return float(self.total[self.half_way] / self.total[self.rival] - 1.0)


def focus_members(mesh: Mesh, members: Members, total: Float[np.ndarray, " member"]) -> Focus:
    """Find the members of the thesis' text.

    Parameters
    ----------
    mesh : Mesh
        Where members stand.
    members : Members
        Of the mesh.
    total : float array [member]
        Total stress of each.
    """
    ends = mesh.node_position[mesh.member_node]
    middle, length = ends.mean(axis=1), np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    heaviest = int(np.argmax(total))
    leg = int(np.where(members.leg, total, -1.0).argmax())
    same = (np.sign(middle[:, :2]) == np.sign(middle[leg, :2])).all(axis=1)
    there = members.leg & same & (members.level > HALF_WAY[0]) & (members.level < HALF_WAY[1])
    half_way = int(np.where(there, total, -1.0).argmax())
    long = length >= SHORT
    others = long.copy()
    others[half_way] = False
    heavier = total > total[half_way]
    return Focus(
        heaviest,
        half_way,
        1 + int(heavier.sum()),
        1 + int((heavier & long).sum()),
        int(np.where(others, total, -1.0).argmax()),
        np.asarray(total / total.max()),
    )


def splash_zone(mesh: Mesh) -> Bool[np.ndarray, " member"]:
    """Members that pass through still water."""
    z = mesh.node_position[mesh.member_node, 2]
    return np.asarray((z.min(axis=1) < 0.0) & (z.max(axis=1) > 0.0))
