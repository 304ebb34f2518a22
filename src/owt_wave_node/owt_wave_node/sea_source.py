"""Seas from files: a case whose sea is a spectrum or a record becomes one of listed components.

Cores read no files, and a recorded case must be able to run again without them: commands, pipeline and wave
node call :func:`resolve_case` before anything else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig, Components, Measured, SpectrumFile
from owt_model.errors import InputError
from owt_wave_node.core.sea import Frame
from owt_wave_node.spectrum_source import from_wavespectra, listed, read_spectrum, realise

if TYPE_CHECKING:
    from owt_wave_node.core.measured import MeasuredSea

__all__ = ["Record", "SourceReport", "from_wavespectra", "read_record", "resolve", "resolve_case"]

#: Difference of a time step from the usual one, over it, that is no rounding of the file's decimals.
UNEVEN = 0.05
#: Residual over the standard deviation of a record from which its report is a warning.
NOTABLE_RESIDUAL = 0.1


@dataclass(frozen=True)
class SourceReport:
    """How a sea came out of its file: one line for the user, its numbers, and whether it is a warning."""

    source: str
    line: str
    numbers: dict[str, float | int]
    kind: Literal["note", "warning"] = "note"


@dataclass(frozen=True)
class Record:
    """A measured elevation: first time and time step in s, elevation in m."""

    start_s: float
    dt_s: float
    elevation_m: Float[np.ndarray, " time"]


def resolve_case(case: CaseConfig) -> CaseConfig:
    """Return `case` with its sea as components, where it came from a file; else `case` itself.

    Raises
    ------
    InputError
        If the file cannot be read or is refused.
    ComputationError
        If the first order of a record is not found.
    """
    return resolve(case)[0]


def resolve(case: CaseConfig) -> tuple[CaseConfig, SourceReport | None]:
    """Like :func:`resolve_case`, with a report of what was read; None where nothing was."""
    if case.spectrum_file is not None:
        components, report = _from_spectrum(case, case.spectrum_file)
    elif case.measured is not None:
        components, report = _from_record(case, case.measured)
    else:
        return case, None
    changed: dict[str, Any] = {"spectrum_file": None, "measured": None, "components": components}
    return CaseConfig(**{name: getattr(case, name) for name in CaseConfig.model_fields} | changed), report


def _from_spectrum(case: CaseConfig, options: SpectrumFile) -> tuple[Components, SourceReport]:
    table = read_spectrum(options)
    made = realise(table, options, case.time.duration_s)
    hs = 4.0 * math.sqrt(float(made.variance.sum()))
    line = (
        f"{options.path}: Hs {table.hs_m:.3f} m, of which {hs:.3f} m in {made.omega.size} components from "
        f"{made.omega[0]:.3g} to {made.omega[-1]:.3g} rad/s"
    )
    numbers: dict[str, float | int] = {
        "file_hs_m": table.hs_m,
        "band_hs_m": hs,
        "components": made.omega.size,
        "mean_direction_deg": table.mean_direction_deg,
    }
    components = listed("spectrum_file", made.omega, made.amplitude, made.phase, made.direction_deg)
    return components, SourceReport("spectrum_file", line, numbers)


def _from_record(case: CaseConfig, options: Measured) -> tuple[Components, SourceReport]:
    record = read_record(Path(options.path))
    # Here: it needs the wave fields, and the cases that do not come from a record wait for no import.
    from owt_wave_node.core.measured import Band, components_of_record

    place = Frame(options.direction_deg).place(np.array([options.place_m], dtype=float))
    found = components_of_record(
        record.elevation_m,
        dt=record.dt_s,
        x=float(place[0, 0]),
        depth=case.water_depth_m,
        gravity=case.gravity_m_s2,
        band=Band(options.cutin_rad_s, options.cutoff_rad_s, options.tolerance, options.max_iterations),
        order=case.wave.order,
    )
    direction = np.full(found.omega.size, options.direction_deg)
    components = listed("measured", found.omega, found.amplitude, found.phase, direction)
    return components, _record_report(case, options, record, found)


def _record_report(case: CaseConfig, options: Measured, record: Record, found: MeasuredSea) -> SourceReport:
    line = (
        f"{options.path}: order {case.wave.order} of {found.omega.size} components leaves a residual of "
        f"{found.residual_rms:.2g} rms, {found.residual_max:.2g} at most, over the record's standard "
        f"deviation {found.std_m:.3g} m, after {found.iterations} iterations; the record's mean "
        f"{found.mean_m:.3g} m is left out, the sea's set-down is {found.set_down_m:.3g} m"
    )
    n = record.elevation_m.size
    if n != case.time.n or not math.isclose(record.dt_s, case.time.dt_s, rel_tol=1e-9):
        line += f"; record {n} x {record.dt_s:g} s, case {case.time.n} x {case.time.dt_s:g} s"
    if record.start_s != 0.0:
        line += f"; the sea's t = 0 is the record's t = {record.start_s:g} s"
    numbers: dict[str, float | int] = {
        "components": found.omega.size,
        "iterations": found.iterations,
        "residual_rms": found.residual_rms,
        "residual_max": found.residual_max,
        "std_m": found.std_m,
        "mean_m": found.mean_m,
        "set_down_m": found.set_down_m,
        "record_dt_s": record.dt_s,
        "record_n": n,
        "record_start_s": record.start_s,
    }
    notable = found.residual_rms > NOTABLE_RESIDUAL
    if notable:
        line += ". Widen the band from measured.cutin_rad_s to measured.cutoff_rad_s for less"
    return SourceReport("measured", line, numbers, "warning" if notable else "note")


def read_record(path: Path) -> Record:
    """Read a CSV file of two columns, time in s and elevation in m, evenly spaced and without gaps.

    Lines that begin with # and a first line of column names, in which no field is a number, are skipped.

    Raises
    ------
    InputError
        Naming the first row that is not two finite numbers, or whose time step differs from the others'.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not UTF-8 text"
        raise InputError(
            "measured.path", str(path), f"cannot be read ({reason})", "Give a readable CSV file."
        ) from None
    rows: list[tuple[int, float, float]] = []
    titled = False
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            t, eta = (float(part) for part in line.split(","))
        except ValueError:
            if not rows and not titled and _is_title(line):
                titled = True
                continue
            t = eta = math.nan
        if not (math.isfinite(t) and math.isfinite(eta)):
            raise InputError(
                "measured.path",
                line.strip(),
                f"in row {number} is not two finite numbers, time in s and elevation in m",
                "Fill gaps before, or cut the record there.",
            )
        rows.append((number, t, eta))
    return _even(path, rows)


