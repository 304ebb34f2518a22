"""The stages run again, for all that a bag leaves out.

Modal state, stress and energies follow from the loads, the recorded load basis and load at the tower top, by
the same functions and in the same blocks as in the structure node. Fixed-end forces, where the bag leaves
them out, come from the case: the wave stage gives the loads again. What was recorded is compared.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from owt_bringup.bag_case import bag_structure, damping_load, other_structure
from owt_model.config import CaseConfig
from owt_model.contracts import Block, EnergyBlock, LoadBlock, ModalBlock, StressBlock, WrenchBlock
from owt_model.errors import ComputationError
from owt_model.mesh import build_mesh
from owt_model.structure import Structure, case_structure
from owt_postproc.bag_reader import PREFIX, BagMessage, decoded, to_block
from owt_postproc.bag_report import BlockSource, as_recorded
from owt_postproc.bag_source import BagSource
from owt_postproc.deviation import Deviation
from owt_ros.decode import is_whole, stress_ends, to_load_basis
from owt_structure_node.core.stage import (
    ResponseModel,
    ResponseState,
    build_response_model,
    initial_state,
    step,
)
from owt_wave_node.core.stage import WaveStage, build_wave_stage

__all__ = ["Recomputation", "block_source", "leaves_out"]

#: Types of what the structure stage gives.
RESPONSE = tuple(PREFIX + name for name in ("ModalState", "MemberStress", "Energy"))
#: Coordinates of fixed-interface modes and load vectors.
SHAPES = ("CB.", "MTA.")


def leaves_out(bag: BagSource) -> bool:
    """Tell whether the first messages of a bag leave something out."""
    unseen = {name for name, topic in bag.topics.items() if topic.type_name in RESPONSE}
    for message in decoded(bag, types=RESPONSE):
        if not is_whole(message.content):
            return True
        unseen.discard(message.topic)
        if not unseen or message.content.sequence > 1:
            break
    return False


def block_source(bag: BagSource) -> BlockSource:
    """Return what gives the blocks of a bag: a :class:`Recomputation`, unless its messages are whole."""
    return Recomputation(bag_structure(bag)) if leaves_out(bag) else as_recorded


class Recomputation:
    """A block source that computes what the structure stage gives from the loads.

    Parameters
    ----------
    structure : Structure, optional
        That the bag was made with; by default the one that its case names.

    Attributes
    ----------
    deviation : Deviation
        Of what was computed from what was recorded.
    notes : tuple of str
        What has changed since the recording.
    turned : bool
        Whether coordinates of modes are others than the recorded ones, of the same motion.
    """

    def __init__(self, structure: Structure | None = None) -> None:
        self._structure = structure
        self.deviation = Deviation()
        self.notes: tuple[str, ...] = ()
        self._loads: deque[LoadBlock] = deque()
        self._wrenches: deque[WrenchBlock] = deque()
        self._model: ResponseModel | None = None
        self._state: ResponseState | None = None
        self.turned = False
        self._waves: WaveStage | None = None
        self._ready: dict[tuple[type[Block], int], Block] = {}

    def __call__(
        self, case: CaseConfig, messages: Iterator[BagMessage]
    ) -> Iterator[tuple[BagMessage, Block | None]]:
        """Yield every message with its block; a response waits for the loads that it comes from.

        Raises
        ------
        InputError
            If the structure of the case is not there any more.
        ComputationError
            If what was recorded is not what the loads give, or there are no loads for it.
        """
        waiting: deque[tuple[BagMessage, Block | None]] = deque()
        for message in messages:
            block = to_block(message)
            if message.type_name == f"{PREFIX}LoadBasis":
                self._build(case, message.content)
            elif isinstance(block, LoadBlock):
                block = self._whole(case, message.topic, block)
                self._loads.append(block)
            elif isinstance(block, WrenchBlock):
                self._wrenches.append(block)
            self._advance(has_wrench=case.wind is not None)
            waiting.append((message, block))
            while waiting and self._is_ready(waiting[0][1]):
                first, recorded = waiting.popleft()
                yield first, self._checked(first, recorded)
        for message, block in waiting:
            assert block is not None
            raise ComputationError(
                f"{message.topic}, block {block.sequence}: the bag has no loads that give it"
            )

    def _whole(self, case: CaseConfig, place: str, load: LoadBlock) -> LoadBlock:
        """Return recorded loads with their fixed-end forces, made again where they were left out."""
        if len(load.element):
            return load
        if self._waves is None:
            self._waves = build_wave_stage(case, build_mesh(case_structure(case.structure, self._structure)))
        again = self._waves.load_block(load.sequence)
        self.deviation.compare(place, load.sequence, "nodal", load.nodal, again.nodal)
        return again

    def _build(self, case: CaseConfig, basis: Any) -> None:
        mesh = build_mesh(case_structure(case.structure, self._structure))
        self.notes = other_structure(case, mesh, basis.model_hash)
        # a structure described anew is told by what it computes, not by its hash
        same = replace(to_load_basis(basis), model_hash=mesh.structure.content_hash)
        self._model = build_response_model(case, mesh, same, damping_load(case, mesh))
        self._state = initial_state(self._model)

    def _advance(self, *, has_wrench: bool) -> None:
        """Integrate over the blocks of loads that are complete."""
        while self._model is not None and self._state is not None and self._loads:
            if has_wrench and not self._wrenches:
                return
            wrench = self._wrenches.popleft() if has_wrench else None
            load = replace(self._loads.popleft(), model_hash=self._model.description.model_hash)
            self._state, response = step(self._model, self._state, load, wrench)
            for block in (response.modal, response.stress, response.energy):
                self._ready[type(block), block.sequence] = block

    def _is_ready(self, block: Block | None) -> bool:
        if not isinstance(block, ModalBlock | StressBlock | EnergyBlock):
            return True
        return (type(block), block.sequence) in self._ready

    def _checked(self, message: BagMessage, recorded: Block | None) -> Block | None:
        """Return the computed block in the place of a recorded response, what both have compared."""
        if not isinstance(recorded, ModalBlock | StressBlock | EnergyBlock):
            return recorded
        block = self._ready.pop((type(recorded), recorded.sequence))
        heads = [(one.start, one.dt, one.last) for one in (recorded, block)]
        if heads[0] != heads[1]:
            raise ComputationError(
                f"{message.topic}, block {block.sequence}: start, time step and end are recorded as "
                f"{heads[0]} and computed again as {heads[1]}"
            )
        ends = stress_ends(message.content)
        for name, values in vars(recorded).items():
            if not isinstance(values, np.ndarray) or (values.ndim > 1 and not values.shape[1]):
                continue
            again = getattr(block, name)
            if ends is not None:
                again = _columns(message.topic, block, again, ends)
            if isinstance(recorded, ModalBlock) and values.shape == again.shape:
                self._compare_coordinates(message.topic, block.sequence, name, values, again)
            else:
                self.deviation.compare(message.topic, block.sequence, name, values, again)
        return block

    def _compare_coordinates(
        self, place: str, sequence: int, name: str, recorded: np.ndarray, again: np.ndarray
    ) -> None:
        """Compare coordinates; those of modes may be turned, as modes of equal frequency are not unique.

        What no turning changes is compared then: the length over all modes, and over all load vectors.
        """
        if np.array_equal(recorded, again):
            self.deviation.values += recorded.size
            return
        assert self._model is not None
        self.turned = True
        names = self._model.description.coordinate_name
        shape = {group: np.array([name.startswith(group) for name in names]) for group in SHAPES}
        physical = ~np.any(list(shape.values()), axis=0)
        self.deviation.compare(place, sequence, name, recorded * physical, again * physical)
        for group, columns in shape.items():
            lengths = [np.sqrt((values[:, columns] ** 2).sum(axis=1)) for values in (recorded, again)]
            self.deviation.compare(place, sequence, f"{name} (length of all {group}*)", *lengths)


def _columns(place: str, block: Block, values: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Stress of the member ends that are recorded."""
    if ends.max() >= values.shape[1]:
        raise ComputationError(f"{place}, block {block.sequence}: there is no member end {ends.max()}")
    return np.asarray(values[:, ends])
