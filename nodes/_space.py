"""The scene in the vectors of one encoder. Vectors of two encoders are never compared."""

import math
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from threading import Thread

from sceneq_core.arrays import Float64
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.routing.router import Router
from sceneq_core.routing.scene import Scene
from sceneq_nodes._front_door import Look


class Space:
    """What reads a question, what it is compared with, and the newest picture of that."""

    def __init__(self, encoder: Encoder, router: Router) -> None:
        self.model = encoder.model_id
        self.router = router
        self.scene = Scene(router.labeller)
        self.look = Look(self.scene.snapshot(), -math.inf)
        self._encoder = encoder

    def warm_up(self) -> None:
        """Load the text tower before a question needs it."""
        self._encoder.encode_texts(["hello"])

    def swap(self, map_arrived_s: float) -> None:
        """Answer from the scene as it is now."""
        self.look = Look(self.scene.snapshot(), map_arrived_s)

    def move(self, position_world: Float64) -> None:
        """Answer from another viewpoint, (3,) metres."""
        self.scene.move_viewpoint(position_world)
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
