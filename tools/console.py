"""What happens in a running graph: one line an event."""

import os
import sys
import time
from collections.abc import Callable
from typing import TextIO

WIDTH = 12
COLOURS = {"good": "\x1b[32m", "warn": "\x1b[33m", "bad": "\x1b[31m"}
RESET = "\x1b[0m"


class Console:
    """Writes ``12:00:03 mapping      ready (0.9 s)`` lines, coloured on a terminal."""

    def __init__(self, stream: TextIO = sys.stdout) -> None:
        self._stream = stream
        self._paint = coloured(stream)

    def say(self, who: str, what: str, tone: str = "") -> None:
        """Write one event of ``who``; ``tone`` is '', good, warn or bad."""
        text = self._paint(" ".join(what.split()), tone)
        print(f"{time.strftime('%H:%M:%S')} {who:<{WIDTH}} {text}", file=self._stream, flush=True)


def coloured(stream: TextIO) -> Callable[[str, str], str]:
    """Return what paints a text in a tone ('', good, warn, bad) for ``stream``."""
    shown = stream.isatty() and "NO_COLOR" not in os.environ

    def paint(text: str, tone: str) -> str:
        return f"{COLOURS[tone]}{text}{RESET}" if shown and tone else text

    return paint
