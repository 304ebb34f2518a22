"""Morison loads: reference jacket, closed forms, equilibrium, surface, growth, blocks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from owt_model.axes import rotation
from owt_model.errors import InputError
from owt_wave_node.core import loads as loads_module
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.hydro_mesh import _wet, build_hydro_mesh
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.loads import Loads, jacket_loads
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import build_sea_state, waves
from owt_wave_node.kernels import morison as morison_kernel
from owt_wave_node.kernels.sections import sectional
from owt_wave_node.kernels.surface import surface_loads

RHO, G, DIAMETER = 1025.0, 9.81, 1.5
AREA = math.pi * DIAMETER**2 / 4.0
REGULAR = {"water_depth_m": 20.0, "time": {"dt_s": 0.1, "n": 100}}


def morison(cd: float = 1.0, cm: float = 2.0, dx: float = 1.0, growth: bool = False) -> dict:
    return {"cd": cd, "cm": cm, "marine_growth": growth, "discretisation_m": dx}


def check_reference(got: Loads, d, key: str, limit: float) -> None:
    at = np.rint(d["t_load"] / 0.1).astype(int)
    for series, expected in zip((got.force[:, 0], got.force[:, 2], got.moment[:, 1]), d[key], strict=True):
        assert np.abs(series[at] - expected).max() < limit * np.abs(expected).max()


REFERENCE = [("A", 1, 2e-4), ("A", 2, 2e-4), ("C", 1, 4e-4), ("C", 2, 1e-3)]


@pytest.mark.parametrize(("name", "order", "limit"), REFERENCE)
def test_reference_jacket(name: str, order: int, limit: float, recorded, reference, oc4) -> None:
    """Shear, lift and overturning moment; the reference itself is 1e-4 (A) to 1e-3 (C) from converged."""
    case = recorded(name, wave={"order": order, "stretching": "taylor"}, morison=morison(dx=0.25))
    got = jacket_loads(case, oc4)
    key = f"load_{'linear' if order == 1 else 'second'}_dx025"
    check_reference(got, reference[name], key, limit)
    other = f"load_{'second' if order == 1 else 'linear'}_dx025"
    with pytest.raises(AssertionError):  # the wrong variant: the other order
        check_reference(got, reference[name], other, limit)


def test_reference_jacket_would_notice_upright_members(recorded, reference, oc4, monkeypatch) -> None:
    """The wrong variant: element z taken to be horizontal, as if every member were upright."""
    build = loads_module.case_hydro_mesh

    def upright(*args, **options):
        hydro = build(*args, **options)
        hydro.element_axes[:] = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
        return hydro

    monkeypatch.setattr(loads_module, "case_hydro_mesh", upright)
    case = recorded("A", wave={"order": 1, "stretching": "taylor"}, morison=morison(dx=0.5))
    with pytest.raises(AssertionError):
        check_reference(jacket_loads(case, oc4), reference["A"], "load_linear_dx025", 5e-3)


def inertia_force(
    t: np.ndarray, a: float, omega: float, k: float, depth: float, *, moving: bool
) -> np.ndarray:
    """Inertia force of one linear wave, its profile continued to the surface, integrated in closed form."""
    psi = omega * t
    top = a * np.cos(psi) if moving else 0.0 * t
    return -RHO * 2.0 * AREA * a * G * np.sin(psi) * np.sinh(k * (top + depth)) / math.cosh(k * depth)


def column_case(
    listed, a: float, dx: float, *, stretching: str = "none", cd: float = 0.0, direction: float = 0.0
):
    omega = 2.0 * math.pi / 10.0
    return listed(
        omega, a, 0.0, direction=direction, wave={"order": 1, "stretching": stretching},
        morison=morison(cd=cd, dx=dx), **REGULAR,
    )  # fmt: skip


def test_upright_cylinder_in_a_linear_wave(listed, column) -> None:
    omega = 2.0 * math.pi / 10.0
    k = float(wavenumber(np.array([omega]), water_depth=20.0, gravity=G)[0])
    mesh = column()
    for a in (0.01, 3.0):
        got = jacket_loads(column_case(listed, a, 0.05), mesh)
        exact = inertia_force(got.t, a, omega, k, 20.0, moving=True)
        assert np.abs(got.force[:, 0] - exact).max() < 2e-6 * np.abs(exact).max()
    fixed = inertia_force(got.t, 3.0, omega, k, 20.0, moving=False)
    assert np.abs(got.force[:, 0] - fixed).max() > 1e-2 * np.abs(exact).max()  # wrong variant: to z = 0
    assert np.abs(got.force[:, 1:]).max() < 1e-9 * np.abs(exact).max()
    turned = jacket_loads(column_case(listed, 3.0, 0.05, direction=37.0), mesh)
    b = math.radians(37.0)
    assert turned.force[:, 1] == pytest.approx(got.force[:, 0] * math.sin(b), abs=1e-6 * np.abs(exact).max())


def test_upright_cylinder_under_wheeler_stretching(listed, column) -> None:
    """z' + d = d (z + d) / (d + eta): the inertia force is that up to z = 0 times (d + eta) / d."""
    omega, a = 2.0 * math.pi / 10.0, 3.0
    k = float(wavenumber(np.array([omega]), water_depth=20.0, gravity=G)[0])
    got = jacket_loads(column_case(listed, a, 0.05, stretching="wheeler"), column())
    still = inertia_force(got.t, a, omega, k, 20.0, moving=False)
    exact = still * (1.0 + a * np.cos(omega * got.t) / 20.0)
    assert np.abs(got.force[:, 0] - exact).max() < 1e-5 * np.abs(exact).max()
    other = inertia_force(got.t, a, omega, k, 20.0, moving=True)
    assert np.abs(other - exact).max() > 1e-3 * np.abs(exact).max()  # the wrong variant: not stretched


