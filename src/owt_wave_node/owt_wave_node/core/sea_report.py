"""Everything that ``owt sea`` says about the sea of a case: spectrum, realised record, crests, regime."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from owt_model.config import CaseConfig
from owt_model.contracts import SeaState
from owt_model.structure import Structure
from owt_wave_node.core.crests import (
    counted_exceedance,
    forristall_crest,
    forristall_shape,
    rayleigh_crest,
    tayfun_crest,
)
from owt_wave_node.core.regime import SeaRegime, sea_regime
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state
from owt_wave_node.core.sea_statistics import (
    RecordStatistics,
    SpectralStatistics,
    component_statistics,
    record_statistics,
)
from owt_wave_node.core.wave_theory import linear_wavenumber

__all__ = ["SeaReport", "sea_report"]

#: Exceedance probabilities per wave at which crests are compared.
PROBABILITIES = (0.1, 0.01, 0.001)


@dataclass(frozen=True)
class SeaReport:
    """Statistics and regime of a sea.

    Attributes
    ----------
    spectrum : SpectralStatistics, optional
        Of the components as realised; None for a regular wave, which has no spectrum.
    first, total : RecordStatistics
        Of the record at the first gauge; `first` is None for a regular wave.
    crests : dict
        Exceedance probability -> crest height in m over the record's mean, counted in the total record
        (None where it is too short) and by Rayleigh, Tayfun and Forristall; empty for a regular wave.
    """

    spectrum: SpectralStatistics | None
    first: RecordStatistics | None
    total: RecordStatistics
    crests: dict[float, dict[str, float | None]]
    regime: SeaRegime

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers with units in their keys, as JSON holds them."""
        regime = self.regime
        return {
            "spectrum": None if self.spectrum is None else self.spectrum.as_dict(),
            "record": {
                "first_order": None if self.first is None else self.first.as_dict(),
                "total": self.total.as_dict(),
            },
            "crests": [{"probability": p, **row} for p, row in self.crests.items()],
            "regime": {
                "wave": regime.wave.as_dict(),
                "largest_wave": regime.largest.as_dict(),
                "n_waves": regime.n_waves,
                "sea_steepness": regime.sea_steepness,
                "cutoff_rad_s": regime.cutoff_rad_s,
                "steepness_cutoff_rad_s": regime.steepness_cutoff_rad_s,
                "members": [
                    {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(member).items()}
                    for member in regime.members
                ],
            },
            "warnings": list(regime.warnings),
        }


def sea_report(case: CaseConfig, structure: Structure | None = None) -> SeaReport:
    """Realise the sea of `case` at its first gauge and describe it.

    Raises
    ------
    InputError
        If the sea is refused or holds no energy.
    """
    sea = build_sea_state(case)
    regime = sea_regime(case, sea, structure)
    gauge = Frame(sea.direction_deg).place(np.array(case.gauges_m[:1], dtype=float))
    first, second = make_field(case, sea).elevation(gauge)
    total = record_statistics(first[0] + second[0], sea.dt_s)
    if case.regular is not None:
        return SeaReport(spectrum=None, first=None, total=total, crests={}, regime=regime)
    spectrum = component_statistics(sea.omega_rad_s, sea.amplitude_m)
    return SeaReport(
        spectrum=spectrum,
        first=record_statistics(first[0], sea.dt_s),
        total=total,
        crests=_crests(sea, spectrum, total),
        regime=regime,
    )


def _crests(
    sea: SeaState, spectrum: SpectralStatistics, record: RecordStatistics
) -> dict[float, dict[str, float | None]]:
    """Crest heights at :data:`PROBABILITIES`."""
    p = np.array(PROBABILITIES)
    hs = spectrum.hm0_m
    k = linear_wavenumber(spectrum.tm01_s, depth=sea.water_depth_m, gravity=sea.gravity_m_s2)
    spread = bool(np.any(sea.component_direction_deg != sea.component_direction_deg[0]))
    alpha, beta = forristall_shape(
        hs=hs,
        tm01=spectrum.tm01_s,
        wavenumber=k,
        depth=sea.water_depth_m,
        gravity=sea.gravity_m_s2,
        spread=spread,
    )
    rows = {
        "rayleigh_m": rayleigh_crest(p, hs=hs),
        "tayfun_m": tayfun_crest(p, hs=hs, wavenumber=k),
        "forristall_m": forristall_crest(p, hs=hs, alpha=alpha, beta=beta),
    }
    height, share = counted_exceedance(record.crest_m)
    counted = [float(np.interp(q, share, height)) if share.size and share[0] <= q else None for q in p]
    return {
        float(q): {"counted_m": counted[i], **{name: float(row[i]) for name, row in rows.items()}}
        for i, q in enumerate(p)
    }
