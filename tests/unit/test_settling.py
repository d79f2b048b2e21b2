"""An answer to where a frame of reference lies is gone by once it stands still."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.ingest.transforms import angle_deg, inverse, transform
from sceneq_core.places.gazetteer import Gazetteer, GazetteerParams
from sceneq_core.places.place import PlaceParams, place_of
from sceneq_core.places.relocaliser import Relocaliser, RelocaliserParams, Relocation
from sceneq_core.places.settling import Settling, SettlingParams

from support.papered_recording import step_aside
from support.papered_room import PaperedRoom
from support.rigid import rigid

HERE = np.zeros(3)


def answer(count, x_m=0.0, turn_deg=0.0):
    """Return what ``count`` keyframes say."""
    T_world_odom, turn = np.eye(4), np.radians(turn_deg)
    T_world_odom[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    T_world_odom[0, 3] = x_m
    return Relocation(T_world_odom, count, 1, 50 * count, 0.9, 0.01)


def taken(*answers, **params):
    """Return which of the answers were gone by."""
    settling = Settling(SettlingParams(**params))
    return [settling.take(found, HERE) is not None for found in answers]


def test_the_first_answer_is_not_gone_by_and_the_next_like_it_is():
    assert taken(None, answer(3), answer(4, x_m=0.009)) == [False, False, True]


@pytest.mark.parametrize("off", [{"x_m": 0.011}, {"turn_deg": 0.3}])
def test_one_that_moves_is_waited_for(off):
    assert taken(answer(3), answer(4, **off), answer(5, **off)) == [False, False, True]


def test_a_keyframe_that_recognises_nothing_proves_nothing():
    assert taken(answer(3), answer(3), answer(3)) == [False, False, False]


def test_it_does_not_wait_for_ever():
    assert taken(*[answer(3)] * 4, patience=3) == [False, False, False, True]


def test_what_becomes_doubtful_begins_anew():
    assert taken(answer(3), None, answer(4), answer(5)) == [False, False, False, True]
    settling = Settling(SettlingParams())
    settling.take(answer(3), HERE)
    assert settling.sure is not None
    settling.take(None, HERE)
    assert settling.sure is None


def test_a_robot_that_turns_to_what_is_known_is_placed_by_what_it_sees_well():
    """The first keyframes show a margin of what is known, and are a degree off."""
    room, T_odom_world = PaperedRoom(), rigid(70, reach_m=2.5)
    gazetteer = Gazetteer(GazetteerParams())
    for turn in range(105, 195, 15):
        gazetteer.visit(room.frame(turn, turn, *step_aside(turn)))
    relocaliser = Relocaliser(RelocaliserParams())
    relocaliser.learn(list(gazetteer))
    settling, first, settled = Settling(SettlingParams()), None, None
    for turn in range(45, 150, 15):
        frame = room.frame(turn, turn, *step_aside(turn))
        pose = T_odom_world @ frame.T_world_camera
        found = relocaliser.see(place_of(replace(frame, T_world_camera=pose), PlaceParams()))
        first = first or found
        settled = settled or settling.take(found, pose[:3, 3])
    assert first is not None
    assert settled is not None
    truth = inverse(T_odom_world)
    assert angle_deg(settled.T_world_odom, truth) < 0.1 < angle_deg(first.T_world_odom, truth)
    cameras = np.stack([pose[:3, 3], pose[:3, 3] + 1.0])
    apart = transform(settled.T_world_odom, cameras) - transform(truth, cameras)
    assert np.linalg.norm(apart, axis=1).max() < 0.01


@pytest.mark.parametrize(
    ("field", "value"), [("steady_m", 0.0), ("steady_deg", -1.0), ("patience", 0)]
)
def test_parameters_are_checked(field, value):
    with pytest.raises(ValueError, match=field):
        SettlingParams(**{field: value})
