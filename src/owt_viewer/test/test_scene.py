"""Lines, colours and legend against what can be written down."""

import numpy as np
import pytest

from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_ros import convert
from owt_viewer.core.colours import GREY, Scale, damage_scale, rising_limit, sea_colours, stress_scale
from owt_viewer.core.scene import Skeleton, legend_items, structure_items
from owt_viewer.picture import _skeleton

RAMP = Scale(0.0, 10.0, False, "stress", "MPa", 1e-6)


@pytest.fixture(scope="module")
def bar() -> Skeleton:
    """One member of three elements along x, and a tower element without values upon its end."""
    return Skeleton.of(
        node=np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [4, 0, 0], [4, 0, 5]]),
        segment=np.array([[0, 1], [1, 2], [2, 3], [3, 4]]),
        member=np.array([0, 0, 0, -1]),
        member_node=np.array([[0, 3]]),
        member_end=np.array([[0, 1]]),
        width=np.array([1.0, 1.0, 1.0, 3.0]),
    )


def test_values_are_linear_between_the_ends_of_a_member(bar: Skeleton) -> None:
    value, known = bar.values(np.array([8.0, 0.0]), np.array([True, True]))
    np.testing.assert_allclose(value, [[8, 6], [6, 4], [4, 0], [0, 0]], rtol=0, atol=1e-14)
    assert known.tolist() == [[True] * 2] * 3 + [[False] * 2]


def test_a_member_with_an_unknown_end_has_no_values(bar: Skeleton) -> None:
    _, known = bar.values(np.array([8.0, 0.0]), np.array([True, False]))
    assert not known.any()


@pytest.mark.parametrize("exaggeration", [0.0, 1.0, 40.0])
def test_a_member_end_stands_where_it_was_displaced_to(bar: Skeleton, exaggeration: float) -> None:
    motion = np.random.default_rng(1).normal(size=(5, 3))
    value, known = np.array([0.0, 1e7]), np.array([True, True])
    thin, thick = structure_items(bar, motion, exaggeration, RAMP, value, known)
    assert (thin.size, thick.size) == (1.0, 3.0)
    expected = bar.node + exaggeration * motion
    np.testing.assert_array_equal(thin.points, expected[[0, 1, 1, 2, 2, 3]])
    np.testing.assert_array_equal(thick.points, expected[[3, 4]])
    np.testing.assert_array_equal(thin.colours[[0, -1]], RAMP.colours(value, known))
    np.testing.assert_array_equal(thick.colours, [GREY, GREY])


def test_members_of_a_mesh_reach_from_joint_to_joint() -> None:
    mesh = build_mesh(load_structure("oc4"))
    description = convert.reduced_model_message(_described(mesh))
    skeleton = _skeleton(convert.model_message(mesh), description, mesh)
    first, last = mesh.member_element.T
    np.testing.assert_allclose(skeleton.place[first, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(skeleton.place[last, 1], 1.0, atol=1e-12)
    np.testing.assert_array_equal(skeleton.end[first, 0], 2 * np.arange(mesh.n_members))
    assert (skeleton.end[mesh.is_tower] == -1).all()
    np.testing.assert_array_equal(skeleton.node, mesh.node_position)


def _described(mesh):
    from owt_model.contracts import ReducedDescription

    return ReducedDescription(
        "oc4", mesh.structure.content_hash, "CB00", (), np.zeros(0), np.zeros(0), mesh.end_name, -1
    )


def test_colours_at_and_beyond_the_limits() -> None:
    value = np.array([-1.0, 0.0, 1e7, 2e7])
    low, first, last, high = RAMP.colours(value, np.ones(4, dtype=bool))
    np.testing.assert_array_equal(low, first)
    np.testing.assert_array_equal(high, last)
    assert not np.allclose(first, last)
    assert not np.allclose(RAMP.colours(np.array([5e6]), np.array([True])), first)
    np.testing.assert_array_equal(RAMP.colours(np.zeros(1), np.array([False])), [GREY])


@pytest.mark.parametrize("scale", [stress_scale(5e7), damage_scale(3e-5)])
def test_the_legend_is_the_inverse_of_the_colours(scale: Scale) -> None:
    share = np.linspace(0.0, 1.0, 9)
    np.testing.assert_allclose(scale.share(scale.value(share)), share, atol=1e-12)
    assert stress_scale(4e7).share(np.array([1e7])) == pytest.approx(0.5), "colour goes by the root"


def test_damage_is_on_a_logarithmic_scale_of_four_decades() -> None:
    scale = damage_scale(2e-7)
    assert (scale.low, scale.high) == pytest.approx((1e-10, 1e-6))
    np.testing.assert_allclose(scale.share(np.array([1e-10, 1e-8, 1e-6, 0.0])), [0, 0.5, 1, 0], atol=1e-12)
    assert [text for _, text in scale.ticks] == ["1e-10", "1e-09", "1e-08", "1e-07", "1e-06"]


def test_the_scale_only_grows() -> None:
    limits = [0.0]
    for largest in (0.0, 3.1e6, 2e6, 5e6, 5.1e6, float("nan"), 4e7):
        limits.append(rising_limit(largest, limits[-1]))
    assert limits[1:] == pytest.approx([0.0, 5e6, 5e6, 5e6, 1e7, 1e7, 5e7])
    assert stress_scale(0.0).high == 1.0


def test_the_legend_names_quantity_unit_and_both_ends() -> None:
    bar, *texts = legend_items(stress_scale(2e7), 5.0, 60.0)
    assert {"0", "5", "20", "von Mises stress [MPa]"} == {item.text for item in texts}
    assert bar.points[:, 2].min() == 5.0
    assert bar.points[:, 2].max() == 60.0
    ends = stress_scale(2e7).colours(np.array([0.0, 2e7]), np.ones(2, dtype=bool))
    np.testing.assert_allclose(bar.colours[[0, -1]], ends, atol=1e-12)


def test_water_is_lighter_on_the_crests() -> None:
    trough, still, crest = sea_colours(np.array([-3.0, 0.0, 3.0]), 2.0)
    assert trough[:3].sum() < still[:3].sum() < crest[:3].sum()
    np.testing.assert_array_equal(sea_colours(np.zeros(1), 0.0), [still])
