"""Pictures of keyframes, fetched from the node that keeps them."""

import logging
from collections import OrderedDict
from threading import Lock

from sceneq_core.arrays import UInt8
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_core.views.view import View
from sceneq_nodes._bus import Bus, QueryError, Reply
from sceneq_schemas.topics import VIEW_IMAGE

log = logging.getLogger(__name__)

TIMEOUT_S = 2.0


class UnreachableError(Exception):
    """Nobody answers for pictures right now; ask again later."""


class Keyframes:
    """Remembers the last ``capacity`` pictures; one 640x480 takes 0.9 MB. Any thread may ask."""

    def __init__(self, bus: Bus, scene: str, capacity: int) -> None:
        self._bus = bus
        self._scene = scene
        self._capacity = capacity
        self._images: OrderedDict[tuple[int, int], UInt8] = OrderedDict()
        self._skipped = 0
        self._lock = Lock()

    def image(self, view: View, *, counted: bool = True) -> UInt8 | None:
        """Return the keyframe of ``view``, uint8 (H, W, 3), or ``None`` when it is gone for good.

        ``counted``: that it is gone or damaged is somebody's loss, and counts as one.

        Raises:
            UnreachableError: the archive does not answer.
        """
        key = (view.seq, view.stamp_ns)
        with self._lock:
            if key not in self._images:
                rgb = self._fetch(view.seq, counted)
                if rgb is None:
                    return None
                self._images[key] = rgb
            self._images.move_to_end(key)
            if len(self._images) > self._capacity:
                self._images.popitem(last=False)
            return self._images[key]

    def _fetch(self, seq: int, counted: bool) -> UInt8 | None:
        try:
            return rgb_from_jpeg(self._ask(seq).payload)
        except QueryError as error:
            if error.code != "not_found":
                raise UnreachableError(str(error)) from error
            self._skip("images_gone" if counted else "", seq, error)
        except ValueError as error:
            self._skip("images_bad" if counted else "", seq, error)
        return None

    def _ask(self, seq: int) -> Reply:
        replies = self._bus.ask(
            VIEW_IMAGE, parameters={"seq": str(seq)}, timeout_s=TIMEOUT_S, scene=self._scene
        )
        if not replies:
            raise UnreachableError(f"no answer for keyframe {seq}")
        return replies[0]

    def _skip(self, counter: str, seq: int, error: Exception) -> None:
        """Count, and log the 1st, 2nd, 4th, 8th, ...: a restart of the archive skips many."""
        if not counter:
            return
        self._bus.count(counter)
        self._skipped += 1
        if self._skipped & (self._skipped - 1) == 0:
            text = "view skipped, no. %d: keyframe %d: %s"
            log.warning(text, self._skipped, seq, error)
