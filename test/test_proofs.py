"""Every proof holds, every wrong variant fails it, and the table of docs/verification.md says so."""

from __future__ import annotations

import pytest

from proofs import proofs_of, table
from proofs.registry import Found, Proof, found

PROOFS = proofs_of()
#: Below this a value is round-off, whose size depends on the machine.
ROUND_OFF = 1e-12


@pytest.mark.parametrize("proof", PROOFS, ids=lambda proof: proof.key)
def test_proof(proof: Proof) -> None:
    assert not found(proof).failures(proof.allowed)


def test_failures_are_seen() -> None:
    assert not Found(1e-13, {"other sign": 0.3}).failures(1e-12)
    assert len(Found(1e-11, {"other sign": 0.3}).failures(1e-12)) == 1
    assert len(Found(float("nan"), {"other sign": 0.3}).failures(1e-12)) == 1
    assert len(Found(0.0, {"other sign": 1e-12, "fine": 1.0, "none": float("nan")}).failures(1e-12)) == 2


def same_size(printed: str, value: float) -> bool:
    shown = float(printed)
    return max(shown, value) <= ROUND_OFF or (shown > 0.0 and 0.1 <= value / shown <= 10.0)


def test_same_size_would_notice() -> None:
    assert same_size("2e-15", 3e-13)
    assert same_size("0", 1e-16)
    assert same_size("0.012", 0.02)
    assert not same_size("0", 1e-3)
    assert not same_size("1e-13", 1e-10)
    assert not same_size("0.01", 0.2)


def test_table_is_that_of_the_proofs() -> None:
    """The page lists exactly these proofs, allowed values and wrong variants, values of the same size."""
    committed = table.committed_rows()
    expected = [row for proof in PROOFS for row in table.cells(proof)]
    fixed = [table.HEADER.index(name) for name in ("claim", "against", "allowed", "wrong variant")]
    assert [[row[i] for i in fixed] for row in committed] == [[row[i] for i in fixed] for row in expected], (
        "run python -m proofs in test/"
    )
    for one, other in zip(committed, expected, strict=True):
        for column in ("found", "its value"):
            at = table.HEADER.index(column)
            assert one[at] == other[at] == "" or same_size(one[at], float(other[at])), (one, other)
