"""Waves and loads: kinematics at a point, the stages of the loads on the jacket, and a record of 3 hours."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.alternatives import second_order_double_sum
from benchmarks.measure import Table, Timing, timing

#: Time in s of the same work elsewhere: quoted, not measured here. OpenFAST's is processor time on two
#: processors, the thesis' is its calculation time.
QUOTED = {
    2: {
        "OpenFAST HydroDyn 5.0 (CPU), grid fine enough for 4e-4": 627.0,
        "OpenFAST HydroDyn 5.0 (CPU), grid of its jacket example (26 % off)": 112.0,
        "thesis table 5.1 (2014)": 200.0,
    },
    1: {"OpenFAST HydroDyn 5.0 (CPU), fine grid": 71.0, "thesis table 5.1 (2014)": 110.0},
}
POINT = (3.0, -2.0, -6.0)


def bench_waves(table: Table) -> None:
    """Second-order kinematics at a point, and the loads on the jacket by stage."""
    per_point = _kinematics(table)
    for order in (1, 2):
        _loads(table, order, per_point)


def _kinematics(table: Table) -> float:
    """Time the kinematics at a point; return the time in s of the plain double sum for it."""
    from owt_model.config import parse_case
    from owt_wave_node.core.kinematics import wave_kinematics
    from owt_wave_node.core.sea import build_sea_state

    case = parse_case({"points_m": [list(POINT)]})
    sea = build_sea_state(case)
    ours = wave_kinematics(case)
    b = np.deg2rad(sea.direction_deg)
    some = np.arange(0, sea.n, 60)

    def double_sum() -> np.ndarray:
        return second_order_double_sum(
            ours.t[some], POINT[0] * np.cos(b) + POINT[1] * np.sin(b), POINT[2], omega=sea.omega_rad_s,
            k=sea.wavenumber_rad_m, a=sea.amplitude_m, phase=sea.phase_rad, depth=sea.water_depth_m,
            gravity=sea.gravity_m_s2,
        )  # fmt: skip

    reference = double_sum()
    along = ours.velocity2[some, 0] @ np.array([np.cos(b), np.sin(b), 0.0])
    error = np.abs(along - reference).max() / np.abs(reference).max()
    assert error < 1e-10, f"second order differs from the double sum by {error:.1e}"
    plain = timing(double_sum, 1).wall * len(ours.t) / len(some)
    table.add(
        "waves",
        f"kinematics at a point, second order, {sea.omega_rad_s.size} components, 6000 samples",
        timing(lambda: wave_kinematics(case)),
        {"numpy double sum, one of its four channels": plain},
    )
    return plain


def _loads(table: Table, order: int, per_point: float) -> None:
    """Time the loads on the jacket as a whole and stage by stage."""
    from owt_model.config import parse_case
    from owt_model.mesh import build_mesh
    from owt_model.parallel import map_threads
    from owt_model.structure import load_structure
    from owt_wave_node.core.hydro_mesh import case_hydro_mesh
    from owt_wave_node.core.loads import prepare_loads
    from owt_wave_node.core.route import make_field
    from owt_wave_node.core.sea import Frame, build_sea_state

    case = parse_case({"wave": {"order": order}})
    mesh = build_mesh(load_structure("oc4"))
    sea = build_sea_state(case)
    field = make_field(case, sea)
    windows = prepare_loads(case, mesh, sea, field)
    place = Frame(sea.direction_deg).place(windows.hydro.station)
    stations = len(place)
    # Those that water can reach, each once: places abreast have the same long-crested waves.
    place = np.unique(np.round(place[place[:, 2] <= windows.highest] * [1.0, 0.0, 1.0], 6), axis=0)
    prepared, pieces = field.prepare(place), np.array_split(np.arange(len(place)), range(16, len(place), 16))
    splash = place[(place[:, 2] > windows.lowest) & (place[:, 2] <= windows.highest)]

    def whole() -> Any:
        return prepare_loads(case, mesh, sea, make_field(case, sea)).window(0)

    parts: dict[str, Callable[[], Any]] = {
        "sea state": partial(build_sea_state, case),
        "tables of all pairs": partial(make_field, case, sea),
        "hydrodynamic mesh": partial(case_hydro_mesh, case, mesh, lowest=windows.lowest),
        "coefficients of all points": partial(field.prepare, place),
        "transforms to time": lambda: map_threads(lambda piece: prepared.kinematics(piece).shape, pieces),
        "surface elevation": partial(field.elevation, splash),
    }
    total = timing(whole)
    name = f"{'first' if order == 1 else 'second'} order"
    beside = {"matrix product 1500 x 1500": table.matmul}
    if order == 2:
        beside["numpy double sum at every wet place, one of four channels"] = per_point * len(place)
    what = f"loads on the jacket, {name}, {stations} stations at {len(place)} wet places"
    table.add(f"loads {order}", what, total, beside, QUOTED[order])
    rest = total
    for label, work in parts.items():
        part = timing(work)
        table.add(f"loads {order}", f"  {label}", part)
        if label != "sea state":
            rest = Timing(rest.wall - part.wall, rest.cpu - part.cpu)
    table.add(f"loads {order}", "  Morison, integration, joints (the rest)", rest)


def bench_long(table: Table) -> None:
    """Loads of 3 hours, window by window, against those of 600 s."""
    from owt_model.config import parse_case
    from owt_model.mesh import build_mesh
    from owt_model.structure import load_structure
    from owt_wave_node.core.loads import prepare_loads
    from owt_wave_node.core.route import make_field
    from owt_wave_node.core.sea import build_sea_state

    mesh = build_mesh(load_structure("oc4"))

    def run(samples: int) -> float:
        case = parse_case({"time": {"dt_s": 0.1, "n": samples}})
        sea = build_sea_state(case)
        windows = prepare_loads(case, mesh, sea, make_field(case, sea))
        for history in windows:
            assert np.isfinite(history.nodal[0, 0, 0])
        return windows.error_estimate

    run(12_000)  # loads the kernels of the long route
    short = timing(partial(run, 6000), 3)
    table.add("long", "loads of 600 s, second order", short)
    errors: list[float] = []
    long = timing(lambda: errors.append(run(108_000)), 1)
    table.add("long", "loads of 10,800 s, second order", long, {"18 times that of 600 s": 18.0 * short.wall})
    table.note("long", "10,800 s over 600 s (18 in length)", long.wall / short.wall, "x")
    table.note("long", "estimated error of the second order over 10,800 s", errors[0], "of its rms")
