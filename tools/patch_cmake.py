"""Point the CMake files of the ROS wheels at this Python.

The wheels were built elsewhere, and their exported targets carry the include folders of that machine. Each
file is written anew and moved over the old one, never edited in place: a package manager may share files with
its cache.
"""

import os
import re
import sys
import sysconfig
from pathlib import Path

import numpy

NUMPY_INCLUDE = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/_core/include")
PYTHON_INCLUDE = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")


def main() -> int:
    """Rewrite every CMake file below the environment's share folder; print how many changed."""
    python_include = sysconfig.get_path("include")
    changed = 0
    for path in (Path(sys.prefix) / "share").rglob("*.cmake"):
        old = path.read_text(encoding="utf-8")
        new = PYTHON_INCLUDE.sub(
            lambda _: python_include, NUMPY_INCLUDE.sub(lambda _: numpy.get_include(), old)
        )
        if "/opt/python/" in new:
            print(f"error: {path} still names the wheel builder's Python", file=sys.stderr)
            return 1
        if new != old:
            fresh = path.with_name(path.name + ".new")
            fresh.write_text(new, encoding="utf-8")
            os.replace(fresh, path)
            changed += 1
    print(f"{changed} CMake files patched")
    return 0


if __name__ == "__main__":
    sys.exit(main())
