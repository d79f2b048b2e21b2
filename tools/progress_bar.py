"""The bar of ``progress`` on a terminal; loads rich."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from sceneq_tools.progress import Advance, amount, rate

BAR_COLUMNS = 28


class _Amount(ProgressColumn):
    """``40 of 200 frames``."""

    def render(self, task: Task) -> Text:
        total = None if task.total is None else int(task.total)
        return Text(amount(int(task.completed), total, task.fields["unit"]))


class _Rate(ProgressColumn):
    """Units a second, of late; over everything when it is finished."""

    def render(self, task: Task) -> Text:
        per_s = task.finished_speed or task.speed
        return Text("" if per_s is None else rate(per_s))


class _Time(ProgressColumn):
    """Time left while it runs, time taken afterwards."""

    def __init__(self) -> None:
        super().__init__()
        self._left, self._taken = TimeRemainingColumn(compact=True), TimeElapsedColumn()

    def render(self, task: Task) -> Text:
        known = task.total is not None and not task.finished
        return self._left.render(task) + " left" if known else self._taken.render(task)


class Bars:
    """All bars of the process, one below the other: two displays would fight over the screen."""

    def __init__(self, console: Console | None = None) -> None:
        self._console = console
        self._display: Progress | None = None
        self._open = 0
        self._lock = threading.Lock()

    @contextmanager
    def bar(self, title: str, total: int | None, unit: str) -> Iterator[Advance]:
        """Show a bar; it stays on the screen unless it lies inside another one."""
        display, task = self._add(title, total, unit)

        def advance(n: int = 1) -> None:
            display.advance(task, n)

        try:
            yield advance
        finally:
            self._remove(task)

    def _add(self, title: str, total: int | None, unit: str) -> tuple[Progress, TaskID]:
        with self._lock:
            if self._display is None:
                self._display = _display(self._console or Console(stderr=True))
                self._display.start()
            self._open += 1
            return self._display, self._display.add_task(title, total=total, unit=unit)

    def _remove(self, task: TaskID) -> None:
        with self._lock:
            display = self._display
            if display is None:
                return
            self._open -= 1
            if self._open:
                display.remove_task(task)
                return
            self._display = None
            display.stop_task(task)
            display.stop()


def _display(console: Console) -> Progress:
    title = TextColumn("{task.description}", markup=False)
    columns = title, BarColumn(BAR_COLUMNS), _Amount(), _Rate(), _Time()
    return Progress(*columns, console=console)


bar = Bars().bar
