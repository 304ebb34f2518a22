"""Spectra of the wavespectra library become components: energy, directions, units, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from owt_model.config import CaseConfig, Components, parse_case
from owt_model.errors import InputError
from owt_wave_node.core.sea import build_sea_state, sea_field
from owt_wave_node.sea_source import from_wavespectra, resolve, resolve_case
from owt_wave_node.spectrum_source import tabulate

FREQUENCY = 0.035 * 1.09 ** np.arange(30)
DIRECTION = np.arange(0.0, 360.0, 15.0)


def density(hs: float = 3.0, fp: float = 0.1) -> np.ndarray:
    """Pierson-Moskowitz in m2/Hz at FREQUENCY."""
    return 5.0 / 16.0 * hs**2 * fp**4 * FREQUENCY**-5.0 * np.exp(-1.25 * (FREQUENCY / fp) ** -4.0)


def spectrum(comes_from: float = 330.0, power: float = 20.0, **units: str) -> xr.Dataset:
    """Two spectra in time, the second twice as high, spread about a direction that turns with frequency."""
    mean = comes_from + 40.0 * (FREQUENCY - 0.1)
    shape = np.abs(np.cos(np.deg2rad(DIRECTION - mean[:, None]) / 2.0)) ** power
    shape /= shape.sum(axis=1, keepdims=True) * 15.0
    one = density()[:, None] * shape
    array = xr.DataArray(
        np.stack([one, 4.0 * one]),
        dims=("time", "freq", "dir"),
        coords={
            "time": np.array(["2020-01-01", "2020-01-02"], "datetime64[ns]"),
            "freq": FREQUENCY,
            "dir": DIRECTION,
        },
        attrs={"units": units.get("density", "m2 s degree-1")},
    )
    return array.to_dataset(name="efth")


def height(components: Components | None) -> float:
    assert components is not None
    return 4.0 * math.sqrt(0.5 * float(np.sum(np.array(components.amplitude_m) ** 2)))


def library_height(dataset: xr.Dataset, index: int = 0) -> float:
    import wavespectra  # noqa: F401  gives the accessor

    return float(dataset.isel(time=index).efth.spec.hs(tail=False))


@pytest.mark.parametrize("duration", [600.0, 10800.0, 37.0])
@pytest.mark.parametrize("directional", [True, False])
def test_height_is_that_of_the_library(duration: float, directional: bool) -> None:
    """To round-off, be the components finer or coarser than the file's bins."""
    dataset = spectrum()
    for index in (0, 1):
        made = from_wavespectra(dataset, duration_s=duration, index=index, directional=directional)
        assert height(made) == pytest.approx(library_height(dataset, index), rel=1e-12)


def test_sampling_the_density_loses_energy() -> None:
    """Negative control: sqrt(2 S df) at the components misses the height that the test above asks for."""
    f = np.arange(2, 60) / 37.0
    sampled = 4.0 * math.sqrt(float(np.sum(np.interp(f, FREQUENCY, density(), right=0.0)) / 37.0))
    assert abs(sampled / library_height(spectrum()) - 1.0) > 1e-3


def test_bins_keep_their_energy() -> None:
    """In 3 h each bin of the file is found again to a component's share of it."""
    made = from_wavespectra(spectrum(), duration_s=10800.0)
    f, a = np.array(made.omega_rad_s) / (2.0 * math.pi), np.array(made.amplitude_m)
    bounds = tabulate(spectrum()).bounds
    energy = density() * np.gradient(FREQUENCY)
    for i in range(4, FREQUENCY.size):
        inside = (f > bounds[i]) & (f <= bounds[i + 1])
        assert 0.5 * np.sum(a[inside] ** 2) == pytest.approx(energy[i], rel=0.05)


def test_a_band_holds_the_energy_between_its_limits() -> None:
    """Two bands that meet hold what one over both holds, and no component leaves its band."""
    dataset, middle = spectrum(), 0.8123
    low = from_wavespectra(dataset, duration_s=600.0, cutoff_rad_s=middle)
    high = from_wavespectra(dataset, duration_s=600.0, cutin_rad_s=middle)
    assert math.hypot(height(low), height(high)) == pytest.approx(library_height(dataset), rel=1e-12)
    assert max(low.omega_rad_s) <= middle <= min(high.omega_rad_s)
    # a component has the same phase and direction in every band
    whole = from_wavespectra(dataset, duration_s=600.0)
    assert whole.phase_rad[-len(high.phase_rad) :] == high.phase_rad
    assert isinstance(whole.direction_deg, tuple)
    assert isinstance(high.direction_deg, tuple)
    assert whole.direction_deg[-len(high.direction_deg) :] == high.direction_deg


def mean_direction(components: Components) -> float:
    b = np.deg2rad(np.broadcast_to(components.direction_deg, len(components.omega_rad_s)))
    return math.degrees(np.angle(np.sum(np.array(components.amplitude_m) ** 2 * np.exp(1j * b)))) % 360.0


