"""Superelement files: what is written is read, variants of the format, and one clear error for each fault."""

from __future__ import annotations

import io
import random
import re
from dataclasses import replace

import numpy as np
import pytest

from owt_model.errors import InputError
from owt_model.superelement import Superelement, extptfm_notes, write_openfast5, write_superelement
from owt_model.superelement_file import parse_superelement

SAMPLES, DT = 7, 0.1


def element(n: int = 8, samples: int = SAMPLES, *, seed: int = 0, elevation: bool = False) -> Superelement:
    """A superelement of Craig-Bampton form with random entries."""
    rng = np.random.default_rng(seed)

    def definite(size: float) -> np.ndarray:
        root = rng.standard_normal((6, 6))
        return size * (root @ root.T + 6.0 * np.eye(6))

    mass, stiffness = np.eye(n), np.diag(rng.uniform(1e2, 1e4, n))
    mass[:6, :6], stiffness[:6, :6] = definite(1e5), definite(1e8)
    mass[:6, 6:] = rng.standard_normal((6, n - 6))
    mass[6:, :6] = mass[:6, 6:].T
    return Superelement(
        mass,
        stiffness,
        0.03 * mass + 0.002 * stiffness,
        DT,
        1e5 * rng.standard_normal((samples, n)),
        rng.standard_normal(samples) if elevation else None,
        ("a jacket", "mass of it, stiffness of it"),  # words that are keywords elsewhere
    )


def text(one: Superelement) -> str:
    stream = io.StringIO()
    write_superelement(stream, one)
    return stream.getvalue()


def parse(content: str) -> Superelement:
    return parse_superelement(content, source="jacket.dat")


def same(one: Superelement, other: Superelement) -> None:
    for name in ("mass", "stiffness", "damping", "loads"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    assert one.dt == other.dt


@pytest.mark.parametrize("elevation", [False, True])
@pytest.mark.parametrize(("n", "samples"), [(6, 1), (8, 7), (26, 600)])
def test_what_is_written_is_read(n: int, samples: int, elevation: bool) -> None:
    given = element(n, samples, elevation=elevation)
    found = parse(text(given))
    same(found, given)
    assert found.comments == given.comments
    if given.elevation is None:
        assert found.elevation is None
    else:
        np.testing.assert_array_equal(found.elevation, given.elevation)


@pytest.mark.parametrize("dt", [0.1, 0.05, 1.0 / 3.0, 0.025, 0.0125])
@pytest.mark.parametrize("samples", [2, 7, 1001])
def test_readers_that_cut_the_number_of_steps_find_all(dt: float, samples: int) -> None:
    lines = text(replace(element(6), loads=np.ones((samples, 6)), dt=dt)).splitlines()
    step, total = (float(line.split(":")[1]) for line in lines[3:5])
    assert int(total / step) + 1 == round(total / step) + 1 == samples


def test_lines_are_where_readers_look_for_them() -> None:
    lines = text(element()).splitlines()
    assert lines[0].startswith("!")
    assert "flex 5 format" in lines[1].lower()
    assert lines[2] == "!Dimension: 8"
    assert lines[3] == "!Time increment in simulation: 0.1"
    assert lines[4].startswith("!Total simulation time in file: 0.6")
    for title in ("!Mass Matrix", "!Stiffness Matrix", "!Damping Matrix", "!Loading and Wave Elevation"):
        at = next(i for i, line in enumerate(lines) if line.startswith(title))
        assert lines[at + 1].startswith("!Dimension: ")
        assert len(lines[at + 2].split()) == (9 if "Loading" in title else 8)


def test_openfast_5_takes_two_files() -> None:
    given, matrices, forces = element(), io.StringIO(), io.StringIO()
    write_openfast5(matrices, forces, given)
    found = parse_superelement(matrices.getvalue(), source="a", forces=(forces.getvalue(), "b"))
    same(found, given)
    alone = parse(matrices.getvalue())
    assert alone.loads.shape == (1, 8)
    assert not alone.loads.any()
    # that reader takes the lines right below the title
    lines = matrices.getvalue().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("!Mass"))
    assert len(lines[at + 1].split()) == 8


def test_constant_weight_is_a_load() -> None:
    matrices = io.StringIO()
    write_openfast5(matrices, io.StringIO(), element())
    zero = " ".join([f"{0.0:23.16e}"] * 8)
    assert matrices.getvalue().count(zero) == 9
    weight = "0 0 -1e6 0 0 0 0 2"
    found = parse(matrices.getvalue().replace(zero, weight, 1))
    np.testing.assert_array_equal(found.loads, [[float(w) for w in weight.split()]])
    *before, last = matrices.getvalue().rsplit(zero, 1)
    with pytest.raises(InputError, match="weight stiffness = 'not zero': is not supported"):
        parse(weight.join([*before, last]))


