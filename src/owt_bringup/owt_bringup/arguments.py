"""Arguments of the launch file and the default parameter file, declared once, derived from the configuration.

``python -m owt_bringup.arguments`` prints ``config/default.yaml``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from owt_bringup.case_flags import FLAGS
from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_ros.fields import Leaf, leaves
from owt_ros.parameters import parameter_yaml

__all__ = ["LAUNCH_ARGUMENTS", "Argument", "default_parameters", "parameter_overrides"]

_HEADER = """\
# Parameters of the graph: the defaults of owt_model.config.CaseConfig, unit in every name.
# Written by `python -m owt_bringup.arguments`; a test compares. Limits: `ros2 param describe`.
"""
_CONVERT = {"float": float, "int": int, "str": str}


@dataclass(frozen=True)
class Argument:
    """A launch argument; an empty one leaves the parameter file as it is."""

    name: str
    default: str
    description: str


def _parameters() -> dict[str, Leaf]:
    """Flags of the command line that are parameters, by flag."""
    table = {leaf.name: leaf for leaf in leaves(CaseConfig)}
    return {flag: table[f"{section}.{field}"] for flag, (section, field, _) in FLAGS.items()}


LAUNCH_ARGUMENTS = (
    Argument("bag", "bags/launch", "folder to record into; must not exist unless overwrite is true"),
    Argument("overwrite", "false", "replace an existing bag: true or false"),
    Argument("parameters", "", "parameter file; that of the package by default"),
    Argument("namespace", "", "namespace of all nodes, services and topics"),
    *(Argument(flag, "", leaf.description) for flag, leaf in _parameters().items()),
)


def parameter_overrides(given: Mapping[str, str]) -> dict[str, Any]:
    """Return the parameters that launch arguments set, typed; empty ones set nothing.

    Raises
    ------
    InputError
        If a text is not of the parameter's type. Limits are checked by the nodes.
    """
    overrides: dict[str, Any] = {}
    for flag, leaf in _parameters().items():
        text = given.get(flag, "")
        if not text:
            continue
        try:
            overrides[leaf.name] = _CONVERT[leaf.kind](text)
        except ValueError:
            kind = {"float": "a number", "int": "a whole number"}[leaf.kind]
            raise InputError(flag, text, f"must be {kind}", f"It is the {leaf.description}.") from None
    return overrides


def default_parameters() -> str:
    """Return the text of ``config/default.yaml``."""
    return _HEADER + parameter_yaml(CaseConfig())


if __name__ == "__main__":
    print(default_parameters(), end="")
