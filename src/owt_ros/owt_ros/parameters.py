"""ROS parameters derived from the configuration object: declared, validated, and read back.

A node declares every field of :class:`CaseConfig` and of its own options, with type, limits and
description. An override that is refused does not stop the node from starting: configure then fails
with the message. Parameters are read when the node is configured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import yaml
from pydantic import BaseModel
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_ros.fields import Leaf, case_from_values, case_values, leaves, model_from_values, unknown_parameter

__all__ = ["NodeParameters", "parameter_yaml"]

_LARGEST = {"int": 2**63 - 1, "float": 1.7976931348623157e308}
#: Parameters that rclpy itself declares.
_FOREIGN = ("use_sim_time", "start_type_description_service", "qos_overrides.")


def _descriptor(leaf: Leaf) -> ParameterDescriptor:
    """Describe one parameter; rclpy itself then refuses another type or a value out of range."""
    described = ParameterDescriptor(
        description=leaf.description, dynamic_typing=leaf.optional or leaf.kind == "any"
    )
    bounded = leaf.minimum is not None or leaf.maximum is not None
    if described.dynamic_typing or not bounded or leaf.kind not in _LARGEST:
        return described
    low = -_LARGEST[leaf.kind] if leaf.minimum is None else leaf.minimum
    high = _LARGEST[leaf.kind] if leaf.maximum is None else leaf.maximum
    if leaf.kind == "int":
        limits = IntegerRange(from_value=int(low) + leaf.above, to_value=int(high) - leaf.below)
        described.integer_range = [limits]
    else:
        low = math.nextafter(low, math.inf) if leaf.above else low
        high = math.nextafter(high, -math.inf) if leaf.below else high
        described.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high))]
    return described


def _plain(value: Any) -> Any:
    """Return a parameter value as plain data."""
    return list(value) if hasattr(value, "__len__") and not isinstance(value, (str, bytes)) else value


class NodeParameters:
    """The parameters of one node.

    Parameters
    ----------
    node : Node
        Made with ``automatically_declare_parameters_from_overrides=True``: that is how its overrides
        are found, unknown ones included.
    options : type of pydantic model
        What the node needs besides the case.
    """

    def __init__(self, node: Node, options: type[BaseModel]) -> None:
        self._node, self._options_model = node, options
        self._case_leaves = {leaf.name: leaf for leaf in leaves(CaseConfig)}
        self._option_leaves = {leaf.name: leaf for leaf in leaves(options)}
        self._refused: dict[str, InputError] = {}
        overrides = self._accepted(self._take_overrides())
        for leaf in (*self._case_leaves.values(), *self._option_leaves.values()):
            value = overrides.get(leaf.name, leaf.default)
            if leaf.kind == "float" and value is not None:
                value = float(value)
            node.declare_parameter(leaf.name, value, _descriptor(leaf), ignore_override=True)
        node.add_on_set_parameters_callback(self._on_set)

    def _take_overrides(self) -> dict[str, Any]:
        """Read what the command line and parameter files gave, and make room for the real declarations."""
        given: dict[str, Any] = {}
        for name in self._node.list_parameters([], 0).names:
            if name.startswith(_FOREIGN):
                continue
            given[name] = _plain(self._node.get_parameter(name).value)
            self._node.undeclare_parameter(name)
        return given

    def _accepted(self, overrides: dict[str, Any]) -> dict[str, Any]:
        """Return the overrides that can be used and remember why the others cannot."""
        while overrides:
            try:
                self._build(overrides)
            except InputError as error:
                name = error.field.split("[")[0]
                faulty = [name] if name in overrides else list(overrides)
                self._refused |= dict.fromkeys(faulty, error)
                overrides = {key: value for key, value in overrides.items() if key not in faulty}
            else:
                break
        return overrides

    def _build(self, changes: dict[str, Any]) -> tuple[CaseConfig, BaseModel]:
        """Validate the declared values, or the defaults, with `changes` on top."""
        known = self._case_leaves | self._option_leaves
        for name, value in changes.items():
            if name not in known:
                raise unknown_parameter(name, value, known)
        values = {name: leaf.default for name, leaf in known.items()}
        for name in known:
            if self._node.has_parameter(name):
                values[name] = _plain(self._node.get_parameter(name).value)
        values |= changes
        case = case_from_values({name: values[name] for name in self._case_leaves})
        options = model_from_values(self._options_model, {name: values[name] for name in self._option_leaves})
        return case, options

    def _on_set(self, parameters: list[Parameter[Any]]) -> SetParametersResult:
        """Refuse what the configuration refuses, with its message."""
        changes = {p.name: _plain(p.value) for p in parameters if not p.name.startswith(_FOREIGN)}
        try:
            self._build(changes)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        for name in changes:
            self._refused.pop(name, None)
        return SetParametersResult(successful=True)

    def read(self) -> tuple[CaseConfig, Any]:
        """Return the case and the node's options.

        Raises
        ------
        InputError
            If an override was refused when the node started and has not been set since.
        """
        for error in self._refused.values():
            raise error
        return self._build({})


def _tree(values: Mapping[str, Any]) -> dict[str, Any]:
    """Turn dotted names into a tree."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *path, key = name.split(".")
        place = tree
        for part in path:
            place = place.setdefault(part, {})
        place[key] = value
    return tree


def parameter_yaml(case: CaseConfig, options: Mapping[str, Mapping[str, Any]] | None = None) -> str:
    """Return a parameter file for a graph: the case for all nodes, and the options of each by node name."""
    document = {"/**": {"ros__parameters": _tree(case_values(case))}}
    for node, values in (options or {}).items():
        document[f"/**/{node}"] = {"ros__parameters": _tree(values)}
    return str(
        yaml.safe_dump(document, sort_keys=False, default_flow_style=None, allow_unicode=True, width=100)
    )