def rate(errors: list[float]) -> float:
    return float(np.polyfit(range(len(errors)), -np.log2(errors), 1)[0])


def test_second_order_convergence_in_the_discretisation(listed, column) -> None:
    """Inertia and drag on an inclined member through the surface: error ~ dx^2, rate within 0.15."""
    mesh = column(top=(6.0, 3.0, 10.0), elements=1)
    series = [
        jacket_loads(column_case(listed, 1.0, dx, stretching="taylor", cd=1.0), mesh).force
        for dx in (2.0, 1.0, 0.5, 0.25, 0.03125)
    ]
    errors = [float(np.sqrt(np.mean((s - series[-1]) ** 2))) for s in series[:-1]]
    assert abs(rate(errors) - 2.0) < 0.15, errors
    assert abs(rate([1.0, 0.5, 0.25, 0.125]) - 2.0) > 0.15  # the wrong variant: first order


def station_forces(case, mesh, dx: float):
    """Stations, lengths along the member and Morison force per length, straight from the kinematics."""
    a, b = mesh.node_position[mesh.member_node[0]]
    hydro = build_hydro_mesh(mesh, water_depth=20.0, longest=dx)
    axis = (b - a) / np.linalg.norm(b - a)
    station = hydro.station
    k = wave_kinematics(case.model_copy(update={"points_m": tuple(map(tuple, station.tolist()))}))
    normal = np.eye(3) - np.outer(axis, axis)
    v, dv = k.velocity @ normal, k.acceleration @ normal
    q = RHO * 2.0 * AREA * dv + 0.5 * RHO * DIAMETER * np.linalg.norm(v, axis=2, keepdims=True) * v
    return station, (station - a) @ axis, q


