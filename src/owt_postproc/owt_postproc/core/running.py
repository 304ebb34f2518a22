"""The count of one run while it goes on: what the stage's functions need between two blocks."""

from __future__ import annotations

from typing import Any

from owt_model.config import CaseConfig
from owt_model.contracts import FatigueBlock, ReducedDescription, StressBlock
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
    """Counts the stress of one case; the member ends become known with the reduced model.

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
        self._reduced: ReducedDescription | None = None
        self._model: FatigueModel | None = None
        self._state: FatigueState | None = None

    @property
    def is_ready(self) -> bool:
        """Whether the member ends are known."""
        return self._model is not None

    @property
    def is_closed(self) -> bool:
        """Whether the block marked last has been counted."""
        return self._state is not None and self._state.closed

    @property
    def samples(self) -> int:
        """Stress samples counted."""
        return 0 if self._state is None else self._state.samples

    def learn(self, reduced: ReducedDescription) -> None:
        """Take the description of the reduced model."""
        self._reduced = reduced
        self._model = build_fatigue_model(self._case, n_ends=len(reduced.end_name))
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