def _is_title(line: str) -> bool:
    """Whether a line holds names: a field that is a number makes it a row, perhaps with a gap."""

    def is_number(part: str) -> bool:
        try:
            float(part)
        except ValueError:
            return False
        return True

    parts = [part.strip() for part in line.split(",")]
    return any(parts) and not any(is_number(part) for part in parts)


def _even(path: Path, rows: list[tuple[int, float, float]]) -> Record:
    """Check that the rows are evenly spaced in time."""
    if len(rows) < 4:
        raise InputError(
            "measured.path", str(path), f"holds {len(rows)} samples, too few", "Use a longer record."
        )
    number, t, eta = (np.array(column) for column in zip(*rows, strict=True))
    step = np.diff(t)
    usual = float(np.median(step))
    uneven = np.flatnonzero(~(np.abs(step - usual) <= UNEVEN * abs(usual)) | (step <= 0.0))
    if uneven.size:
        first = int(uneven[0])
        raise InputError(
            "measured.path",
            float(step[first]),
            f"is the time step in s before row {number[first + 1]}; the others are {usual:g} s",
            "Give an evenly spaced record without gaps.",
        )
    # Twelve digits: the mean of decimals is a decimal again.
    dt = float(f"{(t[-1] - t[0]) / (t.size - 1):.12g}")
    return Record(float(t[0]), dt, eta)
