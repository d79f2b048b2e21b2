"""Pictures for the simulated camera: each rendered once, ahead of its time where that helps."""

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sceneq_core.arrays import Float64, UInt8, UInt16
from sceneq_core.frame import depth_to_mm
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.rendering import Rendering
from sceneq_tools.room.room import Room


class Renders(Protocol):
    """What the studio needs of a renderer; ``render`` goes on while ``update`` works."""

    def update(self, room: Room) -> None:
        """Show another room from now on."""

    def render(self, T_world_camera: Float64, camera: Camera) -> Rendering:
        """Return what a perfect camera at this pose sees."""


Measure = Callable[[Rendering, np.random.Generator], tuple[UInt8, UInt16]]
"""A sensor: rgb uint8 (H, W, 3) and depth uint16 (H, W) millimetres from perfect images."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Measured images; ``pixels``: how many of the perfect image each instance id has.

    ``edition`` counts the changes of the room before it was rendered.
    """

    rgb: UInt8
    depth_mm: UInt16
    pixels: dict[int, int]
    edition: int


class Studio:
    """Renders views of the room as it is; a change shows in every picture not taken before it.

    Whoever takes pictures at even distances, as ingest does with keyframes, finds the next one
    rendered already: shots are asked for some frames before they are due.

    Args:
        seed: of the sensor's noise, which depends on nothing else but the frame's number.
    """

    def __init__(self, renderer: Renders, measure: Measure, camera: Camera, seed: int) -> None:
        self.edition = 0
        self._renderer = renderer
        self._measure = measure
        self._camera = camera
        self._seed = seed
        self._taken: deque[tuple[int, Picture]] = deque(maxlen=3)
        self._ahead = ThreadPoolExecutor(1, thread_name_prefix="render")

    def shot(self, seq: int, T_world_camera: Float64) -> "Shot":
        """Return a frame that is due soon; begin to render it when it will probably be taken."""
        shot = Shot(self, seq, T_world_camera)
        if self._is_expected(seq):
            self._ahead.submit(shot.develop)
        return shot

    def change(self, room: Room) -> None:
        """Show ``room`` in every picture that is not taken yet."""
        self._renderer.update(room)
        self.edition += 1

    def render(self, seq: int, T_world_camera: Float64) -> Picture:
        """Return the picture of one view."""
        edition = self.edition
        rendering = self._renderer.render(T_world_camera, self._camera)
        rgb, depth_mm = self._measure(rendering, np.random.default_rng((self._seed, seq)))
        ids, counts = np.unique(rendering.instance_id, return_counts=True)
        pixels = dict(zip(ids.tolist(), counts.tolist(), strict=True))
        return Picture(rgb, depth_mm, pixels, edition)

    def took(self, seq: int, picture: Picture) -> None:
        """Note that a frame's picture left the camera."""
        self._taken.append((seq, picture))

    @property
    def newest(self) -> tuple[int, dict[int, int]]:
        """The last frame that was taken, -1 for none since the last change, and what it shows."""
        if not self._taken or self._taken[-1][1].edition != self.edition:
            return -1, {}
        seq, picture = self._taken[-1]
        return seq, picture.pixels

    def _is_expected(self, seq: int) -> bool:
        """Tell whether the frame continues the rhythm of the last pictures."""
        if len(self._taken) < 3:
            return False
        first, second, third = (taken for taken, _ in self._taken)
        gap = third - second
        return second - first == gap and (seq - third) % gap == 0


class Shot:
    """One frame of the camera; colour and depth are of one rendering, which exists on demand."""

    def __init__(self, studio: Studio, seq: int, T_world_camera: Float64) -> None:
        self.seq = seq
        self.T_world_camera = T_world_camera
        self._studio = studio
        self._picture: Picture | None = None
        self._is_taken = False
        self._developing = threading.Lock()

    def develop(self) -> None:
        """Render, unless the picture is there and shows the room as it is."""
        with self._developing:
            if self._picture is None or self._picture.edition != self._studio.edition:
                self._picture = self._studio.render(self.seq, self.T_world_camera)

    def read_rgb(self) -> UInt8:
        """Return the colour image, uint8 (H, W, 3)."""
        return self._take().rgb

    def read_depth_mm(self) -> UInt16:
        """Return the depth image, uint16 (H, W) millimetres."""
        return self._take().depth_mm

    def _take(self) -> Picture:
        """Return the picture; once taken it stays, whatever happens to the room."""
        if not self._is_taken or self._picture is None:
            self.develop()
            assert self._picture is not None
            self._is_taken = True
            self._studio.took(self.seq, self._picture)
        return self._picture


def perfect(rendering: Rendering, _: np.random.Generator) -> tuple[UInt8, UInt16]:
    """Return the images of a sensor without fault; depth in whole millimetres."""
    return rendering.rgb, depth_to_mm(rendering.depth_m)
