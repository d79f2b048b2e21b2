"""What happened to a process, told in words."""

import re
from dataclasses import dataclass

from sceneq_tools.supervision import FATAL, Process

EXITED_LINE = re.compile(
    r"exited: (?P<name>\S+) \((?:exit status (?P<code>\d+)|terminated by (?P<signal>\w+))"
)


@dataclass(frozen=True, slots=True)
class Exit:
    """The end of a process that nobody asked for; ``code`` is -1 after a signal."""

    name: str
    code: int
    signal: str = ""

    def __str__(self) -> str:
        if self.signal:
            return f"was ended by {self.signal}"
        return "finished" if self.code == 0 else f"ended with exit code {self.code}"


def exit_in(line: str) -> Exit | None:
    """Return the exit that a line of supervisord's log reports.

    Its XML-RPC interface forgets the exit code of a process that ended soon after its start.
    """
    found = EXITED_LINE.search(line)
    if found is None:
        return None
    code = -1 if found["code"] is None else int(found["code"])
    return Exit(found["name"], code, found["signal"] or "")


def change(before: Process | None, now: Process) -> tuple[str, str] | None:
    """Return text and tone of what to tell between two looks, ``None`` when nothing happened."""
    if now.pid and (before is None or before.state == "STOPPED"):
        return f"started (pid {now.pid})", ""
    if before is None:
        return None
    if now.pid and now.pid != before.pid:
        return f"restarted (pid {now.pid})", "warn"
    if now.state == FATAL != before.state:
        return "failed to start too often, given up", "bad"
    return None
