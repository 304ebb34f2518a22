"""Messages and contracts: every field there and back, exactly, also through CDR."""

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point, PointStamped
from rclpy.serialization import deserialize_message, serialize_message

from owt_model.contracts import (
    Block,
    ElevationBlock,
    EnergyBlock,
    FatigueBlock,
    LoadBasis,
    LoadBlock,
    MeasuredBlock,
    ModalBlock,
    ReducedDescription,
    SeaState,
    StressBlock,
    WrenchBlock,
)
from owt_model.errors import ComputationError
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_model.timing import sample_index
from owt_ros import convert, decode
from owt_ros.wire import NO_MEMBER, head_of, peek_head, peek_stamp

RANDOM = np.random.default_rng(5)
HEAD = {"sequence": 7, "start": 350, "dt": 0.02, "last": True}
NODE, ELEMENT = np.array([3, 5, 8, 9]), np.array([1, 2])


def _r(*shape: int) -> np.ndarray:
    return RANDOM.normal(size=shape)


BLOCKS = {
    "elevation": ElevationBlock(**HEAD, gauge=_r(2, 2), first_order=_r(5, 2), total=_r(5, 2)),
    "nodal_loads": LoadBlock(
        **HEAD, model_hash="ab12", node=NODE, element=ELEMENT, nodal=_r(5, 4, 6), fixed_end=_r(5, 2, 12)
    ),
    "modal": ModalBlock(**HEAD, displacement=_r(5, 3), velocity=_r(5, 3), acceleration=_r(5, 3)),
    "stress": StressBlock(**HEAD, axial=_r(5, 6), bending_y=_r(5, 6), bending_z=_r(5, 6), von_mises=_r(5, 6)),
    "energy": EnergyBlock(
        **HEAD,
        potential=_r(5),
        kinetic=_r(5),
        potential_mode=_r(5, 3),
        kinetic_mode=_r(5, 3),
        potential_substructure=_r(5, 2),
        kinetic_substructure=_r(5, 2),
    ),
    "tower_top_load": WrenchBlock(**HEAD, wrench=_r(5, 6)),
    "load_basis": LoadBasis(
        model_hash="ab12",
        node=NODE,
        vectors=_r(2, 4, 6),
        singular_values=_r(2),
        total_variance=30.0,
        mean=_r(4, 6),
        snapshots=100,
        damping=_r(4, 3, 3),
        spectrum=_r(2, 8),
        highest_frequency=0.1,
    ),
    "reduced_model": ReducedDescription(
        model_name="oc4",
        model_hash="ab12",
        reduction="CB02",
        coordinate_name=("TP.x", "mode 1"),
        frequency_hz=_r(2),
        damping_ratio=_r(2),
        end_name=("M1:J1", "M1:J2"),
        tower_top_coordinate=-1,
        notes=("CB02 has no tower", "and two notes"),
        substructure_name=("jacket", "tower"),
    ),
}
FLAGS = np.array([False, True, False, True, True])
BLOCKS |= {
    "tower_top_load": WrenchBlock(**HEAD, wrench=_r(5, 6), filled=FLAGS),
    "measured": MeasuredBlock(**HEAD, elevation=_r(5), filled=FLAGS),
}
FATIGUE = FatigueBlock(
    **HEAD, samples_counted=351, sn_curve="T", cycles=_r(4), damage=_r(4), total_stress=_r(4),
    max_range=_r(4), side=np.array([0, 1, 2, 1]), angle_deg=_r(4),
)  # fmt: skip


def _assert_same(one: Any, two: Any) -> None:
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(two, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b, err_msg=field.name, strict=True)
        else:
            assert a == b, field.name
            assert type(a) is type(b), field.name


def _message(name: str) -> Any:
    return getattr(convert, f"{name}_message")(BLOCKS[name])


@pytest.mark.parametrize("name", BLOCKS)
def test_there_and_back(name: str) -> None:
    message = _message(name)
    read = getattr(decode, f"to_{name}")
    _assert_same(BLOCKS[name], read(message))
    _assert_same(BLOCKS[name], read(deserialize_message(serialize_message(message), type(message))))


