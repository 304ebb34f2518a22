"""The committed recording reads, and its case gives its numbers again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from owt_campaign.pipeline import run_case
from owt_model.config import parse_case
from owt_postproc.bag_reader import read_bag, read_files
from owt_postproc.bag_report import bag_report

GOLDEN = Path(__file__).parents[1] / "bags" / "golden"
#: Another machine's BLAS and FFT round otherwise; stress and energy pass through eigenvectors.
TOLERANCE = 1e-8


def close(found: np.ndarray, recorded: np.ndarray) -> None:
    np.testing.assert_allclose(found, recorded, rtol=0, atol=TOLERANCE * np.abs(recorded).max())


def test_the_case_in_the_bag_gives_its_numbers_again() -> None:
    case = parse_case(read_files(GOLDEN).case)
    streams = read_bag(GOLDEN).streams
    again = run_case(case, keep_series=True).series
    for topic, stream, channels in (
        ("/owt/surface_elevation", "elevation", ("first_order", "total")),
        ("/owt/nodal_loads", "load", ("nodal", "fixed_end")),
        ("/owt/member_stress", "stress", ("axial", "bending_y", "bending_z", "von_mises")),
        ("/owt/energy", "energy", ("potential", "kinetic")),
    ):
        for channel in channels:
            recorded = streams[topic][channel]
            close(again[f"{stream}.{channel}"].reshape(recorded.shape), recorded)
    # Negative control: another seed is another sea.
    assert case.sea_state is not None
    other = case.model_copy(update={"sea_state": case.sea_state.model_copy(update={"seed": 8})})
    recorded = streams["/owt/nodal_loads"]["nodal"]
    wrong = run_case(other, keep_series=True).series["load.nodal"].reshape(recorded.shape)
    with pytest.raises(AssertionError):
        close(wrong, recorded)


def test_its_report_is_complete() -> None:
    data = bag_report(GOLDEN)
    assert data.complete
    assert data.fatigue.damage.max() > 0.0
    assert data.versions["owt"]
