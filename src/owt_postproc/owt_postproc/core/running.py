"""The count of one run while it goes on: what the stage's functions need between two blocks."""

from __future__ import annotations

from typing import Any

from owt_model.config import CaseConfig
from owt_model.contracts import FatigueBlock, ReducedDescription, StressBlock
from owt_model.errors import ComputationError
from owt_model.frame import Frame
from owt_postproc.core.hot_spots import build_hot_spots
from owt_postproc.core.sn import sn_curve
from owt_postproc.core.stage import (
    FatigueModel,
    FatigueResult,
    FatigueState,
    build_fatigue_model,
    final,
    initial_state,
    step,
)
from owt_postproc.core.summary import fatigue_summary
from owt_postproc.kernels import warm_up

__all__ = ["RunningCount"]


class RunningCount:
    """Counts the stress of one case; its hot spots become known with the structure and the reduced model.

    Parameters
    ----------
    case : CaseConfig
        The case.

    Raises
    ------
    InputError
        If it names an unknown S-N curve.
    """

    def __init__(self, case: CaseConfig) -> None:
        sn_curve(case.fatigue.sn_curve, case.fatigue.sn_file)
        warm_up()  # compiled code is loaded before anything waits for it
        self._case = case
        self._told = False
        self._frame: Frame | None = None
        self._reduced: ReducedDescription | None = None
        self._model: FatigueModel | None = None
        self._state: FatigueState | None = None

    @property
    def is_ready(self) -> bool:
        """Whether the hot spots are known."""
        return self._model is not None

    @property
    def reduced(self) -> ReducedDescription:
        """The description of the reduced model, once it is known."""
        assert self._reduced is not None
        return self._reduced

    @property
    def is_closed(self) -> bool:
        """Whether the block marked last has been counted."""
        return self._state is not None and self._state.closed

    @property
    def samples(self) -> int:
        """Stress samples counted."""
        return 0 if self._state is None else self._state.samples

    def news(self) -> str:
        """Say once which joints are out of the range of their equations; empty if none is, or not known."""
        if self._model is None or self._told:
            return ""
        self._told = True
        return "; ".join(self._model.hot_spots.warnings)

    def learn(self, *, frame: Frame | None = None, reduced: ReducedDescription | None = None) -> None:
        """Take the members of the structure, or the description of the reduced model.

        Raises
        ------
        InputError
            If the case refuses the joints that the structure has.
        ComputationError
            If the two belong to different structures.
        """
        self._frame, self._reduced = frame or self._frame, reduced or self._reduced
        if self._frame is None or self._reduced is None or self._model is not None:
            return
        if self._frame.end_name != self._reduced.end_name:
            raise ComputationError("structure and reduced model have different member ends")
        self._model = build_fatigue_model(self._case, build_hot_spots(self._frame, self._case.fatigue))
        self._state = initial_state(self._model)

    def count(self, stress: StressBlock) -> FatigueBlock:
        """Count the next block of stress.

        Raises
        ------
        ComputationError
            As :func:`owt_postproc.core.stage.step`.
        """
        assert self._model is not None
        assert self._state is not None
        self._state, block = step(self._model, self._state, stress)
        return block

    def result(self) -> FatigueResult:
        """Return the results so far, the residue counted as half cycles."""
        assert self._model is not None
        assert self._state is not None
        return final(self._model, self._state)

    def summary(self) -> dict[str, Any]:
        """Return the results so far, as :func:`~owt_postproc.core.summary.fatigue_summary` gives them."""
        if self._reduced is None or not self.samples:
            return {"samples": 0, "complete": False, "ends": []}
        return fatigue_summary(self.result(), self._reduced, complete=self.is_closed)