def test_marks_of_what_was_made_up() -> None:
    """None in a recording without the field, none in an empty field; another number of them is refused."""
    message = _message("tower_top_load")
    old = SimpleNamespace(
        **{name: getattr(message, name) for name in ("header", "sequence", "dt", "samples")}
    )
    old.last, old.wrench = message.last, message.wrench
    assert decode.to_tower_top_load(old).filled.size == 0
    measured = _message("measured")
    measured.filled = []
    assert not decode.to_measured(measured).filled.any()
    for name, read in (("tower_top_load", decode.to_tower_top_load), ("measured", decode.to_measured)):
        broken = _message(name)
        broken.filled = broken.filled[:-1]
        with pytest.raises(ComputationError, match=r"filled has 4 values, not those of \[5\]"):
            read(broken)
    stamped = PointStamped(header=message.header, point=Point(x=1.0, y=2.0, z=-3.0))
    time_ns, point = decode.to_point(stamped)
    assert time_ns == BLOCKS["tower_top_load"].time_ns
    np.testing.assert_array_equal(point, [1.0, 2.0, -3.0])


def test_fatigue_there_and_back() -> None:
    _assert_same(FATIGUE, decode.to_fatigue(convert.fatigue_message(FATIGUE), dt=0.02))


def test_empty_arrays() -> None:
    basis = BLOCKS["load_basis"]
    nothing = {"singular_values": np.zeros(0), "spectrum": np.zeros((0, 0))}
    bare = dataclasses.replace(basis, vectors=np.zeros((0, 4, 6)), **nothing)
    _assert_same(bare, decode.to_load_basis(convert.load_basis_message(bare)))


def test_sliced_and_transposed_arrays_are_written_in_c_order() -> None:
    block = BLOCKS["modal"]
    odd = dataclasses.replace(block, displacement=np.asfortranarray(block.displacement))
    assert convert.modal_message(odd).displacement == _message("modal").displacement


def test_model_and_sea_state() -> None:
    mesh = build_mesh(load_structure("oc4"))
    model = convert.model_message(mesh)
    assert model.model_hash == mesh.structure.content_hash
    assert len(model.node_name) == mesh.n_nodes == len(model.node_position_m) // 3 == len(model.node_dof) // 6
    np.testing.assert_array_equal(np.array(model.node_dof).reshape(-1, 6), mesh.node_dof)
    owner = np.array(model.element_member, dtype=np.int64)
    np.testing.assert_array_equal(owner == NO_MEMBER, mesh.is_tower)
    names = ("omega_rad_s", "amplitude_m", "phase_rad", "wavenumber_rad_m", "component_direction_deg")
    sea = SeaState(
        **{name: _r(9) for name in names}, direction_deg=210.0, water_depth_m=50.0, gravity_m_s2=9.81,
        density_kg_m3=1025.0, order=2, stretching="taylor", dt_s=0.1, n=6000, seed=2**63 - 1,
    )  # fmt: skip
    message = convert.sea_state_message(sea)
    assert message.seed == 2**63 - 1
    assert message.duration_s == pytest.approx(600.0, rel=1e-15)
    for name in names:
        np.testing.assert_array_equal(np.array(getattr(message, name)), getattr(sea, name))


@pytest.mark.parametrize("name", ["elevation", "nodal_loads", "modal", "stress", "energy"])
def test_head_is_read_from_the_bytes_alone(name: str) -> None:
    message = _message(name)
    cdr = serialize_message(message)
    assert peek_head(cdr, name) == head_of(message)
    assert peek_head(cdr, name).start == HEAD["start"]
    assert peek_stamp(cdr) == BLOCKS[name].time_ns
    message.header.frame_id = "world"
    assert peek_head(serialize_message(message), name) == head_of(message)


