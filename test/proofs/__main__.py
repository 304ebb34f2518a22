"""``python -m proofs`` writes the table of docs/verification.md; with topics it only shows their values."""

from __future__ import annotations

import sys
import time

from proofs import proofs_of, table
from proofs.registry import found


def main(names: list[str]) -> int:
    """Evaluate the proofs of the topics, show them, and write the table if it is of all topics."""
    proofs, failed = proofs_of(*names), 0
    for proof in proofs:
        start = time.perf_counter()
        try:
            values = found(proof)
        except Exception as error:  # the others are to be seen as well
            failed += 1
            print(f"{proof.key}:\n    FAILED {type(error).__name__}: {str(error).splitlines()[0]}")
            continue
        wrong = ", ".join(f"{name}: {value:.2g}" for name, value in values.wrong.items())
        print(
            f"{proof.key}: {values.right:.2g} (allowed {proof.allowed:g}) | {wrong}"
            f" | {time.perf_counter() - start:.1f} s"
        )
        for failure in values.failures(proof.allowed):
            failed += 1
            print(f"    FAILED {failure}")
    if not names and not failed:
        table.write(proofs)
    return 1 if failed else 0


sys.exit(main(sys.argv[1:]))
