"""Wherever the camera goes: through free space, at the pace, as a rigid motion, repeatably."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.ingest.transforms import rigid_defect
from sceneq_tools.room.camera.camera_path import camera_path, coverage
from sceneq_tools.room.camera.floor_plan import FloorPlan
from sceneq_tools.room.camera.pace import Pace
from sceneq_tools.room.room import Room

from support.boxed_room import boxed_room

RATE_HZ = 10.0
few = settings(max_examples=8, deadline=None)
seeds = st.integers(0, 2**32 - 1)
rooms = st.builds(boxed_room, width=st.floats(4.2, 8.0), depth=st.floats(3.4, 7.0))


@few
@given(rooms, seeds)
def test_it_keeps_off_furniture_and_walls(room: Room, seed: int) -> None:
    poses = camera_path(room, 150, RATE_HZ, seed)
    clear_m = FloorPlan(room).clear_m(np.array([T[:2, 3] for T in poses]))
    assert clear_m.min() > 0.1
    heights = [T[2, 3] for T in poses]
    assert 1.0 < min(heights) <= max(heights) < 1.8


@few
@given(rooms, seeds, st.floats(0.5, 1.2), st.floats(40.0, 90.0))
def test_it_keeps_to_the_pace(room: Room, seed: int, walk_m_s: float, turn_deg_s: float) -> None:
    poses = camera_path(room, 120, RATE_HZ, seed, Pace(walk_m_s, turn_deg_s))
    for a, b in pairwise(poses):
        assert np.linalg.norm(b[:3, 3] - a[:3, 3]) * RATE_HZ <= walk_m_s
        turned = np.linalg.norm(cv2.Rodrigues(a[:3, :3].T @ b[:3, :3])[0])
        assert np.degrees(turned) * RATE_HZ <= turn_deg_s


@few
@given(rooms, seeds)
def test_poses_are_rigid_and_the_camera_is_held_upright(room: Room, seed: int) -> None:
    for T_world_camera in camera_path(room, 60, RATE_HZ, seed):
        assert rigid_defect(T_world_camera) is None
        right, down = T_world_camera[:3, 0], T_world_camera[:3, 1]
        assert abs(right[2]) < 0.06
        assert down[2] < -0.5


@few
@given(seeds)
def test_the_speed_changes_gradually(seed: int) -> None:
    rate_hz = 100.0
    places = np.array([T[:3, 3] for T in camera_path(boxed_room(), 1500, rate_hz, seed)])
    acceleration = np.linalg.norm(np.diff(places, n=2, axis=0), axis=1) * rate_hz**2
    assert acceleration.max() < 6.0  # m/s^2; a stop from 0.9 m/s between two frames is 90


@few
@given(seeds, st.integers(1, 40))
def test_equal_arguments_give_equal_paths_and_a_short_one_begins_a_long_one(
    seed: int, frames: int
) -> None:
    room = boxed_room()
    long, short = camera_path(room, 45, 8.0, seed), camera_path(room, frames, 8.0, seed)
    assert (np.array(short) == np.array(long[:frames])).all()


@pytest.mark.parametrize("seed", range(3))
def test_a_minute_shows_everything_that_can_be_seen(seed: int) -> None:
    room = boxed_room(6.0, 5.0)
    seen = coverage(room, camera_path(room, 600, RATE_HZ, seed))
    assert set(seen.visible) >= {6, 7, 8, 9, 10, 11, 12}
    assert seen.share == 1.0


def test_another_seed_is_another_path() -> None:
    room = boxed_room()
    a, b = (np.array(camera_path(room, 60, RATE_HZ, seed)) for seed in (1, 2))
    assert np.abs(a - b).max() > 0.1
