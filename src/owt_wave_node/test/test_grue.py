"""Grue's profile: limits, refusals, and the trough-to-trough period of a record."""

from __future__ import annotations

import math

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_wave_node.core.grue import grue_crest, trough_to_trough

G = 9.81


def test_low_crest_is_a_linear_wave() -> None:
    got = grue_crest(1e-6, 8.0, water_depth=200.0, gravity=G)
    omega = 2.0 * math.pi / 8.0
    assert got.wavenumber == pytest.approx(omega**2 / G, rel=1e-10)
    z = np.array([-20.0, 0.0])
    assert got.velocity(z) == pytest.approx(omega * 1e-6 * np.exp(omega**2 / G * z), rel=1e-6)


def test_value_of_the_crest_is_held_above_it() -> None:
    got = grue_crest(5.0, 8.0, water_depth=200.0, gravity=G)
    u = got.velocity(np.array([4.0, 5.0, 9.0]))
    assert u[0] < u[1] == u[2]


@pytest.mark.parametrize(
    ("crest", "period", "depth", "field"),
    [
        (0.0, 8.0, 200.0, "crest"),
        (float("nan"), 8.0, 200.0, "crest"),
        (5.0, -1.0, 200.0, "period"),
        (12.0, 8.0, 200.0, "crest"),  # k eta 0.621
        (5.0, 12.0, 50.0, "water_depth"),
    ],
)
def test_refusals(crest: float, period: float, depth: float, field: str) -> None:
    with pytest.raises(InputError) as error:
        grue_crest(crest, period, water_depth=depth, gravity=G)
    assert error.value.field == field


def test_just_below_the_limit() -> None:
    assert grue_crest(11.95, 8.0, water_depth=200.0, gravity=G).wavenumber * 11.95 < 0.62


@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_trough_to_trough(offset: float) -> None:
    t = np.arange(0.0, 60.0, 0.1)
    eta = np.cos(2.0 * np.pi * (t - 30.0 - offset) / 8.0)
    at = int(eta[200:400].argmax()) + 200
    assert trough_to_trough(t, eta, at) == pytest.approx(8.0, abs=1e-4)  # a parabola's error in a cosine


def test_ripples_in_a_trough_are_one_trough() -> None:
    t = np.arange(0.0, 60.0, 0.1)
    eta = np.cos(2.0 * np.pi * (t - 30.0) / 8.0) + 0.08 * np.cos(2.0 * np.pi * (t - 30.0) / 1.6)
    coarse = trough_to_trough(t, eta, 300)
    assert coarse == pytest.approx(8.0, abs=0.01)


@pytest.mark.parametrize("at", [0, 5, 599])
def test_a_crest_at_the_end_of_a_record_is_refused(at: int) -> None:
    t = np.arange(0.0, 60.0, 0.1)
    with pytest.raises(InputError, match="no whole trough"):
        trough_to_trough(t, np.cos(2.0 * np.pi * t / 8.0), at)
