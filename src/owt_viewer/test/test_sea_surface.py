"""The surface shown is the first-order elevation that the waves stage publishes, and no other."""

import dataclasses

import numpy as np
import pytest

from owt_campaign.pipeline import CaseRun, prepare_case, stream_case
from owt_model.config import parse_case
from owt_model.contracts import SeaState
from owt_viewer.core.sea import SeaSurface, grid_triangles

SPREAD = {"hs_m": 4.0, "tp_s": 9.0, "seed": 5, "direction_deg": 210.0, "spreading": 8}
#: Sums of some hundred cosines of order one, in another order than the FFT's.
TOLERANCE_M = 1e-9


@pytest.fixture(scope="module", params=[None, 8.0], ids=["long-crested", "short-crested"])
def sea(request: pytest.FixtureRequest) -> tuple[SeaState, np.ndarray, float]:
    """A sea, its elevation at the gauges, and the time step."""
    state = SPREAD | {"spreading": request.param}
    case = parse_case(
        {
            "sea_state": {name: value for name, value in state.items() if value is not None},
            "wave": {"order": 2},
            "time": {"n": 200},
            "structure": {"reduction": "CB00"},
            "gauges_m": [[0.0, 0.0], [10.0, -10.0], [-10.0, 10.0]],
        }
    )
    run: CaseRun = prepare_case(case)
    first = np.concatenate([block.elevation.first_order for block in stream_case(run)])
    return run.wave.sea_state, first, case.time.dt_s


def shown(state: SeaState, time_s: float) -> np.ndarray:
    """The surface at the gauges, which are points of a grid of three by three."""
    return SeaSurface(state, 20.0, 3).elevation(time_s)[[1, 2, 0], [1, 0, 2]]


@pytest.mark.parametrize("row", [0, 1, 57, 199])
def test_it_is_the_elevation_of_the_wave_stage(sea: tuple[SeaState, np.ndarray, float], row: int) -> None:
    state, first, dt = sea
    np.testing.assert_allclose(shown(state, row * dt), first[row], rtol=0.0, atol=TOLERANCE_M)


@pytest.mark.parametrize("wrong", ["phase_rad", "omega_rad_s"])
def test_a_flipped_sign_would_be_seen(sea: tuple[SeaState, np.ndarray, float], wrong: str) -> None:
    state, first, dt = sea
    turned = dataclasses.replace(state, **{wrong: -getattr(state, wrong)})
    assert np.abs(shown(turned, 57 * dt) - first[57]).max() > 0.1


def test_triangles_cover_the_grid_once() -> None:
    x, y = np.meshgrid(np.arange(4.0), np.arange(3.0), indexing="ij")
    corner = np.stack([x.ravel(), y.ravel()], axis=1)[grid_triangles(4, 3)].reshape(-1, 3, 2)
    (a, b) = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    np.testing.assert_array_equal(area, 0.5)
    assert area.sum() == 6.0
