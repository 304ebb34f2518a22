"""Proper orthogonal decomposition of a load history."""

from __future__ import annotations

import numpy as np
import pytest

from owt_model.block_lanczos import leading_shapes
from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.pod import BANDS, Scatter, clustered_basis, load_basis

RNG = np.random.default_rng(3)
NODE = np.arange(4)


def history(n: int = 400, rank: int = 3) -> np.ndarray:
    shapes = RNG.standard_normal((rank, 4, 6))
    weights = RNG.standard_normal((n, rank)) * (10.0 ** -np.arange(rank))
    return np.asarray(np.tensordot(weights, shapes, axes=1) + RNG.standard_normal((4, 6)))


def residual(nodal: np.ndarray, vectors: np.ndarray) -> float:
    centred = (nodal - nodal.mean(axis=0)).reshape(len(nodal), -1)
    flat = vectors.reshape(len(vectors), -1)
    return float(np.linalg.norm(centred - centred @ flat.T @ flat) / np.linalg.norm(centred))


@pytest.mark.parametrize("n", [400, 10])
def test_vectors_span_the_history(n: int) -> None:
    nodal = history(n)
    basis = load_basis(nodal, NODE, 3, model_hash="h")
    assert residual(nodal, basis.vectors) < 1e-13
    # Negative control: one vector fewer does not.
    assert residual(nodal, basis.vectors[:2]) > 1e-4


def test_truncation_error_is_the_discarded_singular_values() -> None:
    nodal = RNG.standard_normal((300, 4, 6)) * np.linspace(1.0, 3.0, 24).reshape(4, 6)
    basis = load_basis(nodal, NODE, 5, model_hash="h")
    sigma = np.linalg.svd((nodal - nodal.mean(axis=0)).reshape(300, -1), compute_uv=False)
    np.testing.assert_allclose(basis.singular_values, sigma[:5], rtol=1e-12)
    expected = np.sqrt((sigma[5:] ** 2).sum() / (sigma**2).sum())
    assert expected == pytest.approx(np.sqrt(1.0 - basis.variance_fraction), rel=1e-10)
    assert residual(nodal, basis.vectors) == pytest.approx(expected, rel=1e-12)
    # Negative control: shares by sigma instead of sigma squared are wrong.
    assert residual(nodal, basis.vectors) != pytest.approx(np.sqrt(sigma[5:].sum() / sigma.sum()), rel=1e-2)
    flat = basis.vectors.reshape(5, -1)
    np.testing.assert_allclose(flat @ flat.T, np.eye(5), atol=1e-13)


def test_mean_is_kept_apart() -> None:
    nodal = history()
    basis = load_basis(nodal, NODE, 2, model_hash="h")
    np.testing.assert_allclose(basis.mean, nodal.mean(axis=0), rtol=1e-14)


def test_fewer_shapes_than_asked_for() -> None:
    """Only what rises above round-off is kept; loads that do not change have no shape at all."""
    nodal = history()
    basis = load_basis(nodal, NODE, 4, model_hash="h")
    assert basis.vectors.shape == (3, 4, 6)
    assert residual(nodal, basis.vectors) < 1e-13
    assert load_basis(np.zeros((50, 4, 6)), NODE, 4, model_hash="h").vectors.shape == (0, 4, 6)
    assert load_basis(np.full((50, 4, 6), 7.0), NODE, 4, model_hash="h").vectors.shape == (0, 4, 6)
    scatter = Scatter()
    scatter.add(np.zeros((50, 4, 6)))
    assert scatter.basis(NODE, 4, model_hash="h").vectors.shape == (0, 4, 6)
    assert load_basis(history(), NODE, 0, model_hash="h").vectors.shape == (0, 4, 6)


