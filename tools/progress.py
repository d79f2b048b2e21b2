"""How far long work has come: a bar on a terminal, plain lines anywhere else.

    with progress("rendering", total=200, unit="frames", quiet=quiet) as advance:
        for frame in frames:
            ...
            advance()

Everything goes to stderr, so that a command's own output can be piped.
"""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Annotated, Protocol, TextIO

import typer

LINE_EVERY_S = 10.0
LINE_EVERY_SHARE = 0.1
LINE_AT_MOST_EVERY_S = 2.0
"""Short work would write its ten lines at once."""
MINUTE_S, HOUR_S = 60, 3600

Quiet = Annotated[bool, typer.Option("--quiet", help="Do not show how far it has come.")]
"""The option of every command that takes long."""


class Advance(Protocol):
    """Says that ``n`` more are done; may be called from any thread."""

    def __call__(self, n: int = 1) -> None:
        """Add ``n`` to what is done."""


def progress(
    title: str, total: int | None, unit: str = "", quiet: bool = False
) -> AbstractContextManager[Advance]:
    """Show how far the work of a ``with`` block has come; it gets ``advance(n=1)`` to say so.

    Blocks may follow one another or lie in one another: of the inner ones no bar or line stays.

    Args:
        title: what is being done, such as "rendering".
        total: how many there are to do; None = unknown, then there is no time left to show.
        unit: what is counted, in the plural, such as "frames".
        quiet: show nothing.
    """
    if quiet:
        return nullcontext(_ignore)
    if sys.stderr.isatty() and os.environ.get("TERM") != "dumb":
        from sceneq_tools.progress_bar import bar

        return bar(title, total, unit)
    return lines(title, total, unit)


@contextmanager
def lines(
    title: str,
    total: int | None,
    unit: str = "",
    stream: TextIO | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Advance]:
    """Write a line at the start, now and then, and at the end."""
    report = Lines(title, total, unit, stream or sys.stderr, clock, nested=_Open.count > 0)
    _Open.change(1)
    report.begin()
    try:
        yield report.advance
    except BaseException:
        report.end("stopped at ")
        raise
    else:
        report.end()
    finally:
        _Open.change(-1)


class Lines:
    """Lines of one piece of work: ``rendering: 40 of 200 frames, 5.2/s, 31 s left``."""

    def __init__(
        self,
        title: str,
        total: int | None,
        unit: str,
        stream: TextIO,
        clock: Callable[[], float],
        nested: bool = False,
    ) -> None:
        self._title, self._total, self._unit = title, total, unit
        self._stream, self._clock, self._nested = stream, clock, nested
        self._done = self._written = 0
        self._start_s = self._line_s = clock()
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Say what begins; inside other work only what lasts is worth a line."""
        if not self._nested:
            unit = self._unit or "to do"
            self._write("" if self._total is None else f"{self._total} {unit}")

    def advance(self, n: int = 1) -> None:
        """Add ``n``; write a line when the last one is old or much has been done since."""
        with self._lock:
            self._done += n
            if self._is_due():
                self._written, self._line_s = self._done, self._clock()
                self._write(f"{amount(self._done, self._total, self._unit)}{self._pace()}")

    def end(self, how: str = "") -> None:
        """Say how much was done in what time."""
        took_s = self._clock() - self._start_s
        if not self._nested or took_s > LINE_EVERY_S:
            total = None if self._done == self._total else self._total
            done = amount(self._done, total, self._unit)
            self._write(f"{how}{done} in {duration(took_s)}")

    def _is_due(self) -> bool:
        quiet_s = self._clock() - self._line_s
        if quiet_s >= LINE_EVERY_S:
            return True
        share = (self._done - self._written) / self._total if self._total else 0.0
        far = share >= LINE_EVERY_SHARE and self._done != self._total
        return far and quiet_s >= LINE_AT_MOST_EVERY_S and not self._nested

    def _pace(self) -> str:
        """Return rate and time left, by the mean rate since the start."""
        elapsed_s = self._clock() - self._start_s
        if not self._done or elapsed_s <= 0:
            return ""
        per_s = self._done / elapsed_s
        left = "" if self._total is None else self._left((self._total - self._done) / per_s)
        return f", {rate(per_s)}{left}"

    def _left(self, left_s: float) -> str:
        return f", {duration(left_s)} left" if left_s > 0 else ""

    def _write(self, what: str) -> None:
        text = f"{self._title}: {what}" if what else self._title
        print(text, file=self._stream, flush=True)


def amount(done: int, total: int | None, unit: str) -> str:
    """Return ``40 of 200 frames``."""
    of = "" if total is None else f" of {total}"
    return f"{done}{of} {unit}".rstrip()


def rate(per_s: float) -> str:
    """Return ``5.2/s``, with three figures whatever the size."""
    return f"{per_s:.0f}/s" if per_s >= 100 else f"{per_s:.3g}/s"


def duration(seconds: float) -> str:
    """Return ``0.4 s``, ``31 s``, ``2 min 05 s`` or ``1 h 10 min``."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < MINUTE_S:
        return f"{whole} s"
    if whole < HOUR_S:
        return f"{whole // MINUTE_S} min {whole % MINUTE_S:02d} s"
    return f"{whole // HOUR_S} h {whole % HOUR_S // MINUTE_S:02d} min"


def _ignore(n: int = 1) -> None:
    """Nobody looks."""


class _Open:
    """How many blocks of lines are open in this process."""

    count = 0
    _lock = threading.Lock()

    @classmethod
    def change(cls, by: int) -> None:
        with cls._lock:
            cls.count += by
