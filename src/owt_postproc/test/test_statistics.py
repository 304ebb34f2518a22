"""Statistics and spectra against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from owt_model.errors import InputError
from owt_postproc.core.statistics import spectrum, statistics


def test_statistics_of_a_sine():
    t = np.arange(2000) / 100
    s = statistics(3.0 + 2.0 * np.sin(2 * np.pi * t + 0.1))
    assert s.mean == pytest.approx(3.0)
    assert s.std == pytest.approx(np.sqrt(2.0))
    assert s.skewness == pytest.approx(0.0, abs=1e-12)
    assert s.zero_up_crossings == 20
    assert s.as_dict("m")["max_m"] == pytest.approx(5.0, abs=1e-2)


def test_skewness_of_an_exponential():
    assert statistics(np.random.default_rng(0).exponential(size=200_000)).skewness == pytest.approx(
        2.0, abs=0.1
    )


def test_constant_series_has_no_skewness():
    assert statistics(np.full(10, 0.1)).skewness == 0.0


@pytest.mark.parametrize("bad", [np.zeros(0), np.array([1.0, np.nan])])
def test_empty_or_not_finite_is_refused(bad):
    with pytest.raises(InputError, match="series"):
        statistics(bad)


@pytest.mark.parametrize("n", [900, 901, 1234])
def test_spectrum_is_welch(n):
    series = np.cumsum(np.random.default_rng(n).normal(size=n))
    result = spectrum(series, 0.1)
    length = round(1.0 / (result.resolution * 0.1))
    frequency, density = signal.welch(
        series - series.mean(), fs=10.0, window="hann", nperseg=length, detrend=False
    )
    np.testing.assert_allclose(result.frequency, frequency[1:], rtol=1e-12)
    np.testing.assert_allclose(result.density, density[1:], rtol=1e-10)


def test_spectrum_holds_the_variance_and_the_peak():
    dt, n = 0.02, 30_000
    t = dt * np.arange(n)
    noise = np.random.default_rng(1).normal(size=n)
    series = 5.0 + 2.0 * np.sin(2 * np.pi * 0.31 * t) + noise
    result = spectrum(series, dt)
    assert np.sum(result.density) * result.resolution == pytest.approx(series.var(), rel=0.02)
    assert result.frequency[np.argmax(result.density)] == pytest.approx(0.31, abs=result.resolution)
    high = result.frequency > 1.0
    assert result.density[high].mean() == pytest.approx(2 * dt, rel=0.03)  # white noise of unit variance
