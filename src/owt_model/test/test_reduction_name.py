"""The name of a reduction."""

import pytest

from owt_model.errors import InputError
from owt_model.reduction_name import AUTO_MODES, AUTO_VECTORS, ReductionName, parse_reduction


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("full", ReductionName(True, 0, 0)),
        ("auto", ReductionName(False, AUTO_MODES[-1], AUTO_VECTORS[-1], auto=True)),
        ("CB00", ReductionName(False, 0, 0)),
        ("CB20", ReductionName(False, 20, 0)),
        ("M20", ReductionName(False, 0, 20)),
        ("CB10M10", ReductionName(False, 10, 10)),
        ("CB100M05", ReductionName(False, 100, 5)),
        ("CB10M10j2", ReductionName(False, 10, 10, order=2)),
        ("CB10M10Y", ReductionName(False, 10, 10, interface_vectors=True)),
        ("CB10Yj1", ReductionName(False, 10, 0, order=1, interface_vectors=True)),
        ("M05j1Y", ReductionName(False, 0, 5, order=1, interface_vectors=True)),
        ("Y", ReductionName(False, 0, 0, interface_vectors=True)),
        ("CB20+SIM", ReductionName(False, 20, 0, static_improvement=True)),
        ("CB20SIM", ReductionName(False, 20, 0, static_improvement=True)),
        ("CB10M10j1Y+SIM", ReductionName(False, 10, 10, 1, True, True)),
    ],
)
def test_parts(name: str, expected: ReductionName) -> None:
    assert parse_reduction(name) == expected


@pytest.mark.parametrize(
    "name",
    [
        "",
        "CB",
        "M",
        "CB1",
        "10M10",
        "M10CB10",
        "CB10M10x",
        "FULL",
        "SIM",
        "M10YjY",
        "M10YY",
        "CB10M10j12",
        "AUTO",
    ],
)
def test_anything_else_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="must be full, CBnn"):
        parse_reduction(name)


@pytest.mark.parametrize("name", ["CB10j1", "j1", "CB10j1+SIM"])
def test_an_order_needs_vectors(name: str) -> None:
    with pytest.raises(InputError, match="order jk of no vectors"):
        parse_reduction(name)
