"""Style, types and architecture are tests too."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BIN = Path(sys.executable).parent
MAX_LINES = 400
MAX_NODE_LINES = 150


def tracked(pattern: str) -> list[Path]:
    command = ["git", "ls-files", "-co", "--exclude-standard", pattern]
    listing = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / line for line in listing.stdout.splitlines() if (ROOT / line).is_file()]


@pytest.mark.parametrize(
    "command",
    [["ruff", "check"], ["ruff", "format", "--check"], ["mypy"], ["lint-imports"]],
    ids=lambda command: " ".join(command),
)
def test_tool_is_content(command: list[str]) -> None:
    result = subprocess.run([BIN / command[0], *command[1:]], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_import_contract_would_notice_ros_in_core(tmp_path: Path) -> None:
    """Negative control: the same contracts refuse a core module that imports rclpy."""
    package = tmp_path / "owt_wave_node"
    (package / "core").mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "core" / "__init__.py").write_text("import rclpy\n")
    (tmp_path / ".importlinter").write_text(
        "[importlinter]\nroot_package = owt_wave_node\ninclude_external_packages = True\n"
        "[importlinter:contract:1]\nname = core\ntype = forbidden\nsource_modules = owt_wave_node.core\n"
        "forbidden_modules = rclpy\n"
    )
    result = subprocess.run(
        [BIN / "lint-imports", "--no-cache"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(tmp_path), "PATH": "/usr/bin:/bin"},
    )
    assert result.returncode != 0
    assert "BROKEN" in result.stdout


def test_files_stay_readable() -> None:
    lengths = {path.relative_to(ROOT): len(path.read_text().splitlines()) for path in tracked("*.py")}
    assert not {path: n for path, n in lengths.items() if n > MAX_LINES}


def test_nodes_hold_no_formula() -> None:
    nodes = [path for path in tracked("src/*/*/node.py")]
    assert len(nodes) == 4
    for path in nodes:
        text = path.read_text()
        assert len(text.splitlines()) <= MAX_NODE_LINES, path
        assert not re.search(r"^\s*(import|from) (numpy|scipy|numba)", text, re.MULTILINE), path


def test_no_machine_paths() -> None:
    suspicious = re.compile(r"/(root|home|work|opt/pypi|opt/wheels)/|shared/(data|THEORY|DESIGN|STYLE|ROS)")
    found = [
        str(path.relative_to(ROOT))
        for path in tracked("*")
        if path.suffix in {".py", ".md", ".sh", ".yaml", ".toml", ".json", ".lock", ".in", ""}
        and path.name != "test_architecture.py"
        and suspicious.search(path.read_text(errors="ignore"))
    ]
    assert not found


def test_one_version_everywhere() -> None:
    from owt_model import __version__

    for manifest in tracked("src/*/package.xml"):
        assert f"<version>{__version__}</version>" in manifest.read_text(), manifest
    for setup in tracked("src/*/setup.py"):
        assert 'version=MANIFEST.findtext("version")' in setup.read_text(), setup
    assert f"version: {__version__}\n" in (ROOT / "CITATION.cff").read_text()
