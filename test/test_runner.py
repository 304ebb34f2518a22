"""The task runner, in a folder with a space in its name that holds only what it looks at."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from owt_bringup.cli import COMMANDS

ROOT = Path(__file__).parents[1]
WITH_HELP = ("setup", "doctor", "test", "lint", "bench", "clean", "run")
WITHOUT_ARGUMENTS = ("setup", "doctor", "lint", "clean")
SOURCES = (
    "requirements.lock", "src/*/package.xml", "src/*/setup.*", "src/*/CMakeLists.txt", "src/*/resource/*",
    "src/owt_msgs/*/*", "src/*/*/kernels/*.py",
)  # fmt: skip
BUILT = (".venv/pyvenv.cfg", ".venv/bin/python", "build/x", "install/x", "log/x", "bags/mine/x")

# Defines what the script `owt` defines before it runs a command.
PRELUDE = 'set -euo pipefail; shopt -s nullglob; ROOT=$1; source "$ROOT/tools/env.sh"; MODE=$(ros_mode); '
WRITE_STAMPS = """
for part in environment messages packages; do write_stamp "$part"; done
for package in $(kernel_packages); do write_stamp "kernels:$package"; done
"""


def environment() -> dict[str, str]:
    """The caller's, without what this test run's own `owt` has set."""
    return {k: v for k, v in os.environ.items() if not k.startswith(("OWT_", "ROS_", "AMENT_"))}


def bash(script: str, root: Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = ["bash", "-c", PRELUDE + script, "bash", str(root)]
    return subprocess.run(command, cwd=cwd, env=environment(), capture_output=True, text=True)


def owt(root: Path, *arguments: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    command = [str(root / "owt"), *arguments]
    return subprocess.run(
        command, cwd=cwd, env=environment() | variables, capture_output=True, text=True, timeout=60
    )


def files(root: Path) -> set[Path]:
    return {path for path in root.rglob("*") if path.is_file()}


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Sources, stand-ins for what set-up builds, and the stamps of a finished set-up."""
    root = tmp_path / "a clone" / "owt"
    paths = [ROOT / "owt", *(ROOT / "tools").glob("*.*"), *(p for s in SOURCES for p in ROOT.glob(s))]
    for path in paths:
        target = root / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, target)
    for name in BUILT:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).touch()
    (root / ".venv/bin/python").chmod(0o755)
    made = bash(WRITE_STAMPS, root, root)
    assert made.returncode == 0, made.stderr
    return root


def test_set_up_is_recognised_from_any_folder(workspace: Path, tmp_path: Path) -> None:
    for cwd in (workspace, tmp_path, workspace / "src" / "owt_msgs"):
        result = owt(workspace, "setup", cwd=cwd)
        assert (result.returncode, result.stdout, result.stderr) == (0, "nothing to do\n", "")


@pytest.mark.parametrize(
    "name",
    [
        "requirements.lock", "tools/setup.sh", "src/owt_msgs/msg/Energy.msg", "src/owt_ros/setup.py",
        "src/owt_wave_node/owt_wave_node/kernels/morison.py",
    ],
)  # fmt: skip
def test_a_change_is_noticed_from_any_folder(workspace: Path, tmp_path: Path, name: str) -> None:
    with (workspace / name).open("a") as file:
        file.write("# changed\n")
    for cwd in (workspace, tmp_path):
        result = bash("all_up_to_date && echo yes || echo no", workspace, cwd)
        assert (result.stdout, result.stderr) == ("no\n", "")


def test_usage_names_every_command(workspace: Path, tmp_path: Path) -> None:
    """Of the workspace, and of the command line that takes the rest."""
    usage = owt(workspace, "--help", cwd=tmp_path).stdout
    named = set(re.findall(r"^  ([a-z]+) ", usage, re.MULTILINE))
    assert named == {*WITH_HELP, *COMMANDS}


@pytest.mark.parametrize("flag", ["-h", "--help"])
@pytest.mark.parametrize("command", WITH_HELP)
def test_help_only_prints(workspace: Path, tmp_path: Path, command: str, flag: str) -> None:
    before = files(workspace)
    result = owt(workspace, command, flag, cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout.startswith(f"usage: ./owt {command}")
    assert files(workspace) == before


@pytest.mark.parametrize("command", WITHOUT_ARGUMENTS)
def test_arguments_that_mean_nothing_are_refused(workspace: Path, tmp_path: Path, command: str) -> None:
    before = files(workspace)
    for arguments in (["bags"], ["--force"], ["two\nlines", "--help"]):
        result = owt(workspace, command, *arguments, cwd=tmp_path)
        assert (result.returncode, result.stdout) == (2, "")
        assert result.stderr.startswith("error: ")
        assert result.stderr.count("\n") == 1
    assert files(workspace) == before


def test_clean_keeps_sources_and_bags(workspace: Path, tmp_path: Path) -> None:
    assert owt(workspace, "clean", cwd=tmp_path).returncode == 0
    left = {path.relative_to(workspace).parts[0] for path in files(workspace)}
    assert left == {"owt", "tools", "src", "bags", "requirements.lock"}


def test_run_hands_arguments_over(workspace: Path, tmp_path: Path) -> None:
    """The prefix holds a space, as the folder of the workspace does."""
    executable = workspace / "install/lib/some_package/say"
    index = workspace / "install/share/ament_index/resource_index/packages"
    executable.parent.mkdir(parents=True)
    index.mkdir(parents=True)
    (index / "some_package").touch()
    executable.write_text('#!/bin/sh\nprintf "<%s>" "$@"\n')
    executable.chmod(0o755)
    result = owt(workspace, "run", "some_package", "say", "--help", "a b", cwd=tmp_path)
    assert (result.returncode, result.stdout, result.stderr) == (0, "<--help><a b>", "")
    for arguments in ([], ["some_package"], ["some_package", "sing"], ["no_such_package", "say"]):
        result = owt(workspace, "run", *arguments, cwd=tmp_path)
        assert result.returncode != 0
        assert result.stderr.startswith("error: ")
        assert result.stderr.count("\n") == 1


def test_a_space_in_the_path_reaches_no_first_line(workspace: Path, tmp_path: Path) -> None:
    """Colcon writes the environment's Python after ``#!``, where Linux takes no space."""
    python, executable = workspace / ".venv/bin/python", workspace / "install/lib/owt_some/say"
    python.unlink()
    python.symlink_to(sys.executable)
    executable.parent.mkdir(parents=True)
    executable.write_text(f"#!{python}\nimport sys\nprint(sys.argv[1:])\n")
    executable.chmod(0o755)
    with pytest.raises(OSError, match="No such file"):  # negative control
        subprocess.run([executable])
    for _ in range(2):
        owt(workspace, "run", "no_such_package", "say", cwd=tmp_path)
        result = subprocess.run([executable, "--flag", "a b"], capture_output=True, text=True)
        assert (result.returncode, result.stdout) == (0, "['--flag', 'a b']\n")