def test_nodal_loads_are_in_equilibrium_with_the_distributed_force(listed, column) -> None:
    """Nodal forces and moments add up to the integrals of the linearly distributed force, to round-off."""
    mesh = column(top=(5.0, -4.0, -2.0), elements=3)
    case = column_case(listed, 0.5, 0.7, stretching="taylor", cd=1.0, direction=25.0)
    # The interface of this column lies below water: the check of the surface must let it pass here.
    monkey = pytest.MonkeyPatch()
    monkey.setattr(loads_module, "interface_level", lambda mesh: 30.0)
    monkey.setattr("owt_wave_node.core.hydro_mesh.interface_level", lambda mesh: 30.0)
    try:
        got = jacket_loads(case, mesh)
        station, s, q = station_forces(case, mesh, 0.7)
    finally:
        monkey.undo()
    step = np.diff(s)
    force = np.einsum("tpc,p->tc", 0.5 * (q[:, 1:] + q[:, :-1]), step)
    lever = np.zeros_like(force)
    for g, w in ((0.5 - math.sqrt(0.15), 5 / 18), (0.5, 8 / 18), (0.5 + math.sqrt(0.15), 5 / 18)):
        r = station[:-1] + g * np.diff(station, axis=0)
        here = q[:, :-1] + g * np.diff(q, axis=1)
        lever += w * np.einsum("tpc,p->tc", np.cross(r[None], here), step)
    assert np.abs(got.force - force).max() < 1e-12 * np.abs(force).max()
    assert np.abs(got.moment - lever).max() < 1e-12 * np.abs(lever).max()
    lumped = np.einsum("tpc,p->tc", np.cross(station[None, :-1], q[:, :-1]), step)
    assert np.abs(lumped - lever).max() > 1e-12 * np.abs(lever).max()  # the wrong variant: lumped stations


def test_beam_under_uniform_load_has_textbook_end_moments(listed, column) -> None:
    """A uniform q on a clamped element: fixed-end forces qL/2 and moments qL^2/12 of opposite signs."""
    place, length, q = np.linspace(0.0, 1.0, 6), 7.0, 1000.0
    weights, rows = np.empty((5, 2, 6)), np.zeros((10, 3))
    morison_kernel.segment_weights(place, length, 1, False, weights)
    morison_kernel.add_stations(np.full((6, 3, 3), q), _wet(weights)[0], rows)
    f, m = q * length / 2.0, q * length**2 / 12.0
    assert rows[:, 0] == pytest.approx([f, m, f, -m, f, -m, f, m, f, f], rel=1e-13)


def test_fixed_end_forces_are_those_of_the_nodal_loads(listed, column) -> None:
    """The rows of the end elements, turned to global axes, are the loads of the joints."""
    mesh = column(top=(3.0, 2.0, 10.0), elements=4)
    history = jacket_loads(column_case(listed, 2.0, 0.5, stretching="taylor", cd=1.0), mesh).history
    first = int(mesh.member_element[0, 0])
    row = int(np.flatnonzero(history.element == first)[0])
    axes = history.hydro.element_axes[int(np.flatnonzero(history.hydro.element == first)[0])]
    f_y, m_z, _, _, f_z, m_y, _, _ = history.end_rows[row]
    foot = history.nodal[int(np.flatnonzero(history.node == 0)[0])]
    turn = axes[1:].T
    expected = np.concatenate([turn @ np.stack([f_y, f_z]), turn @ np.stack([m_y, m_z])])
    assert np.abs(foot - expected).max() < 1e-12 * np.abs(expected).max()
    swapped = np.concatenate([turn @ np.stack([f_z, f_y]), expected[3:]])
    assert np.abs(foot - swapped).max() > 1e-3 * np.abs(expected).max()  # the wrong variant: y and z swapped


def jump(force: np.ndarray) -> float:
    """Largest step between neighbours over the range."""
    return float(np.abs(np.diff(force)).max() / np.ptp(force))


