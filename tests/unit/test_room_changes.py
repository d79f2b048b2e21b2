from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.ingest.source import Camera
from sceneq_tools.room.layout.changes import changing_room, in_view, there_and_back

from support.boxed_room import boxed_room, placed

CAMERA = Camera(np.array([[50.0, 0, 31.5], [0, 50.0, 23.5], [0, 0, 1]]), (64, 48))


def looking(x: float, y: float, yaw: float) -> np.ndarray:
    """A camera 1 m up that looks level along ``yaw``."""
    forward = np.array([np.cos(yaw), np.sin(yaw), 0])
    T_world_camera = np.eye(4)
    T_world_camera[:3, 2], T_world_camera[:3, 1] = forward, [0, 0, -1]
    T_world_camera[:3, 0] = np.cross([0, 0, -1], forward)
    T_world_camera[:3, 3] = (x, y, 1.0)
    return T_world_camera


def test_there_and_back_shows_everything_twice() -> None:
    path = [np.eye(4) * k for k in range(3)]
    assert [int(T[0, 0]) for T in there_and_back(path)] == [0, 1, 2, 2, 1, 0]


def test_a_view_ends_at_its_edges_and_at_small_things_reach() -> None:
    points = np.array([[2.0, 0, 1.0], [2.0, 1.8, 1.0], [-2.0, 0, 1.0], [9.0, 0, 1.0]])
    seen = in_view(points, [looking(0, 0, 0.0), looking(0, 0, np.pi)], CAMERA)
    assert seen.tolist() == [[True, False, False, False], [False, False, True, False]]


def test_the_room_changes_while_nobody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    room = boxed_room()
    mug = replace(room.thing(8), T_world_thing=placed(4.6, 1.4, 0.74))
    moved = replace(room, things=(*(t for t in room.things if t.id != 8), mug))
    stand_in = lambda *_: (moved, ["the mug was moved"])  # noqa: E731
    monkeypatch.setattr("sceneq_tools.room.layout.edits.random_changes", stand_in)
    turns = [*np.linspace(0, np.pi, 10), *np.linspace(np.pi, 0, 10)]
    poses = [looking(3.0, 1.2, turn) for turn in turns]
    before, after = changing_room(room, None, poses, CAMERA, np.random.default_rng(0), 1)
    seen = in_view(np.array([[4.5, 1.1, 0.8], [4.6, 1.4, 0.8]]), poses, CAMERA).any(1)
    assert (before.first, before.room, after.room) == (0, room, moved)
    assert after.changes == ("the mug was moved",)
    assert not seen[after.first - 1 : after.first + 1].any()
    assert seen[: after.first].any()
    assert seen[after.first :].any()
