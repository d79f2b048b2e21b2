"""Where frames lie to each other: chains, time, and what a tree must refuse."""

import numpy as np
import pytest

from sceneq_core.ingest.frame_tree import (
    ExtrapolationError,
    FrameTree,
    FrameTreeParams,
    StampedTransform,
    TopologyError,
    UnconnectedError,
    UnknownFrameError,
)

S = 1_000_000_000
STRAIGHT = np.array([0.0, 0.0, 0.0, 1.0])
QUARTER_ABOUT_Z = np.array([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])


def at(stamp_s, parent, child, xyz, xyzw=STRAIGHT, static=False):
    return StampedTransform(
        round(stamp_s * S), parent, child, np.array(xyz, float), np.array(xyzw), static
    )


def tree_of(*transforms, **params):
    tree = FrameTree(FrameTreeParams(**params))
    for transform in transforms:
        tree.add(transform)
    return tree


ROBOT = (
    at(0, "map", "odom", (10, 0, 0), static=True),
    at(1, "odom", "base", (0, 0, 0)),
    at(2, "odom", "base", (2, 0, 0), QUARTER_ABOUT_Z),
    at(5, "base", "camera", (0, 0, 1), static=True),
)


def test_a_chain_through_static_and_moving_frames():
    tree = tree_of(*ROBOT)
    assert tree.lookup("map", "camera", 1 * S)[:3, 3].tolist() == [10, 0, 1]
    assert np.allclose(tree.lookup("map", "camera", 2 * S)[:3, 3], [12, 0, 1])
    assert tree.frames() == ["base", "camera", "map", "odom"]


def test_half_way_is_half_the_distance_and_half_the_turn():
    found = tree_of(*ROBOT).lookup("map", "base", 3 * S // 2)
    c = np.cos(np.pi / 4)
    assert np.allclose(found, [[c, -c, 0, 11], [c, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def test_a_turn_goes_the_shorter_way_whatever_the_sign_of_the_quaternion():
    other = tree_of(*ROBOT[:2], at(2, "odom", "base", (2, 0, 0), -QUARTER_ABOUT_Z))
    expected = tree_of(*ROBOT).lookup("odom", "base", S + S // 3)
    assert np.allclose(other.lookup("odom", "base", S + S // 3), expected)


def test_siblings_meet_in_their_common_parent():
    tree = tree_of(*ROBOT, at(0, "base", "lidar", (1, 0, 0), static=True))
    assert tree.lookup("lidar", "camera", 0)[:3, 3].tolist() == [-1, 0, 1]
    assert tree.lookup("camera", "camera", 0).tolist() == np.eye(4).tolist()


def test_a_static_transform_may_come_late_and_may_be_mended():
    tree = tree_of(*ROBOT[:3])
    with pytest.raises(UnknownFrameError, match="unknown frame 'camera'"):
        tree.lookup("map", "camera", S)
    tree.add(ROBOT[3])
    tree.add(at(7, "base", "camera", (0, 0, 2), static=True))
    assert tree.lookup("map", "camera", S)[2, 3] == 2


def test_the_name_of_an_unknown_frame_comes_with_those_known():
    with pytest.raises(UnknownFrameError, match=r"'world' \(known: base, camera, map, odom\)"):
        tree_of(*ROBOT).lookup("world", "camera", S)
    with pytest.raises(UnknownFrameError, match="known: none"):
        FrameTree().lookup("world", "camera", S)


def test_two_trees_are_not_one():
    tree = tree_of(*ROBOT, at(0, "arm", "hand", (0, 0, 0), static=True))
    with pytest.raises(UnconnectedError, match="their roots are 'map' and 'arm'"):
        tree.lookup("map", "hand", S)


def test_a_time_that_is_not_known():
    tree = tree_of(*ROBOT)
    with pytest.raises(ExtrapolationError, match=r"odom -> base: after the last .* 0\.500 s") as e:
        tree.lookup("map", "camera", 5 * S // 2)
    assert e.value.is_ahead
    with pytest.raises(ExtrapolationError, match=r"before the first .* 0\.250 s") as e:
        tree.lookup("map", "camera", 3 * S // 4)
    assert not e.value.is_ahead


def test_nothing_is_made_up_across_a_gap():
    tree = tree_of(*ROBOT, max_gap_s=0.5)
    with pytest.raises(ExtrapolationError, match=r"in a gap of the known transform by 1\.000 s"):
        tree.lookup("odom", "base", 3 * S // 2)


def test_old_motion_is_forgotten():
    tree = tree_of(*(at(t, "odom", "base", (t, 0, 0)) for t in range(30)), keep_s=10)
    assert tree.lookup("odom", "base", 19 * S)[0, 3] == 19
    with pytest.raises(ExtrapolationError, match="before the first"):
        tree.lookup("odom", "base", 18 * S)


def test_the_order_of_arrival_does_not_matter_and_a_repetition_replaces():
    tree = tree_of(*ROBOT[::-1])
    assert np.allclose(tree.lookup("map", "camera", 2 * S)[:3, 3], [12, 0, 1])
    tree.add(at(2, "odom", "base", (4, 0, 0)))
    assert tree.lookup("odom", "base", 2 * S)[0, 3] == 4


def test_circles_and_second_parents_are_refused():
    tree = tree_of(*ROBOT)
    with pytest.raises(TopologyError, match="circle: map -> camera -> base -> odom -> map"):
        tree.add(at(0, "camera", "map", (0, 0, 0)))
    with pytest.raises(TopologyError, match="circle: x -> x"):
        tree.add(at(0, "x", "x", (0, 0, 0)))
    with pytest.raises(TopologyError, match="'base' has two parents: 'odom' and 'map'"):
        tree.add(at(3, "map", "base", (0, 0, 0)))
    assert tree.lookup("map", "camera", S)[:3, 3].tolist() == [10, 0, 1]


@pytest.mark.parametrize(
    ("xyz", "xyzw", "said"),
    [
        ((np.nan, 0, 0), STRAIGHT, "translation .nan"),
        ((1e300, 0, 0), STRAIGHT, "a -> b: translation .1e.300"),
        ((0, 0, 0), np.array([0, 1e300, 0, 1]), "length"),
        ((0, 0, 0), np.zeros(4), "length 0"),
        ((0, 0, 0), np.array([0, 0, 0, 1.1]), "length 1.1"),
        ((0, 0, 0), np.array([0, 0, np.nan, 1]), "length nan"),
    ],
)
def test_what_is_no_motion_is_refused(xyz, xyzw, said):
    with pytest.raises(ValueError, match=said):
        FrameTree().add(at(0, "a", "b", xyz, xyzw))


def test_after_a_clock_that_was_set_back_only_static_frames_are_left():
    tree = tree_of(*ROBOT)
    tree.set_back(-100 * S)
    assert tree.frames() == ["base", "camera", "map", "odom"]
    with pytest.raises(UnconnectedError):
        tree.lookup("map", "camera", S)
    tree.add(at(-100, "odom", "base", (1, 0, 0)))
    assert tree.lookup("map", "camera", -100 * S)[:3, 3].tolist() == [11, 0, 1]


def test_motion_far_in_the_past_is_another_clock():
    tree = tree_of(*ROBOT)
    tree.add(at(-100, "odom", "base", (1, 0, 0)))
    assert tree.lookup("map", "camera", -100 * S)[:3, 3].tolist() == [11, 0, 1]
    with pytest.raises(ExtrapolationError, match="after the last"):
        tree.lookup("map", "camera", S)
