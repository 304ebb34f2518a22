"""Bags that leave out what follows from the loads: computed again, to the bit, and compared."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bag_tools import ENDS, rewrite, shorten
from local_graph import short_case
from owt_bringup.analysis import analyse
from owt_bringup.bag_case import recorded_run
from owt_bringup.cli import main
from owt_bringup.graph import run_graph
from owt_bringup.recompute import Recomputation, block_source, leaves_out
from owt_campaign.pipeline import run_case
from owt_model.contracts import Block
from owt_model.errors import ComputationError, InputError
from owt_model.structure import load_structure
from owt_model.structure_text import structure_text
from owt_postproc.bag_reader import decoded, read_bag
from owt_postproc.bag_report import as_recorded, bag_case, bag_report
from owt_postproc.bag_source import BagSource
from owt_postproc.report import summary

pytestmark = [pytest.mark.graph, pytest.mark.timeout(180)]

GOLDEN = Path(__file__).parents[1] / "bags" / "golden"
SERIES = "time_s,fx_n,my_nm\n0,1e5,-2e6\n7.3,3e5,1e6\n30,-1e5,0\n"
RESPONSE = ("/owt/modal_state", "/owt/member_stress", "/owt/energy")


@pytest.fixture(scope="module")
def wind_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("wind") / "wind.csv"
    path.write_text(SERIES)
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, wind_file: Path) -> Path:
    """A bag of the graph with a load at the tower top from a file, which is gone afterwards."""
    bag = tmp_path_factory.mktemp("whole") / "run"
    case = short_case(
        wave={"order": 2},
        wind={"series": {"path": str(wind_file), "direction_deg": 30.0}},
        morison={"hydrodynamic_damping": True},
        structure={"reduction": "CB04M03", "ramp_s": 2.0},
    )
    run_graph(case, bag, record="all")
    run_graph(case, bag.with_name("default"))
    wind_file.unlink()
    return bag


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory, whole: Path) -> Path:
    """The same, with the response left out as far as a bag may."""
    return rewrite(whole, tmp_path_factory.mktemp("short") / "run")


def blocks_of(bag: Path) -> dict[tuple[str, int], Block]:
    with BagSource(bag) as source:
        found = block_source(source)(bag_case(source), decoded(source))
        return {(message.topic, block.sequence): block for message, block in found if block is not None}


def assert_equal(found: dict[tuple[str, int], Block], wanted: dict[tuple[str, int], Block]) -> None:
    assert found.keys() == wanted.keys()
    for key, block in wanted.items():
        for name, values in vars(block).items():
            np.testing.assert_array_equal(getattr(found[key], name), values, err_msg=f"{key} {name}")


def test_what_was_left_out_comes_back_bit_for_bit(whole: Path, short: Path) -> None:
    """Every end, mode, velocity and acceleration, with load basis, drag damping, ramp and wind of the bag."""
    for bag, expected in ((whole, False), (short, True)):
        with BagSource(bag) as source:
            assert leaves_out(source) == expected
    recorded = blocks_of(whole)
    assert {topic for topic, _ in recorded} >= {*RESPONSE, "/owt/tower_top_load"}
    assert_equal(blocks_of(short), recorded)
    stream = read_bag(short).streams["/owt/member_stress"]
    np.testing.assert_array_equal(stream["end"], ENDS)
    assert stream["axial"].shape[1] == len(ENDS)
    # Negative control: without the load at the tower top the response is another.
    silent = rewrite(short, short.with_name("silent"), _without_wind)
    with pytest.raises(
        ComputationError, match=r"/owt/modal_state, block 0: displacement \[\d+, \d+\] is rec"
    ):
        blocks_of(silent)


def test_the_bag_of_a_run_gives_back_all_that_it_leaves_out(whole: Path) -> None:
    """Fixed-end forces too, which only the waves of the case give; 8 member ends of 224 are kept."""
    default = whole.with_name("default")
    stream = read_bag(default).streams
    assert stream["/owt/nodal_loads"]["fixed_end"].size == 0
    assert stream["/owt/member_stress"]["axial"].shape[1] == 8
    found, wanted = blocks_of(default), blocks_of(whole)
    assert_equal(found, wanted)
    data, _, notes = analyse(default)
    assert any("equals what was recorded bit for bit" in note for note in notes)
    assert summary(data)["fatigue"] == summary(analyse(whole)[0])["fatigue"]


def test_loads_that_the_case_does_not_give_are_named(whole: Path, tmp_path: Path) -> None:
    def change(kind: str, content: Any) -> None:
        if kind == "NodalLoads" and content.sequence == 1:
            content.nodal = content.nodal * (1.0 + 1e-6)

    with pytest.raises(ComputationError, match=r"/owt/nodal_loads, block 1: nodal \[.*\] is recorded as "):
        blocks_of(rewrite(whole.with_name("default"), tmp_path / "other", change))


def test_a_structure_of_ones_own_is_in_the_bag(tmp_path: Path) -> None:
    """Its file is gone: the bag runs again, and is read, as if it were there."""
    file, bag = tmp_path / "mine.yaml", tmp_path / "run"
    own = load_structure("oc4").model_copy(update={"name": "mine", "description": "a copy"})
    file.write_text(structure_text(own))
    assert load_structure(str(file)) == own
    case = short_case(structure={"model": str(file), "reduction": "CB04M03"}, time={"n": 100})
    run_graph(case, bag)
    wanted = summary(run_case(case).report)["fatigue"]
    file.unlink()
    assert main(["simulate", "--from-bag", str(bag), "-o", str(tmp_path / "again")]) == 0
    assert json.loads((tmp_path / "again" / "summary.json").read_text())["fatigue"] == wanted
    assert summary(analyse(bag)[0])["fatigue"] == wanted
    with pytest.raises(InputError, match=r"mine\.yaml"):  # negative control: without the bag there is none
        run_case(case)


def _without_wind(kind: str, content: Any) -> None:
    if kind == "TowerTopLoad":
        content.wrench = np.zeros_like(content.wrench)


@pytest.mark.parametrize(
    ("kind", "field", "message"),
    [
        ("ModalState", "displacement", r"/owt/modal_state, block 2: displacement \[3, 1\] is recorded as "),
        (
            "ModalState",
            "displacement CB",
            r"block 2: displacement \(length of all CB.\*\) \[3\] is recor",
        ),
        ("MemberStress", "bending_z", r"/owt/member_stress, block 2: bending_z \[\d+, 1\] is recorded as "),
        ("Energy", "kinetic", r"/owt/energy, block 2: kinetic \[\d+\] is recorded as "),
        ("FatigueState", "damage", r"/owt/fatigue, block 2: damage \[\d+\] is recorded as "),
        ("FatigueState", "cycles", r"/owt/fatigue, block 2: cycles \[\d+\] is recorded as "),
    ],
)
def test_a_number_that_the_loads_do_not_give_is_named(
    tmp_path: Path, short: Path, kind: str, field: str, message: str
) -> None:
    def change(name: str, content: Any) -> None:
        if name == kind and content.sequence == 2:
            values = getattr(content, field.split()[0]).copy()
            columns = len(values) // getattr(content, "samples", 1)
            column = 7 if field.endswith("CB") else 1
            values[3 * columns + column if columns < len(values) else 1] += 1e-6 * np.abs(values).max()
            setattr(content, field.split()[0], values)

    bad = rewrite(short, tmp_path / "bad", change)
    with pytest.raises(ComputationError, match=message):
        analyse(bad)
    assert main(["analyse", str(bad)]) == 1
    assert not (bad / "summary.json").exists()


def test_rounding_is_no_error_and_is_said(tmp_path: Path, short: Path) -> None:
    def change(name: str, content: Any) -> None:
        if name == "MemberStress":
            content.axial = content.axial * (1.0 + 1e-11)

    _, _, notes = analyse(rewrite(short, tmp_path / "rounded", change), tmp_path / "out")
    assert notes[0].endswith("equals what was recorded to 1e-11 of the largest value")


def test_a_bag_without_loads_for_its_response_is_named(tmp_path: Path, short: Path) -> None:
    def drop(name: str, content: Any) -> bool:
        return not (name == "NodalLoads" and content.sequence >= 2)

    with pytest.raises(ComputationError, match=r"/owt/modal_state, block 2: the bag has no loads"):
        blocks_of(rewrite(short, tmp_path / "bad", drop))


def test_a_gap_in_what_was_recorded_is_named(tmp_path: Path, short: Path) -> None:
    def drop(name: str, content: Any) -> bool:
        return not (name == "MemberStress" and content.sequence == 1)

    with pytest.raises(ComputationError, match=r"stress sequence 2: expected 1"):
        analyse(rewrite(short, tmp_path / "bad", drop))

    def without_fatigue(name: str, content: Any) -> bool:
        return not (name == "FatigueState" and content.last)

    with pytest.raises(
        ComputationError, match=r"/owt/fatigue, block 3: the bag has no fatigue that goes with"
    ):
        analyse(rewrite(short, tmp_path / "worse", without_fatigue))


def test_messages_alone_do_not_do_for_a_short_bag(short: Path) -> None:
    with pytest.raises(InputError, match=r"/owt/modal_state.*leaves out.*owt analyse"):
        bag_report(short)
    with BagSource(short) as source:
        assert isinstance(block_source(source), Recomputation)
    with BagSource(GOLDEN) as source:
        assert block_source(source) is as_recorded


def test_whole_and_short_bag_and_the_run_in_one_process_agree(
    tmp_path: Path, whole: Path, short: Path, wind_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Summary and report by `analyse`, `report`, and `simulate --from-bag`, which has no file of the wind."""
    assert not wind_file.exists()
    found = {}
    for command, bag in (("analyse", whole), ("report", short), ("simulate", short)):
        option = ["--from-bag"] if command == "simulate" else []
        assert main([command, *option, str(bag), "-o", str(tmp_path / command)]) == 0
        found[command] = json.loads((tmp_path / command / "summary.json").read_text())
        assert (tmp_path / command / "report.html").stat().st_size > 1e5
        if command != "simulate":
            notes = capsys.readouterr().err.splitlines()
            assert notes.pop() == "note: cycles counted again: equal the recorded fatigue bit for bit"
            response = (
                "note: response computed again from the recorded loads: equals what was recorded bit for bit"
            )
            assert notes == ([response] if bag == short else [])
    assert found["analyse"] == found["report"] == found["simulate"]
    assert found["analyse"]["statistics"]["tower_top_load_x"]["max_n"] > 2e5


