"""Where a frame of reference lies: found in rooms that can tell, and in no others."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from sceneq_core.ingest.transforms import angle_deg, inverse, transform
from sceneq_core.places.gazetteer import Gazetteer, GazetteerParams
from sceneq_core.places.place import PlaceParams, place_of
from sceneq_core.places.relocaliser import Relocaliser, RelocaliserParams, Relocation

from support.papered_room import PaperedRoom
from support.rigid import rigid

MAPPED = (0, 10, 0.0, 36.0)
BACK = (100, 4, 17.0, 36.0)


@lru_cache(maxsize=4)
def atlas(room):
    """Return the places of a walk all round the room."""
    gazetteer = Gazetteer(GazetteerParams())
    for frame in room.walk(*MAPPED):
        gazetteer.visit(frame)
    return list(gazetteer)


def come_back(room, frames, T_odom_world, **params) -> tuple[Relocation | None, Relocaliser]:
    """Show frames whose poses are in another frame of reference to who knows the room."""
    relocaliser = Relocaliser(RelocaliserParams(**params))
    relocaliser.learn(atlas(room))
    found = None
    for frame in frames:
        pose = T_odom_world @ frame.T_world_camera
        found = relocaliser.see(place_of(replace(frame, T_world_camera=pose), PlaceParams()))
    return found, relocaliser


def test_a_known_motion_is_found_within_two_centimetres():
    room = PaperedRoom()
    T_odom_world = rigid(1, reach_m=5.0)
    frames = room.walk(*BACK)
    found, _ = come_back(room, frames, T_odom_world)
    assert found is not None
    truth = inverse(T_odom_world)
    cameras = np.stack([(T_odom_world @ f.T_world_camera)[:3, 3] for f in frames])
    apart = transform(found.T_world_odom, cameras) - transform(truth, cameras)
    assert np.linalg.norm(apart, axis=1).max() < 0.02
    assert angle_deg(found.T_world_odom, truth) < 0.5
    assert found.keyframes >= 3
    assert found.spread_m < 0.03


def test_the_same_frames_give_the_same_bits():
    room, T_odom_world = PaperedRoom(), rigid(3, reach_m=1.0)
    frames = room.walk(*BACK)[:3]
    one, other = (come_back(room, frames, T_odom_world)[0] for _ in range(2))
    assert one is not None
    assert np.array_equal(one.T_world_odom, other.T_world_odom)


def test_another_room_is_not_taken_for_this_one():
    found, relocaliser = come_back(PaperedRoom(), PaperedRoom(seed=5).walk(*BACK), np.eye(4))
    assert found is None
    assert relocaliser.standing.agreeing < 2


def test_a_room_that_looks_the_same_from_both_sides_is_ambiguous():
    room = PaperedRoom(is_symmetric=True)
    found, relocaliser = come_back(room, room.walk(*BACK), np.eye(4))
    assert found is None
    assert relocaliser.standing.rivals >= 0.5 * relocaliser.standing.agreeing > 0


def test_bare_walls_tell_nothing():
    room = PaperedRoom(is_plain=True)
    found, relocaliser = come_back(room, room.walk(*BACK), np.eye(4))
    assert found is None
    assert relocaliser.standing.seen == 4


def test_one_keyframe_alone_is_not_believed():
    room = PaperedRoom()
    found, relocaliser = come_back(room, room.walk(*BACK)[:1], np.eye(4))
    assert found is None
    assert relocaliser.standing.recognised == 1


def test_places_that_moved_are_known_at_their_new_poses():
    room, T_new_old = PaperedRoom(), rigid(4, reach_m=1.0)
    relocaliser = Relocaliser(RelocaliserParams())
    relocaliser.learn(atlas(room))
    relocaliser.learn([place.at(T_new_old @ place.T_world_camera) for place in atlas(room)])
    for frame in room.walk(*BACK):
        found = relocaliser.see(place_of(frame, PlaceParams()))
    assert found is not None
    assert angle_deg(found.T_world_odom, T_new_old) < 0.5


@pytest.mark.parametrize(
    ("field", "value"),
    [("min_keyframes", 0), ("near_m", 0.0), ("near_deg", -1.0), ("rival_share", 1.0)],
)
def test_parameters_are_checked(field, value):
    with pytest.raises(ValueError, match=field):
        RelocaliserParams(**{field: value})