def test_lanczos_agrees_with_the_dense_decomposition() -> None:
    """A history larger than the dense limit: same values and vectors as LAPACK."""
    shapes = np.linalg.qr(RNG.standard_normal((360, 360)))[0].reshape(360, 60, 6)
    nodal = np.tensordot(RNG.standard_normal((900, 360)) * 0.9 ** np.arange(360), shapes, axes=1)
    basis = load_basis(nodal, np.arange(60), 6, model_hash="h")
    centred = (nodal - nodal.mean(axis=0)).reshape(900, -1)
    _, sigma, vectors = np.linalg.svd(centred, full_matrices=False)
    np.testing.assert_allclose(basis.singular_values, sigma[:6], rtol=1e-12)
    overlap = basis.vectors.reshape(6, -1) @ vectors[:6].T
    np.testing.assert_allclose(np.abs(overlap), np.eye(6), atol=1e-9)
    # Negative control: the vectors of the history whose mean is left in are others.
    _, _, wrong = np.linalg.svd(centred + 1.0, full_matrices=False)
    assert np.abs(np.abs(basis.vectors.reshape(6, -1) @ wrong[:6].T) - np.eye(6)).max() > 1e-3


def gathered(nodal: np.ndarray, cuts: list[int], n_vectors: int) -> LoadBasis:
    scatter = Scatter()
    for part in np.split(nodal, cuts):
        scatter.add(part)
    return scatter.basis(np.arange(nodal.shape[1]), n_vectors, model_hash="h")


@pytest.mark.parametrize(("loaded", "n"), [(4, 400), (60, 1700)])
def test_windows_give_the_basis_of_the_whole(loaded: int, n: int) -> None:
    """Dense and Lanczos, windows of any length, also of one snapshot; a mean that drifts."""
    rng = np.random.default_rng(5)
    shapes = np.linalg.qr(rng.standard_normal((6 * loaded, 6 * loaded)))[0].reshape(-1, loaded, 6)
    decay = 0.8 ** np.arange(6 * loaded)
    nodal = np.tensordot(rng.standard_normal((n, 6 * loaded)) * decay, shapes, axes=1)
    nodal += np.linspace(0.0, 3.0, n)[:, None, None] * rng.standard_normal((loaded, 6))
    whole = load_basis(nodal, np.arange(loaded), 5, model_hash="h")
    parts = gathered(nodal, [1, 130, 131, n - 90], 5)
    assert parts.snapshots == n
    np.testing.assert_allclose(parts.mean, whole.mean, rtol=0, atol=1e-13 * np.abs(nodal).max())
    np.testing.assert_allclose(parts.singular_values, whole.singular_values, rtol=1e-12)
    np.testing.assert_allclose(parts.vectors, whole.vectors, rtol=0, atol=1e-8)
    assert parts.total_variance == pytest.approx(whole.total_variance, rel=1e-12)
    # Negative control: windows that each lose their own mean, the means never brought together.
    own = np.concatenate([part - part.mean(axis=0) for part in np.split(nodal, [1, 130, 131, n - 90])])
    wrong = load_basis(own, np.arange(loaded), 5, model_hash="h")
    assert np.abs(wrong.vectors - whole.vectors).max() > 1e-5


def test_windows_of_fewer_shapes() -> None:
    nodal = history()
    assert gathered(nodal, [200], 3).vectors.shape == (3, 4, 6)
    assert gathered(nodal, [200], 0).total_variance > 0.0
    found = gathered(nodal, [200], 4)
    assert found.vectors.shape == (3, 4, 6)
    assert found.spectrum.shape == (0, 0)  # not known of windows


