"""What a keyframe shows is found by looking up the voxel of every pixel."""

import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.views.place import NO_PLACE, Places

from support.room import Room
from support.true_map import TrueMap, delta, frame_of, voxels

VOXEL_M = 0.1


def facing_wall(depth_m: np.ndarray) -> Frame:
    """Return a frame whose pixel (0, 0) at 1 m shows world (0.05, 0.05, 1), inside a voxel."""
    K = np.array([[100.0, 0, -5], [0, 100, -5], [0, 0, 1]])
    rgb = np.zeros((*depth_m.shape, 3), np.uint8)
    return Frame(0, 0, rgb, depth_m.astype(np.float32), K, np.eye(4))


def test_every_pixel_of_a_mapped_frame_shows_its_thing():
    frame, things = frame_of(Room(), 2, 5)
    replica, places, true_map = MapReplica(), Places(), TrueMap()
    change = true_map.integrate(frame, things)
    replica.apply(change)
    places.learn(change.voxel_id, change.voxel_coord)
    shown = places.instance_of_place(replica)[places.render(frame, change.voxel_size_m)]
    assert shown.shape == (60, 80)
    truth = things[::2, ::2]
    wrong = (shown > 0) & (shown != truth)
    assert np.mean(shown[truth > 0] == truth[truth > 0]) > 0.9
    assert wrong.mean() < 0.02
    assert (shown[truth == 0] == 0).all()


def test_pixels_without_depth_or_voxel_show_nothing():
    places = Places()
    places.learn(np.array([5], np.int32), np.array([[0, 0, 10]], np.int32))
    depth_m = np.zeros((4, 4))
    depth_m[0, 0], depth_m[2, 2] = 1.05, 3.0
    place = places.render(facing_wall(depth_m), VOXEL_M)
    assert place.dtype == np.int32
    assert place.tolist() == [[0, NO_PLACE], [NO_PLACE, NO_PLACE]]


def test_the_voxel_beyond_the_nearest_face_stands_in():
    places = Places()
    places.learn(np.array([0], np.int32), np.array([[0, 0, 10]], np.int32))
    near, far = np.full((1, 1), 1.11), np.full((1, 1), 1.19)
    assert places.render(facing_wall(near), VOXEL_M).tolist() == [[0]]
    assert places.render(facing_wall(far), VOXEL_M).tolist() == [[NO_PLACE]]


def test_places_outlive_voxel_ids():
    replica, places = MapReplica(), Places()
    replica.apply(delta(**voxels(range(3), (0, 1, 2))))
    places.learn(np.arange(3, dtype=np.int32), replica.voxel_coord)
    assert len(places) == 3
    places.forget_voxels()
    places.learn(np.arange(3, dtype=np.int32), replica.voxel_coord[::-1].copy())
    assert len(places) == 3


def test_points_too_far_to_number_show_nothing():
    frame = facing_wall(np.full((2, 2), 60.0))
    far_away = np.eye(4)
    far_away[0, 3] = 1e7
    moved = Frame(0, 0, frame.rgb, frame.depth_m, frame.K, far_away)
    assert Places().render(moved, VOXEL_M).tolist() == [[NO_PLACE]]


def test_there_is_nothing_to_see_before_the_map():
    with pytest.raises(ValueError, match="no map"):
        Places().render(facing_wall(np.ones((2, 2))), 0.0)