GUYAN = """a jacket by hand
#Mass
@M@
#Damping
@C@
#Stiffness
@K@
# time-varying force
# Time Fx Fy Fz Mx My Mz
# s N N N N-m N-m N-m
"""


def guyan(one: Superelement, loads: str = "") -> str:
    rows = {
        key: "\n".join(" ".join(f"{value!r}" for value in row) for row in matrix.tolist())
        for key, matrix in (("@M@", one.mass), ("@C@", one.damping), ("@K@", one.stiffness))
    }
    return re.sub("@.@", lambda found: rows[found[0]], GUYAN) + loads


def test_guyan_file() -> None:
    given = element(6, 3)
    rows = (f"{0.1 * i:g} " + " ".join(map(repr, row)) for i, row in enumerate(given.loads.tolist()))
    found = parse(guyan(given, "\n".join(rows) + "\n\n"))
    same(found, given)
    constant = parse(guyan(given))
    assert not constant.loads.any()
    with pytest.raises(InputError, match=r"line 27: loads, numbers = 2: must be 7 in a line"):
        parse(guyan(given, "0 1 2 3 4 5 6\n1 2\n"))
    with pytest.raises(InputError, match=r"line 9: damping matrix = '#Stiffness': must be titled #damping"):
        parse(guyan(given).replace("#Damping", "#Stiffness"))


def test_variants_of_the_format() -> None:
    given = element(elevation=True)
    content = text(given)
    same(parse(content.replace("\n", "\r\n")), given)
    same(parse(content.upper()), given)
    same(parse(content.replace("e+", "D+").replace("e-", "d-")), given)
    same(parse(re.sub(r"!Dimension: (8\n )", r"Dimension: \1", content)), given)  # that line is not a comment
    same(parse(re.sub(r"(?<=\d) +(?=-?\d\.)", ", ", content)), given)
    rounded = re.sub(r"-?\d\.\d{16}e", lambda found: f"{float(found[0][:-1]):.8f}e", content)
    assert np.abs(parse(rounded).loads - given.loads).max() < 1e-2
    assert np.abs(parse(rounded).loads - given.loads).max() > 0.0


def test_small_asymmetry_is_evened_out() -> None:
    given = element()
    mass = given.mass.copy()
    mass[0, 1] *= 1.0 + 1e-9
    found = parse(text(replace(given, mass=mass)))
    np.testing.assert_array_equal(found.mass, found.mass.T)
    assert found.mass[0, 1] == 0.5 * (mass[0, 1] + mass[1, 0])


def change(content: str, pattern: str, new: str) -> str:
    changed, count = re.subn(pattern, new, content, count=1, flags=re.MULTILINE)
    assert count == 1, pattern
    return changed


NUMBER = r"-?\d\.\d{16}e[+-]\d\d"


