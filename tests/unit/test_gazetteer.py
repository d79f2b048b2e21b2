"""The places of a map: one of each part of the way, bounded, durable."""

import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.mapping.correction import Correction
from sceneq_core.places.gazetteer import Gazetteer, GazetteerParams
from sceneq_core.places.place import PlaceParams, place_of
from sceneq_core.state import build, take_apart

from support.papered_room import PaperedRoom

K = np.array([[100.0, 0, 39.5], [0, 100.0, 29.5], [0, 0, 1]])


def at(seq, x, y=0.0):
    pose = np.eye(4)
    pose[:2, 3] = x, y
    rgb = np.full((60, 80, 3), seq % 200, np.uint8)
    return Frame(seq, seq, rgb, np.full((60, 80), 2.0, np.float32), K, pose)


def gazetteer(*frames, **params):
    made = Gazetteer(GazetteerParams(**params))
    for frame in frames:
        made.visit(frame)
    return made


def test_going_there_again_makes_no_place():
    made = gazetteer(at(0, 0.0), at(1, 0.2), at(2, 0.5), at(3, 0.55), at(4, 0.0))
    assert [place.seq for place in made] == [0, 2]
    assert made.revision == 2


def test_looking_elsewhere_from_there_does():
    turned = at(1, 0.0)
    angle = np.radians(30)
    turned.T_world_camera[:2, :2] = [
        [np.cos(angle), -np.sin(angle)],
        [np.sin(angle), np.cos(angle)],
    ]
    assert len(gazetteer(at(0, 0.0), turned)) == 2


def test_beyond_the_limit_the_most_needless_goes():
    made = gazetteer(at(0, 0.0), at(1, 5.0), at(2, 0.5), at(3, 10.0), most=3)
    assert [place.seq for place in made] == [0, 1, 3]


def test_places_move_with_their_keyframes():
    made = gazetteer(at(0, 0.0), at(1, 1.0))
    pose = np.eye(4)
    pose[0, 3] = 3.0
    made.correct(Correction(np.array([1, 9]), np.stack([pose, pose])))
    assert [place.T_world_camera[0, 3] for place in made] == [0.0, 3.0]
    assert made.revision == 3


def test_they_come_back_from_a_state():
    made = gazetteer(at(0, 0.0), at(1, 1.0))
    again = build(take_apart(made))
    again.visit(at(2, 2.0))
    assert [place.seq for place in again] == [0, 1, 2]
    assert [p.jpeg for p in again][:2] == [p.jpeg for p in made]


def test_a_place_is_small_and_shows_what_the_camera_saw():
    frame = PaperedRoom(size=(640, 480), focal_px=520.0).frame(7, 20.0)
    place = place_of(frame, PlaceParams())
    assert place.grey().shape == (360, 480)
    assert len(place.jpeg) + place.depth_mm.nbytes < 120_000
    x, y, z = place.K[0, 2], place.K[1, 2], place.K[0, 0]
    # The middle of the picture stays the middle, and the field of view the same.
    assert (x, y) == (239.5, 179.5)
    assert z == pytest.approx(520.0 * 0.75)


def test_what_is_no_picture_is_refused():
    place = place_of(at(0, 0.0), PlaceParams())
    with pytest.raises(ValueError, match="place 0 is no JPEG"):
        type(place)(0, place.T_world_camera, b"no", K, place.depth_mm, K).grey()
