"""Morison loads: reference jacket, closed forms, equilibrium, surface, growth, blocks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_wave_node.core import loads as loads_module
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.ends import free_ends
from owt_wave_node.core.hydro_mesh import build_hydro_mesh
from owt_wave_node.core.loads import Loads, jacket_loads
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import build_sea_state, waves
from owt_wave_node.core.stage import build_wave_stage

RHO, G, DIAMETER = 1025.0, 9.81, 1.5
AREA = math.pi * DIAMETER**2 / 4.0
REGULAR = {"water_depth_m": 20.0, "time": {"dt_s": 0.1, "n": 100}}


def morison(cd: float = 1.0, cm: float = 2.0, dx: float = 1.0, growth: bool = False) -> dict:
    return {"cd": cd, "cm": cm, "marine_growth": growth, "discretisation_m": dx}


def check_reference(got: Loads, d, key: str, limit: float) -> None:
    at = np.rint(d["t_load"] / 0.1).astype(int)
    for series, expected in zip((got.force[:, 0], got.force[:, 2], got.moment[:, 1]), d[key], strict=True):
        assert np.abs(series[at] - expected).max() < limit * np.abs(expected).max()


def test_reference_jacket(recorded, reference, oc4) -> None:
    """Linear loads in the steeper sea; the other references are among the proofs."""
    case = recorded("C", wave={"order": 1, "stretching": "taylor"}, morison=morison(dx=0.25))
    check_reference(jacket_loads(case, oc4), reference["C"], "load_linear_dx025", 4e-4)


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
    crest = {"hs_m": 3.0, "tp_s": 12.0, "focus": {"crest_m": 19.0, "time_s": 10.0, "background": False}}
    with pytest.raises(InputError, match=r"sea_state\.focus\.crest_m = 19\.0: raises the surface"):
        jacket_loads(parse_case({"sea_state": crest, "time": {"n": 200}}), oc4)
    airy = {"theory": "airy", "height_m": 11.0, "period_s": 10.0}
    regular = {"regular": airy, "time": {"n": 200}, "water_depth_m": 20.0}
    with pytest.raises(InputError, match=r"regular\.height_m = 11\.0: raises the surface"):
        jacket_loads(parse_case(regular | {"wave": {"order": 1}}), column(top=(0.0, 0.0, 5.0)))
    read = column_case(listed, 6.0, 1.0)
    made = read.components.model_copy(update={"source": "measured"})
    with pytest.raises(InputError, match=r"components\.amplitude_m \(from measured\) = 6\.0: raises"):
        jacket_loads(read.model_copy(update={"components": made}), column(top=(0.0, 0.0, 5.0)))


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


def test_gauss_points_replace_the_stations_of_submerged_elements(oc4) -> None:
    """Every element below the level has Gauss points, up to the bed; others have stations."""
    hydro = build_hydro_mesh(oc4, water_depth=50.0, longest=1.0, marine_growth=True, gauss_below=-6.0)
    top = oc4.node_position[oc4.element_node[hydro.element], 2].max(axis=1)
    loaded = np.zeros(len(hydro.element))
    for runs in hydro.runs:
        for run in runs:
            assert all((top[e] < -6.0) == run.is_gauss for e in run.elements)
            length = run.wet[:, :, 4:].sum(axis=(1, 2))  # the axial shapes add up to one
            loaded[run.elements.start : run.elements.stop] += length
    z = oc4.node_position[oc4.element_node[hydro.element], 2]
    above_bed = (z.max(axis=1) - np.maximum(z.min(axis=1), -50.0)) / np.maximum(np.ptp(z, axis=1), 1e-9)
    share = np.where(np.ptp(z, axis=1) > 1e-9, above_bed, 1.0)
    assert loaded == pytest.approx(share * hydro.element_length, rel=1e-12)


def test_gauss_points_of_the_whole_jacket(recorded, oc4) -> None:
    """Fewer points, and closer to 0.1 m elements than the 1 m rule is."""
    case = {"time": {"dt_s": 0.1, "n": 600}}
    truth, rule, gauss = (
        jacket_loads(recorded("A", **case, morison=options), oc4)
        for options in (
            {"discretisation_m": 0.1},
            {},
            {"points": "gauss", "distribution": "quadratic"},
        )
    )
    assert len(gauss.history.hydro.station) < len(rule.history.hydro.station)
    off, before = (np.abs(got.force - truth.force).max() for got in (gauss, rule))
    assert off < 0.1 * before


def test_loads_along_members_reach_the_end_forces(recorded, oc4) -> None:
    """Fixed-end forces of a block hold the axial rows, with the other sign."""
    options = {"axial_cd": 0.1, "axial_ca": 0.2}
    stage = build_wave_stage(recorded("A", time={"dt_s": 0.1, "n": 50}, morison=options), oc4)
    block, history = stage.load_block(0), stage.history()
    assert history.end_rows.shape[1] == 10
    assert np.array_equal(block.fixed_end[:, :, [0, 6]], -history.end_rows[:, 8:].transpose(2, 0, 1))
    plain = build_wave_stage(recorded("A", time={"dt_s": 0.1, "n": 50}), oc4).load_block(0)
    assert not plain.fixed_end[:, :, [0, 3, 6, 9]].any()


def test_free_ends_are_those_of_one_member_that_nothing_holds(oc4, column) -> None:
    assert free_ends(oc4) == []
    assert free_ends(column()) == []


@pytest.mark.parametrize(
    "fields",
    [
        {"wave": {"order": 1, "stretching": "wheeler"}},
        {"components": None, "regular": {"theory": "stream", "height_m": 2.0, "period_s": 8.0}},
    ],
)
def test_diffraction_needs_linear_components(listed, column, fields) -> None:
    case = {"wave": {"order": 1, "stretching": "taylor"}, "morison": {"diffraction": "maccamy-fuchs"}}
    with pytest.raises(InputError, match=r"morison\.diffraction"):
        jacket_loads(listed(0.8, 0.5, 0.0, **REGULAR | case | fields), column())


def test_diffraction_is_small_for_slender_members(recorded, oc4) -> None:
    fields = {"time": {"dt_s": 0.1, "n": 300}}
    plain, diffracted = (
        jacket_loads(recorded("A", **fields, morison={"diffraction": name}), oc4).force
        for name in ("none", "maccamy-fuchs")
    )
    change = np.abs(plain - diffracted).max() / np.abs(plain).max()
    assert 1e-4 < change < 2e-2


def test_damping_of_a_record_does_not_depend_on_its_windows(recorded, oc4) -> None:
    """The mean over three windows is that over the record; without the option there is none."""
    fields = {"time": {"dt_s": 0.1, "n": 600}, "stream": {"block": 100}}
    case = {"hydrodynamic_damping": True}
    whole, cut, none = (
        build_wave_stage(recorded("A", **fields, morison=options, wave={"window": window}), oc4)
        .load_basis(2)
        .damping
        for options, window in ((case, None), (case, 200), ({}, None))
    )
    assert none.shape == (0, 3, 3)
    assert np.abs(whole - cut).max() < 1e-9 * np.abs(whole).max()
    assert np.abs(whole - whole.transpose(0, 2, 1)).max() < 1e-12 * np.abs(whole).max()
    assert np.linalg.eigvalsh(whole).min() > -1e-9 * np.abs(whole).max()  # drag takes energy out


EVERYTHING = {
    "cd": [[-20.0, 0.7], [0.0, 1.1]],
    "cm": [[-20.0, 1.8], [0.0, 1.6]],
    "distribution": "quadratic",
    "points": "gauss",
    "diffraction": "maccamy-fuchs",
    "axial_cd": 0.1,
    "axial_ca": 0.2,
    "end_cd": 1.0,
    "end_ca": 1.0,
    "marine_growth": True,
}


def test_all_options_by_every_route(recorded, column) -> None:
    """Loads with every option on do not depend on how the waves are summed, nor on how they are windowed."""
    growth = {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -12.0, "z_top_m": -2.0}
    mesh = column(depth=50.0, top=(8.0, 3.0, 12.0), marine_growth=growth)
    fields = {
        "time": {"dt_s": 0.5, "n": 300},
        "current": {"speed_m_s": 0.7, "direction_deg": 80.0},
        "morison": EVERYTHING,
        "stream": {"block": 50},
    }
    loads = [
        jacket_loads(recorded("A", **fields, wave={"order": 1, "route": route, "window": window}), mesh)
        for route, window in (("exact", None), ("direct", None), ("compressed", None), ("exact", 150))
    ]
    assert np.abs(loads[0].force[:, 1]).max() > 1e3  # the current pushes across the waves
    for other in loads[1:]:
        assert np.abs(other.force - loads[0].force).max() < 1e-6 * np.abs(loads[0].force).max()
        assert np.abs(other.moment - loads[0].moment).max() < 1e-6 * np.abs(loads[0].moment).max()


def test_all_options_in_short_crested_waves(listed, column) -> None:
    """Directions that are almost one give the loads of one: three channels against two."""
    mesh = column(top=(8.0, 3.0, 12.0), marine_growth=None)
    one, other = (
        jacket_loads(
            listed(
                [0.6, 0.9, 1.2], [0.4, 0.3, 0.1], [0.0, 1.0, 2.0], direction=directions, **REGULAR,
                current={"speed_m_s": 0.7, "direction_deg": 80.0},
                morison=EVERYTHING | {"marine_growth": False},
            ),
            mesh,
        ).force
        for directions in (40.0, [40.0, 40.0 + 1e-5, 40.0])
    )  # fmt: skip
    assert np.abs(one - other).max() < 1e-6 * np.abs(one).max()
    assert np.abs(one - other).max() > 0.0  # they did take different ways
