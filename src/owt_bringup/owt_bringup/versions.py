"""What made the numbers: versions of this project and of what it computes with."""

from __future__ import annotations

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

__all__ = ["versions"]

PACKAGES = ("numpy", "scipy", "numba", "mcap", "rosbags", "plotly", "pydantic")


def versions() -> dict[str, str]:
    """Return the versions, the source revision too where the project runs from a git checkout."""
    found = {"owt": "0.1.0", "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    revision = _revision()
    if revision:
        found["revision"] = revision
    return found


def _revision() -> str:
    """Short commit of the checkout, marked when files differ from it; empty outside a checkout."""
    folder = Path(__file__).resolve().parent
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty"]
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=5, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return result.stdout.strip() if result.returncode == 0 else ""
