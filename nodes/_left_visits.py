"""Visits of earlier runs and of robots that have gone, which wait until the map knows their place.

Each is a file in the scene's folder (_held_frames). Whoever plays a source in the scene takes them
along: as the map grows they are looked at again, and what is recognised goes into the map.
"""

import logging
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from sceneq_core.places.relocaliser import Relocaliser
from sceneq_core.places.visit import Visit
from sceneq_nodes._bus import Bus
from sceneq_nodes._held_files import Caller, delete_held, held_files, put_away, touched_s
from sceneq_nodes._held_frames import HeldFrames
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._submap import Submap

log = logging.getLogger(__name__)


class LeftVisits:
    """The visits left in ``folder``, as far as nobody else has them.

    ``most`` keyframes each. Those of ``robot`` are taken at once, those of others when nobody has
    written to them for ``quiet_s``: their ingest may be on its way back.
    """

    def __init__(
        self, folder: Path | None, robot: str, most: int, quiet_s: float, bus: Bus
    ) -> None:
        self._folder, self._robot, self._most = folder, robot, most
        self._quiet_s = quiet_s
        self._bus = bus
        self._submaps: dict[Path, Submap] = {}
        self._refused: set[Path] = set()

    def __iter__(self) -> Iterator[Submap]:
        """Yield them, the one last written to first."""
        return iter(list(self._submaps.values()))

    def find(
        self,
        register: Callable[[Caller], Visit | None],
        recognise: Callable[[], Relocaliser],
        own: Path | None,
    ) -> None:
        """Take what is there and not the visit's ``own``."""
        if self._folder is None:
            return
        for path in held_files(self._folder):
            if path not in self._submaps and path != own and self._is_left(path):
                self._take(path, register, recognise)

    def let_go_of_old(self, most: int) -> None:
        """Delete the visits beyond the ``most`` that were written to last, unless in use."""
        for path in held_files(self._folder)[most:] if self._folder else []:
            if path in self._submaps:
                self._close(path)
            try:
                held = HeldFrames(path, self._most)
                count = len(held)
                held.close()
                delete_held(path)
            except (StoreError, DamageError, OSError) as error:
                log.debug("%s", error)  # in use, or not to be had
                continue
            self._bus.count("visits_let_go")
            log.warning("%s: %d keyframes never found their place", path, count)

    def drop_finished(self) -> None:
        """Close those that are in the map."""
        for path, submap in list(self._submaps.items()):
            if submap.is_over:
                self._close(path)

    def set_aside(self, submap: Submap, error: Exception) -> None:
        """Put a visit away that cannot be read."""
        self._bus.count("frames_lost", len(submap.held))
        self._close(submap.held.path)
        put_away(submap.held.path, error)

    def close(self) -> None:
        """Leave all to the next one who comes."""
        for path in list(self._submaps):
            self._close(path)

    def _is_left(self, path: Path) -> bool:
        if path in self._refused:
            return False
        is_own = path.name.startswith(f"held-{self._robot}-")
        return is_own or time.time() - touched_s(path) >= self._quiet_s

    def _take(
        self,
        path: Path,
        register: Callable[[Caller], Visit | None],
        recognise: Callable[[], Relocaliser],
    ) -> None:
        try:
            held = HeldFrames(path, self._most)
        except StoreError as error:
            log.debug("%s", error)  # somebody else has it
            return
        except DamageError as error:
            put_away(path, error)
            return
        visit = register(held.caller) if len(held) else None
        if visit is None:
            held.close()
            return
        log.info("visit %d of %s: %d keyframes wait", visit.number, visit.robot, len(held))
        self._submaps[path] = Submap(visit, held, recognise())

    def _close(self, path: Path) -> None:
        try:
            self._submaps.pop(path).held.close()
        except (StoreError, OSError) as error:
            log.warning("%s", error)
        if path.exists():
            self._refused.add(path)
