"""How far work has come: lines, the bar of a terminal, and silence."""

import io
import sys
import threading

import pytest
from rich.console import Console

from sceneq_tools import progress as module
from sceneq_tools.progress import amount, duration, lines, progress, rate
from sceneq_tools.progress_bar import Bars


class Clock:
    """Time that passes when told to."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def told(total: int | None, steps: int, step_s: float, unit: str = "frames") -> list[str]:
    stream, clock = io.StringIO(), Clock()
    with lines("rendering", total, unit, stream, clock) as advance:
        for _ in range(steps):
            clock.now_s += step_s
            advance()
    return stream.getvalue().splitlines()


def test_slow_work_gets_a_line_every_ten_seconds() -> None:
    assert told(100, 4, 5.0) == [
        "rendering: 100 frames",
        "rendering: 2 of 100 frames, 0.2/s, 8 min 10 s left",
        "rendering: 4 of 100 frames, 0.2/s, 8 min 00 s left",
        "rendering: 4 of 100 frames in 20 s",
    ]


def test_quicker_work_gets_a_line_every_tenth_and_quick_work_only_start_and_end() -> None:
    quicker = told(1000, 1000, 0.03)
    assert len(quicker) == 2 + 9
    assert quicker[1] == "rendering: 100 of 1000 frames, 33.3/s, 27 s left"
    assert told(1000, 1000, 0.001) == ["rendering: 1000 frames", "rendering: 1000 frames in 1.0 s"]


def test_without_a_total_there_is_no_time_left() -> None:
    assert told(None, 3, 5.0, unit="") == [
        "rendering",
        "rendering: 2, 0.2/s",
        "rendering: 3 in 15 s",
    ]


def test_what_stopped_says_where() -> None:
    stream = io.StringIO()

    def interrupted() -> None:
        with lines("map", 9, "frames", stream, Clock()) as advance:
            advance(4)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert stream.getvalue().splitlines()[-1] == "map: stopped at 4 of 9 frames in 0.0 s"


def test_inner_work_is_silent_unless_it_lasts() -> None:
    stream, clock = io.StringIO(), Clock()
    with lines("suite", 2, "rooms", stream, clock) as outer:
        for step_s in (0.1, 11.0):
            with lines("room", 1, "frames", stream, clock) as inner:
                clock.now_s += step_s
                inner()
            outer()
    assert stream.getvalue().splitlines() == [
        "suite: 2 rooms",
        "room: 1 of 1 frames, 0.0909/s",
        "room: 1 frames in 11 s",
        "suite: 2 of 2 rooms, 0.18/s",
        "suite: 2 rooms in 11 s",
    ]
    assert module._Open.count == 0


def test_no_terminal_means_lines_on_stderr(capsys: pytest.CaptureFixture[str]) -> None:
    with progress("map", 2, "frames") as advance:
        advance(2)
    assert capsys.readouterr() == ("", "map: 2 frames\nmap: 2 frames in 0.0 s\n")


def test_quiet_means_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with progress("map", 2, quiet=True) as advance:
        advance()
        advance(n=1)
    assert capsys.readouterr() == ("", "")


def test_many_threads_may_advance(capsys: pytest.CaptureFixture[str]) -> None:
    with progress("map", 800) as advance:
        threads = [
            threading.Thread(target=lambda: [advance() for _ in range(100)]) for _ in range(8)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert capsys.readouterr().err.splitlines()[-1].startswith("map: 800 in ")


def terminal() -> Console:
    return Console(file=io.StringIO(), force_terminal=True, width=100, color_system=None)


def shown(console: Console) -> str:
    return console.file.getvalue()


def test_a_terminal_shows_amount_and_rate() -> None:
    console = terminal()
    with Bars(console).bar("rendering [1]", 4, "frames") as advance:
        advance(3)
        advance()
    last = shown(console)[shown(console).rindex("rendering [1]") :]
    assert "4 of 4 frames" in last
    assert "/s" in last


def test_an_inner_bar_leaves_the_terminal_and_the_outer_one_stays() -> None:
    console = terminal()
    bars = Bars(console)
    with bars.bar("suite", 2, "rooms") as outer:
        for _ in range(2):
            with bars.bar("room", 1, "frames") as inner:
                inner()
            outer()
    ending = shown(console)[shown(console).rindex("suite") :]
    assert "2 of 2 rooms" in ending
    assert "room " not in ending
    with bars.bar("next", None, "") as advance:
        advance(7)
    assert "7" in shown(console)[shown(console).rindex("next") :]


def test_a_terminal_gets_the_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    screen.isatty = lambda: True  # type: ignore[method-assign]
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with progress("map", 1, "frames") as advance:
        advance()
    assert "1 of 1 frames" in screen.getvalue()
    assert "map: " not in screen.getvalue()


def test_wording() -> None:
    assert [amount(3, 10, "frames"), amount(3, None, ""), amount(0, 0, "x")] == [
        "3 of 10 frames",
        "3",
        "0 of 0 x",
    ]
    assert [rate(0.0123), rate(5.24), rate(12345.6)] == ["0.0123/s", "5.24/s", "12346/s"]
    assert [duration(s) for s in (0.44, 31.2, 59.7, 125, 4210)] == [
        "0.4 s",
        "31 s",
        "1 min 00 s",
        "2 min 05 s",
        "1 h 10 min",
    ]
