"""Schemas for bags: text and hash of installed messages."""

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from owt_model.config import parse_case
from owt_model.errors import InputError
from owt_ros.schema import definition, type_hash, type_name
from owt_ros.topics import CREDIT, RECORDED, STATUS, TOWER_TOP_LOAD, recorded

EVERY = recorded(parse_case({"wind": {"thrust": {}}}))


@pytest.mark.parametrize("topic", EVERY, ids=lambda topic: topic.label)
def test_an_independent_library_reads_the_schema_and_computes_the_same_hash(topic) -> None:
    name = type_name(topic.message)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition(name), name))
    assert store.hash_rihs01(name) == type_hash(name)


def test_nested_types_appear_once() -> None:
    text = definition("diagnostic_msgs/msg/DiagnosticArray")
    for nested in ("std_msgs/Header", "builtin_interfaces/Time", "diagnostic_msgs/KeyValue"):
        assert text.count(f"MSG: {nested}\n") == 1


def test_unknown_types_are_named() -> None:
    with pytest.raises(InputError, match="no_such_package"):
        definition("no_such_package/msg/X")
    with pytest.raises(InputError, match="has no definition"):
        definition("owt_msgs/msg/NoSuchMessage")


def test_flow_control_and_supervision_are_not_recorded() -> None:
    assert CREDIT not in EVERY
    assert STATUS not in EVERY


def test_the_load_at_the_tower_top_is_recorded_where_there_is_one() -> None:
    assert set(EVERY) == {*RECORDED, TOWER_TOP_LOAD}
    assert recorded(parse_case({})) == RECORDED
