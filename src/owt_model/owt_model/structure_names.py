"""Names of nodes that a mesh adds to the joints of a structure, and the refusal of joints named alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from owt_model.errors import InputError
from owt_model.parts import Member, Tower

__all__ = ["TOWER_TOP", "check_names"]

#: Name of the tower's upper end in `dashpots`; the transition piece where there is no tower.
TOWER_TOP = "tower_top"


def check_names(
    joints: Iterable[str], members: Mapping[str, Member], elements_per_member: int, tower: Tower | None
) -> None:
    """Refuse a joint that has the name of another node: what refers to one would reach the other.

    Raises
    ------
    InputError
        Naming the joint.
    """
    taken = {TOWER_TOP, "TP"}
    if tower is not None:
        taken |= {f"tower.{i + 1}" for i in range(tower.elements)}
    for name, member in members.items():
        taken |= {f"{name}.{i}" for i in range(1, elements_per_member)}
        taken |= {f"{name}:{joint}" for joint in member.joints}
    for name in joints:
        if name in taken:
            raise InputError(
                f"joints.{name}",
                name,
                "is the name of another node (TP, tower_top, tower.i, member.i, member:joint)",
                "Choose another name.",
            )
