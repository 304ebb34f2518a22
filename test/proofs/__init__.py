"""Proofs of waves and loads, by topic: every module here that has PROOFS.

A new topic is a new module; nothing else needs an edit. ``python -m proofs TOPIC ...`` (from test/) shows the
values found, ``python -m proofs`` writes them all to docs/verification.md.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from proofs.registry import Proof

__all__ = ["proofs_of", "topics"]

#: Modules of this package that are no topics.
SHARED = {"__main__", "cases", "crossing", "flow", "literal", "registry", "table"}


def topics() -> list[str]:
    """Names of the topic modules, sorted."""
    return sorted(module.name for module in iter_modules(__path__) if module.name not in SHARED)


def proofs_of(*names: str) -> list[Proof]:
    """Proofs of the topics `names`, or of all.

    Raises
    ------
    ValueError
        If two proofs share a key or a claim, or a proof has no wrong variant.
    """
    proofs: list[Proof] = []
    for name in names or topics():
        proofs += import_module(f"proofs.{name}").PROOFS
    for field in ("key", "claim"):
        values = [getattr(proof, field) for proof in proofs]
        repeated = {value for value in values if values.count(value) > 1}
        if repeated:
            raise ValueError(f"proofs share a {field}: {sorted(repeated)}")
    unproven = [proof.key for proof in proofs if not proof.wrong]
    if unproven:
        raise ValueError(f"proofs without a wrong variant: {unproven}")
    return proofs
