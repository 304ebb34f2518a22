"""A reduced substructure with its loads, and the text file of it that Flex5 and OpenFAST's ExtPtfm share.

The first six degrees of freedom are those of the interface, surge, sway, heave, roll, pitch and yaw along and
about x, y, z (z up, right-handed); generalised coordinates inside the substructure follow. SI units. What the
loads act on is the substructure, in the same order and sense::

    M x'' + C x' + K x = loads + force of the structure above at the interface

:mod:`owt_model.superelement_file` reads what is written here.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from io import TextIOBase

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["INTERFACE", "Superelement", "extptfm_notes", "write_openfast5", "write_superelement"]

#: Degrees of freedom of the interface, the first ones.
INTERFACE = 6
#: Difference of two entries that should be equal, relative to the diagonal: files have six digits and more.
_SYMMETRY = 1e-5
#: ExtPtfm cuts the lines of the loads there.
_LINE = 4096
_DIGITS = "%23.16e"  # seventeen significant digits: float64 exactly


@dataclass(frozen=True)
class Superelement:
    """Matrices of a substructure on its supports, and a record of its loads.

    Attributes
    ----------
    mass, stiffness, damping : float arrays [dof, dof]
        In kg, kg m, kg m2; N/m, N, N m; N s/m, N s, N m s, for mass-normalised coordinates their modal
        equivalents.
    dt : float
        Time step of the loads in s; without meaning for a single sample, which is a constant load.
    loads : float array [sample, dof]
        Forces in N, moments in N m and generalised loads from t = 0 on, linear in between.
    elevation : float array [sample], optional
        Surface elevation in m.
    comments : tuple of str
        One line each.

    Raises
    ------
    InputError
        If a value is not finite, a matrix is not symmetric, mass or stiffness is not positive definite, or
        sizes do not fit.
    """

    mass: Float[np.ndarray, "dof dof"]
    stiffness: Float[np.ndarray, "dof dof"]
    damping: Float[np.ndarray, "dof dof"]
    dt: float
    loads: Float[np.ndarray, "sample dof"]
    elevation: Float[np.ndarray, " sample"] | None = None
    comments: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.mass)
        if n < INTERFACE:
            raise InputError(
                "dimension", n, "must be at least 6", "The first six degrees of freedom are the interface's."
            )
        if not (np.isfinite(self.dt) and self.dt > 0.0):
            raise InputError("time increment", self.dt, "must be > 0 s", "Give the step of the loads.")
        for name in ("mass", "stiffness", "damping"):
            _check_matrix(f"{name} matrix", getattr(self, name), n, definite=name != "damping")
        if self.loads.ndim != 2 or self.loads.shape[1] != n or not len(self.loads):
            raise InputError(
                "loads", self.loads.shape, f"must be one sample or more of {n} columns", "Give each a load."
            )
        if not np.isfinite(self.loads).all():
            sample, dof = np.argwhere(~np.isfinite(self.loads))[0].tolist()
            raise InputError(
                f"loads, sample {sample + 1}, degree of freedom {dof + 1}",
                float(self.loads[sample, dof]),
                "must be finite",
                "Check the loads.",
            )
        if self.elevation is not None and not (
            self.elevation.shape == (len(self.loads),) and np.isfinite(self.elevation).all()
        ):
            raise InputError(
                "wave elevation",
                self.elevation.shape,
                f"must be {len(self.loads)} finite numbers, one for each sample of the loads",
                "Leave it out if it is not known.",
            )

    @property
    def n_dof(self) -> int:
        """Number of degrees of freedom, those of the interface included."""
        return len(self.mass)

    @property
    def duration(self) -> float:
        """Time of the last sample in s."""
        return (len(self.loads) - 1) * self.dt


def _check_matrix(name: str, matrix: Float[np.ndarray, "row column"], n: int, *, definite: bool) -> None:
    """Refuse a matrix that no structure has; what is off is named by row and column, from 1."""
    if matrix.shape != (n, n):
        raise InputError(name, matrix.shape, f"must be {n} x {n}", "All matrices have one dimension.")
    if not np.isfinite(matrix).all():
        i, j = np.argwhere(~np.isfinite(matrix))[0].tolist()
        raise InputError(f"{name} [{i + 1}, {j + 1}]", float(matrix[i, j]), "must be finite", "Check it.")
    diagonal = matrix.diagonal()
    i = int(diagonal.argmin())
    if diagonal[i] < 0.0 or (definite and diagonal[i] == 0.0):
        rule = "must be > 0" if definite else "must be >= 0"
        remedy = "A substructure stands on supports and has mass in every direction."
        raise InputError(f"{name} [{i + 1}, {i + 1}]", float(diagonal[i]), rule, remedy)
    scale = np.sqrt(diagonal)
    excess = np.abs(matrix - matrix.T) - _SYMMETRY * np.outer(scale, scale)
    if (excess > 0.0).any():
        i, j = sorted(divmod(int(excess.argmax()), n))
        raise InputError(
            f"{name} [{i + 1}, {j + 1}] and [{j + 1}, {i + 1}]",
            (float(matrix[i, j]), float(matrix[j, i])),
            "must be equal",
            "Check rows and columns, or write more digits.",
        )
    if definite:
        smallest = float(np.linalg.eigvalsh(matrix / np.outer(scale, scale))[0])
        if not smallest > 0.0:
            raise InputError(
                name,
                smallest,
                "must be positive definite; this is its lowest eigenvalue, the diagonal scaled to one",
                "Check the order of rows and columns, or write more digits.",
            )


def extptfm_notes(element: Superelement) -> tuple[str, ...]:
    """Say what ExtPtfm takes for granted and `element` does not have, one line each.

    Its equations have an identity for the mass of the inner coordinates, and no stiffness between them and
    the interface: a Craig-Bampton basis of mass-normalised modes has both.
    """
    inner, notes = slice(INTERFACE, None), []
    away = np.abs(element.mass[inner, inner] - np.eye(element.n_dof - INTERFACE)).max(initial=0.0)
    if away > 1e-6:
        notes.append(f"the inner mass matrix differs from the identity, which ExtPtfm takes, by {away:.1e}")
    scale = np.sqrt(element.stiffness.diagonal())
    coupling = element.stiffness[:INTERFACE, inner] / np.outer(scale[:INTERFACE], scale[inner])
    away = np.abs(coupling).max(initial=0.0)
    if away > 1e-6:
        notes.append(f"stiffness between interface and inner coordinates, which ExtPtfm ignores: {away:.1e}")
    return tuple(notes)


def write_superelement(stream: TextIOBase, element: Superelement) -> None:
    """Write the file that Flex5 takes, and ExtPtfm up to OpenFAST 4 as FlexASCII, every number exactly.

    Raises
    ------
    InputError
        If the lines of the loads come out longer than ExtPtfm reads.
    """
    n = element.n_dof
    _check_width(n)
    total = element.duration
    while int(total / element.dt) < len(element.loads) - 1:  # for readers that cut instead of rounding
        total = float(np.nextafter(total, np.inf))
    _title(
        stream,
        element,
        f"!Dimension: {n}\n!Time increment in simulation: {element.dt!r}\n"
        f"!Total simulation time in file: {total!r}\n",
    )
    for name, units in (("Mass", "kg, m"), ("Stiffness", "N, m"), ("Damping", "N, m, s")):
        stream.write(f"\n!{name} Matrix (Units ({units}))\n!Dimension: {n}\n")
        _rows(stream, getattr(element, name.lower()))
    stream.write("\n!Loading and Wave Elevation (Units (s, N, m))\n")
    stream.write(f"!Dimension: 1 time column - {n} force columns")
    if element.elevation is None:
        stream.write("\n")
        _samples(stream, element.dt, element.loads)
    else:
        stream.write(" - 1 wave elevation column\n")
        _samples(stream, element.dt, np.column_stack([element.loads, element.elevation]))


def write_openfast5(matrices: TextIOBase, forces: TextIOBase, element: Superelement) -> None:
    """Write the two files that ExtPtfm of OpenFAST 5 takes: matrices, and loads (``UserForcing``).

    Weight is left out, as from the loads; the elevation has no place there.

    Raises
    ------
    InputError
        If the lines of the loads come out longer than ExtPtfm reads.
    """
    n = element.n_dof
    _check_width(n)
    _title(matrices, element, f"!Dimension: {n}\n")
    for name, units in (("Mass", "kg, m"), ("Stiffness", "N, m"), ("Damping", "N, m, s")):
        matrices.write(f"\n!{name} Matrix (Units ({units}))\n")
        _rows(matrices, getattr(element, name.lower()))
    matrices.write("\n!Weight constant (Units (N, m))\n")
    _rows(matrices, np.zeros((1, n)))
    matrices.write("\n!Weight stiffness (Units (N, m))\n")
    _rows(matrices, np.zeros((n, n)))
    forces.write(f"! Loads of a superelement\n!nSteps: {len(element.loads)}\n\n!Forcing (Units (s, N, m))\n")
    _samples(forces, element.dt, element.loads)


def _check_width(n: int) -> None:
    most = _LINE // 24 - 2
    if n > most:
        raise InputError(
            "dimension",
            n,
            f"makes lines of loads longer than the {_LINE} characters that ExtPtfm reads; at most {most}",
            "Keep fewer modes and vectors.",
        )


def _title(stream: TextIOBase, element: Superelement, header: str) -> None:
    """Write two comments, the header, which some readers expect on line 3, and the other comments.

    A space behind the mark keeps the words of a comment from being read as keywords.
    """
    lines = [" ".join(text.split()).encode("ascii", "replace").decode() for text in element.comments]
    first, *others = lines or ["Superelement"]
    stream.write(f"! {first}\n! Comment Flex 5 Format\n{header}")
    stream.writelines(f"! {text}\n" for text in others)


def _rows(stream: TextIOBase, matrix: Float[np.ndarray, "row column"]) -> None:
    layout = " ".join([_DIGITS] * matrix.shape[1]) + "\n"
    stream.writelines(layout % tuple(row) for row in matrix.tolist())


def _samples(stream: TextIOBase, dt: float, values: Iterable[Float[np.ndarray, " column"]]) -> None:
    """Write one line for each sample, time first."""
    layout = ""
    for i, row in enumerate(values):
        numbers = row.tolist()
        layout = layout or "%16.10g " + " ".join([_DIGITS] * len(numbers)) + "\n"
        stream.write(layout % (i * dt, *numbers))
