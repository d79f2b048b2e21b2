"""What happens in a running graph: one line an event."""

import os
import sys
import time
from typing import TextIO

WIDTH = 12
COLOURS = {"good": "\x1b[32m", "warn": "\x1b[33m", "bad": "\x1b[31m"}
RESET = "\x1b[0m"


class Console:
    """Writes ``12:00:03 mapping      ready (0.9 s)`` lines, coloured on a terminal."""

    def __init__(self, stream: TextIO = sys.stdout) -> None:
        self._stream = stream
        self._coloured = stream.isatty() and "NO_COLOR" not in os.environ

    def say(self, who: str, what: str, tone: str = "") -> None:
        """Write one event of ``who``; ``tone`` is '', good, warn or bad."""
        text = " ".join(what.split())
        if self._coloured and tone:
            text = f"{COLOURS[tone]}{text}{RESET}"
        print(f"{time.strftime('%H:%M:%S')} {who:<{WIDTH}} {text}", file=self._stream, flush=True)
