"""The end of a process: one stop event, and an exit within a second whatever a thread is doing."""

import logging
import os
import signal
import socket
import threading
from collections.abc import Callable

log = logging.getLogger(__name__)

GRACE_S = 0.7
"""What is left of the second is for leaving the network."""
LEAVE_S = 0.2


class Stop:
    """Set by SIGINT or SIGTERM.

    Python runs signal handlers only between bytecodes of the main thread, so a long computation
    would delay them. The C handler also writes the signal's number to a socket: a thread reads it,
    sets the event, and ends the process if it is still there after ``GRACE_S``.
    """

    def __init__(self, leave: Callable[[], None]) -> None:
        self.event = threading.Event()
        self._leave = leave
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)

    def install(self) -> None:
        """Listen to the signals from now on; call it on the main thread."""
        signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: self.event.set())
        threading.Thread(target=self._watch, name="stop", daemon=True).start()

    def _watch(self) -> None:
        while self._reader.recv(1)[0] not in (signal.SIGINT, signal.SIGTERM):
            continue
        self.event.set()
        threading.Event().wait(GRACE_S)
        log.warning("still at work %.1f s after the stop signal, leaving", GRACE_S)
        leaving = threading.Thread(target=self._leave, name="leave", daemon=True)
        leaving.start()
        leaving.join(LEAVE_S)
        end(0)


def end(code: int) -> None:
    """End the process now: no thread, ours or of a library, may keep it alive."""
    logging.shutdown()
    os._exit(code)
