"""What a visit holds on its way into the map, and what is left of it whenever that is cut short."""

import os

import numpy as np
import pytest

from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.ingest.transforms import nearest_rigid
from sceneq_core.places.relocaliser import Relocaliser, RelocaliserParams
from sceneq_core.places.visit import Visit
from sceneq_core.visits import seq_in_scene
from sceneq_nodes._held_files import Caller, held_files
from sceneq_nodes._held_frames import HeldFrames
from sceneq_nodes._left_visits import LeftVisits
from sceneq_nodes._submap import Submap

from support.fake_bus import CONTEXT, FakeBus
from support.papered_room import PaperedRoom
from support.rigid import rigid

ROOM = PaperedRoom(size=(64, 48), focal_px=52.0)
T_WORLD_ODOM = rigid(3)
VISIT = Visit(2, "r2", "", 0, 5, 7, T_WORLD_ODOM)


def keyframe(seq, corrected=None):
    frame = ROOM.frame(seq, 20.0 * seq)
    return Ingested(seq, frame.stamp_ns, frame.T_world_camera, "given", frame, corrected or {})


def submap_in(folder, *frames):
    held = HeldFrames.of(Caller.of(VISIT), folder, 9)
    submap = Submap(VISIT, held, Relocaliser(RelocaliserParams()))
    for frame in frames:
        submap.hold(frame)
    return submap


def left_in(folder, robot, quiet_s=0.0):
    return LeftVisits(folder, robot, 9, quiet_s, FakeBus(CONTEXT))


def taken(left):
    left.find(lambda caller: VISIT, lambda: Relocaliser(RelocaliserParams()), None)
    return [len(submap.held) for submap in left]


def test_keyframes_go_at_the_poses_known_best_and_are_held_until_acknowledged(tmp_path):
    better = ROOM.frame(0, 3.0).T_world_camera
    submap_in(tmp_path, keyframe(0), keyframe(1, {0: better})).held.close()
    submap = submap_in(tmp_path)  # the next process
    first, second = submap.next(), submap.next()
    assert (first.seq, second.seq) == (seq_in_scene(2, 0), seq_in_scene(2, 1))
    assert np.array_equal(first.T_world_camera, nearest_rigid(T_WORLD_ODOM @ better))
    assert np.array_equal(first.keyframe.T_world_camera, first.T_world_camera)
    assert submap.next() is None
    assert not submap.is_releasing
    submap.acknowledge(first.seq)
    assert not submap.is_over
    submap.held.close()
    again = submap_in(tmp_path)
    assert again.next().seq == second.seq
    again.acknowledge(second.seq)
    assert again.is_over
    again.held.close()
    assert list(tmp_path.iterdir()) == []


def test_what_becomes_known_of_poses_meanwhile_comes_with_the_next_one(tmp_path):
    submap = submap_in(tmp_path, keyframe(0), keyframe(1))
    first, better = submap.next(), ROOM.frame(0, 3.0).T_world_camera
    submap.hold(keyframe(2, {0: better, 1: better}))
    second, third = submap.next(), submap.next()
    assert list(second.corrected) == [first.seq]
    assert np.array_equal(second.corrected[first.seq], nearest_rigid(T_WORLD_ODOM @ better))
    assert np.array_equal(second.T_world_camera, nearest_rigid(T_WORLD_ODOM @ better))
    assert third.corrected == {}
    submap.held.close()


def test_what_nobody_acknowledges_goes_again_at_the_next_start(tmp_path):
    submap = submap_in(tmp_path, keyframe(0))
    submap.give_up(submap.next().seq)
    assert submap.is_over
    submap.held.close()
    again = submap_in(tmp_path)
    assert again.next().seq == seq_in_scene(2, 0)
    again.held.close()


def test_one_ingest_takes_a_visit_that_was_left(tmp_path):
    submap_in(tmp_path, keyframe(0), keyframe(1)).held.close()
    one, other = left_in(tmp_path, "r1"), left_in(tmp_path, "r3")
    assert (taken(one), taken(other)) == ([2], [])
    one.close()
    assert taken(other) == [2]
    other.close()


@pytest.mark.parametrize(("robot", "expected"), [("r1", []), ("r2", [1])])
def test_another_robots_is_left_to_it_for_a_while(tmp_path, robot, expected):
    submap_in(tmp_path, keyframe(0)).held.close()
    left = left_in(tmp_path, robot, quiet_s=60.0)
    assert taken(left) == expected
    left.close()


def test_the_oldest_visits_give_way(tmp_path):
    for number in range(4):
        held = HeldFrames.of(Caller("r2", number, 0, 0), tmp_path, 9)
        held.add(keyframe(0))
        held.close()
        os.utime(held.path, (number, number))
    left = left_in(tmp_path, "r1")
    left.let_go_of_old(2)
    assert len(held_files(tmp_path)) == 2
    assert left._bus.counters["visits_let_go"] == 2
