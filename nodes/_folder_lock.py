"""One writer of a folder of durable files at a time; the lock ends with the process."""

import fcntl
import os
from pathlib import Path

from sceneq_nodes._set_aside import StoreError

NAME = "lock"


class FolderLock:
    """Holds a folder, or what ``name`` stands for in it, until the process ends, however it does.

    Raises:
        StoreError: another process holds it.
    """

    def __init__(self, folder: Path, name: str = NAME) -> None:
        self._descriptor = os.open(folder / name, os.O_RDONLY | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._descriptor)
            raise StoreError(f"{folder}: another process writes here") from error

    def close(self) -> None:
        """Let others write."""
        os.close(self._descriptor)
