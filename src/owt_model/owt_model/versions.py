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
    """Short commit of the checkout that holds this file, marked when files differ from it; else empty."""
    root = here.parents[3]
    if not (root / ".git").exists():
        return ""
    command = ["git", "-C", str(root), "describe", "--always", "--dirty"]
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=5, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return result.stdout.strip() if result.returncode == 0 else ""
