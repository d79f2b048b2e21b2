"""Each picture is rendered once, ahead of its time if expected, and shows the room as it is."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.rendering import Rendering
from sceneq_tools.room.room import Room
from sceneq_tools.sim.studio import Shot, Studio, perfect

from support.boxed_room import boxed_room

CAMERA = Camera(np.eye(3), (4, 3))


class Counting:
    """A renderer whose pictures say which room they show and where from."""

    def __init__(self) -> None:
        self.rendered: list[float] = []
        self.seed = 0
        self.done = threading.Semaphore(0)

    def update(self, room: Room) -> None:
        self.seed = room.seed

    def render(self, T_world_camera: Float64, camera: Camera) -> Rendering:
        self.rendered.append(float(T_world_camera[0, 3]))
        shape = camera.size[::-1]
        ids = np.full(shape, self.seed + 1, np.uint16)
        ids[0, 0] = 7
        depth_m = np.full(shape, T_world_camera[0, 3], np.float32)
        self.done.release()
        rgb = np.full((*shape, 3), self.seed, np.uint8)
        return Rendering(rgb, depth_m, ids, np.ones(shape, np.float32))


@pytest.fixture
def renderer() -> Counting:
    return Counting()


@pytest.fixture
def studio(renderer: Counting) -> Studio:
    return Studio(renderer, perfect, CAMERA, seed=0)


def shot(studio: Studio, seq: int) -> Shot:
    T_world_camera = np.eye(4)
    T_world_camera[0, 3] = seq
    return studio.shot(seq, T_world_camera)


def test_colour_and_depth_come_from_one_rendering(studio: Studio, renderer: Counting) -> None:
    frame = shot(studio, 3)
    assert not renderer.rendered
    assert (frame.read_depth_mm() == 3000).all()
    assert frame.read_rgb().shape == (3, 4, 3)
    assert renderer.rendered == [3.0]
    assert studio.newest == (3, {1: 11, 7: 1})


def test_a_change_shows_in_what_is_not_taken_yet(studio: Studio, renderer: Counting) -> None:
    taken, waiting = shot(studio, 1), shot(studio, 2)
    assert taken.read_rgb().max() == 0
    waiting.develop()
    studio.change(replace(boxed_room(), seed=5))
    assert taken.read_depth_mm()[0, 0] == 1000
    assert waiting.read_rgb().max() == 5
    assert renderer.rendered == [1.0, 2.0, 2.0]


def test_an_even_rhythm_is_rendered_ahead(studio: Studio, renderer: Counting) -> None:
    shots = [shot(studio, seq) for seq in range(30)]
    assert not renderer.rendered
    for seq in (0, 10, 20):
        shots[seq].read_rgb()
    for _ in range(3):
        renderer.done.acquire()
    later = [shot(studio, seq) for seq in range(30, 41)]
    for _ in range(2):
        assert renderer.done.acquire(timeout=30)
    assert renderer.rendered == [0, 10, 20, 30, 40]
    assert (later[0].read_depth_mm() == 30_000).all()
    assert renderer.rendered == [0, 10, 20, 30, 40]


def test_without_a_rhythm_nothing_is_rendered_in_vain(studio: Studio, renderer: Counting) -> None:
    for seq in (0, 3, 10):
        shot(studio, seq).read_rgb()
    for seq in range(11, 40):
        shot(studio, seq)
    assert not renderer.done.acquire(timeout=0) or len(renderer.rendered) == 3
    assert renderer.rendered == [0, 3, 10]