def test_a_bag_runs_again_alone_bit_for_bit(whole: Path, short: Path) -> None:
    with BagSource(short) as source:
        recorded = recorded_run(source)
    again = run_case(recorded.case, keep_series=True, tower_top=recorded.tower_top).series
    streams = read_bag(whole).streams
    names = {
        "/owt/surface_elevation": "elevation", "/owt/nodal_loads": "load", "/owt/tower_top_load": "tower_top",
        "/owt/modal_state": "modal", "/owt/member_stress": "stress", "/owt/energy": "energy",
    }  # fmt: skip
    compared = 0
    for topic, stream in names.items():
        for name, values in streams[topic].items():
            if f"{stream}.{name}" in again and name != "filled":
                np.testing.assert_array_equal(again[f"{stream}.{name}"].reshape(values.shape), values, name)
                compared += 1
    assert compared > 15
    # Negative control: another seed is another sea.
    sea = recorded.case.sea_state
    assert sea is not None
    case = recorded.case.model_copy(update={"sea_state": sea.model_copy(update={"seed": 4})})
    other = run_case(case, keep_series=True, tower_top=recorded.tower_top).series
    assert not np.array_equal(other["stress.axial"], again["stress.axial"])
    np.testing.assert_array_equal(other["tower_top.wrench"], again["tower_top.wrench"])


