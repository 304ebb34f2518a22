"""What commands do to start sooner harms nobody: a module that is put off is whole at its first use."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import sys
import numpy
from owt_bringup.startup import start_quickly
{start}
import scipy.linalg
assert scipy.linalg.norm([3.0, 4.0]) == 5.0
assert ("numpy.f2py.crackfortran" in sys.modules) == {loaded}
import numpy.f2py
assert numpy.f2py.get_include().endswith("src")
assert numpy.f2py is sys.modules["numpy.f2py"]
assert "numpy.f2py.crackfortran" in sys.modules
"""


def run(start: str, *, loaded: bool) -> None:
    script = SCRIPT.format(start=start, loaded=loaded)
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)


def test_an_unused_module_is_put_off() -> None:
    run("start_quickly()", loaded=False)


def test_twice_is_as_good_as_once() -> None:
    run("start_quickly(); start_quickly()", loaded=False)


def test_without_it_the_module_is_loaded_at_once() -> None:
    run("pass", loaded=True)
