"""The viewer beside a graph: its parameters, and its process while a graph runs."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from owt_bringup.domain import full_namespace
from owt_bringup.process import Child, find_executable, stop_all
from owt_model.config import CaseConfig
from owt_ros.parameters import parameter_yaml
from owt_ros.topics import VIEWER

__all__ = ["DEFAULT_PORT", "VIEWER_OPTIONS", "describe_connection", "viewer_arguments", "viewer_beside"]

#: What Foxglove and Lichtblick suggest.
DEFAULT_PORT = 8765
#: Parameters of the viewer that the command line sets.
VIEWER_OPTIONS = ("host", "port", "colour", "exaggeration", "fps")


def viewer_arguments(
    case: CaseConfig, options: Mapping[str, Any], folder: Path, *, namespace: str = ""
) -> list[str]:
    """ROS arguments of a viewer, whose parameter file is written into `folder`.

    Raises
    ------
    InputError
        If the namespace is none.
    """
    name = full_namespace(namespace)
    path = folder / "viewer.yaml"
    path.write_text(parameter_yaml(case, {VIEWER: options}), encoding="utf-8")
    remap = [] if name == "/" else ["-r", f"__ns:={name}"]
    return ["--ros-args", "--disable-external-lib-logs", "--params-file", str(path), *remap]


def describe_connection(host: str, port: int) -> str:
    """Say where the picture is."""
    if not port:
        return "note: the picture is on /owt/markers"
    return (
        f"note: open ws://{host}:{port} in Foxglove or Lichtblick (Foxglove WebSocket); layout: "
        "docs/foxglove_layout.json; also on /owt/markers"
    )


@contextmanager
def viewer_beside(case: CaseConfig, port: int, domain: int, namespace: str = "") -> Iterator[None]:
    """Keep a viewer running in a domain while the block lasts; its end, of whatever kind, ends nothing else.

    Raises
    ------
    InputError
        If it is not installed.
    """
    program = find_executable("owt_viewer", VIEWER)
    with tempfile.TemporaryDirectory(prefix="owt-view-") as name:
        folder = Path(name)
        arguments = viewer_arguments(case, {"port": port}, folder, namespace=namespace)
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        child = Child(VIEWER, [str(program), *arguments], folder / "viewer.log", environment)
        print(describe_connection("127.0.0.1", port), file=sys.stderr)
        try:
            yield
        finally:
            if child.exit_code is not None:
                print(f"note: {child.describe_end()}", file=sys.stderr)
            stop_all([child])