def test_a_recording_of_another_machine_is_within_rounding(tmp_path: Path) -> None:
    """The committed bag without what follows from its loads; its messages are of an older definition."""

    new = {
        "MemberStress": "uint32[] end",
        "LoadBasis": "float64[] damping\nfloat64[] spectrum\nfloat64 highest_frequency",
    }

    def change(kind: str, content: Any) -> None:
        shorten(kind, content)
        if kind == "LoadBasis":
            content.damping, content.spectrum, content.highest_frequency = np.zeros(0), np.zeros(0), 0.0

    def define(kind: str, text: str) -> str:
        return "\n".join(filter(None, [new.get(kind), text]))

    bag = rewrite(GOLDEN, tmp_path / "golden", change, schemas=define)
    data, _, notes = analyse(bag)
    assert any("is not the one that the bag was made with" in note for note in notes)
    with BagSource(GOLDEN) as source:
        assert "is not the one that the bag was made with" in recorded_run(source).notes[0]
    recorded = bag_report(GOLDEN)
    largest = recorded.fatigue.damage.max()
    np.testing.assert_allclose(data.fatigue.damage, recorded.fatigue.damage, rtol=0.0, atol=1e-8 * largest)
    assert summary(data)["fatigue"]["complete"]


@pytest.mark.parametrize("arguments", [[], ["case.json", "--from-bag", "bag"]], ids=["none", "both"])
def test_simulate_takes_a_case_or_a_bag(
    tmp_path: Path, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", *arguments, "-o", str(tmp_path / "out")]) == 1
    assert "must be given, or a bag by --from-bag, and not both" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
