"""The scene in the vectors of one encoder. Vectors of two encoders are never compared."""

import math
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from threading import Thread

import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8
from sceneq_core.encoding.encoder import Crop, Encoder
from sceneq_core.routing.router import Router
from sceneq_core.routing.scene import Scene
from sceneq_core.teaching.album import Album
from sceneq_nodes._look import Look
from sceneq_nodes._name_keeper import NameKeeper


class Space:
    """What reads a question, what it is compared with, and the newest picture of that."""

    def __init__(self, encoder: Encoder, router: Router, names: NameKeeper, album: Album) -> None:
        self.model = encoder.model_id
        self.router = router
        self.scene = Scene(router.labeller)
        self.album = album
        self._names = names
        self._bare = self.scene.snapshot()
        self.look = Look(self._bare, -math.inf, router.calibration)
        self._encoder = encoder

    def warm_up(self) -> None:
        """Load the text tower before a question needs it."""
        self._encoder.encode_texts(["hello"])

    def see(self, rgb: UInt8) -> Float32:
        """Return the descriptor (D,) of a picture; the first one loads the image tower.

        Raises:
            NotImplementedError: the encoder has none.
        """
        whole = Crop(rgb, np.ones(rgb.shape[:2], np.bool_))
        descriptor: Float32 = self._encoder.encode_crops([whole])[0][0]
        return descriptor

    def familiarity(self, descriptor: Float32, feature: Float32) -> float | None:
        """Return how familiar what has this feature (F,) looks to the encoder.

        ``None`` when descriptor (D,) or feature cannot be the encoder's.
        """
        if not (self.scene.accepts(descriptor) and np.isfinite(feature).all()):
            return None
        try:
            return self.router.labeller.familiarity(feature)
        except ValueError:
            return None

    def swap(self, map_arrived_s: float) -> None:
        """Answer from the scene as it is now."""
        bare = self.scene.snapshot()
        with self._names.lock:
            self._bare = bare
            named = self._names.named(bare, self.album)
            self.look = replace(self.look, snapshot=named, map_arrived_s=map_arrived_s)

    def rename(self) -> None:
        """Answer with the names as they are now; may be called from any thread."""
        with self._names.lock:
            named = self._names.named(self._bare, self.album)
            self.look = replace(self.look, snapshot=named)

    def move(self, position_world: Float64) -> None:
        """Answer from another viewpoint, (3,) metres."""
        self.scene.move_viewpoint(position_world)
        with self._names.lock:
            self._bare = replace(self._bare, viewpoint_world=position_world)
            seen = replace(self.look.snapshot, viewpoint_world=position_world)
            self.look = replace(self.look, snapshot=seen)

    def take_over(self, other: "Space") -> None:
        """Know the map and the views that ``other`` knows."""
        self.scene.take_over(other.scene)
        self.swap(other.look.map_arrived_s)

    def share_in(self, other: "Space") -> float:
        """Return the share of the instances answered with here that ``other`` can answer with.

        Where there are none, the first one of ``other`` is an advance.
        """
        here = {one.instance_id for one in self.look.snapshot.instances}
        there = {one.instance_id for one in other.look.snapshot.instances}
        return len(here & there) / len(here) if here else float(bool(there))


def in_background(make: Callable[[], Space]) -> "Future[Space]":
    """Return the space to come: loading a text tower and reading all labels takes a while.

    The thread ends with the process, whatever it is at.
    """
    made: Future[Space] = Future()

    def run() -> None:
        try:
            space = make()
            space.warm_up()
            made.set_result(space)
        except Exception as error:
            made.set_exception(error)

    Thread(target=run, name="new encoder", daemon=True).start()
    return made