@pytest.mark.parametrize(
    ("pattern", "new", "message"),
    [
        (r"^!Dimension: 8$", "", "line 3: dimension|is missing before"),
        (r"^!Dimension: 8$", "!Dimension: 9", r"dimension = '8': is 9 in line 3"),
        (r"^!Dimension: 8$", "!Dimension: 5", r"line 3: dimension = '5': must be a whole number, 6 to 10000"),
        (r"^!Dimension: 8$", "!Dimension: 8.5", "line 3: dimension = '8.5'"),
        (r"^!Dimension: 8$", "!Dimension: eight", "line 3: dimension = 'eight': is not a number"),
        (r"^!Dimension: 8$", "!Dimension:", "line 3: dimension = '': must be a whole number"),
        (r"^!Time increment.*$", "", "time increment = 'nothing': is missing in the header"),
        (r"^!Time increment.*$", "!Time increment in simulation: 0", "line 4: time increment = '0': must be"),
        (r"^!Time increment.*$", "!Time increment in simulation: 0.2", "loads, lines = 7: must be 4"),
        (r"^!Total simulation.*$", "", "total simulation time = 'nothing': is missing"),
        (r"^!Total simulation.*$", "!Total simulation time in file: 0.7", "loads, lines = 7: must be 8"),
        (r"^!Total simulation.*$", "!Total simulation time in file: nan", "must be finite"),
        (r"^!Mass Matrix.*$", "", "line 10: numbers = .*belong to no section"),
        (r"^!Mass Matrix(.|\n)*?(?=!Stiff)", "", "mass matrix = 'nothing': is missing"),
        (r"^!Stiffness Matrix.*$", "!Mass Matrix", r"line 19: mass matrix = 'again': is in line 8 already"),
        (r"^!Damping Matrix(.|\n)*?(?=!Load)", "", "damping matrix = 'nothing': is missing"),
        (rf"^ +{NUMBER}.*\n", "", r"line 8: mass matrix, lines = 7: must be 8"),
        (rf"^( +{NUMBER}.*\n)", r"\1\1", r"line 8: mass matrix, lines = 9: must be 8"),
        (rf" {NUMBER}$", "", r"line 10: mass matrix, numbers = 7: must be 8 in a line"),
        (NUMBER, "nan", r"line 10: mass matrix = nan: must be finite"),
        (NUMBER, "inf", r"line 10: mass matrix = inf: must be finite"),
        (NUMBER, "1_0", r"line 10: mass matrix = '1_0': is not a number"),
        (NUMBER, "***", r"line 10: mass matrix = '\*\*\*': is not a number"),
        (NUMBER, "-1.0", r"mass matrix \[1, 1\] = -1.0: must be > 0"),
        (rf"{NUMBER}( +){NUMBER}", r"1e5\g<1>9e4", r"mass matrix \[1, 2\] and \[2, 1\].*must be equal"),
        (r"^ +0 +.*\n", "", r"loads, lines = 6: must be 7"),
        (r"^ +0 ", " 0.05 ", r"loads, time of sample 1 = 0.05: must be 0 s"),
        (r"^ +0\.3 ", " 0.35 ", r"loads, time of sample 4 = 0.35: must be 0.3 s"),
        (r"^( +0\.2 .*)$", r"\1 1.0", r"loads, numbers = 10: must be 9 in a line"),
        (r"^( +0\.2 .*)$", r"\1 1.0 2.0", r"loads, numbers = 11: must be 9 or 10 in a line|must be 9"),
    ],
)
def test_faults_have_one_clear_error(pattern: str, new: str, message: str) -> None:
    content = change(text(element()), pattern, new)
    with pytest.raises(InputError, match=message) as error:
        parse(content)
    assert str(error.value).startswith("jacket.dat")


@pytest.mark.parametrize(
    "content", ["", "\n\n", "hello", "!", "1 2 3", "!Dimension: 6", "\x00\x01", "#\n#mass"]
)
def test_other_files_are_refused(content: str) -> None:
    with pytest.raises(InputError, match=r"jacket\.dat"):
        parse(content)


def test_garbage_is_never_a_traceback() -> None:
    """Characters struck out, lines swapped, tokens replaced: read, or refused in the one way."""
    rng, content = random.Random(1), text(element(elevation=True))
    refused = 0
    for _ in range(300):
        lines = content.splitlines()
        for _ in range(rng.randint(1, 3)):
            i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
            lines[i] = rng.choice(
                [
                    lines[j],
                    "",
                    lines[i][: rng.randrange(len(lines[i]) + 1)],
                    lines[i].replace(".", "!", 1),
                    "-1",
                ]
            )
        try:
            parse("\n".join(lines))
        except InputError:
            refused += 1
    assert refused > 200


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"dt": 0.0}, "time increment = 0.0"),
        ({"mass": np.diag([1.0] * 7 + [0.0])}, r"mass matrix \[8, 8\] = 0.0: must be > 0"),
        ({"stiffness": np.eye(8) + 2.0 * (1.0 - np.eye(8))}, "stiffness matrix = -1.*positive definite"),
        ({"damping": np.diag([-1.0] + [1.0] * 7)}, r"damping matrix \[1, 1\] = -1.0: must be >= 0"),
        ({"loads": np.full((7, 8), np.inf)}, "loads, sample 1, degree of freedom 1 = inf"),
        ({"loads": np.zeros((0, 8))}, r"loads = \(0, 8\): must be one sample or more"),
    ],
)
def test_what_no_structure_has_is_refused(changes: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(element(), **changes)


def test_undamped_is_allowed() -> None:
    given = replace(element(), damping=np.zeros((8, 8)))
    same(parse(text(given)), given)


def test_notes_on_what_extptfm_takes_for_granted() -> None:
    given = element()
    assert extptfm_notes(given) == ()
    scale = np.diag([1.0] * 6 + [10.0, 1.0])
    (note,) = extptfm_notes(replace(given, mass=scale @ given.mass @ scale))
    assert "identity" in note
    stiffness = given.stiffness.copy()
    stiffness[0, 7] = stiffness[7, 0] = 1e3
    (note,) = extptfm_notes(replace(given, stiffness=stiffness))
    assert "stiffness between" in note


def test_lines_too_long_for_extptfm_are_refused() -> None:
    with pytest.raises(InputError, match="dimension = 169: makes lines of loads longer than the 4096"):
        text(element(169, 2))
    assert max(map(len, text(element(168, 2, elevation=True)).splitlines())) <= 4096
