"""The results of a report as tables: each as CSV and as Parquet, units in the names of the columns."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from owt_model.errors import InputError
from owt_postproc.core.hot_spots import SCF_NAMES
from owt_postproc.report_measures import YEAR_S, DesignLife
from owt_postproc.report_usage import Usage

if TYPE_CHECKING:
    import pyarrow

__all__ = ["Table", "case_hash", "usage_tables", "write_tables"]


@dataclass(frozen=True)
class Table:
    """Columns of equal length.

    Attributes
    ----------
    name : str
        Of the files, without ending.
    columns : mapping
        Name with unit, and values: an array or a sequence of text.
    """

    name: str
    columns: Mapping[str, Any]


def case_hash(case: Mapping[str, Any]) -> str:
    """SHA-256 (hex) of a case as plain data, whatever the order of its keys."""
    return hashlib.sha256(json.dumps(case, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def usage_tables(usage: Usage, design: DesignLife | None) -> list[Table]:
    """Member ends, spots, and cycles per range bin, of which the empty ones are left out."""
    spot = usage.worst_spot
    member, joint = zip(*(name.partition(":")[::2] for name in usage.end_name), strict=True)
    ends: dict[str, Any] = {
        "member_end": usage.end_name,
        "member": member,
        "joint": joint,
        "joint_class": usage.end_kind,
        "nominal_because": usage.end_reason,
        "worst_spot": [usage.spot_name[s] for s in spot],
        **_spot_columns(usage, spot),
        "max_range_end_pa": usage.end_max_range,
        "total_stress_pa": usage.total_stress,
        "von_mises_cycles": usage.von_mises_cycles,
    }
    everywhere = np.arange(len(usage.spot_name))
    spots: dict[str, Any] = {
        "hot_spot": usage.spot_name,
        "member_end": [usage.end_name[e] for e in usage.spot_end],
        **_spot_columns(usage, everywhere),
    }
    if design is not None:
        for columns, which in ((ends, spot), (spots, everywhere)):
            columns["utilisation"] = design.utilisation(usage.damage[which], usage.duration_s)
    edge = np.concatenate([[0.0], usage.range_edge, [np.inf]])
    at, bins = np.nonzero(usage.histogram)
    counts = {
        "hot_spot": [usage.spot_name[s] for s in at],
        "range_low_pa": edge[bins],
        "range_high_pa": edge[bins + 1],
        "cycles": usage.histogram[at, bins],
    }
    return [Table("member_ends", ends), Table("hot_spots", spots), Table("stress_ranges", counts)]


def _spot_columns(usage: Usage, spot: np.ndarray) -> dict[str, Any]:
    damage = usage.damage[spot]
    return {
        "side": [usage.spot_side[s] for s in spot],
        "angle_deg": usage.spot_angle_deg[spot],
        **{f"scf_{name}": usage.spot_scf[spot, i] for i, name in enumerate(SCF_NAMES)},
        "damage": damage,
        "damage_per_year": damage * YEAR_S / max(usage.duration_s, 1e-300),
        "cycles": usage.cycles[spot],
        "max_range_pa": usage.max_range[spot],
    }


def write_tables(tables: list[Table], folder: Path, metadata: Mapping[str, str]) -> list[Path]:
    """Write each table as NAME.csv and NAME.parquet, whole or not at all; return the paths.

    Parameters
    ----------
    tables : list of Table
    folder : Path
        That exists.
    metadata : mapping of str
        What made the numbers; in the schema of the Parquet files, under these names.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    import pyarrow.csv
    import pyarrow.parquet

    paths = []
    for table in tables:
        arrow = _arrow(table, metadata)
        for ending, write in ((".csv", pyarrow.csv.write_csv), (".parquet", pyarrow.parquet.write_table)):
            path = folder / f"{table.name}{ending}"
            partial = path.with_name(f".{path.name}.partial")
            try:
                write(arrow, partial)
                partial.replace(path)
            except OSError as error:
                partial.unlink(missing_ok=True)
                raise InputError(
                    "tables",
                    str(path),
                    f"cannot be written ({error.strerror or error})",
                    "Choose a folder with free space.",
                ) from None
            paths.append(path)
    return paths


def _arrow(table: Table, metadata: Mapping[str, str]) -> pyarrow.Table:
    """Arrow table with units in the metadata of its columns, and what made it in that of its schema."""
    import pyarrow

    arrays = [pyarrow.array(values, from_pandas=True) for values in table.columns.values()]
    schema = [
        pyarrow.field(name, array.type, metadata={"unit": _unit(name)})
        for name, array in zip(table.columns, arrays, strict=True)
    ]
    known = {"table": table.name, **metadata}
    return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(schema, metadata=known))


#: Endings of column names, and the units that they stand for.
UNITS = {"_pa": "Pa", "_deg": "deg", "_s": "s", "_m": "m", "_per_year": "1/year", "_hz": "Hz"}


def _unit(name: str) -> str:
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")
