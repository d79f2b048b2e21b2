"""What one check found."""

from dataclasses import dataclass
from enum import StrEnum


class State(StrEnum):
    """``warning``: works, but worse than it could; ``problem``: something will not work."""

    OK = "ok"
    WARNING = "warning"
    PROBLEM = "problem"


@dataclass(frozen=True, slots=True)
class Finding:
    """``found`` in words; ``mend`` is one command, '' when there is nothing to do.

    With state ok, ``mend`` is a command that one may like to know.
    """

    state: State
    found: str
    mend: str = ""

    @property
    def is_problem(self) -> bool:
        """Tell whether something will not work."""
        return self.state is State.PROBLEM


def ok(found: str, mend: str = "") -> Finding:
    """Return that all is well."""
    return Finding(State.OK, found, mend)


def warning(found: str, mend: str) -> Finding:
    """Return what works badly."""
    return Finding(State.WARNING, found, mend)


def problem(found: str, mend: str) -> Finding:
    """Return what does not work."""
    return Finding(State.PROBLEM, found, mend)
