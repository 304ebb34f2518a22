"""Canonical bytes of serialised messages: against the message, and against an independent serialiser."""

from array import array
from collections.abc import Callable
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import WrenchStamped
from owt_msgs.msg import Energy, LoadBasis, NodalLoads, ReducedModel
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from owt_model.errors import ComputationError
from owt_ros import schema
from owt_ros.cdr import canonical


def numbers(*values: float) -> "array[float]":
    return array("d", values)


MESSAGES = [
    NodalLoads(model_hash="ab", node=array("I", [1, 2, 3]), nodal=numbers(1.0, 2.0)),
    NodalLoads(model_hash="a" * 64, element=array("I", [7]), fixed_end=numbers(*range(12))),
    Energy(sequence=3, dt=0.02, samples=1, last=True, potential=numbers(1.5)),
    LoadBasis(model_hash="x", snapshots=9, total_variance=2.0, spectrum=numbers(1.0, 2.0, 3.0)),
    ReducedModel(model_name="oc4", coordinate_name=["a", "bcd", ""], end_side=array("B", [0, 1, 0])),
    DiagnosticArray(
        status=[
            DiagnosticStatus(level=b"\x02", name="n", values=[KeyValue(key="k", value="vv")]),
            DiagnosticStatus(message="two"),
        ]
    ),
    WrenchStamped(),
]


def soiled(clean: bytes, again: Callable[[bytes], bytes]) -> bytes:
    """Bytes as Fast DDS may leave them: any value in the gaps, something behind the end.

    A gap is a zero that a reader does not look at: `again` reads and writes a message.
    """
    found = bytearray(clean)
    for i in range(4, len(clean)):
        tried = bytearray(clean)
        tried[i] = 0xA5
        try:
            if clean[i] == 0 and again(bytes(tried)) == clean:
                found[i] = 0xA5
        except Exception:  # a count or a text that cannot be: no gap
            continue
    return bytes(found) + b"\x01\x02\x03"


@pytest.mark.parametrize("message", MESSAGES, ids=lambda m: type(m).__name__)
def test_bytes_depend_on_the_content_alone(message: Any) -> None:
    name = schema.type_name(type(message))
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.definition(name), name))

    def again(cdr: bytes) -> bytes:
        return bytes(store.serialize_cdr(store.deserialize_cdr(cdr, name), name))

    found = canonical(type(message), bytes(serialize_message(message)))
    assert found == again(found)
    assert deserialize_message(found, type(message)) == message
    assert canonical(type(message), found) == found
    dirty = soiled(found, again)
    assert dirty[: len(found)] != found, "the comparison would notice bytes that were left as they came"
    assert canonical(type(message), dirty) == found


@pytest.mark.parametrize("cut", [0, 3, 5, 20, 60])
def test_what_is_no_such_message_is_an_error(cut: int) -> None:
    whole = canonical(NodalLoads, bytes(serialize_message(MESSAGES[0])))
    with pytest.raises(ComputationError, match="no message of type NodalLoads"):
        canonical(NodalLoads, whole[:cut])


def test_a_length_that_cannot_be_is_an_error() -> None:
    whole = bytearray(canonical(ReducedModel, bytes(serialize_message(MESSAGES[4]))))
    whole[4:8] = b"\xff\xff\xff\x7f"
    with pytest.raises(ComputationError, match="no message of type ReducedModel"):
        canonical(ReducedModel, bytes(whole))
