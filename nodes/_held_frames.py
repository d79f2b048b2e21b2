"""Keyframes whose place in the scene is not known yet, in a file, oldest first."""

import logging
import tempfile
from pathlib import Path

from sceneq_core.ingest.ingestor import Ingested
from sceneq_nodes._images import frame_from_message, frame_message
from sceneq_nodes._journal import Entry, Journal
from sceneq_nodes._set_aside import COMPANIONS, StoreError
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.topics import FRAME

log = logging.getLogger(__name__)


class HeldFrames:
    """A queue on disk of ``most`` keyframes; one more, and the oldest is let go.

    The file lies in ``folder``, or among the system's temporary ones when that is ``None`` or
    cannot be written. It begins empty: what an earlier run held is in an unknown frame for good.
    """

    def __init__(self, folder: Path | None, robot: str, most: int) -> None:
        self._most = most
        self._first, self._last = 1, 0
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._journal = self._open(folder, f"held-{robot}.sqlite")

    def __len__(self) -> int:
        """Return how many wait."""
        return self._last - self._first + 1

    def add(self, frame: Ingested) -> bool:
        """Put a keyframe behind the others; tell whether the oldest was let go for it.

        Raises:
            StoreError: the disk fails.
        """
        assert frame.keyframe is not None
        self._last += 1
        message = to_bytes(FRAME, frame_message(frame.keyframe, "raw", "raw"))
        self._journal.append(Entry(self._last, frame.pose_source, message))
        is_full = len(self) > self._most
        if is_full:
            self._drop(1)
        return is_full

    def pop(self) -> Ingested:
        """Return the oldest and forget it; raise ``StoreError`` or ``DamageError``."""
        entry = next(self._journal.entries(self._first - 1))
        self._drop(1)
        frame = frame_from_message(from_bytes(FRAME, entry.first))
        return Ingested(frame.seq, frame.stamp_ns, frame.T_world_camera, entry.kind, frame)

    def close(self) -> None:
        """Delete the file."""
        self._journal.close()
        _delete(self._journal.path)
        if self._temporary is not None:
            self._temporary.cleanup()

    def _drop(self, count: int) -> None:
        self._first += count
        self._journal.drop(self._first - 1)

    def _open(self, folder: Path | None, name: str) -> Journal:
        try:
            if folder is not None:
                _delete(folder / name)
                return Journal(folder / name)
        except (StoreError, OSError) as error:
            log.warning("%s; keyframes wait among the temporary files", error)
        self._temporary = tempfile.TemporaryDirectory(prefix="sceneq-held-")
        return Journal(Path(self._temporary.name) / name)


def _delete(path: Path) -> None:
    for one in (path, *(path.with_name(path.name + companion) for companion in COMPANIONS)):
        one.unlink(missing_ok=True)
