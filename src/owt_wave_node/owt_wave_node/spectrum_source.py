"""Spectra of the wavespectra library, from its files or in memory, as components.

The library's convention is that of metocean tables: directions waves come from, in degrees clockwise from
north, frequencies in Hz and a density in m2/(Hz degree). A unit of radian in the attributes is followed;
other attributes of an object are not, since readers of the library leave those of the file on what they
convert. x points north and y west (docs/conventions.md): waves travel to b = (180 - direction) mod 360.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import ValidationError

from owt_model.config import Components, SpectrumFile
from owt_model.errors import InputError
from owt_model.validation import input_error
from owt_wave_node.core.tabulated import TabulatedComponents, TabulatedSpectrum, realise_table

__all__ = ["from_wavespectra", "listed", "read_spectrum", "realise", "tabulate"]

#: Gap between directions, over the usual one, that is no bin: the table leaves a sector out.
SECTOR = 2.0
#: Functions of the library that read no file.
NO_READER = {"dataset"}


def from_wavespectra(
    spectrum: Any,
    *,
    duration_s: float,
    index: int = 0,
    direction_deg: float | None = None,
    directional: bool = True,
    seed: int = 1,
    amplitudes: Literal["deterministic", "rayleigh"] = "deterministic",
    cutin_rad_s: float = 0.0,
    cutoff_rad_s: float | None = None,
) -> Components:
    """Components of a Dataset or DataArray of the wavespectra library; see :class:`SpectrumFile`.

    Parameters
    ----------
    spectrum : xarray.Dataset or xarray.DataArray
        With the dimension ``freq``, perhaps ``dir``, perhaps others; of a Dataset its variable ``efth``.
    duration_s : float
        Length n dt of the record in s: components are multiples of 2 pi / duration_s.

    Raises
    ------
    InputError
        If there is no such spectrum, it is not finite, or it holds no energy in the band.
    """
    options = SpectrumFile(
        path="(in memory)",
        index=index,
        direction_deg=direction_deg,
        directional=directional,
        seed=seed,
        amplitudes=amplitudes,
        cutin_rad_s=cutin_rad_s,
        cutoff_rad_s=cutoff_rad_s,
    )
    table = tabulate(spectrum, index=index, direction_deg=direction_deg)
    made = realise(table, options, duration_s)
    return listed("spectrum_file", made.omega, made.amplitude, made.phase, made.direction_deg)


def realise(table: TabulatedSpectrum, options: SpectrumFile, duration_s: float) -> TabulatedComponents:
    """Realise a table as a case asks."""
    return realise_table(
        table,
        duration=duration_s,
        cutin=options.cutin_rad_s,
        cutoff=options.cutoff_rad_s,
        amplitude=options.amplitudes,
        directional=options.directional,
        seed=options.seed,
    )


def listed(
    source: Literal["spectrum_file", "measured"],
    omega: np.ndarray,
    amplitude: np.ndarray,
    phase: np.ndarray,
    direction: np.ndarray,
) -> Components:
    """Components in rad/s, m, rad and degrees as a case lists them; one direction where all travel alike.

    Raises
    ------
    InputError
        If a case cannot hold them, such as an amplitude above its limit.
    """
    alike = bool(np.all(direction == direction[0]))
    try:
        return Components(
            omega_rad_s=tuple(omega.tolist()),
            amplitude_m=tuple(amplitude.tolist()),
            phase_rad=tuple(phase.tolist()),
            direction_deg=float(direction[0]) if alike else tuple(direction.tolist()),
            source=source,
        )
    except ValidationError as error:
        raise input_error(error, Components, remedy="Narrow the band, or check the file.") from None


def read_spectrum(options: SpectrumFile) -> TabulatedSpectrum:
    """Read a spectrum from a file.

    Raises
    ------
    InputError
        If the library has no such reader, cannot read the file, or the spectrum is refused.
    """
    import wavespectra  # here: a second of imports, for this source only

    readers = sorted(
        name[5:] for name in vars(wavespectra) if name.startswith("read_") and name[5:] not in NO_READER
    )
    if options.reader not in readers:
        raise InputError(
            "spectrum_file.reader",
            options.reader,
            "is no reader of the wavespectra library",
            f"Use one of {', '.join(readers)}.",
        )
    if not Path(options.path).exists():
        raise InputError("spectrum_file.path", options.path, "does not exist", "Give the path of a file.")
    try:
        found = getattr(wavespectra, f"read_{options.reader}")(options.path)
        unit = _unit_in_file(options.path) if options.reader == "netcdf" else None
        # Data are read late: a damaged file fails here, not later.
        return tabulate(found, index=options.index, direction_deg=options.direction_deg, unit=unit)
    except InputError:
        raise
    except Exception as error:
        reason = (str(error).splitlines() or [""])[0]
        raise InputError(
            "spectrum_file.path",
            options.path,
            f"cannot be read as {options.reader} ({type(error).__name__}: {reason})",
            f"Check the file, or set spectrum_file.reader to one of {', '.join(readers)}.",
        ) from None


def _unit_in_file(path: str) -> str | None:
    """Unit of the density as the file has it, which the reader of plain netCDF replaces without converting.

    Raises
    ------
    InputError
        If the file says that its directions or frequencies are not the library's: it would not convert them.
    """
    import xarray

    with xarray.open_dataset(path) as raw:
        for name, attribute, word, convention in (
            ("dir", "standard_name", "to_direction", "directions the waves come from"),
            ("freq", "units", "rad", "frequencies in Hz"),
        ):
            said = str(raw[name].attrs.get(attribute, "")) if name in raw.coords else ""
            if word in said:
                raise InputError(
                    "spectrum_file.path",
                    said,
                    f"is the {attribute} of {name} in the file, and this reader takes {convention}",
                    "Set spectrum_file.reader to that of the model which wrote it, or convert the file.",
                )
        return str(raw["efth"].attrs.get("units", "")) if "efth" in raw else None


def tabulate(
    spectrum: Any,
    *,
    index: int = 0,
    direction_deg: float | None = None,
    unit: str | None = None,
) -> TabulatedSpectrum:
    """Take one spectrum out of an object of the library, in Hz and in degrees of travel.

    Parameters
    ----------
    spectrum, index, direction_deg
        See :func:`from_wavespectra`.
    unit : str, optional
        Unit of the density, where the object's own attribute is not to be trusted.

    Raises
    ------
    InputError
        If there is no such spectrum, or it is not one.
    """
    array = _density(spectrum)
    array = array.isel(_position(array, index))
    density_unit = str(array.attrs.get("units", "") if unit is None else unit).lower()
    frequency = np.asarray(array["freq"].values, dtype=float)
    spread = "dir" in array.dims
    values = np.asarray(array.transpose("freq", *(["dir"] if spread else [])).values, dtype=float)
    _check_values(frequency, values)
    order = np.argsort(frequency)
    frequency, values = frequency[order], values[order]
    if not spread:
        if direction_deg is None:
            raise InputError(
                "spectrum_file.direction_deg",
                None,
                "is needed: the spectrum holds no directions",
                "Give the direction the waves travel to, in degrees.",
            )
        only = np.array([float(direction_deg)])
        return TabulatedSpectrum(frequency, only, only - 0.5, only + 0.5, values[:, None])
    if direction_deg is not None:
        raise InputError(
            "spectrum_file.direction_deg",
            direction_deg,
            "is given, but the spectrum holds directions of its own",
            "Leave it out.",
        )
    if "rad" in density_unit and "deg" not in density_unit:
        values = values * (math.pi / 180.0)
    return _by_direction(frequency, _travel(array["dir"]), values)


def _density(spectrum: Any) -> Any:
    """The density as a DataArray with the dimension ``freq``."""
    if hasattr(spectrum, "data_vars"):
        if "efth" not in spectrum:
            raise InputError(
                "spectrum_file.path",
                sorted(map(str, spectrum.data_vars)),
                "lacks the variable efth of a spectrum",
                "Use a file that the wavespectra library reads as a spectrum.",
            )
        spectrum = spectrum["efth"]
    if "freq" not in getattr(spectrum, "dims", ()):
        raise InputError(
            "spectrum_file.path",
            tuple(map(str, getattr(spectrum, "dims", ()))),
            "are dimensions without freq",
            "Use a spectrum over frequency.",
        )
    return spectrum


def _position(array: Any, index: int) -> dict[Any, int]:
    """Place of spectrum `index` along the dimensions other than frequency and direction."""
    others = [dimension for dimension in array.dims if dimension not in ("freq", "dir")]
    shape = tuple(array.sizes[dimension] for dimension in others)
    count = math.prod(shape)
    if not 0 <= index < count:
        raise InputError(
            "spectrum_file.index", index, f"is past the {count} spectra of the file", "Counting starts at 0."
        )
    return {name: int(i) for name, i in zip(others, np.unravel_index(index, shape), strict=True)}


def _check_values(frequency: np.ndarray, values: np.ndarray) -> None:
    if frequency.size < 2 or not np.isfinite(frequency).all() or frequency.min() < 0.0:
        raise InputError(
            "spectrum_file.path",
            frequency.tolist(),
            "are frequencies that must be two or more, finite and not negative",
            "Check the file.",
        )
    if np.unique(frequency).size < frequency.size:
        raise InputError("spectrum_file.path", frequency.tolist(), "repeats a frequency", "Check the file.")
    if not (np.isfinite(values).all() and values.min() >= 0.0):
        bad = np.argwhere(~(values >= 0.0) | ~np.isfinite(values))[0]
        raise InputError(
            "spectrum_file.path",
            float(values[tuple(bad)]),
            f"at {frequency[bad[0]]:.4g} Hz: a density must be finite and not negative",
            "Choose another of the file's spectra with spectrum_file.index, or mend it.",
        )


def _travel(coordinate: Any) -> np.ndarray:
    """Directions of travel in degrees, measured from x (north) towards y (west)."""
    direction = np.asarray(coordinate.values, dtype=float)
    # Readers that convert to degrees may leave the unit of the file: radian end at 2 pi.
    if "rad" in str(coordinate.attrs.get("units", "")).lower() and np.abs(direction).max() < 6.3:
        direction = np.rad2deg(direction)
    return np.asarray((180.0 - direction) % 360.0)


def _by_direction(frequency: np.ndarray, direction: np.ndarray, values: np.ndarray) -> TabulatedSpectrum:
    """Sort by direction and give each its bin, which ends half-way to its neighbours."""
    if not np.isfinite(direction).all():
        raise InputError("spectrum_file.path", direction.tolist(), "are no directions", "Check the file.")
    order = np.argsort(direction, kind="stable")
    direction, values = direction[order], values[:, order]
    if direction.size == 1:  # as the library has it: a single direction is a degree wide
        return TabulatedSpectrum(frequency, direction, direction - 0.5, direction + 0.5, values)
    gap = np.diff(direction, append=direction[0] + 360.0)
    usual = float(np.median(gap))
    gap = np.where(gap > SECTOR * usual, usual, gap)
    return TabulatedSpectrum(
        frequency, direction, direction - 0.5 * np.roll(gap, 1), direction + 0.5 * gap, values
    )
