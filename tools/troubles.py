"""Warnings and errors in the logs of nodes, forwarded without flooding."""

import json
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from sceneq_tools.console import Console
from sceneq_tools.log_tail import LogTail

TROUBLE = re.compile(r"\b(WARNING|ERROR|CRITICAL)\b")
NUMBER = re.compile(r"[0-9]+")


class Troubles:
    """Follows one log file per node.

    Lines that differ only in their numbers are shown the 1st, 2nd, 4th, 8th, ... time; the log has
    them all.
    """

    def __init__(self, logs: Path, names: Iterable[str], console: Console) -> None:
        self._console = console
        self._tails = {name: LogTail(logs / f"{name}.log") for name in names}
        self._seen: Counter[tuple[str, str]] = Counter()

    def forward(self) -> None:
        """Show what is new."""
        for name, tail in self._tails.items():
            for line in tail.new_lines():
                if said := trouble(name, line):
                    self._show(name, *said)

    def close(self) -> None:
        """Let the files go."""
        for tail in self._tails.values():
            tail.close()

    def _show(self, name: str, level: str, text: str) -> None:
        kind = (name, NUMBER.sub("#", text))
        self._seen[kind] += 1
        count = self._seen[kind]
        if count & (count - 1) == 0:
            often = f" ({count} like this)" if count > 1 else ""
            tone = "warn" if level == "WARNING" else "bad"
            self._console.say(name, f"{level} {text}{often}", tone)


def trouble(name: str, line: str) -> tuple[str, str] | None:
    """Return level and text of a warning or worse in the log of ``name``, whatever its form."""
    if line.startswith("{"):
        return _of_object(line)
    hit = TROUBLE.search(line)
    return (hit[1], line[hit.end() :].removeprefix(f" {name}:").strip()) if hit else None


def _of_object(line: str) -> tuple[str, str] | None:
    try:
        told = json.loads(line)
        level, text = str(told["level"]), str(told["message"])
    except (ValueError, KeyError, TypeError):
        return None
    last = str(told.get("error", "")).rpartition("\n")[2]
    return (level, f"{text}: {last}" if last else text) if TROUBLE.fullmatch(level) else None
