"""What tests that start ROS nodes share: strict messages, and a domain of their own."""

import os
from collections.abc import Iterator

import pytest

# before the first message class is imported: wrong types are then errors that name the field
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS domain that nothing else on this machine uses."""
    from owt_bringup.domain import own_domain

    with own_domain() as number:
        yield number
