"""Broken SubDyn decks, and files: an error by name, never a traceback."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from owt_model.errors import InputError
from owt_model.structure import load_structure
from owt_model.subdyn import parse_subdyn

PARTS = {
    "QR0": "",
    "INTERFACE": "4 1 1 1 1 1 1\n7 1 1 1 1 1 1",
    "MEMBERS": "1 1 4 1 1 1c 0\n2 2 4 1 3 1c 0\n3 3 4 1 1 1c 0\n5 4 7 2 2 1c 0",
    "MASS": "4 5.0e3 1.0 2.0 3.0 0.1 0.2 0.3 0.5 0.6 0.7",
}


def deck():
    folder = Path(__file__).parents[3] / "test" / "data" / "structure"
    text = (folder / "tripod.dat").read_text(encoding="utf-8")
    for name, value in PARTS.items():
        text = text.replace(f"@{name}@", value)
    return text


def test_garbage_is_an_input_error():
    """Cut, shuffled and overwritten decks, and things that are no deck at all."""
    rng = random.Random(0)
    lines = deck().splitlines()
    parsed = 0
    for _trial in range(400):
        broken = list(lines)
        for _ in range(rng.randint(1, 4)):
            i = rng.randrange(len(broken))
            kind = rng.randrange(5)
            if kind == 0:
                del broken[i]
            elif kind == 1:
                broken[i] = broken[i][: rng.randrange(len(broken[i]) + 1)]
            elif kind == 2:
                broken[i] = "".join(chr(rng.randrange(1, 300)) for _ in range(40))
            elif kind == 3:
                j = rng.randrange(len(broken))
                broken[i], broken[j] = broken[j], broken[i]
            else:
                broken[i] = broken[i].replace(
                    "1", rng.choice(["-1", "1e400", "", "9" * 400, "0", '"', "1.5"])
                )
            if not broken:
                break
        try:
            parse_subdyn("\n".join(broken), source="deck.dat")
            parsed += 1
        except InputError:
            pass
    assert 0 < parsed < 400
    for text in ("", "\n", "NJoints", "1 NJoints", "\x00\x01", "--- \n" * 5, "a: 1\nb: [2]", deck()[:500]):
        with pytest.raises(InputError):
            parse_subdyn(text, source="deck.dat")


def test_a_deck_loads_by_path(tmp_path):
    path = tmp_path / "tripod.dat"
    path.write_text(deck(), encoding="utf-8")
    plain = load_structure(str(path))
    assert plain.elements_per_member == 2
    # Comments in another encoding, as old editors write them, do no harm.
    path.write_bytes(b"! angles in \xb0, \xb1 1\n" + deck().encode())
    assert load_structure(str(path)).content_hash == plain.content_hash
    path.write_bytes(b"\xff\xfe\x00bad")
    with pytest.raises(InputError):
        load_structure(str(path))
