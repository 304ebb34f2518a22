"""A ROS domain of one's own, so that graphs on one machine do not hear each other.

A domain counts as taken while another graph of ours holds its lock, an abstract Unix socket that goes
with its process, or while any ROS 2 process listens on one of the first discovery ports of the domain.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager

from owt_model.errors import InputError, OwtError

__all__ = ["LARGEST_DOMAIN", "own_domain"]

#: Above it, the ports of a domain reach into the range that Linux hands out on its own.
LARGEST_DOMAIN = 101
_FIRST_PORT, _PORTS_PER_DOMAIN, _UNICAST, _PORTS_PER_PARTICIPANT = 7400, 250, 10, 2
_PARTICIPANTS = 16


def _lock(domain: int) -> socket.socket | None:
    """Return the lock of `domain`, or None if another graph holds it."""
    lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        lock.bind(f"\0owt-ros-domain-{domain}")
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
        lock = _lock(domain)
        if lock is None:
            continue
        with closing(lock):
            if _is_silent(domain):
                yield domain
                return
    raise OwtError(f"no free ROS domain among 1 to {LARGEST_DOMAIN}: stop other ROS graphs on this machine")
