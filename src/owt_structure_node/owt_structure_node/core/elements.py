"""Two-node beam element in its own axes: stiffness, mass of the wall, and mass over a part of its length.

Degrees of freedom: ux, uy, uz, rx, ry, rz of the first node, then of the second; x along the element
(:mod:`owt_model.axes`), rotations right-handed, so that ry = -dw/dx and rz = +dv/dx.

Stiffness is Euler-Bernoulli's or Timoshenko's; the mass is Euler-Bernoulli's consistent mass in both
cases, as in OpenFAST's SubDyn: no shear in the mass, rotary inertia on request, torsion with rho J.

The lumped mass has no terms off the diagonal: the mass goes to the nodes as a lever has it, halves where it
is uniform, with the rotary terms of the scaled diagonal of the consistent matrix (Hinton, Rock and
Zienkiewicz 1976), L^2/39 of each node's mass; rho J L/2 in torsion, rho I L/2 in bending on request.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from owt_model.section import area, bending_inertia, polar_inertia

__all__ = [
    "lumped_mass",
    "partial_mass",
    "shear_coefficient",
    "shear_parameter",
    "slope_matrix",
    "stiffness",
    "tube_mass",
]

Array = Float[np.ndarray, " element"]
Matrices = Float[np.ndarray, "element 12 12"]

#: Degrees of freedom of bending in the x-y and in the x-z plane, and the sign of each against
#: (deflection, slope, deflection, slope).
_PLANES = (
    (np.array([1, 5, 7, 11]), np.array([1.0, 1.0, 1.0, 1.0])),
    (np.array([2, 4, 8, 10]), np.array([1.0, -1.0, 1.0, -1.0])),
)
#: Four Gauss points integrate the square of a cubic shape function exactly.
_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(4)


def shear_coefficient(diameter: Array, thickness: Array, poisson: Array) -> Array:
    """Shear coefficient kappa of a tube: shear area over area, as SubDyn has it.

    Parameters
    ----------
    diameter, thickness : float arrays [element]
        Outer diameter and wall thickness in m.
    poisson : float array [element]
        Poisson's ratio nu = E/(2G) - 1.
    """
    nu = poisson
    r2 = ((diameter - 2.0 * thickness) / diameter) ** 2
    ring = (1.0 + r2) ** 2
    numerator = 6.0 * (1.0 + nu) ** 2 * ring
    return np.asarray(
        numerator / (ring * (7.0 + 14.0 * nu + 8.0 * nu**2) + 4.0 * r2 * (5.0 + 10.0 * nu + 4.0 * nu**2))
    )


def shear_parameter(
    length: Array, diameter: Array, thickness: Array, youngs_modulus: Array, shear_modulus: Array
) -> Array:
    """Ratio 12 E I / (kappa G A L^2) of bending to shear flexibility of a Timoshenko element."""
    kappa = shear_coefficient(diameter, thickness, youngs_modulus / (2.0 * shear_modulus) - 1.0)
    bending = 12.0 * youngs_modulus * bending_inertia(diameter, thickness)
    return np.asarray(bending / (kappa * shear_modulus * area(diameter, thickness) * length**2))


def stiffness(
    length: Array,
    diameter: Array,
    thickness: Array,
    youngs_modulus: Array,
    shear_modulus: Array,
    shear: Array,
) -> Matrices:
    """Stiffness matrices in element axes.

    Parameters
    ----------
    length, diameter, thickness : float arrays [element]
        In m.
    youngs_modulus, shear_modulus : float arrays [element]
        In Pa.
    shear : float array [element]
        :func:`shear_parameter` of a Timoshenko element, zero for Euler-Bernoulli.

    Returns
    -------
    float array [element, 12, 12]
        In N/m, N, N m.
    """
    inertia = bending_inertia(diameter, thickness)
    axial = youngs_modulus * area(diameter, thickness) / length
    torsion = shear_modulus * polar_inertia(diameter, thickness) / length
    result = np.zeros((len(length), 12, 12))
    _add_bar(result, 0, axial * np.array([[1.0], [-1.0]]))
    _add_bar(result, 3, torsion * np.array([[1.0], [-1.0]]))
    ell, phi, unit = length, shear, np.ones_like(length)
    block = _symmetric4(
        [12.0 * unit, 6.0 * ell, -12.0 * unit, 6.0 * ell],
        [(4.0 + phi) * ell**2, -6.0 * ell, (2.0 - phi) * ell**2],
    )
    block *= (youngs_modulus * inertia / (length**3 * (1.0 + shear)))[:, None, None]
    _add_planes(result, block)
    return result


def tube_mass(
    length: Array,
    diameter: Array,
    thickness: Array,
    density: Array,
    *,
    rotary_inertia: bool,
    lumped: bool = False,
) -> Matrices:
    """Mass matrices of the wall, in element axes [element, 12, 12], in kg, kg m, kg m2.

    Parameters
    ----------
    length, diameter, thickness : float arrays [element]
        In m.
    density : float array [element]
        In kg/m3.
    rotary_inertia : bool
        Whether the cross-sections resist rotation in bending (Rayleigh's term).
    lumped : bool
        Lumped instead of consistent.
    """
    line = density * area(diameter, thickness)
    if lumped:
        result = lumped_mass(length, np.zeros_like(length), np.ones_like(length), line, line)
        result[:, [3, 9], [3, 9]] += (0.5 * density * polar_inertia(diameter, thickness) * length)[:, None]
        if rotary_inertia:
            bending = (0.5 * density * bending_inertia(diameter, thickness) * length)[:, None]
            result[:, [4, 5, 10, 11], [4, 5, 10, 11]] += bending
        return result
    result = partial_mass(length, np.zeros_like(length), np.ones_like(length), line, line)
    torsion = density * polar_inertia(diameter, thickness) * length / 6.0
    _add_bar(result, 3, torsion * np.array([[2.0], [1.0]]))
    if rotary_inertia:
        line = density * bending_inertia(diameter, thickness)
        result += slope_matrix(length) * line[:, None, None]
    return result


def slope_matrix(length: Array) -> Matrices:
    """Integral of the product of the shape functions' slopes, both planes of bending, in element axes.

    Times rho I the rotary inertia, times an axial force (tension positive) the geometric stiffness.
    """
    ell, unit = length, np.ones_like(length)
    block = _symmetric4(
        [36.0 * unit, 3.0 * ell, -36.0 * unit, 3.0 * ell], [4.0 * ell**2, -3.0 * ell, -(ell**2)]
    )
    result = np.zeros((len(length), 12, 12))
    _add_planes(result, block / (30.0 * ell)[:, None, None])
    return result


def partial_mass(length: Array, begin: Array, end: Array, transverse: Array, axial: Array) -> Matrices:
    """Consistent mass of a line mass that covers a part of each element, integrated exactly.

    Parameters
    ----------
    length : float array [element]
        In m.
    begin, end : float arrays [element]
        Part covered, as fractions of the length from the first node.
    transverse, axial : float arrays [element]
        Mass per length in kg/m that moves with the element across and along its axis. Torsion and
        rotary inertia of the line mass are left out.

    Returns
    -------
    float array [element, 12, 12]
        In element axes; kg, kg m, kg m2.
    """
    half = 0.5 * (end - begin)
    xi = (begin + half)[:, None] + half[:, None] * _GAUSS_X
    weight = (length * half)[:, None] * _GAUSS_W
    ell = length[:, None]
    bend = np.stack(
        [
            1.0 - 3.0 * xi**2 + 2.0 * xi**3,
            ell * (xi - 2.0 * xi**2 + xi**3),
            3.0 * xi**2 - 2.0 * xi**3,
            ell * (xi**3 - xi**2),
        ],
        axis=-1,
    )
    bar = np.stack([1.0 - xi, xi], axis=-1)
    result = np.zeros((len(length), 12, 12))
    lateral = np.einsum("ep,epi,epj->eij", weight, bend, bend) * transverse[:, None, None]
    along = np.einsum("ep,epi,epj->eij", weight, bar, bar) * axial[:, None, None]
    _add_planes(result, lateral)
    result[:, 0, 0] += along[:, 0, 0]
    result[:, 6, 6] += along[:, 1, 1]
    result[:, 0, 6] += along[:, 0, 1]
    result[:, 6, 0] += along[:, 1, 0]
    return result


def lumped_mass(length: Array, begin: Array, end: Array, transverse: Array, axial: Array) -> Matrices:
    """Lumped mass of a line mass that covers a part of each element: arguments as of :func:`partial_mass`."""
    covered = length * (end - begin)
    second = 0.5 * (begin + end)
    result = np.zeros((len(length), 12, 12))
    for first, share in ((0, 1.0 - second), (6, second)):
        result[:, first, first] = axial * covered * share
        for dof in (1, 2):
            result[:, first + dof, first + dof] = transverse * covered * share
        for dof in (4, 5):
            result[:, first + dof, first + dof] = transverse * covered * share * length**2 / 39.0
    return result


def _add_bar(result: Matrices, dof: int, terms: Float[np.ndarray, "2 element"]) -> None:
    """Add diagonal term ``terms[0]`` and coupling ``terms[1]`` of a two-node bar at `dof`."""
    result[:, dof, dof] += terms[0]
    result[:, dof + 6, dof + 6] += terms[0]
    result[:, dof, dof + 6] += terms[1]
    result[:, dof + 6, dof] += terms[1]


def _symmetric4(first: list[Array], slope: list[Array]) -> Float[np.ndarray, "element 4 4"]:
    """Beam matrix of (deflection, slope) at both ends from its first row and the rest of its second row."""
    dd, ds, dd2, ds2 = first
    ss, sd2, ss2 = slope
    rows = [[dd, ds, dd2, ds2], [ds, ss, sd2, ss2], [dd2, sd2, dd, -ds], [ds2, ss2, -ds, ss]]
    return np.moveaxis(np.array(rows), -1, 0).copy()


def _add_planes(result: Matrices, block: Float[np.ndarray, "element 4 4"]) -> None:
    """Add a beam matrix to both planes of bending."""
    for dofs, sign in _PLANES:
        index: tuple[slice, Int[np.ndarray, "4 1"], Int[np.ndarray, " 4"]] = (
            slice(None),
            dofs[:, None],
            dofs,
        )
        result[index] += block * (sign[:, None] * sign)
