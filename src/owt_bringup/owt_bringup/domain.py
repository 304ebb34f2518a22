"""A ROS domain of one's own, so that graphs on one machine do not hear each other, and a place within it.

A domain counts as taken while another graph of ours holds its lock, an abstract Unix socket that goes
with its process, or while any ROS 2 process listens on one of the first discovery ports of the domain.
"""

from __future__ import annotations

import hashlib
import os
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager

from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from owt_model.errors import InputError, OwtError

__all__ = ["LARGEST_DOMAIN", "full_namespace", "own_domain", "own_place"]

#: Above it, the ports of a domain reach into the range that Linux hands out on its own.
LARGEST_DOMAIN = 101
_FIRST_PORT, _PORTS_PER_DOMAIN, _UNICAST, _PORTS_PER_PARTICIPANT = 7400, 250, 10, 2
_PARTICIPANTS = 16


def _lock(name: str) -> socket.socket | None:
    """Return the lock `name`, or None if somebody else holds it."""
    lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        lock.bind(f"\0owt-ros-{name}")
    except OSError:
        lock.close()
        return None
    return lock


def _is_silent(domain: int) -> bool:
    """Tell whether nobody listens on the discovery ports of the first participants of `domain`."""
    first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain + _UNICAST
    for participant in range(_PARTICIPANTS):
        with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
            try:
                probe.bind(("", first + _PORTS_PER_PARTICIPANT * participant))
            except OSError:
                return False
    return True


@contextmanager
def own_domain(wanted: int | None = None) -> Iterator[int]:
    """Hold a domain for as long as the block lasts.

    Parameters
    ----------
    wanted : int, optional
        The domain to use, taken or not; by default a free one.

    Raises
    ------
    InputError
        If `wanted` is no domain.
    OwtError
        If no domain is free.
    """
    if wanted is not None:
        if not 0 <= wanted <= LARGEST_DOMAIN:
            raise InputError("ROS domain", wanted, f"must lie in 0 to {LARGEST_DOMAIN}", "Leave it out.")
        yield wanted
        return
    first = 1 + os.getpid() % LARGEST_DOMAIN
    for i in range(LARGEST_DOMAIN):
        domain = 1 + (first + i) % LARGEST_DOMAIN
        lock = _lock(f"domain-{domain}")
        if lock is None:
            continue
        with closing(lock):
            if _is_silent(domain):
                yield domain
                return
    raise OwtError(f"no free ROS domain among 1 to {LARGEST_DOMAIN}: stop other ROS graphs on this machine")


def full_namespace(name: str) -> str:
    """Return a namespace as ROS writes it: "/north" for "north", "/" for an empty one.

    Raises
    ------
    InputError
        If it cannot be one.
    """
    full = "/" + name.strip("/")
    try:
        validate_namespace(full)
    except InvalidNamespaceException:
        raise InputError(
            "namespace",
            name,
            "is no ROS namespace",
            "Use letters, digits and _, none beginning with a digit.",
        ) from None
    return full


@contextmanager
def own_place(what: str, domain: int, namespace: str) -> Iterator[None]:
    """Hold a namespace of a domain for as long as the block lasts: two graphs in one place would mix.

    Parameters
    ----------
    what : str
        What there may be only one of: "graph" or "server".
    domain, namespace : int, str
        The place; the namespace in full.

    Raises
    ------
    InputError
        If another one on this machine is there.
    """
    # names of abstract sockets end after 107 bytes
    key = hashlib.sha256(namespace.encode()).hexdigest()[:32]
    lock = _lock(f"{what}-{domain}-{key}")
    if lock is None:
        raise InputError(
            "namespace",
            namespace,
            f"has a {what} in ROS domain {domain} already",
            "Give this one a namespace or a ROS domain of its own.",
        )
    with closing(lock):
        yield
