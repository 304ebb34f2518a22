"""Checks array shapes and types at run time in the model package and in every core, in tests only.

Tests that start ROS nodes run one after the other, whatever the number of processes: they watch the time.
Those of a file share its fixtures, so they stay together.
"""

import pytest
from jaxtyping import install_import_hook

install_import_hook(
    ["owt_model", "owt_wave_node.core", "owt_structure_node.core", "owt_postproc.core", "owt_viewer.core"],
    "beartype.beartype",
)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tell which tests have to run in the same process, before pytest-xdist looks."""
    for item in items:
        group = "graph" if item.get_closest_marker("graph") else item.location[0]
        item.add_marker(pytest.mark.xdist_group(group))
