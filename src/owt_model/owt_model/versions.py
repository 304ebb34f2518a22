"""What made the numbers: versions of this project and of what it computes with."""

from __future__ import annotations

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from owt_model import __version__

__all__ = ["versions"]

PACKAGES = ("numpy", "scipy", "numba", "mcap", "rosbags", "pydantic")


def versions() -> dict[str, str]:
    """Return the versions, the source revision too where the project runs from its git checkout."""
    found = {"owt": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    revision = _revision(Path(__file__).resolve())
    if revision:
        found["revision"] = revision
    return found


def _revision(here: Path) -> str:
    """Short commit of the checkout that holds this file, marked when its sources differ; else empty."""
    root = here.parents[3]
    if not (root / ".git").exists():
        return ""
    commit = _git(root, "describe", "--always")
    if commit is None or commit.returncode != 0:
        return ""
    sources = _git(root, "diff", "--quiet", "HEAD", "--", "src")
    return commit.stdout.strip() + ("" if sources is not None and sources.returncode == 0 else "-dirty")


def _git(root: Path, *arguments: str) -> subprocess.CompletedProcess[str] | None:
    """Run git in `root`; None where that is not possible."""
    try:
        return subprocess.run(
            ["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=5, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
