"""The name of a reduction."""

import pytest

from owt_model.errors import InputError
from owt_model.reduction_name import ReductionName, parse_reduction


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("full", ReductionName(True, 0, 0)),
        ("CB00", ReductionName(False, 0, 0)),
        ("CB20", ReductionName(False, 20, 0)),
        ("M20", ReductionName(False, 0, 20)),
        ("CB10M10", ReductionName(False, 10, 10)),
        ("CB100M05", ReductionName(False, 100, 5)),
    ],
)
def test_parts(name: str, expected: ReductionName) -> None:
    assert parse_reduction(name) == expected


@pytest.mark.parametrize("name", ["", "CB", "M", "CB1", "10M10", "M10CB10", "CB10M10x", "FULL"])
def test_anything_else_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="must be full, CBnn"):
        parse_reduction(name)
