"""Who may do what in a secured graph: enclaves of the processes, and the SROS 2 policy of the graph.

The policy is derived from the list of topics. ``python -m owt_bringup.security`` prints
``config/policy.xml``.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree as Xml

from owt_bringup.domain import full_namespace
from owt_bringup.nodes import NODES
from owt_ros import topics
from owt_ros.peers import beacon
from owt_ros.topics import (
    CREDIT,
    DIAGNOSTICS,
    MEASURED_ELEVATION,
    POSTPROC,
    STATUS,
    STRUCTURE,
    TOWER_TOP_WRENCH,
    WAVE,
    Topic,
)

__all__ = ["BRINGUP", "SERVER", "Rights", "enclave", "enclave_arguments", "policy_xml", "rights"]

#: Nodes of the bring-up: the one that drives a graph, and the one that serves operators.
BRINGUP, SERVER = "owt_bringup", "bringup_node"
#: Relative names of what the server offers.
ACTION, CHECK_CASE = "owt/run_sea_state", "owt/check_case"

#: What takes part from outside, and the node that listens to it.
_INPUTS: dict[Topic, str] = {TOWER_TOP_WRENCH: STRUCTURE, MEASURED_ELEVATION: WAVE}
#: Services of single nodes besides those that every managed node has.
_SERVICES = {POSTPROC: (topics.FATIGUE_SUMMARY, topics.FLUSH)}
_PARAMETERS = (
    "describe_parameters", "get_parameter_types", "get_parameters", "get_type_description", "list_parameters",
    "set_parameters", "set_parameters_atomically",
)  # fmt: skip
_LIFECYCLE = (
    "change_state", "get_available_states", "get_available_transitions", "get_state", "get_transition_graph",
)  # fmt: skip
_EVERY_NODE = ("/parameter_events", "/rosout")


@dataclass(frozen=True)
class Rights:
    """What one node does; names are relative, private (``~``) or absolute, as ROS writes them."""

    publish: tuple[str, ...] = ()
    subscribe: tuple[str, ...] = ()
    reply: tuple[str, ...] = ()
    request: tuple[str, ...] = ()
    execute: tuple[str, ...] = ()


def enclave(node: str) -> str:
    """Return the enclave of a node, whatever its namespace."""
    return f"/owt/{node}"


def enclave_arguments(node: str, environment: Mapping[str, str] = os.environ) -> list[str]:
    """Return what the command line of a process says of its enclave; nothing unless security is on."""
    secured = environment.get("ROS_SECURITY_ENABLE", "").lower() == "true"
    return ["--enclave", enclave(node)] if secured else []


def _all_topics() -> list[Topic]:
    return [value for value in vars(topics).values() if isinstance(value, Topic)]


def _stage_rights(name: str) -> Rights:
    """Rights of a managed node: its topics, credits, beacons and services."""
    roles = [node.name for node in NODES]
    publish = [topic.name for topic in _all_topics() if topic.producer == name]
    subscribe = [
        topic.name for topic in _all_topics() if name in topic.consumers or _INPUTS.get(topic) == name
    ]
    if name == topics.POSTPROC:
        subscribe.append(DIAGNOSTICS.name)
    return Rights(
        publish=_sorted(publish, [t.name for t in (CREDIT, STATUS, DIAGNOSTICS)], [beacon(name)],
                        _EVERY_NODE, ["~transition_event"]),
        subscribe=_sorted(subscribe, [CREDIT.name], [beacon(role) for role in roles if role != name]),
        reply=_sorted((f"~{service}" for service in (*_PARAMETERS, *_LIFECYCLE)), _SERVICES.get(name, ())),
    )  # fmt: skip


def _sorted(*names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted({name for group in names for name in group}))


def rights() -> dict[str, Rights]:
    """Return the rights of every node of the graph, by name."""
    own = _sorted(f"~{service}" for service in _PARAMETERS)
    return {
        **{node.name: _stage_rights(node.name) for node in NODES},
        BRINGUP: Rights(
            publish=_sorted(_EVERY_NODE),
            subscribe=(STATUS.name,),
            reply=own,
            request=_sorted(f"{node.name}/change_state" for node in NODES),
        ),
        SERVER: Rights(
            publish=_sorted(_EVERY_NODE, [STATUS.name]), reply=_sorted(own, [CHECK_CASE]), execute=(ACTION,)
        ),
    }


_TAGS = {
    "publish": ("topics", "topic"),
    "subscribe": ("topics", "topic"),
    "reply": ("services", "service"),
    "request": ("services", "service"),
    "execute": ("actions", "action"),
}


def policy_xml(namespace: str = "") -> str:
    """Return the SROS 2 policy of a graph in `namespace`: one enclave per node, what is not listed is denied.

    Raises
    ------
    InputError
        If `namespace` cannot be one.
    """
    place = full_namespace(namespace)
    root = Xml.Element("policy", version="0.2.0")
    enclaves = Xml.SubElement(root, "enclaves")
    for name, allowed in rights().items():
        profiles = Xml.SubElement(Xml.SubElement(enclaves, "enclave", path=enclave(name)), "profiles")
        profile = Xml.SubElement(profiles, "profile", ns=place, node=name)
        for verb, (group, item) in _TAGS.items():
            names = getattr(allowed, verb)
            if names:
                listed = Xml.SubElement(profile, group, {verb: "ALLOW"})
                for entry in names:
                    Xml.SubElement(listed, item).text = entry
    Xml.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{Xml.tostring(root, encoding="unicode")}\n'


if __name__ == "__main__":
    print(policy_xml(), end="")
