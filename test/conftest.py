"""What tests that start ROS nodes share: strict messages, and a domain of their own."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from owt_campaign.pipeline import CaseBlocks, CaseRun

# before the first message class is imported: wrong types are then errors that name the field
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def pytest_configure(config: pytest.Config) -> None:
    """Give this process the transport of the nodes; Fast DDS reads it once, before the first participant."""
    from owt_bringup.transport import PROFILE_VARIABLE, shared_memory_profile

    profile = shared_memory_profile(8)
    if profile is not None and PROFILE_VARIABLE not in os.environ:
        folder = tempfile.TemporaryDirectory(prefix="owt-fastdds-")
        config.add_cleanup(folder.cleanup)
        path = Path(folder.name) / "fastdds.xml"
        path.write_text(profile, encoding="utf-8")
        os.environ[PROFILE_VARIABLE] = str(path)


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS domain that nothing else on this machine uses."""
    from owt_bringup.domain import own_domain

    with own_domain() as number:
        yield number


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag that is not there yet."""
    return tmp_path / "bag"


@pytest.fixture(scope="session")
def reference() -> "tuple[CaseRun, list[CaseBlocks]]":
    """The short case in one process."""
    from local_graph import short_case
    from owt_campaign.pipeline import prepare_case, stream_case

    run = prepare_case(short_case())
    return run, list(stream_case(run))
