"""A record becomes components: recovered from a synthetic record, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import ComputationError, InputError
from owt_wave_node.core.measured import Band, components_of_record
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state
from owt_wave_node.sea_source import read_record, resolve, resolve_case

SEA = {"sea_state": {"hs_m": 5.0, "tp_s": 9.0, "direction_deg": 30.0, "cutoff_over_peak": 3.0}}
TIME = {"dt_s": 0.25, "n": 1200}
PLACE = (12.0, -7.0)


def gauge_record(case: CaseConfig, place: tuple[float, float] = PLACE) -> np.ndarray:
    sea = build_sea_state(case)
    first, second = make_field(case, sea).elevation(Frame(sea.direction_deg).place(np.array([place])))
    return first[0] + second[0]


def write(path: Path, record: np.ndarray, dt: float = 0.25, start: float = 0.0) -> Path:
    rows = [f"{start + i * dt:.6g},{eta!r}" for i, eta in enumerate(record.tolist())]
    path.write_text("time s,elevation m\n# a comment\n" + "\n".join(rows) + "\n")
    return path


def measured(path: Path, **more: Any) -> dict[str, Any]:
    options = {
        "path": str(path),
        "place_m": list(PLACE),
        "direction_deg": 30.0,
        "cutoff_rad_s": 2.1,
        "tolerance": 1e-8,
    }
    return {"measured": options | more, "time": TIME, "gauges_m": [list(PLACE)]}


def at_bins(omega: Any, amplitude: Any, phase: Any, duration: float = 300.0) -> np.ndarray:
    """Complex amplitudes by number m of the frequency 2 pi m / duration."""
    m = np.rint(np.asarray(omega) * duration / (2.0 * np.pi)).astype(int)
    out = np.zeros(200, dtype=complex)
    out[m] = np.asarray(amplitude) * np.exp(-1j * np.asarray(phase))
    return out


def known_bins(case: CaseConfig) -> np.ndarray:
    sea = build_sea_state(case)
    return at_bins(sea.omega_rad_s, sea.amplitude_m, sea.phase_rad)


@pytest.fixture(scope="module")
def case() -> CaseConfig:
    return parse_case(SEA | {"time": TIME})


@pytest.fixture(scope="module")
def record(case: CaseConfig) -> np.ndarray:
    return gauge_record(case)


def test_components_come_back(case: CaseConfig, record: np.ndarray, tmp_path: Path) -> None:
    """A second-order record of known components: amplitudes and phases at the origin to 1e-6."""
    resolved, report = resolve(parse_case(measured(write(tmp_path / "record.csv", record))))
    found, expected = resolved.components, known_bins(case)
    assert found is not None
    assert found.source == "measured"
    A = at_bins(found.omega_rad_s, found.amplitude_m, found.phase_rad)
    assert np.abs(A - expected).max() < 1e-6 * np.abs(expected).max()
    assert report is not None
    assert report.numbers["residual_rms"] < 1e-6
    assert report.line.count("\n") == 0
    # And the case reproduces its record through the ordinary way.
    again = gauge_record(resolved)
    assert np.abs((again - again.mean()) - (record - record.mean())).max() < 1e-6 * record.std()


def test_without_second_order_removed_the_components_are_others(
    case: CaseConfig, record: np.ndarray, tmp_path: Path
) -> None:
    """Negative control: at order 1 nothing is removed."""
    linear = measured(write(tmp_path / "record.csv", record)) | {"wave": {"order": 1}}
    found = resolve_case(parse_case(linear)).components
    assert found is not None
    A, expected = at_bins(found.omega_rad_s, found.amplitude_m, found.phase_rad), known_bins(case)
    assert np.abs(A - expected).max() > 1e-2 * np.abs(expected).max()


def test_the_mean_is_left_out(record: np.ndarray, tmp_path: Path) -> None:
    """The datum of the gauge changes nothing but the mean that is reported."""
    a, first = resolve(parse_case(measured(write(tmp_path / "a.csv", record))))
    b, second = resolve(parse_case(measured(write(tmp_path / "b.csv", record + 2.0))))
    assert a.components is not None
    assert b.components is not None
    np.testing.assert_allclose(a.components.amplitude_m, b.components.amplitude_m, atol=1e-9)
    assert first is not None
    assert second is not None
    assert second.numbers["mean_m"] - first.numbers["mean_m"] == pytest.approx(2.0, abs=1e-12)
    assert first.numbers["set_down_m"] == pytest.approx(first.numbers["mean_m"], abs=1e-6)


def test_what_lies_outside_the_band_is_the_residual(record: np.ndarray) -> None:
    """Noise above the cut-off is not explained away: it stays as residual, of its own size."""
    t = np.arange(record.size) * 0.25
    noise = 0.1 * np.cos(2.0 * np.pi * 1.5 * t)
    found = components_of_record(
        record + noise, dt=0.25, x=0.0, depth=50.0, gravity=9.81, band=Band(0.0, 2.1, 1e-8)
    )
    assert found.residual_rms * found.std_m == pytest.approx(0.1 / np.sqrt(2.0), rel=1e-3)
    assert found.residual_max * found.std_m == pytest.approx(0.1, rel=1e-2)


def test_steep_seas_converge() -> None:
    """Hs 10 m at 9.45 s up to four times the peak: plain iteration diverges here."""
    steep = {"hs_m": 10.0, "tp_s": 9.45, "cutoff_over_peak": 4.0}
    case = parse_case({"sea_state": steep, "time": {"dt_s": 0.2, "n": 1500}})
    record = gauge_record(case, (0.0, 0.0))
    found = components_of_record(record, dt=0.2, x=0.0, depth=50.0, gravity=9.81, band=Band(0.0, 2.66, 1e-7))
    assert np.abs(at_bins(found.omega, found.amplitude, found.phase) - known_bins(case)).max() < 1e-6


def test_long_records_converge() -> None:
    """In 50 min the lowest multiples of 2 pi / duration are no waves of second order; they are left out."""
    sea = {"hs_m": 6.0, "tp_s": 9.45, "cutoff_over_peak": 2.0}
    case = parse_case({"sea_state": sea, "time": {"dt_s": 0.5, "n": 6000}})
    record = gauge_record(case, (0.0, 0.0))
    found = components_of_record(record, dt=0.5, x=0.0, depth=50.0, gravity=9.81, band=Band(0.0, 1.34, 1e-6))
    assert found.residual_rms < 1e-5
    assert found.omega[0] > 0.05 * np.sqrt(9.81 / 50.0)


def test_no_convergence_is_an_error(record: np.ndarray, tmp_path: Path) -> None:
    path = write(tmp_path / "record.csv", record)
    with pytest.raises(ComputationError, match="3 iterations"):
        resolve_case(parse_case(measured(path, max_iterations=3, tolerance=1e-9)))
    with pytest.raises(ComputationError, match=r"cutoff_rad_s"):
        resolve_case(parse_case(measured(write(path, 20.0 * record), cutoff_rad_s=6.0)))


def test_other_times_are_told(record: np.ndarray, tmp_path: Path) -> None:
    path = write(tmp_path / "record.csv", record, start=100.0)
    same, report = resolve(parse_case(measured(path)))
    assert report is not None
    assert "samples" not in report.line
    assert "case 1200" not in report.line
    other, told = resolve(parse_case(measured(path) | {"time": {"dt_s": 0.5, "n": 100}}))
    assert told is not None
    assert "record 1200 x 0.25 s, case 100 x 0.5 s" in told.line
    assert other.components == same.components


def test_the_start_of_a_record_is_told(record: np.ndarray, tmp_path: Path) -> None:
    """Where the record does not start at 0, and only there."""
    for start, told in ((0.0, False), (100.0, True)):
        report = resolve(parse_case(measured(write(tmp_path / "record.csv", record, start=start))))[1]
        assert report is not None
        assert ("the record's t = 100 s" in report.line) is told


def with_noise(record: np.ndarray, share: float) -> np.ndarray:
    """`record` with a wave above the cut-off that is `share` of the standard deviation of the sum."""
    t = np.arange(record.size) * 0.25
    size = record.std() * share / np.sqrt(1.0 - share**2)
    return record + np.sqrt(2.0) * size * np.cos(2.0 * np.pi * 1.5 * t)


def test_a_large_residual_is_a_warning(record: np.ndarray, tmp_path: Path) -> None:
    for share, kind in ((0.09, "note"), (0.11, "warning"), (0.49, "warning")):
        report = resolve(parse_case(measured(write(tmp_path / "record.csv", with_noise(record, share)))))[1]
        assert report is not None
        assert report.kind == kind
    path = write(tmp_path / "record.csv", with_noise(record, 0.51))
    with pytest.raises(InputError, match=r"measured\.cutoff_rad_s = 2\.1: leaves 0\.51 of"):
        resolve(parse_case(measured(path)))


@pytest.mark.parametrize("order", [1, 2])
def test_a_band_without_waves_is_refused(order: int, tmp_path: Path) -> None:
    """A record of the Nyquist frequency alone: nothing of it, or only round-off, lies below the cut-off."""
    for n in (64, 63):
        path = write(tmp_path / "record.csv", (-1.0) ** np.arange(n), dt=1.0)
        case = measured(path, cutoff_rad_s=1.2) | {"wave": {"order": order}}
        with pytest.raises(InputError, match=r"measured\.cutoff_rad_s = 1\.2: leaves "):
            resolve(parse_case(case))


@pytest.mark.parametrize("scale", [1e300, 1.7e308, 1e7, 1e-300])
def test_elevations_beyond_all_waves_are_refused(record: np.ndarray, tmp_path: Path, scale: float) -> None:
    """Not an overflow or underflow: these are no metres."""
    path = write(tmp_path / "record.csv", record / np.abs(record).max() * scale)
    with pytest.raises(InputError, match=r"measured\."):
        resolve(parse_case(measured(path)))


@pytest.mark.parametrize("first", ["0.0,", ",1.0", "0.0,n/a", "0.0", ",", "nan,nan", "0.0,1.0,2.0"])
def test_a_first_row_with_a_gap_is_no_title(tmp_path: Path, first: str) -> None:
    """Taken for one, the sea would start a sample later."""
    path = tmp_path / "record.csv"
    path.write_text("\n".join([first, *(f"{i}.0,{i % 3}.0" for i in range(1, 20))]))
    with pytest.raises(InputError, match="row 1 "):
        read_record(path)


def test_the_title_may_follow_comments(tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    path.write_text("# buoy\n\ntime,\n" + "\n".join(f"{i}.0,{i % 3}.0" for i in range(20)))
    assert read_record(path).elevation_m.size == 20
    path.write_text("time,eta\ns,m\n" + "\n".join(f"{i}.0,{i % 3}.0" for i in range(20)))
    with pytest.raises(InputError, match="row 2 "):
        read_record(path)


def spoil(lines: list[str], row: int, text: str | None) -> list[str]:
    """Replace a row (from 1), or take it out."""
    return lines[: row - 1] + ([] if text is None else [text]) + lines[row:]


@pytest.mark.parametrize(
    ("row", "text", "message"),
    [
        (10, "2.0,nan", "row 10"),
        (10, "2.0,", "row 10"),
        (10, "2.0,1.0,3.0", "row 10"),
        (10, "abc,1.0", "row 10"),
        (10, None, "row 10"),
        (10, "1.9,0.5", "row 10"),
    ],
)
def test_gaps_name_their_row(
    record: np.ndarray, tmp_path: Path, row: int, text: str | None, message: str
) -> None:
    path = write(tmp_path / "record.csv", record)
    path.write_text("\n".join(spoil(path.read_text().splitlines(), row, text)))
    with pytest.raises(InputError, match=message):
        read_record(path)


def test_records_that_are_refused(tmp_path: Path, record: np.ndarray) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_record(tmp_path / "absent.csv")
    short = tmp_path / "short.csv"
    short.write_text("0,1\n1,2\n")
    with pytest.raises(InputError, match="too few"):
        read_record(short)
    path = write(tmp_path / "record.csv", record)
    for change, message in (
        ({"cutoff_rad_s": 13.0}, "Nyquist"),
        ({"cutin_rad_s": 2.0, "cutoff_rad_s": 1.0}, "no component"),
    ):
        with pytest.raises(InputError, match=message):
            resolve_case(parse_case(measured(path, **change)))
    with pytest.raises(InputError, match="no waves"):
        resolve_case(parse_case(measured(write(path, np.ones(50)))))
