"""Results of a campaign as Parquet tables, written in pieces: memory does not grow with the number of cases.

``cases`` has one row per case: status, message, worst spot, energies. ``damage`` has one per case and hot
spot, ``total_stress`` one per case and member end, ``energy`` one per case and part, ``stages`` one per
case and stage, ``errors_*`` those against the unreduced model. ``totals``, ``total_stress_per_year`` and
``stress_ranges`` are the probability-weighted sums per year, by wave order. Units are in the names of the
columns; the schema holds the provenance.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from owt_campaign.engine import CaseOutcome
from owt_campaign.errors_full import ErrorsAgainstFull
from owt_campaign.plan import CampaignPlan, Place
from owt_campaign.totals import OrderTotals

__all__ = ["NAMES", "CampaignTables"]

#: The tables that there may be.
NAMES = (
    "cases", "damage", "total_stress", "energy", "stages", "errors_hot_spot", "errors_member_end",
    "errors_part", "totals", "total_stress_per_year", "stress_ranges",
)  # fmt: skip
#: Rows of a table that are held before they are written.
HELD = 200_000


class CampaignTables:
    """Parquet tables under way.

    Parameters
    ----------
    folder : Path
        Where they are written; of another name until it is complete.
    plan : CampaignPlan
        What was run.
    end_name : tuple of str
        Of the member ends.
    attributes : mapping
        Provenance.
    """

    def __init__(
        self, folder: Path, plan: CampaignPlan, end_name: tuple[str, ...], attributes: Mapping[str, Any]
    ) -> None:
        folder.mkdir(exist_ok=True)
        self._folder, self._plan, self._end_name = folder, plan, end_name
        self._metadata = {"owt": json.dumps(dict(attributes), default=str)}
        self._held: dict[str, list[pa.Table]] = {}
        self._writers: dict[str, pq.ParquetWriter] = {}

    def __enter__(self) -> Self:
        """Open already."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write what is held; the files get their names if nothing went wrong."""
        for name in list(self._held):
            self._flush(name)
        for name, writer in self._writers.items():
            writer.close()
            partial = self._partial(name)
            if kind is None:
                partial.replace(self._folder / f"{name}.parquet")
            else:
                partial.unlink(missing_ok=True)
        for name in NAMES if kind is None else ():  # those of an earlier run with other options
            if name not in self._writers:
                (self._folder / f"{name}.parquet").unlink(missing_ok=True)

    def _partial(self, name: str) -> Path:
        return self._folder / f".{name}.parquet.partial"

    def _add(self, name: str, columns: dict[str, Any]) -> None:
        held = self._held.setdefault(name, [])
        held.append(pa.table(columns))
        if sum(table.num_rows for table in held) >= HELD:
            self._flush(name)

    def _flush(self, name: str) -> None:
        tables = self._held.pop(name, [])
        if not tables:
            return
        table = pa.concat_tables(tables).unify_dictionaries()
        if name not in self._writers:
            schema = table.schema.with_metadata(self._metadata)
            self._writers[name] = pq.ParquetWriter(self._partial(name), schema, compression="zstd")
        self._writers[name].write_table(table.cast(self._writers[name].schema))

    def _place(self, place: Place, n: int) -> dict[str, Any]:
        """Columns that tell the case of `n` rows."""
        row = self._plan.table.rows[place.row].row
        return {
            "case": np.full(n, row, dtype=np.int32),
            "seed": np.full(n, place.seed, dtype=np.int64),
            "order": np.full(n, place.order, dtype=np.int8),
        }

    def add(self, place: Place, key: str, outcome: CaseOutcome) -> None:
        """Add the outcome of a case."""
        fatigue, energy = outcome.fatigue, outcome.energy
        spots = fatigue.hot_spots
        worst = int(np.argmax(fatigue.damage))
        total = energy.part.index("total")
        self._case(place, key, "done", "", {
            "largest_damage": float(fatigue.damage[worst]),
            "largest_damage_spot": spots.name[worst],
            "largest_range_pa": float(fatigue.max_range.max()),
            "total_stress_sum_pa": float(fatigue.total_stress.sum()),
            "potential_mean_j": float(energy.potential_mean[total]),
            "potential_std_j": float(energy.potential_std[total]),
            "kinetic_mean_j": float(energy.kinetic_mean[total]),
            "kinetic_std_j": float(energy.kinetic_std[total]),
            "seconds": float(sum(outcome.stage_seconds.values())),
            "reduction": outcome.reduction,
        })  # fmt: skip
        self._add("damage", {
            **self._place(place, spots.n_spots), "hot_spot": _words(spots.name), "damage": fatigue.damage,
            "cycles": fatigue.cycles, "max_range_pa": fatigue.max_range,
        })  # fmt: skip
        self._add("total_stress", {
            **self._place(place, spots.n_ends), "member_end": _words(self._end_name),
            "total_stress_pa": fatigue.total_stress, "von_mises_cycles": fatigue.von_mises_cycles,
        })  # fmt: skip
        self._add("energy", {
            **self._place(place, len(energy.part)), "part": _words(energy.part),
            "potential_mean_j": energy.potential_mean, "potential_std_j": energy.potential_std,
            "kinetic_mean_j": energy.kinetic_mean, "kinetic_std_j": energy.kinetic_std,
        })  # fmt: skip
        stages = outcome.stage_seconds
        self._add("stages", {
            **self._place(place, len(stages)), "stage": _words(tuple(stages)),
            "seconds": np.array(list(stages.values())),
        })  # fmt: skip

    def add_failed(self, place: Place, key: str, message: str) -> None:
        """Add why a case failed."""
        self._case(place, key, "failed", message, {})

    def _case(self, place: Place, key: str, status: str, message: str, results: Mapping[str, Any]) -> None:
        row = self._plan.table.rows[place.row]
        columns = {
            **self._place(place, 1), "sea_seed": [row.own_seed(place.seed)],
            "hs_m": [row.hs_m], "tp_s": [row.tp_s], "direction_deg": [row.direction_deg],
            "probability": [float(self._plan.occurrence.probability[place.row])],
            "status": [status], "message": [message], "key": [key],
        }  # fmt: skip
        for name in self._plan.table.columns:
            columns[f"table_{name}"] = [row.extra[name]]
        for name, kind in CASE_RESULTS.items():
            columns[name] = pa.array([results.get(name)], type=kind)
        self._add("cases", columns)

    def add_errors(self, place: Place, errors: ErrorsAgainstFull, outcome: CaseOutcome) -> None:
        """Add the errors of a case against the unreduced model."""
        places = {
            "spot": ("hot_spot", outcome.fatigue.hot_spots.name),
            "end": ("member_end", self._end_name),
            "part": ("part", outcome.energy.part),
        }
        for by, (column, words) in places.items():
            found = {
                name: getattr(errors, name) for name, (of, _) in ErrorsAgainstFull.MEANING.items() if of == by
            }
            columns = {**self._place(place, len(words)), column: _words(words), **found}
            self._add(f"errors_{column}", columns)

    def add_totals(
        self, totals: Mapping[int, OrderTotals], sample: CaseOutcome, design_fatigue_factor: float
    ) -> None:
        """Add the totals of each wave order."""
        fatigue = sample.fatigue
        spots = fatigue.hot_spots
        edges = fatigue.range_edge
        low, high = np.concatenate([[0.0], edges]), np.concatenate([edges, [np.inf]])
        for order, total in totals.items():
            self._add("totals", {
                "order": np.full(spots.n_spots, order, dtype=np.int8), "hot_spot": _words(spots.name),
                "member_end": _words([self._end_name[end] for end in spots.end]), "side": _words(spots.side),
                "damage_per_year": total.damage_per_year,
                "damage_error_per_year": total.damage_error_per_year,
                "life_years": total.life_years(design_fatigue_factor),
            })  # fmt: skip
            self._add("total_stress_per_year", {
                "order": np.full(spots.n_ends, order, dtype=np.int8), "member_end": _words(self._end_name),
                "total_stress_per_year_pa": total.total_stress_per_year,
            })  # fmt: skip
            spot, place = np.nonzero(total.cycles_per_year)
            self._add("stress_ranges", {
                "order": np.full(len(spot), order, dtype=np.int8),
                "hot_spot": pa.DictionaryArray.from_arrays(spot.astype(np.int32), pa.array(spots.name)),
                "range_from_pa": low[place], "range_to_pa": high[place],
                "cycles_per_year": total.cycles_per_year[spot, place],
            })  # fmt: skip


#: Columns of the table of cases that a failed one lacks.
CASE_RESULTS = {
    "largest_damage": pa.float64(),
    "largest_damage_spot": pa.string(),
    "largest_range_pa": pa.float64(),
    "total_stress_sum_pa": pa.float64(),
    "potential_mean_j": pa.float64(),
    "potential_std_j": pa.float64(),
    "kinetic_mean_j": pa.float64(),
    "kinetic_std_j": pa.float64(),
    "seconds": pa.float64(),
    "reduction": pa.string(),
}


def _words(names: Any) -> pa.DictionaryArray:
    """A column of names, each kept once."""
    return pa.array(list(names)).dictionary_encode()