@pytest.mark.parametrize("n", [400, 401])
def test_spectrum_of_the_amplitudes(n: int) -> None:
    """Bands add up to the POV, and a cosine lies in its band alone."""
    basis = load_basis(history(n), NODE, 3, model_hash="h")
    np.testing.assert_allclose(basis.spectrum.sum(axis=1), basis.pov, rtol=1e-12)
    assert basis.pov[0] != pytest.approx(basis.singular_values[0] / n, rel=1e-2)  # sigma squared, not sigma
    shape = RNG.standard_normal((4, 6))
    wave = np.cos(2.0 * np.pi * 0.1 * np.arange(n - n % 10))
    one = load_basis(wave[:, None, None] * shape, NODE, 1, model_hash="h").spectrum[0]
    assert one.argmax() == int(0.2 * BANDS)
    assert one.max() == pytest.approx(one.sum(), rel=1e-12)
    time = np.arange(n - n % 50)
    slow = np.cos(2.0 * np.pi * 0.02 * time) + 0.01 * np.cos(0.8 * np.pi * time)
    loads = slow[:, None, None] * shape
    for vectors in (0, 1):  # a ten-thousandth of the variance at 0.4 does not count, all of it at 0.1 does
        found = load_basis(loads, NODE, vectors, model_hash="h").highest_frequency
        assert found == pytest.approx(0.02, abs=1.0 / BANDS)
    found = load_basis(wave[:, None, None] * shape, NODE, 0, model_hash="h").highest_frequency
    assert found == pytest.approx(0.1, abs=1.0 / BANDS)
    assert load_basis(np.ones((9, 4, 6)), NODE, 0, model_hash="h").highest_frequency == 0.0


def test_clusters_weigh_every_case_alike() -> None:
    """A small and a large sea state of one shape each share the basis; unnormalised the large one has it."""
    small, large = RNG.standard_normal((2, 4, 6))
    cases = [
        RNG.standard_normal((300, 1, 1)) * small * 1e-3,
        RNG.standard_normal((200, 1, 1)) * large * 1e3 + 5.0,
    ]
    both = clustered_basis(iter(cases), NODE, 2, model_hash="h")
    assert max(residual(case, both.vectors) for case in cases) < 1e-9
    assert both.total_variance == pytest.approx(2.0)
    assert both.snapshots == 500
    one = clustered_basis(cases, NODE, 1, model_hash="h")
    assert min(residual(case, one.vectors) for case in cases) > 0.1
    plain = load_basis(np.concatenate(cases), NODE, 1, model_hash="h")
    assert residual(cases[1], plain.vectors) < 1e-3  # negative control: the small case is not seen
    alone = clustered_basis([cases[1]], NODE, 1, model_hash="h")
    np.testing.assert_allclose(
        alone.vectors, load_basis(cases[1], NODE, 1, model_hash="h").vectors, atol=1e-9
    )
    with pytest.raises(InputError, match="must be one or more"):
        clustered_basis([], NODE, 1, model_hash="h")
    with pytest.raises(InputError, match="must have 4 nodes"):
        clustered_basis([np.zeros((5, 3, 6))], NODE, 1, model_hash="h")


def test_large_history_of_few_shapes() -> None:
    """Fewer shapes than asked for, and one far smaller than the others: squares know too little of them."""
    shapes = np.linalg.qr(RNG.standard_normal((360, 4)))[0].T.reshape(4, 60, 6)
    weights = RNG.standard_normal((900, 4)) * [1.0, 0.5, 0.1, 1e-9]
    nodal = np.tensordot(weights, shapes, axes=1) + RNG.standard_normal((60, 6))
    basis = load_basis(nodal, np.arange(60), 6, model_hash="h")
    assert len(basis.vectors) >= 4
    sigma = np.linalg.svd((nodal - nodal.mean(axis=0)).reshape(900, -1), compute_uv=False)
    np.testing.assert_allclose(basis.singular_values[:4], sigma[:4], rtol=1e-5)
    rows = nodal.reshape(900, -1).T
    assert leading_shapes(rows, rows.mean(axis=1), 6) is None
    few = leading_shapes(rows, rows.mean(axis=1), 3)
    assert few is not None
    np.testing.assert_allclose(few[0], sigma[:3], rtol=1e-12)
    # Negative control: with the mean left in the values are others.
    wrong = leading_shapes(rows, np.zeros(360), 3)
    assert wrong is None or np.abs(wrong[0] / sigma[:3] - 1.0).max() > 1e-3
