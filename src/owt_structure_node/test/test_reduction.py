"""Reduced models: what each must reproduce exactly, and what it must refuse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array

from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.modes import dense_modes, factorise, lowest_modes
from owt_structure_node.core.reduction import guyan, load_vectors, mta_vectors, reduce
from owt_structure_node.core.stage import n_mta


@pytest.fixture(scope="module")
def frame(models):
    mesh = build_mesh(models.frame())
    return assemble(mesh)


def random_basis(models, assembly, count, seed=0):
    mesh = assembly.mesh
    vectors = np.random.default_rng(seed).standard_normal((count, mesh.n_nodes, 6))
    vectors[:, mesh.transition_piece :] = 0.0
    return models.load_basis(mesh, vectors)


def static(assembly, reduced, load):
    """Static displacement of the reduced model, over the unreduced degrees of freedom."""
    return reduced.shapes @ np.linalg.solve(reduced.stiffness, reduced.shapes.T @ load)


def error(found, exact):
    return np.abs(found - exact).max() / np.abs(exact).max()


def test_guyan_is_exact_for_boundary_loads(frame):
    """CB00 gives the exact static answer to loads on transition piece and tower, and to no others."""
    rng = np.random.default_rng(2)
    load = np.zeros(frame.mesh.n_dof)
    load[frame.internal :] = rng.standard_normal(frame.mesh.n_dof - frame.internal)
    exact = factorise(frame.stiffness).solve(load)
    reduced = reduce(frame, "CB00")
    assert error(static(frame, reduced, load), exact) < 1e-9
    load[: frame.internal] = 10 * rng.standard_normal(frame.internal)
    exact = factorise(frame.stiffness).solve(load)
    assert error(static(frame, reduced, load), exact) > 1e-2


def test_all_fixed_interface_modes_give_the_full_model(frame):
    """As many modes as internal degrees of freedom: the frequencies of the unreduced structure."""
    full = dense_modes(frame.stiffness.toarray(), frame.mass.toarray())[0]
    complete = reduce(frame, f"CB{frame.internal}")
    found = dense_modes(complete.stiffness, complete.mass)[0]
    assert np.abs(np.sqrt(found / full) - 1).max() < 1e-6
    fewer = reduce(frame, f"CB{frame.internal // 2}")
    found = dense_modes(fewer.stiffness, fewer.mass)[0]
    assert np.abs(np.sqrt(found / full[: len(found)]) - 1).max() > 1e-3


@pytest.mark.parametrize("reduction", ["M06", "CB05M06"])
def test_mta_is_exact_for_static_loads_in_the_span(models, frame, reduction):
    """A static load made of the load vectors, plus any boundary load, is answered exactly."""
    basis = random_basis(models, frame, 6)
    reduced = reduce(frame, reduction, basis)
    rng = np.random.default_rng(4)
    load = load_vectors(frame, basis) @ rng.standard_normal(6)
    load[frame.internal :] += rng.standard_normal(frame.mesh.n_dof - frame.internal)
    exact = factorise(frame.stiffness).solve(load)
    assert error(static(frame, reduced, load), exact) < 1e-8
    other = load_vectors(frame, random_basis(models, frame, 6, seed=9)) @ rng.standard_normal(6)
    exact = factorise(frame.stiffness).solve(other)
    assert error(static(frame, reduced, other), exact) > 1e-3


def test_orthogonality(models, frame):
    """Eq. 3.44 for modes and augmentation vectors together, and the structure of eq. 3.57."""
    basis = random_basis(models, frame, 6)
    n = frame.internal
    k_ii, m_ii = csc_array(frame.jacket_stiffness[:n, :n]), csc_array(frame.jacket_mass[:n, :n])
    omega2, phi = lowest_modes(k_ii, m_ii, 5)
    loads = load_vectors(frame, basis)[:n]
    sigma2, vectors = mta_vectors(factorise(k_ii), k_ii, m_ii, phi, loads)
    both = np.hstack([phi, vectors])
    square = np.concatenate([omega2, sigma2])

    def check(shapes):
        assert np.abs(shapes.T @ (m_ii @ shapes) - np.eye(11)).max() < 1e-8
        scaled = shapes / np.sqrt(square)
        assert np.abs(scaled.T @ (k_ii @ scaled) - np.eye(11)).max() < 1e-8

    check(both)
    raw = factorise(k_ii).solve(loads)  # neither orthogonalised nor through the interaction problem
    raw /= np.sqrt(np.einsum("dv,dv->v", raw, m_ii @ raw))
    with pytest.raises(AssertionError):
        check(np.hstack([phi, raw]))
    assert (sigma2 > omega2[-1]).all()  # pseudo-frequencies lie above the modes kept (thesis 3.6.2)
    reduced = reduce(frame, "CB05M06", basis)
    coupling = reduced.stiffness[:6, 6:17]
    assert np.abs(coupling).max() < 1e-9 * np.abs(reduced.stiffness[:6, :6]).max()
    assert reduced.coordinate_name[:7] == ("TP.ux", "TP.uy", "TP.uz", "TP.rx", "TP.ry", "TP.rz", "CB.01")
    assert reduced.coordinate_name[10:12] == ("CB.05", "MTA.01")
    assert reduced.coordinate_name[-6] == "tower.3.ux"
    assert len(reduced.coordinate_name) == len(reduced.mass) == 6 + 5 + 6 + 18


def test_reduction_is_from_above_and_improves(frame):
    """Rayleigh-Ritz: frequencies from above, none worse with a larger basis."""
    full = dense_modes(frame.stiffness.toarray(), frame.mass.toarray())[0][:10]
    before = np.full(10, np.inf)
    for name in ("CB00", "CB05", "CB20", "CB60"):
        reduced = reduce(frame, name)
        found = dense_modes(reduced.stiffness, reduced.mass)[0][:10]
        assert (found >= full * (1 - 1e-9)).all()
        assert (found <= before * (1 + 1e-9)).all()
        before = found
    assert np.abs(before / full - 1).max() < 1e-2


def test_iterative_modes_are_the_dense_ones(models):
    """Sparse shift-invert against the dense solver, on a frame large enough for the sparse one."""
    assembly = assemble(build_mesh(models.frame(elements_per_member=5)))
    n = assembly.internal
    assert n > 300
    k_ii, m_ii = csc_array(assembly.jacket_stiffness[:n, :n]), csc_array(assembly.jacket_mass[:n, :n])
    sparse, shapes = lowest_modes(k_ii, m_ii, 25)
    dense, _ = dense_modes(k_ii.toarray(), m_ii.toarray())
    assert np.abs(sparse / dense[:25] - 1).max() < 1e-6
    assert np.abs(sparse[:24] / dense[1:25] - 1).max() > 1e-6  # one mode missed
    residual = k_ii @ shapes - (m_ii @ shapes) * sparse
    assert np.abs(residual).max() < 1e-6 * np.abs(k_ii @ shapes).max()
    assert np.abs(shapes.T @ (m_ii @ shapes) - np.eye(25)).max() < 1e-9


def test_guyan_matrices_are_symmetric_and_definite(frame):
    static_model = guyan(frame)
    assert (np.linalg.eigvalsh(static_model.stiffness) > 0).all()
    assert (np.linalg.eigvalsh(static_model.mass) > 0).all()


def test_refusals(models, frame):
    """More than there is, nothing to augment with, dependent vectors, the wrong structure."""
    mesh = frame.mesh
    six = random_basis(models, frame, 6)
    double = models.load_basis(mesh, np.concatenate([six.vectors[:3], six.vectors[:3]]))
    tower_only = np.zeros((1, mesh.n_nodes, 6))
    tower_only[0, mesh.tower_top, 0] = 1.0
    alien = models.load_basis(mesh, six.vectors, model_hash="0" * 64)
    nan = models.load_basis(mesh, np.full((1, mesh.n_nodes, 6), np.nan))
    outside = models.load_basis(mesh, np.ones((1, 1, 6)), node=np.array([mesh.n_nodes]))
    for reduction, basis, message in (
        ("CB999", None, "internal degrees of freedom"),
        ("M06", None, "needs 6 load vectors, 0 are given"),
        ("M08", six, "needs 8 load vectors, 6 are given"),
        ("M06", double, "depend on each other"),
        ("M01", models.load_basis(mesh, tower_only), "does not load the inside"),
        ("M06", alien, "is not that of structure"),
        ("M01", nan, "must be finite"),
        ("M01", outside, "must be a node"),
        ("full", None, "has no reduction basis"),
        ("CB", None, "must be full, CBnn"),
    ):
        with pytest.raises(InputError, match=message):
            reduce(frame, reduction, basis)


def test_number_of_load_vectors():
    assert [n_mta(name) for name in ("full", "CB00", "CB20", "M20", "CB10M10", "CB10M100")] == [
        0,
        0,
        0,
        20,
        10,
        100,
    ]
    with pytest.raises(InputError):
        n_mta("nonsense")
