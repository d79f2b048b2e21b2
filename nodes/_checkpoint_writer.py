"""Writes checkpoints beside the work, seldom enough not to hold it up."""

import os
import threading
import time

from sceneq_core.state import State
from sceneq_nodes._checkpoints import Checkpoints

NICE = 10
"""How much the writing thread yields to the mapping of this and other processes."""


class CheckpointWriter:
    """One checkpoint at a time, on a thread of its own.

    Args:
        checkpoints: where they go.
        keep: how many stay.
        share: of the time that writing may take; the pause after each is as long as that asks for.
    """

    def __init__(self, checkpoints: Checkpoints, keep: int, share: float) -> None:
        self._checkpoints = checkpoints
        self._keep = keep
        self._share = share
        self._thread: threading.Thread | None = None
        self._error: OSError | None = None
        self._rest_until_s = 0.0
        self.oldest = 0
        """Position of the oldest checkpoint kept, 0 = none."""

    def is_free(self) -> bool:
        """Tell whether the last one is written and its pause is over."""
        return not self._at_work() and time.monotonic() >= self._rest_until_s

    def start(self, position: int, state: State) -> None:
        """Write ``state``; ask ``finished`` for what came of it."""
        self._thread = threading.Thread(
            target=self._write, args=(position, state), name="checkpoint", daemon=True
        )
        self._thread.start()

    def finished(self) -> bool:
        """Return whether a checkpoint has been written since the last call.

        Raises:
            OSError: it could not be written.
        """
        if self._thread is None or self._at_work():
            return False
        self._thread = None
        error, self._error = self._error, None
        if error is not None:
            raise error
        return True

    def wait(self) -> None:
        """Wait for the one being written."""
        if self._thread is not None:
            self._thread.join()

    def _at_work(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def _write(self, position: int, state: State) -> None:
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)
        try:
            self._checkpoints.write(position, state)
            self._checkpoints.keep_newest(self._keep)
            self.oldest = self._checkpoints.newest_first()[-1].position
        except OSError as error:
            self._error = error
        worked_s = time.thread_time()  # not the clock's: the thread gives way to others
        self._rest_until_s = time.monotonic() + worked_s * (1 / self._share - 1)