@pytest.mark.parametrize("dt", [0.1, 0.02, 1 / 3, 1 / 128, 0.001, 7.3])
@pytest.mark.parametrize("start", [0, 1, 49, 6000, 9_999_999])
def test_stamps_are_exact_and_give_the_index_back(dt: float, start: int) -> None:
    time_ns = Block(0, start, dt, False).time_ns
    assert time_ns == pytest.approx(start * dt * 1e9, abs=1 + start * 1e-3)
    assert sample_index(time_ns, dt) == start


@pytest.mark.parametrize(
    ("name", "field", "message"),
    [
        ("nodal_loads", "nodal", r"NodalLoads 7: nodal has 119 values, not those of \[5, 4, 6\]"),
        ("stress", "von_mises", r"MemberStress 7: von_mises has 29 values"),
        ("energy", "potential", "Energy 7: potential has 4 values"),
        ("modal", "displacement", r"ModalState 7: displacement has 14 values, not those of \[5, \*\]"),
    ],
)
def test_a_message_with_too_few_values_is_refused(name: str, field: str, message: str) -> None:
    broken = _message(name)
    setattr(broken, field, getattr(broken, field)[:-1])
    with pytest.raises(ComputationError, match=message):
        getattr(decode, f"to_{name}")(broken)


@pytest.mark.parametrize(
    ("field", "value"), [("dt", 0.0), ("dt", float("nan")), ("dt", -1.0), ("samples", 0)]
)
def test_a_head_that_cannot_be_is_refused(field: str, value: Any) -> None:
    broken = _message("modal")
    setattr(broken, field, value)
    for read in (decode.to_modal, head_of):
        with pytest.raises(ComputationError, match="ModalState 7: "):
            read(broken)


def test_garbage_bytes_are_refused() -> None:
    for garbage in (b"", b"\x00\x01\x00\x00", bytes(20), b"\xff" * 40):
        with pytest.raises(ComputationError, match="/owt/energy"):
            peek_head(garbage, "/owt/energy")
    with pytest.raises(ComputationError, match="no message with a time"):
        peek_stamp(b"\x00\x01\x00\x00")


def test_what_a_bag_leaves_out_has_no_columns() -> None:
    """Velocities, accelerations, shares of the modes; stress of the ends that are listed."""
    modal = convert.modal_message(BLOCKS["modal"])
    stress = convert.stress_message(BLOCKS["stress"])
    energy = convert.energy_message(BLOCKS["energy"])
    assert all(decode.is_whole(message) for message in (modal, stress, energy))
    assert decode.stress_ends(stress) is None
    modal.velocity = modal.acceleration = []
    energy.potential_mode = energy.kinetic_mode = []
    stress.end = [4, 1, 5]
    for name in ("axial", "bending_y", "bending_z", "von_mises"):
        values = np.asarray(getattr(stress, name)).reshape(5, 6)[:, [4, 1, 5]]
        setattr(stress, name, values.ravel().tolist())
    assert not any(decode.is_whole(message) for message in (modal, stress, energy))
    found = decode.to_modal(modal)
    np.testing.assert_array_equal(found.displacement, BLOCKS["modal"].displacement)
    assert found.velocity.shape == found.acceleration.shape == (5, 0)
    assert (
        decode.to_energy(energy).potential_mode.shape == decode.to_energy(energy).kinetic_mode.shape == (5, 0)
    )
    np.testing.assert_array_equal(decode.stress_ends(stress), [4, 1, 5])
    np.testing.assert_array_equal(
        decode.to_stress(stress).von_mises, BLOCKS["stress"].von_mises[:, [4, 1, 5]]
    )
    # Negative controls: half of a field is no field that was left out, and columns must be those listed.
    modal.velocity = [0.0] * 5
    with pytest.raises(ComputationError, match=r"ModalState 7: velocity has 5 values"):
        decode.to_modal(modal)
    stress.end = [4, 1]
    with pytest.raises(ComputationError, match=r"MemberStress 7: axial has 15 values, not those of \[5, 2\]"):
        decode.to_stress(stress)