RULES = {
    "linear": (0, 1),
    "quadratic": (0, 2),
    "constant": (1, 1),
    "midpoint": (2, 1),
    "midpoint, three nodes": (2, 2),
}


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("channels", [4, 6])
def test_no_step_when_a_station_wets_or_dries(name: str, channels: int) -> None:
    """A surface that rises steadily past the stations of an inclined element: the force grows steadily."""
    rule, stride = RULES[name]
    n, length, size = 4001, 6.0, 5 * stride + 1
    place, z = np.linspace(0.0, 1.0, size), np.linspace(-2.0, 3.0, size)
    weights, rows, full = np.empty((5, stride + 1, 6)), np.zeros((10, n)), np.zeros((10, n))
    morison_kernel.segment_weights(place, length, stride, rule == 1, weights)
    eta = np.broadcast_to(np.linspace(-2.5, 3.5, n), (size, n)).copy()
    motion = np.ones((size, channels, n)) * (1.0 + 0.1 * z[:, None, None])
    axes, current = rotation(np.zeros(3), np.array([1.0, 2.0, 3.0])), np.full((size, 3), 0.2)
    coefficient = np.column_stack([5.0 + 0.1 * z, 2.0 - 0.1 * z, 0.0 * z + 0.3, 0.0 * z + 0.1])
    q = np.empty((size, 3, n))
    sectional(motion, axes, coefficient, current, q)
    surface_loads(q, motion, z, eta, rule, stride, axes, coefficient, current, place, length, weights, rows)
    steps = [jump(row) for row in rows]
    # A ramp over the element's 5 m in 3333 samples, at most some 30 times steeper than the mean.
    if rule == 2:
        assert min(steps) > 1e-2  # the wrong variant: a segment is wet when its middle is
    else:
        assert max(steps) < 1e-2
    assert np.array_equal(rows[:, 0], np.zeros(10))
    morison_kernel.add_stations(q, _wet(weights)[0], full)
    assert rows[:, -1] == pytest.approx(full[:, -1], rel=1e-13)


def test_direction_of_an_element_does_not_matter(listed, column) -> None:
    """A member listed from top to bottom carries the same loads."""
    up = column(top=(3.0, 2.0, 10.0))
    down = column(top=(3.0, 2.0, 10.0), members={"tube": {"joints": ["head", "foot"], "section": "tube"}})
    case = column_case(listed, 2.0, 0.5, stretching="taylor", cd=1.0, direction=70.0)
    one, other = jacket_loads(case, up), jacket_loads(case, down)
    assert np.abs(one.force - other.force).max() < 1e-10 * np.abs(one.force).max()
    assert np.abs(one.moment - other.moment).max() < 1e-10 * np.abs(one.moment).max()


def test_mesh_below_the_bed_carries_nothing(listed, column) -> None:
    """A pile that reaches below the sea bed is cut there."""
    case = column_case(listed, 0.5, 0.25, cd=1.0)
    reference = jacket_loads(case, column(depth=20.0, elements=4))
    deep = jacket_loads(case, column(depth=20.8, elements=1))
    assert np.abs(reference.force - deep.force).max() < 1e-5 * np.abs(reference.force).max()
    hydro = build_hydro_mesh(column(depth=20.8), water_depth=20.0, longest=0.25)
    assert hydro.station[:, 2].min() == pytest.approx(-20.0, abs=1e-12)


def test_stations_of_the_jacket(oc4) -> None:
    hydro = build_hydro_mesh(oc4, water_depth=50.0, longest=1.0)
    runs = [run for member in hydro.runs for run in member]
    length = np.concatenate([hydro.element_length[run.elements[0]] * np.diff(run.place) for run in runs])
    assert length.max() <= 1.0 + 1e-9
    assert length.min() > 0.0
    assert not np.any(oc4.is_tower[hydro.element])
    assert hydro.station[:, 2].min() >= -50.0 - 1e-9
    for run in runs:  # no segment spans still water
        z = hydro.station[run.stations.start : run.stations.stop, 2]
        assert z.max() <= 1e-9 or z.min() >= -1e-9


def test_marine_growth_widens_the_zone_only(listed, column) -> None:
    """Inertia force on (D + 2 t) inside the zone: the closed form over the two parts."""
    growth = {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -12.3, "z_top_m": -2.1}
    mesh = column(marine_growth=growth)
    omega, a = 2.0 * math.pi / 10.0, 0.01
    k = float(wavenumber(np.array([omega]), water_depth=20.0, gravity=G)[0])
    case = listed(
        omega,
        a,
        0.0,
        wave={"order": 1, "stretching": "none"},
        morison=morison(0.0, 2.0, 0.05, True),
        **REGULAR,
    )
    got = jacket_loads(case, mesh)
    clean = inertia_force(got.t, a, omega, k, 20.0, moving=True)
    part = (math.sinh(k * (20.0 - 2.1)) - math.sinh(k * (20.0 - 12.3))) / math.cosh(k * 20.0)
    extra = math.pi / 4.0 * (1.7**2 - 1.5**2)
    exact = clean - RHO * 2.0 * extra * a * G * np.sin(omega * got.t) * part
    assert np.abs(got.force[:, 0] - exact).max() < 2e-6 * np.abs(exact).max()
    assert np.abs(got.force[:, 0] - clean).max() > 1e-2 * np.abs(exact).max()  # the wrong variant: no growth


