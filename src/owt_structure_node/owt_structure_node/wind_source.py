"""Tower-top load of a case: what comes from a file is read here, the rest is made from the case alone."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_model.live_samples import LiveRules
from owt_model.mesh import Mesh
from owt_model.wind_config import WrenchSeries, WrenchTopic
from owt_structure_node.core.tower_top import TowerTopLoad, WrenchSamples, thrust_load, turned

__all__ = ["COLUMNS", "read_wrench", "tower_top_load", "wrench_samples"]

#: Columns of a wrench file beside the time.
COLUMNS = ("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")


def tower_top_load(case: CaseConfig, mesh: Mesh, *, live: bool = False) -> TowerTopLoad | None:
    """Load at the tower top of a case, None where it has none.

    Parameters
    ----------
    case : CaseConfig
        The case.
    mesh : Mesh
        Its structure.
    live : bool
        Whether a topic can bring the load.

    Raises
    ------
    InputError
        If the file is refused, a rotor has no tower, or a topic is asked for where there is none.
    """
    wind = case.wind
    if wind is None:
        return None
    if wind.series is not None:
        return _from_file(wind.series, dt=case.time.dt_s, n=case.time.n)
    if wind.topic is not None:
        if not live:
            raise InputError(
                "wind.topic",
                "given",
                "is read by the running graph only",
                "Use ./owt demo --case or the nodes, or give wind.series.",
            )
        return TowerTopLoad(None)
    assert wind.thrust is not None
    if not len(mesh.tower_node):
        raise InputError(
            "wind.thrust", "given", f"needs a tower, {mesh.structure.name} has none", "Give wind.series."
        )
    top = float(mesh.node_position[mesh.tower_top, 2])
    return thrust_load(wind.thrust, tower_top_z=top, dt=case.time.dt_s, n=case.time.n)


def wrench_samples(topic: WrenchTopic) -> WrenchSamples:
    """Where the messages of a topic go, by the rules of the case."""
    return WrenchSamples(
        LiveRules.of(
            step=topic.interpolation == "hold",
            missing=topic.missing,
            max_gap_s=topic.max_gap_s,
            reorder_s=topic.reorder_s,
        )
    )


def read_wrench(path: Path) -> tuple[Float[np.ndarray, " row"], Float[np.ndarray, "row 6"]]:
    """Read times in s and wrenches in N and N m from a CSV file with a line of column names.

    Lines that begin with # are skipped, columns that are not there are zero.

    Raises
    ------
    InputError
        If the file cannot be read, has other columns, or a row that is not finite or not later than the last.
    """
    field = "wind.series.path"
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        reason = "is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else reason
        raise InputError(
            field, str(path), f"cannot be read ({reason})", "Give a readable CSV file."
        ) from None
    numbered = [(i, line) for i, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    table = [_entries(line) for _, line in numbered]
    names = [name.strip() for name in table[0]] if table else []
    unknown = [name for name in names if name not in ("time_s", *COLUMNS)]
    if unknown or names.count("time_s") != 1 or len(set(names)) < len(names) or len(names) < 2:
        raise InputError(
            field,
            str(path),
            f"is headed by {','.join(names) or 'nothing'}: it must be time_s and one or more of "
            f"{', '.join(COLUMNS)}, each once",
            "Name the columns in the first line.",
        )
    rows = np.zeros((len(table) - 1, 7))
    place = [0 if name == "time_s" else 1 + COLUMNS.index(name) for name in names]
    for i, (entries, (number, line)) in enumerate(zip(table[1:], numbered[1:], strict=True)):
        try:
            # Python takes 1_000 for a number, other readers do not.
            values = [] if "_" in line else [float(entry) for entry in entries]
        except ValueError:
            values = []
        if len(values) != len(names) or not all(map(math.isfinite, values)):
            raise InputError(
                field,
                str(path),
                f"has a row {number}, {line.strip()[:60]!r}, that is not {len(names)} finite numbers",
                "Fill gaps before.",
            )
        rows[i, place] = values
        if i and not rows[i, 0] > rows[i - 1, 0]:
            raise InputError(
                field,
                str(path),
                f"has the time {rows[i, 0]:g} s in row {number}, not later than the row before",
                "Sort rows.",
            )
    return rows[:, 0], rows[:, 1:]


def _entries(line: str) -> list[str]:
    """Entries of one line; a quote that is left open does not reach the next."""
    try:
        return next(csv.reader([line], strict=True))
    except csv.Error:
        return []


def _from_file(options: WrenchSeries, *, dt: float, n: int) -> TowerTopLoad:
    """Linear interpolation of a file onto the load samples."""
    time, wrench = read_wrench(Path(options.path))
    end = (n - 1) * dt
    slack = 1e-9 * max(end, dt)
    if len(time) < 2 or time[0] > slack or time[-1] < end - slack:
        covered = f"{time[0]:g} to {time[-1]:g} s" if len(time) else "nothing"
        raise InputError(
            "wind.series.path", options.path, f"covers {covered}, the record is 0 to {end:g} s",
            "Give a series from 0 s to the end of the record, or a shorter record.",
        )  # fmt: skip
    samples = dt * np.arange(n)
    found = np.stack([np.interp(samples, time, column) for column in wrench.T], axis=1)
    notes = []
    finest = float(np.diff(time).min())
    if finest < 0.9 * dt:
        notes.append(
            f"wind: {options.path} has steps of {finest:g} s, taken every {dt:g} s without a filter: what is "
            f"faster than {0.5 / dt:g} Hz appears slower"
        )
    return TowerTopLoad(turned(found, options.direction_deg), notes=tuple(notes))
