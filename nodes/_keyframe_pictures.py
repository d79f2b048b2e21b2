"""Keyframes for a reasoner, fetched from the node that keeps them when they are looked at."""

import logging

from sceneq_core.arrays import UInt8
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_nodes._bus import Bus, QueryError
from sceneq_schemas.topics import VIEW_IMAGE

log = logging.getLogger(__name__)

LONGEST_WAIT_S = 2.0
"""A keyframe comes in milliseconds or not at all; the model needs the rest of the time."""


class KeyframePictures:
    """The pictures of a scene; safe to call from several threads."""

    def __init__(self, bus: Bus, scene: str) -> None:
        self._bus = bus
        self._scene = scene

    def __call__(self, seq: int, timeout_s: float) -> UInt8 | None:
        """Return the keyframe, uint8 (H, W, 3), or ``None`` when it cannot be had, which counts."""
        try:
            replies = self._bus.ask(
                VIEW_IMAGE,
                parameters={"seq": str(seq)},
                timeout_s=min(timeout_s, LONGEST_WAIT_S),
                scene=self._scene,
            )
            if replies:
                return rgb_from_jpeg(replies[0].payload)
            self._miss(seq, "no answer")
        except (QueryError, ValueError) as error:
            self._miss(seq, str(error))
        return None

    def _miss(self, seq: int, why: str) -> None:
        self._bus.count("pictures_missing")
        log.warning("keyframe %d is not to be had: %s", seq, why)