def test_order_of_work_does_not_change_the_loads(recorded, oc4, monkeypatch) -> None:
    """One thread or two, small batches and pieces or large: the same numbers."""
    from owt_wave_node.core import assembly

    case = recorded("A", time={"dt_s": 0.1, "n": 300}, morison=morison(dx=1.0))
    monkeypatch.setenv("OWT_THREADS", "1")
    one = jacket_loads(case, oc4)
    monkeypatch.setenv("OWT_THREADS", "3")
    assert np.array_equal(one.history.nodal, jacket_loads(case, oc4).history.nodal)
    monkeypatch.setattr(assembly, "PREPARED_BYTES", 16 * 300 * 50)
    monkeypatch.setattr(assembly, "MOTION_BYTES", 32 * 300 * 6)
    small = jacket_loads(case, oc4)
    assert np.abs(small.history.nodal - one.history.nodal).max() < 1e-12 * np.abs(one.history.nodal).max()
    assert (
        np.abs(small.history.end_rows - one.history.end_rows).max()
        < 1e-12 * np.abs(one.history.end_rows).max()
    )


def test_nodal_array_covers_the_mesh(recorded, oc4) -> None:
    got = jacket_loads(recorded("A", time={"dt_s": 0.1, "n": 50}), oc4)
    nodal = got.nodal()
    assert nodal.shape == (50, oc4.n_nodes, 6)
    assert not np.any(nodal[:, oc4.tower_node])
    scale = np.abs(got.force).max()
    assert nodal[:, :, :3].sum(axis=1) == pytest.approx(got.force, abs=1e-12 * scale)
    about = (nodal[:, :, 3:] + np.cross(oc4.node_position[None], nodal[:, :, :3])).sum(axis=1)
    assert about == pytest.approx(got.moment, abs=1e-10 * scale)


def test_surface_above_the_interface_is_refused(listed, column, recorded, oc4) -> None:
    with pytest.raises(InputError, match=r"components\.amplitude_m = 6\.0: raises the surface to z = 6"):
        jacket_loads(column_case(listed, 6.0, 1.0), column(top=(0.0, 0.0, 5.0)))
    from owt_model.config import parse_case

    wild = {"hs_m": 29.0, "tp_s": 14.0, "seed": 3}
    with pytest.raises(InputError, match=r"sea_state\.hs_m = 29\.0: raises the surface .*interface joint"):
        jacket_loads(parse_case({"sea_state": wild}), oc4)


def test_water_depth_must_be_that_of_the_structure(recorded, oc4) -> None:
    with pytest.raises(InputError, match=r"water_depth_m = 45\.0"):
        jacket_loads(recorded("A", water_depth_m=45.0), oc4)


def test_surface_range_finds_the_crest_between_gauges(listed) -> None:
    """The highest of a few gauges per wave is within 8 percent of the crest, which the safety covers."""
    wave = {"order": 1, "stretching": "taylor"}
    case = listed(2.0 * math.pi / 6.0, 1.0, 0.3, time={"dt_s": 0.1, "n": 60}, wave=wave)
    w = waves(build_sea_state(case))
    length = 2.0 * math.pi / float(w.wavenumber[0])
    low, high = loads_module.surface_range(
        component_field(w), np.array([[-10.0, 0.0, 0.0], [10.0, 0.0, 0.0]]), length
    )
    assert 0.92 < high <= 1.0
    assert -1.0 <= low < -0.92
