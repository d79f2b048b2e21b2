"""What is wrong with a graph: one line each, all of them at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sceneq_tools.errors import UserError

ABSENT: Any = object()
"""The value of a problem that is not about one."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Where it stands (``graph.yaml:12`` or ``--rate``), the key path, and how to mend it."""

    where: str
    path: str
    message: str
    value: Any = ABSENT
    hint: str = ""

    def __str__(self) -> str:
        parts = [self.where, self.path, self.message]
        text = ": ".join(part for part in parts if part)
        if self.value is not ABSENT:
            text += f", got {self.value!r:.80}"
        return f"{text} ({self.hint})" if self.hint else text


class GraphError(UserError):
    """A graph that cannot run."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__("\n".join(map(str, problems)), exit_code=2)
        self.problems = tuple(problems)
