"""What a scenario is given, and what it says came of its fault."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

NOTHING = "nothing"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one fault.

    ``times``: how often it was done, 0 = it could not be, and ``detail`` says why; ``lost``: what a
    reader or the disk had lost at the end; ``detail``: numbers, or what failed.
    """

    fault: str
    times: int
    lost: str
    passed: bool
    detail: str = ""

    @property
    def verdict(self) -> str:
        """Return ``ok``, ``FAILED`` or ``skipped``."""
        if not self.passed:
            return "FAILED"
        return "ok" if self.times else "skipped"


@dataclass(frozen=True, slots=True)
class Plan:
    """How a scenario is to be run.

    ``work`` is an empty folder of its own, ``shared`` one that all scenarios of a run have, where
    there is one; both are removed afterwards. ``count``: damaged inputs of a fuzz; ``short``: a few
    seconds each, for every commit.
    """

    work: Path
    seed: int = 0
    short: bool = False
    count: int = 200_000
    shared: Path | None = None

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ValueError(f"count: must be at least 1, got {self.count}")

    @property
    def together(self) -> Path:
        """Where to keep what other scenarios can use."""
        return self.shared or self.work

    def pick(self, whole: int, short: int) -> int:
        """Return how often to do something."""
        return short if self.short else whole


Scenario = Callable[[Plan], Iterable[Outcome]]


def skipped(fault: str, reason: str) -> Outcome:
    """Return the outcome of a fault that this machine does not permit."""
    return Outcome(fault, 0, "", True, reason)
