"""TCP ports that nobody has."""

import contextlib
import itertools
import os
import socket

FIRST_PORT, PORTS = 20_000, 12_000
"""Below those that the system gives away by itself."""


def free_port() -> int:
    """Return a TCP port that nobody has, and that this process has not been given before.

    Not one of those that the system chooses: whoever connects might get it meanwhile.
    """
    while True:
        port = FIRST_PORT + next(_PORTS) % PORTS
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port


_PORTS = itertools.count(64 * os.getpid())
"""Processes that run side by side begin apart."""
