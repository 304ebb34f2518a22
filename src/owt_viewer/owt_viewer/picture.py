"""What the viewer knows of a run, from its messages, and the picture that this makes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from owt_model.errors import ComputationError
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import Structure, case_structure, load_structure, shipped_structures
from owt_model.structure_config import StructureConfig
from owt_ros import decode
from owt_ros.wire import NO_MEMBER, indices, read_doubles
from owt_viewer.core.colours import Scale, damage_scale, rising_limit, stress_scale
from owt_viewer.core.scene import Item, Skeleton, label_items, legend_items, sea_item, structure_items
from owt_viewer.core.sea import SeaSurface
from owt_viewer.core.shape import displacement_basis, node_displacement
from owt_viewer.feed import Moment

__all__ = ["Picture", "find_structure"]


def find_structure(model: Any, config: StructureConfig) -> Structure:
    """Return the structure that a ModelDescription describes: that of the parameters, or a shipped one.

    Raises
    ------
    ComputationError
        If neither has its hash.
    InputError
        If the structure of the parameters cannot be read.
    """
    found = case_structure(config)
    if found.content_hash != model.model_hash and model.model_name in shipped_structures():
        found = load_structure(model.model_name)
    if found.content_hash != model.model_hash:
        raise ComputationError(
            f"the graph's structure {model.model_name} {model.model_hash[:12] or '(none)'} is not known, "
            "it is shown without its deformation: give the viewer the case of the run"
        )
    return found


class Picture:
    """The scene of one run.

    Parameters
    ----------
    config : StructureConfig
        Structure of the viewer's parameters.
    colour : str
        ``stress`` or ``damage``.
    exaggeration : float
        What displacements are multiplied by.
    extent_m, points : float, int
        Side of the square of sea and grid points along it.
    """

    def __init__(
        self, config: StructureConfig, *, colour: str, exaggeration: float, extent_m: float, points: int
    ) -> None:
        self._config, self._colour, self._exaggeration = config, colour, exaggeration
        self._extent, self._grid = extent_m, points
        self._skeleton: Skeleton | None = None
        self._sea: SeaSurface | None = None
        self._basis: Float[np.ndarray, "node 3 coordinate"] | None = None
        self._ends: tuple[str, ...] = ()
        self._limit = 0.0

    # --- descriptions -----------------------------------------------------------------------------

    def describe_sea(self, sea: Any) -> None:
        """Take a SeaState message."""
        self._sea = SeaSurface(sea, self._extent, self._grid)

    def describe_structure(self, model: Any, reduced: Any | None, basis: Any | None) -> None:
        """Take the messages that describe the structure; the first alone gives its undeformed shape.

        Raises
        ------
        OwtError
            If they do not fit each other or no structure known here; the undeformed shape is there even so.
        """
        self._basis, self._limit = None, 0.0
        self._skeleton = _skeleton(model, reduced)
        self._ends = () if reduced is None else tuple(reduced.end_name)
        mesh = build_mesh(find_structure(model, self._config))
        self._skeleton = _skeleton(model, reduced, mesh)
        if reduced is None or basis is None:
            return
        for name, message in (("reduced model", reduced), ("load basis", basis)):
            if message.model_hash != model.model_hash:
                raise ComputationError(
                    f"the {name} belongs to model {message.model_hash[:12] or '(none)'}, the graph's is "
                    f"{model.model_hash[:12]}: the structure is shown without its deformation"
                )
        description = decode.to_reduced_model(reduced)
        self._basis = displacement_basis(mesh, description, decode.to_load_basis(basis))

    # --- one instant ------------------------------------------------------------------------------

    def items(self, moment: Moment) -> tuple[list[Item], dict[str, float]]:
        """Draw the scene at a moment, and return the numbers of it that are known.

        Raises
        ------
        ComputationError
            If the numbers do not go with the descriptions.
        """
        time_ns, modal, stress, fatigue = moment.time_ns, moment.modal, moment.stress, moment.fatigue
        numbers = {"time_s": 1e-9 * time_ns}
        found = [] if self._sea is None else [sea_item(self._sea, numbers["time_s"])]
        von_mises = _at(stress, time_ns, None if stress is None else stress.von_mises)
        if moment.elevation_m is not None:
            numbers["elevation_m"] = moment.elevation_m
        if von_mises.size:
            numbers["largest_stress_mpa"] = 1e-6 * float(von_mises.max())
        if fatigue is not None and fatigue.damage.size:
            numbers["largest_damage"] = float(fatigue.damage.max())
        if numbers.get("largest_damage", 0.0) > 0.0:  # small numbers that a plot on a linear axis cannot show
            numbers["log10_largest_damage"] = math.log10(numbers["largest_damage"])
        if self._skeleton is None:
            return found, numbers
        is_damage = self._colour == "damage"
        given = (np.zeros(0) if fatigue is None else fatigue.damage) if is_damage else von_mises
        value, known = self._of_ends(given, [] if is_damage else moment.stress_end)
        coming = stress.von_mises if stress is not None and not is_damage else given
        self._limit = rising_limit(float(coming.max(initial=0.0)), self._limit)
        scale = (damage_scale if is_damage else stress_scale)(self._limit)
        motion = self._displacement(_at(modal, time_ns, None if modal is None else modal.displacement))
        found += structure_items(self._skeleton, motion, self._exaggeration, scale, value, known)
        found += self._words(self._skeleton, scale, numbers["time_s"])
        return found, numbers

    def _words(self, skeleton: Skeleton, scale: Scale, time_s: float) -> list[Item]:
        """Legend and labels."""
        top = skeleton.node[skeleton.node[:, 2].argmax()]
        deformed = f"displacement x {self._exaggeration:g}" if self._basis is not None else "not deformed"
        return [
            *legend_items(scale, 0.08 * float(top[2]), 0.65 * float(top[2])),
            *label_items(top, [f"t = {time_s:.1f} s", deformed]),
        ]

    def _displacement(self, coordinate: Float[np.ndarray, " coordinate"]) -> Float[np.ndarray, "node 3"]:
        """Displacement of all nodes in m; none where it is not known."""
        assert self._skeleton is not None
        if self._basis is None or not coordinate.size:
            return np.zeros_like(self._skeleton.node)
        if len(coordinate) != self._basis.shape[2]:
            raise ComputationError(
                f"the response has {len(coordinate)} coordinates, the reduced model {self._basis.shape[2]}"
            )
        return node_displacement(self._basis, coordinate)

    def _of_ends(
        self, given: Float[np.ndarray, " given"], end: list[int]
    ) -> tuple[Float[np.ndarray, " end"], Bool[np.ndarray, " end"]]:
        """Spread values over all ends, and say which are known."""
        n = len(self._ends)
        value, known = np.zeros(max(n, 1)), np.zeros(max(n, 1), dtype=bool)
        if not given.size or not n:
            return value, known
        place = np.array(end if end else range(n), dtype=np.int64)
        if len(place) != len(given) or not ((place >= 0) & (place < n)).all():
            raise ComputationError(f"{len(given)} values for {len(place)} of {n} member ends")
        value[place], known[place] = given, True
        return value, known


def _at(block: Any, time_ns: int, rows: Any) -> Float[np.ndarray, " channel"]:
    """The sample of a block nearest to a time; empty without a block."""
    if block is None:
        return np.zeros(0)
    row = round((time_ns - block.time_ns) * 1e-9 / block.dt)
    return np.asarray(rows[min(max(row, 0), len(rows) - 1)])


def _skeleton(model: Any, reduced: Any | None, mesh: Mesh | None = None) -> Skeleton:
    """The structure of a ModelDescription; a mesh knows the diameters of the tower too."""
    node = read_doubles(model, "node_position_m", -1, 3)
    segment = indices(model.element_node).reshape(-1, 2)
    member = indices(model.element_member)
    member = np.where(member == NO_MEMBER, -1, member)
    member_node = indices(model.member_node).reshape(-1, 2)
    diameter = read_doubles(model, "member_diameter_m", len(member_node))
    for name, index, limit in (("node", segment, len(node)), ("member", member, len(member_node))):
        if index.size and not (index.min() >= -1 and index.max() < limit):
            raise ComputationError(f"the model's elements name a {name} that it does not have")
    if not len(segment) or len(member) != len(segment):
        raise ComputationError(f"the model has {len(segment)} elements and {len(member)} members of elements")
    width = np.where(member < 0, diameter.max(initial=1.0), diameter[member] if len(diameter) else 1.0)
    end = np.full((len(member_node), 2), -1)
    if reduced is not None:
        of, side = indices(reduced.end_member), indices(reduced.end_side)
        end[of, side] = np.arange(len(of))
    return Skeleton.of(
        node=node.copy(),
        segment=segment,
        member=member,
        member_node=member_node,
        member_end=end,
        width=width if mesh is None else mesh.element_diameter,
    )
