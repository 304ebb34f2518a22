"""Results of a campaign as one netCDF file that xarray opens, written case by case in little memory.

Dimensions are ``case`` (row of the table), ``seed``, ``order``, ``member``, ``end`` (of the member),
``hot_spot``, ``bin``, ``part`` and ``stage``. A case that failed has ``status`` 1 and its ``message``, and
missing values everywhere else.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5netcdf
import numpy as np

from owt_campaign.engine import CaseOutcome
from owt_campaign.errors_full import ErrorsAgainstFull
from owt_campaign.plan import CampaignPlan, Place
from owt_campaign.totals import OrderTotals
from owt_model.mesh import Mesh

__all__ = ["STAGES", "CampaignFile"]

PER_CASE = ("case", "seed", "order")
STAGES = ("tower-top load", "waves and loads", "load basis", "reduction", "response and stress", "rainflow")
#: Dimensions of an array per hot spot, per member end, per part or per stage.
DIMENSIONS = {"spot": ("hot_spot",), "end": ("member", "end"), "part": ("part",), "stage": ("stage",)}
#: Name, what it is counted by, unit, meaning.
RESULTS = (
    ("damage", "spot", "1", "Palmgren-Miner damage of the record"),
    ("cycles", "spot", "1", "cycles of the hot-spot stress"),
    ("max_range", "spot", "Pa", "largest range of the hot-spot stress"),
    ("total_stress", "end", "Pa", "sum of range x count of the von Mises stress, the measure of the thesis"),
    ("von_mises_cycles", "end", "1", "cycles of the von Mises stress"),
    ("von_mises_max_range", "end", "Pa", "largest range of the von Mises stress"),
)
ENERGIES = (
    ("potential_mean", "mean potential energy"),
    ("potential_std", "standard deviation of the potential energy"),
    ("kinetic_mean", "mean kinetic energy"),
    ("kinetic_std", "standard deviation of the kinetic energy"),
)
HALF_CYCLES = {"scale_factor": 0.5, "units": "1", "long_name": "cycles of the hot-spot stress per range bin"}


class CampaignFile:
    """A netCDF file under way.

    Parameters
    ----------
    path : Path
        File to write; of another name until it is complete, by the caller.
    plan : CampaignPlan
        What was run.
    sample : CaseOutcome
        Any outcome: it tells the hot spots and their names.
    mesh : Mesh
        Its members.
    attributes : mapping
        Provenance.
    """

    def __init__(
        self,
        path: Path,
        plan: CampaignPlan,
        sample: CaseOutcome,
        mesh: Mesh,
        attributes: Mapping[str, Any],
    ) -> None:
        self._plan, self._file = plan, h5netcdf.File(path, "w")
        self._row_place = {
            (s, o): (i, j) for i, s in enumerate(plan.seeds) for j, o in enumerate(plan.orders)
        }
        self._file.dimensions = {
            "case": len(plan.table.rows),
            "seed": len(plan.seeds),
            "order": len(plan.orders),
            "member": mesh.n_members,
            "end": 2,
            "hot_spot": sample.fatigue.hot_spots.n_spots,
            "bin": sample.fatigue.histogram.shape[1],
            "edge": len(sample.fatigue.range_edge),
            "part": len(sample.energy.part),
            "stage": len(STAGES),
        }
        for name, value in attributes.items():
            self._file.attrs[name] = value
        self._coordinates(sample, mesh)
        self._declare()

    def __enter__(self) -> Self:
        """Open already."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self._file.close()

    def _put(self, name: str, dimensions: tuple[str, ...], values: Any, unit: str, meaning: str) -> None:
        values = np.asarray(values)
        if values.dtype.kind in "UO":
            values = values.astype(object)
            variable = self._file.create_variable(name, dimensions, dtype=_text(), data=values)
        else:
            variable = self._file.create_variable(name, dimensions, data=values)
            variable.attrs["units"] = unit
        variable.attrs["long_name"] = meaning

    def _coordinates(self, sample: CaseOutcome, mesh: Mesh) -> None:
        plan, spots, fatigue = self._plan, sample.fatigue.hot_spots, sample.fatigue
        rows = plan.table.rows
        self._put("case", ("case",), [row.row for row in rows], "1", "row of the load-case table, from 1")
        self._put("seed", ("seed",), np.array(plan.seeds), "1", "number of the realisation")
        own = [[row.own_seed(seed) for seed in plan.seeds] for row in rows]
        self._put("sea_seed", ("case", "seed"), own, "1", "seed of its random numbers, in the case file")
        self._put("order", ("order",), np.array(plan.orders), "1", "order of the waves")
        self._put("hs_m", ("case",), [row.hs_m for row in rows], "m", "significant wave height")
        self._put("tp_s", ("case",), [row.tp_s for row in rows], "s", "peak period")
        self._put(
            "direction_deg", ("case",), [row.direction_deg for row in rows], "degree",
            "direction that waves come from, clockwise from north",
        )  # fmt: skip
        self._put(
            "probability",
            ("case",),
            plan.occurrence.probability,
            "1",
            f"share of time; {plan.occurrence.source}",
        )
        for name in plan.table.columns:
            self._put(
                f"table_{name}", ("case",), [row.extra[name] for row in rows], "", "column of the table"
            )
        self._put("member", ("member",), mesh.member_name, "", "member")
        self._put("end", ("end",), [1, 2], "1", "first and second end of a member")
        joint = [[mesh.node_name[node] for node in nodes] for nodes in mesh.member_node]
        self._put("joint", ("member", "end"), joint, "", "joint at the member end")
        member, end = np.divmod(spots.end, 2)
        self._put("hot_spot", ("hot_spot",), spots.name, "", "hot spot")
        self._put("hot_spot_member", ("hot_spot",), [mesh.member_name[m] for m in member], "", "its member")
        self._put("hot_spot_end", ("hot_spot",), end + 1, "1", "end of its member, 1 or 2")
        self._put("hot_spot_side", ("hot_spot",), spots.side, "", "chord, brace or wall")
        self._put("hot_spot_angle_deg", ("hot_spot",), spots.angle_deg, "degree", "angle of the spot")
        self._put("range_edge", ("edge",), fatigue.range_edge, "Pa", "inner edges of the range bins")
        self._put("part", ("part",), sample.energy.part, "", "the whole and its substructures")
        self._put("stage", ("stage",), STAGES, "", "stage of the computation")
        beside = [name for name in self._file.variables if name not in self._file.dimensions]
        self._file.attrs["coordinates"] = " ".join(beside)  # of the CF conventions, so that xarray knows them

    def _declare(self) -> None:
        """Variables per case, missing until a case is written."""
        for name, by, unit, meaning in RESULTS:
            self._variable(name, by, unit, meaning)
        for name, meaning in ENERGIES:
            self._variable(name, "part", "J", meaning)
        self._variable("stage_seconds", "stage", "s", "time spent in each stage")
        size = (1, 1, 1, *(self._file.dimensions[name].size for name in ("hot_spot", "bin")))
        histogram = self._file.create_variable(
            "histogram", (*PER_CASE, "hot_spot", "bin"), dtype="u4", chunks=size, compression="gzip",
            compression_opts=1, shuffle=True,
        )  # fmt: skip
        histogram.attrs.update(HALF_CYCLES)
        shape = tuple(self._file.dimensions[name].size for name in PER_CASE)
        status = self._file.create_variable("status", PER_CASE, data=np.ones(shape, dtype="i1"))
        status.attrs["flag_values"] = np.array([0, 1], dtype="i1")
        status.attrs["flag_meanings"] = "done failed"
        for name, meaning in (("message", "why a case failed"), ("key", "content hash of the case")):
            variable = self._file.create_variable(name, PER_CASE, dtype=_text())
            variable.attrs["long_name"] = meaning

    def _variable(self, name: str, by: str, unit: str, meaning: str) -> None:
        size = (1, 1, 1, *self._shape(by))
        variable = self._file.create_variable(
            name, (*PER_CASE, *DIMENSIONS[by]), dtype="f8", chunks=size, fillvalue=np.nan
        )
        variable.attrs["units"], variable.attrs["long_name"] = unit, meaning

    def _shape(self, by: str) -> tuple[int, ...]:
        return tuple(self._file.dimensions[name].size for name in DIMENSIONS[by])

    def _at(self, place: Place) -> tuple[int, int, int]:
        return (place.row, *self._row_place[place.seed, place.order])

    def write(self, place: Place, key: str, outcome: CaseOutcome) -> None:
        """Write the outcome of a case."""
        at, fatigue, file = self._at(place), outcome.fatigue, self._file
        for name, by, *_ in RESULTS:
            file[name][at] = getattr(fatigue, name).reshape(self._shape(by))
        for name, _ in ENERGIES:
            file[name][at] = getattr(outcome.energy, name)
        file["stage_seconds"][at] = np.array([outcome.stage_seconds.get(stage, 0.0) for stage in STAGES])
        file["histogram"][at] = np.rint(2.0 * fatigue.histogram).astype("u4")
        file["status"][at] = 0
        file["key"][at] = key

    def write_failed(self, place: Place, key: str, message: str) -> None:
        """Write why a case failed."""
        at = self._at(place)
        self._file["message"][at], self._file["key"][at] = message, key

    def write_errors(self, place: Place, errors: ErrorsAgainstFull) -> None:
        """Write the errors of a case against the unreduced model."""
        for name, (by, meaning) in ErrorsAgainstFull.MEANING.items():
            if name not in self._file.variables:
                self._variable(name, by, "1", meaning)
            self._file[name][self._at(place)] = getattr(errors, name).reshape(self._shape(by))

    def write_totals(self, totals: Mapping[int, OrderTotals], design_fatigue_factor: float) -> None:
        """Write the totals of each wave order."""
        life = {order: total.life_years(design_fatigue_factor) for order, total in totals.items()}
        weighted = "weighted by probability, mean over the seeds"
        for name, by, unit, meaning, values in (
            ("damage_per_year", "spot", "1/a", weighted, {o: t.damage_per_year for o, t in totals.items()}),
            (
                "damage_error_per_year",
                "spot",
                "1/a",
                "standard error of the damage in a year by the scatter of the seeds",
                {o: t.damage_error_per_year for o, t in totals.items()},
            ),
            (
                "total_stress_per_year",
                "end",
                "Pa/a",
                weighted,
                {o: t.total_stress_per_year for o, t in totals.items()},
            ),
            ("life_years", "spot", "a", f"with design fatigue factor {design_fatigue_factor:g}", life),
        ):
            missing = np.full(self._shape(by), np.nan)
            rows = [values[o].reshape(missing.shape) if o in values else missing for o in self._plan.orders]
            self._put(name, ("order", *DIMENSIONS[by]), rows, unit, meaning)
        covered = [totals[o].covered if o in totals else 0.0 for o in self._plan.orders]
        self._put("probability_covered", ("order",), covered, "1", "probability of the rows in the totals")


def _text() -> Any:
    import h5py

    return h5py.string_dtype()