@pytest.mark.parametrize("comes_from", [330.0, 0.0, 90.0, 215.0])
def test_metocean_directions(comes_from: float) -> None:
    """b = (180 - metocean) mod 360: waves from the north (0) travel to -x, from the east (90) to +y."""
    expected = (180.0 - comes_from) % 360.0
    one = from_wavespectra(spectrum(comes_from, 200.0), duration_s=600.0, directional=False)
    assert isinstance(one.direction_deg, float)
    difference = (one.direction_deg - expected + 180.0) % 360.0 - 180.0
    assert abs(difference) < 3.0  # the mean direction turns by 40 degrees per Hz
    many = from_wavespectra(spectrum(comes_from, 200.0), duration_s=10800.0)
    assert abs((mean_direction(many) - one.direction_deg + 180.0) % 360.0 - 180.0) < 1.0


def test_directions_follow_the_frequency() -> None:
    """Mean and spread of the drawn directions are those of the file at that frequency."""
    dataset = spectrum(330.0, 30.0)
    made = from_wavespectra(dataset, duration_s=36000.0)
    f = np.array(made.omega_rad_s) / (2.0 * math.pi)
    b = np.deg2rad(np.array(made.direction_deg))
    found = dataset.isel(time=0).efth
    unit = np.exp(1j * np.deg2rad((180.0 - DIRECTION) % 360.0))
    for centre in (0.08, 0.12, 0.2):
        band = np.abs(f - centre) < 0.01
        row = found.sel(freq=centre, method="nearest").values
        expected = np.sum(row * unit) / np.sum(row)
        drawn = np.mean(np.exp(1j * b[band]))
        # 700 draws of a spread of 20 degrees: the mean is known to 0.8 degrees, three times that is allowed.
        # Frequencies nearby have a mean 0.4 degrees away; a bin of 15 degrees shortens the vector by 0.3 %.
        assert abs(np.degrees(np.angle(drawn / expected))) < 3.0
        assert abs(drawn) == pytest.approx(abs(expected), abs=0.02)


def test_seeds_and_amplitudes() -> None:
    a, b, c = (from_wavespectra(spectrum(), duration_s=600.0, seed=s) for s in (1, 1, 2))
    assert a == b
    assert a.phase_rad != c.phase_rad
    assert a.direction_deg != c.direction_deg
    random = [
        height(from_wavespectra(spectrum(), duration_s=600.0, seed=s, amplitudes="rayleigh"))
        for s in range(20)
    ]
    assert np.std(random) > 0.02
    assert np.mean(np.square(random)) == pytest.approx(library_height(spectrum()) ** 2, rel=0.1)


def write(dataset: xr.Dataset, path: Path) -> Path:
    dataset.to_netcdf(path, engine="h5netcdf")
    return path


def case_of(path: Path, **more: Any) -> CaseConfig:
    return parse_case({"spectrum_file": {"path": str(path)} | more, "time": {"dt_s": 0.2, "n": 3000}})


def test_a_file_is_what_it_is_in_memory(tmp_path: Path) -> None:
    path = write(spectrum(), tmp_path / "spectra.nc")
    case, report = resolve(case_of(path, index=1, seed=3))
    assert case.components == from_wavespectra(spectrum(), duration_s=600.0, index=1, seed=3)
    assert case.spectrum_file is None
    assert sea_field(case) == "components.amplitude_m (from spectrum_file)"
    assert report is not None
    assert report.line.count("\n") == 0
    assert report.numbers["file_hs_m"] == pytest.approx(library_height(spectrum(), 1), rel=1e-12)
    # The case can be written, read and run again without its file.
    path.unlink()
    again = CaseConfig.model_validate_json(case.model_dump_json())
    assert again == case
    assert build_sea_state(again).omega_rad_s.size == report.numbers["components"]


def test_other_cases_stay_as_they_are() -> None:
    case = parse_case({})
    assert resolve(case) == (case, None)
    assert resolve_case(case) is case


def test_radians_are_degrees(tmp_path: Path) -> None:
    """A density per radian, in memory and in a file whose unit the library's reader replaces."""
    degrees = from_wavespectra(spectrum(), duration_s=600.0)
    radian = spectrum(density="m2 s rad-1")
    radian["efth"] *= 180.0 / math.pi
    for unit in ("m2 s rad-1", "m2/Hz/rad", "m^2 s radian^-1"):
        radian["efth"].attrs["units"] = unit
        assert height(from_wavespectra(radian, duration_s=600.0)) == pytest.approx(height(degrees), rel=1e-12)
    file = resolve_case(case_of(write(radian, tmp_path / "radian.nc")))
    assert height(file.components) == pytest.approx(height(degrees), rel=1e-12)
    # Negative control: taken as per degree it is 7.6 times as high.
    radian["efth"].attrs["units"] = "m2 s degree-1"
    assert height(from_wavespectra(radian, duration_s=600.0)) > 7.0 * height(degrees)
    # Directions in radian
    turned = spectrum().assign_coords(dir=("dir", np.deg2rad(DIRECTION), {"units": "radian"}))
    np.testing.assert_allclose(
        from_wavespectra(turned, duration_s=600.0).direction_deg, degrees.direction_deg, atol=1e-9
    )


