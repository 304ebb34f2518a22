"""Reduced models: what each must reproduce exactly, and what it must refuse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array

from owt_model.errors import InputError
from owt_model.mesh import build_mesh
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.modes import dense_modes, factorise, lowest_modes
from owt_structure_node.core.mta import augment
from owt_structure_node.core.recovery import end_force_map
from owt_structure_node.core.reduction import guyan, interface_loads, load_vectors, reduce
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
    added = augment(factorise(k_ii), k_ii, m_ii, phi, loads)
    sigma2, vectors = added.sigma_squared, added.vectors
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
    """More than there is, nothing to augment with, the wrong structure."""
    mesh = frame.mesh
    six = random_basis(models, frame, 6)
    tower_only = np.zeros((1, mesh.n_nodes, 6))
    tower_only[0, mesh.tower_top, 0] = 1.0
    alien = models.load_basis(mesh, six.vectors, model_hash="0" * 64)
    nan = models.load_basis(mesh, np.full((1, mesh.n_nodes, 6), np.nan))
    outside = models.load_basis(mesh, np.ones((1, 1, 6)), node=np.array([mesh.n_nodes]))
    for reduction, basis, message in (
        ("CB999", None, "internal degrees of freedom"),
        ("M06", None, "needs 6 load vectors, no load basis"),
        ("M01", models.load_basis(mesh, tower_only), "has no vector left"),
        ("M06", models.load_basis(mesh, np.zeros((0, mesh.n_nodes, 6))), "has no vector left"),
        ("auto", six, "has no reduction basis"),
        ("M06", alien, "is not that of structure"),
        ("M01", nan, "must be finite"),
        ("M01", outside, "must be a node"),
        ("full", None, "has no reduction basis"),
        ("CB", None, "must be full, CBnn"),
    ):
        with pytest.raises(InputError, match=message):
            reduce(frame, reduction, basis)


def test_vectors_that_add_nothing_are_left_out(models, frame):
    """Repeated shapes, shapes above the jacket, and fewer shapes than asked for: a note, and the rest."""
    mesh = frame.mesh
    six = random_basis(models, frame, 6)
    alone = reduce(frame, "CB05M06", six)
    assert alone.notes == ()
    double = models.load_basis(mesh, np.concatenate([six.vectors, six.vectors[:3] + six.vectors[3:]]))
    found = reduce(frame, "CB05M09", double)
    assert found.notes == ("CB05M09 has 6 of 9 augmentation vectors: 3 depend on modes or on other vectors",)
    np.testing.assert_allclose(found.pseudo, alone.pseudo, rtol=1e-8)
    fewer = reduce(frame, "CB05M08", six)
    assert fewer.notes == ("CB05M08 has 6 of 8 augmentation vectors: the loads have 6 independent shapes",)
    above = np.zeros((1, mesh.n_nodes, 6))
    above[0, mesh.tower_top, 0] = 1.0
    mixed = models.load_basis(mesh, np.concatenate([above, six.vectors]))
    assert "1 of their shapes do not load the inside" in reduce(frame, "CB05M07", mixed).notes[0]
    bare = reduce(frame, "CB05M01", models.load_basis(mesh, above))
    np.testing.assert_array_equal(bare.stiffness, reduce(frame, "CB05").stiffness)
    assert bare.notes[0].startswith("CB05M01 has 0 of 1")
    everything = reduce(frame, f"CB{frame.internal - 2}M06", six)  # two vectors complete the space
    assert len(everything.mass) == frame.mesh.n_dof
    assert "4 depend" in everything.notes[0]


def test_higher_orders_and_interface_vectors(models, frame):
    """Counts, orthogonality, and the span of eq. 3.53 as printed."""
    basis = random_basis(models, frame, 3)
    n = frame.internal
    k_ii, m_ii = csc_array(frame.jacket_stiffness[:n, :n]), csc_array(frame.jacket_mass[:n, :n])
    reduced = reduce(frame, "CB05M03j2Y", basis)
    assert len(reduced.pseudo) == (3 + 6) * 3
    inside = reduced.shapes[:n, 6 : 6 + 5 + 27]
    assert np.abs(inside.T @ (m_ii @ inside) - np.eye(32)).max() < 1e-8
    factor, static = factorise(k_ii), guyan(frame)
    loads = np.hstack([load_vectors(frame, basis)[:n], interface_loads(frame, static)])
    vectors = factor.solve(loads)
    unit = inside / np.sqrt(np.einsum("di,di->i", inside, k_ii @ inside))
    for j in range(4):
        vectors = vectors / np.sqrt(np.einsum("di,di->i", vectors, k_ii @ vectors))
        left = vectors - unit @ (unit.T @ (k_ii @ vectors))
        share = np.sqrt(np.einsum("di,di->i", left, k_ii @ left)).max()
        assert (share < 1e-7) == (j < 3), (j, share)  # order 3 is not in the basis
        vectors = factor.solve(np.asarray(m_ii @ vectors))


def test_static_improvement_is_exact_for_static_loads(models, frame):
    """CB05+SIM gives displacement, end forces and energy of any static load; CB05 does not."""
    mesh = frame.mesh
    rng = np.random.default_rng(8)
    node = np.arange(4, mesh.transition_piece)
    nodal = np.zeros((mesh.n_nodes, 6))
    nodal[node] = rng.standard_normal((len(node), 6)) * 1e5
    load = frame.expansion.T @ nodal.reshape(-1)
    exact = factorise(frame.stiffness).solve(load)
    reduced = reduce(frame, "CB05+SIM")
    assert reduced.improvement is not None
    shift = static(frame, reduced, load)
    part = reduced.improvement.map(node)
    flat = nodal[node].reshape(1, -1)
    force = end_force_map(frame, exact[:, None])[0]
    plain = end_force_map(frame, shift[:, None])[0]
    improved = plain + part.forces(flat).reshape(-1, 6)
    assert error(improved, force) < 1e-8
    assert error(plain, force) > 1e-3
    energy = 0.5 * exact @ (frame.stiffness @ exact)
    base = 0.5 * shift @ (frame.stiffness @ shift)
    assert base + part.energy(flat, 1)[0] == pytest.approx(energy, rel=1e-9)
    assert base != pytest.approx(energy, rel=1e-4)


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
