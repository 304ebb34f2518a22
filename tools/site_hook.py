"""Run at every start of this environment's Python, before the ROS wheels' own hook (see owt.pth).

A bare `.venv/bin/python` then finds owt_msgs and the ROS libraries as it does under `./owt`: the search paths
are completed here, and the wheels' hook restarts Python with them. A child that inherited the "already
restarted" marker without the paths is restarted as well.
"""

import os
import sys


def _complete(variable: str, folders: list[str]) -> bool:
    """Put the missing folders in front of a search path; tell whether there were any."""
    present = [folder for folder in os.environ.get(variable, "").split(os.pathsep) if folder]
    missing = [folder for folder in folders if folder not in present]
    os.environ[variable] = os.pathsep.join(missing + present)
    return bool(missing)


_install = os.path.join(os.path.dirname(sys.prefix), "install")
_complete("AMENT_PREFIX_PATH", [_install, sys.prefix])
if _complete("LD_LIBRARY_PATH", [os.path.join(_install, "lib"), os.path.join(sys.prefix, "lib")]):
    os.environ.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None)
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
