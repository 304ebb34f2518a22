"""The file of ``owt loads``: written window by window, whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from owt_bringup.cli import main
from owt_bringup.output import npz_file
from owt_model.config import parse_case
from owt_wave_node.core.buoyancy import buoyancy
from owt_wave_node.core.loads import jacket_loads
from proofs.cases import oc4


def test_rows_make_the_file_of_numpy(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    arrays = {"long": rng.standard_normal((7, 3, 2)), "names": np.array(["a", "bcd"]), "one": np.array(2.5)}
    np.savez(tmp_path / "numpy.npz", **arrays)
    with npz_file(tmp_path / "rows.npz") as file:
        with file.rows("long", (7, 3, 2), np.dtype(float)) as write:
            for start in (0, 3, 6):
                write(arrays["long"][start : start + 3])
        file.add("names", arrays["names"])
        file.add("one", arrays["one"])
    with np.load(tmp_path / "rows.npz") as rows, np.load(tmp_path / "numpy.npz") as expected:
        assert sorted(rows) == sorted(expected)
        for name in expected:
            assert rows[name].dtype == expected[name].dtype
            assert np.array_equal(rows[name], expected[name])


def test_a_file_that_fails_half_way_does_not_appear(tmp_path: Path) -> None:
    def half() -> None:
        with npz_file(tmp_path / "half.npz") as file, file.rows("x", (9,), np.dtype(float)) as write:
            write(np.zeros(4))
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError, match="half way"):
        half()
    assert not list(tmp_path.iterdir())


def test_loads_of_several_windows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = {"time": {"dt_s": 0.1, "n": 230}, "wave": {"window": 100}}
    (tmp_path / "case.json").write_text(json.dumps(data))
    assert main(["loads", str(tmp_path / "case.json"), "-o", str(tmp_path / "out.npz")]) == 0
    assert "waves compressed, estimated error" in capsys.readouterr().err
    expected = jacket_loads(parse_case(data), oc4())
    with np.load(tmp_path / "out.npz") as found:
        assert np.array_equal(found["nodal"], expected.nodal())
        assert np.array_equal(found["t"], expected.t)
        assert found["force"] == pytest.approx(expected.force, rel=1e-12)
        assert found["moment"] == pytest.approx(expected.moment, rel=1e-12)
        assert 0.0 < found["error_estimate"] == expected.error_estimate < 1e-8
        # Negative control: the windows are not repeated.
        assert not np.allclose(found["nodal"][:100], found["nodal"][100:200])


@pytest.mark.parametrize("asked", [True, False])
def test_buoyancy_is_an_array_of_its_own(tmp_path: Path, asked: bool) -> None:
    data = {"time": {"dt_s": 0.1, "n": 120}, "wave": {"order": 1}}
    morison = {"morison": {"buoyancy": asked}}
    (tmp_path / "case.json").write_text(json.dumps(data | morison))
    assert main(["loads", str(tmp_path / "case.json"), "-o", str(tmp_path / "out.npz")]) == 0
    with np.load(tmp_path / "out.npz") as found:
        assert ("buoyancy" in found) == asked
        assert np.array_equal(found["nodal"], jacket_loads(parse_case(data), oc4()).nodal())
        if asked:
            assert np.array_equal(found["buoyancy"], buoyancy(parse_case(data), oc4()))
