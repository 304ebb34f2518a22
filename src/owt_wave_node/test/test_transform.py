"""The inverse transforms against numpy's, for lengths of every kind."""

from __future__ import annotations

import numpy as np
import pytest

from owt_wave_node.core.grid import FrequencyGrid
from owt_wave_node.core.transform import plan_transform

SPACING = 0.01


def plain(spectra: np.ndarray, length: int) -> np.ndarray:
    """Signals and their time derivatives by numpy."""
    rates = 1j * SPACING * np.arange(spectra.shape[2])
    half = 0.5 * np.concatenate([spectra, rates * spectra], axis=1)
    half[..., 0] = 2.0 * half[..., 0].real
    return np.asarray(np.fft.irfft(half, length, norm="forward"))


def coefficients(rows: int, signals: int, bins: int) -> np.ndarray:
    rng = np.random.default_rng(bins)
    return np.asarray(rng.standard_normal((rows, signals, bins, 2)) @ [1.0, 1j])


def grid(length: int, oversampling: int = 1) -> FrequencyGrid:
    return FrequencyGrid(np.array([1]), SPACING, length, oversampling, length // oversampling)


@pytest.mark.parametrize(
    ("length", "bins"),
    # Few and many bins for the same length, so that frequencies do and do not share places; every radix.
    [(6000, 254), (6000, 2900), (600, 7), (8, 3), (24, 11), (4096, 100), (1620, 300), (40000, 3000)],
)
@pytest.mark.parametrize("signals", [2, 3])
def test_equals_numpy(length: int, bins: int, signals: int) -> None:
    assert plan_transform(length, bins) is not None
    spectra = coefficients(3, signals, bins)
    index = np.array([2, 0])
    got = grid(length).series(spectra, index, channels=2 * signals)
    expected = plain(spectra, length)[index]
    for c in range(2 * signals):
        assert (
            np.abs(got[:, c] - expected[:, c]).max() < 2e-15 * np.log2(length) * np.abs(expected[:, c]).max()
        )
    shifted = np.roll(expected, 1, axis=-1)  # the wrong variant: one sample late
    assert np.abs(got - shifted).max() > 1e-3 * np.abs(expected).max()


def test_signals_without_derivatives() -> None:
    spectra = coefficients(2, 2, 50)
    got = grid(600).series(spectra, np.arange(2), channels=2)
    assert np.array_equal(got, grid(600).series(spectra, np.arange(2), channels=4)[:, :2])


def test_any_number_of_signals() -> None:
    spectra = coefficients(1, 5, 50)
    expected = plain(spectra, 600)[:, :5]
    for got in (grid(600).signal(spectra), grid(600).signal(spectra[0])[None]):
        assert np.abs(got - expected).max() < 1e-13 * np.abs(expected).max()


@pytest.mark.parametrize("length", [6001, 4004, 5998, 6])
def test_other_lengths_take_the_library(length: int) -> None:
    """A length without a factor 4, or with a prime factor above 5, has no plan and the same answer."""
    assert plan_transform(length, 3) is None
    spectra = coefficients(2, 2, 3)
    got = grid(length).series(spectra, np.arange(2), channels=4)
    assert np.abs(got - plain(spectra, length)).max() < 1e-13 * np.abs(got).max()


def test_subsampling() -> None:
    spectra = coefficients(1, 2, 200)
    fine = grid(1200).series(spectra, np.array([0]), channels=4)
    coarse = grid(1200, 3).series(spectra, np.array([0]), channels=4)
    assert np.array_equal(fine[..., ::3], coarse)
