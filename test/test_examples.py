"""Every example runs to its assert and draws its picture; the README lists them all."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import matplotlib as mpl
import pytest

ROOT = Path(__file__).parents[1]
#: Clients of a server, without a picture; test_action.py runs them.
CLIENTS = [ROOT / "examples" / "run_sea_state.py"]
EXAMPLES = sorted(set((ROOT / "examples").glob("*.py")) - set(CLIENTS))
#: Bytes below which a picture shows nothing.
SMALLEST = 10_000
MAX_LINES = 100


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mpl.use("Agg")
    spec = importlib.util.spec_from_file_location(f"example_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with monkeypatch.context() as patch:
        patch.syspath_prepend(str(path.parent))
        spec.loader.exec_module(module)
        module.main(tmp_path)
    pictures = {file.name: file.stat().st_size for file in tmp_path.glob("*.png")}
    assert pictures.get(f"{path.stem}.png", 0) > SMALLEST, pictures


@pytest.mark.parametrize("path", EXAMPLES + CLIENTS, ids=lambda path: path.stem)
def test_example_is_short_listed_and_asserts(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= MAX_LINES
    assert "    assert " in text
    assert f"`{path.name}`" in (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    if path not in CLIENTS:
        assert (ROOT / "docs" / "images" / f"{path.stem}.png").stat().st_size > SMALLEST