def test_one_dimension_takes_the_direction_given() -> None:
    one = xr.DataArray(density(), dims="freq", coords={"freq": FREQUENCY}, name="efth")
    made = from_wavespectra(one, duration_s=600.0, direction_deg=10.0)
    assert made.direction_deg == 10.0
    assert height(made) == pytest.approx(library_height(spectrum()), rel=1e-12)


def test_a_sector_has_no_bin_across_the_rest_of_the_circle() -> None:
    sector = spectrum(330.0, 60.0).sel(dir=slice(240.0, 345.0))
    assert height(from_wavespectra(sector, duration_s=600.0)) == pytest.approx(
        library_height(sector), rel=1e-12
    )


@pytest.mark.parametrize("reader", ["swan", "ww3", "octopus", "netcdf"])
def test_formats_agree(tmp_path: Path, reader: str) -> None:
    """The same sea in formats with unlike conventions: WAVEWATCH III has "to" directions and radian."""
    import wavespectra  # noqa: F401  gives the accessor

    path = tmp_path / f"sea.{reader}"
    dataset = spectrum().expand_dims(site=[1]).transpose("time", "site", "freq", "dir")
    dataset = dataset.assign({"lon": ("site", [3.0]), "lat": ("site", [54.0])})
    for name, value in (("wspd", 10.0), ("wdir", 330.0), ("dpt", 50.0)):
        dataset[name] = (("time", "site"), [[value], [value]])
    getattr(dataset.spec, f"to_{reader}")(str(path))
    case, report = resolve(case_of(path, reader=reader, index=1, directional=False))
    expected = from_wavespectra(spectrum(), duration_s=600.0, index=1, directional=False)
    assert report is not None
    assert report.numbers["file_hs_m"] == pytest.approx(library_height(spectrum(), 1), rel=1e-3)
    assert case.components is not None
    assert case.components.direction_deg == pytest.approx(expected.direction_deg, abs=0.1)


def test_a_plain_file_in_other_conventions_is_refused(tmp_path: Path) -> None:
    """Not taken for what it is not: the reader of plain netCDF converts nothing."""
    for name, attributes in (
        ("dir", {"standard_name": "sea_surface_wave_to_direction"}),
        ("freq", {"units": "rad s-1"}),
    ):
        dataset = spectrum()
        dataset[name].attrs.update(attributes)
        with pytest.raises(InputError, match="this reader takes"):
            resolve_case(case_of(write(dataset, tmp_path / f"{name}.nc")))


def test_the_second_site_of_the_second_time() -> None:
    sites = xr.concat([spectrum().efth, 9.0 * spectrum().efth], dim="site").transpose(
        "time", "site", "freq", "dir"
    )
    heights = [height(from_wavespectra(sites, duration_s=600.0, index=i)) for i in range(4)]
    np.testing.assert_allclose(np.array(heights) / heights[0], [1.0, 3.0, 2.0, 6.0], rtol=1e-12)


def test_what_is_refused(tmp_path: Path) -> None:
    good = write(spectrum(), tmp_path / "good.nc")
    bad = spectrum()
    bad["efth"][0, 3, 4] = np.nan
    nan = write(bad, tmp_path / "nan.nc")
    text = tmp_path / "text.nc"
    text.write_text("not a spectrum")
    other = tmp_path / "other.nc"
    xr.Dataset({"a": ("x", [1.0, 2.0])}).to_netcdf(other, engine="h5netcdf")
    cases: list[tuple[Path, dict[str, Any], str]] = [
        (tmp_path / "absent.nc", {}, "does not exist"),
        (good, {"index": 2}, "past the 2 spectra"),
        (good, {"reader": "magic"}, "no reader .* netcdf"),
        (good, {"direction_deg": 10.0}, "directions of its own"),
        (good, {"cutin_rad_s": 10.0}, "no component"),
        (good, {"cutin_rad_s": 0.2, "cutoff_rad_s": 0.201}, "no component"),
        (nan, {}, "finite and not negative"),
        (text, {}, "cannot be read as netcdf"),
        (other, {}, "lacks the variable efth"),
    ]
    for path, options, message in cases:
        with pytest.raises(InputError, match=message):
            resolve_case(case_of(path, **options))
    assert resolve_case(case_of(nan, index=1)).components is not None


def test_spectra_that_are_refused() -> None:
    one = xr.DataArray(density(), dims="freq", coords={"freq": FREQUENCY})
    with pytest.raises(InputError, match="holds no directions"):
        from_wavespectra(one, duration_s=600.0)
    for change, message in (
        (0.0 * one, "no energy"),
        (-one, "not negative"),
        (one.isel(freq=[3]), "two or more"),
        (one.isel(freq=[3, 3, 4]), "repeats a frequency"),
        (one.rename(freq="f"), "without freq"),
    ):
        with pytest.raises(InputError, match=message):
            from_wavespectra(change, duration_s=600.0, direction_deg=0.0)
