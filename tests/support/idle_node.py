"""Nodes that do nothing, or the wrong thing on purpose."""

import time
from dataclasses import dataclass, field
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, Received


@dataclass(frozen=True, slots=True)
class IdleLimits:
    """A group of parameters."""

    most: int = 3
    least: int = 0

    def __post_init__(self) -> None:
        if self.most < self.least:
            raise ValueError(f"most: expected at least {self.least}, got {self.most}")


@dataclass(frozen=True, slots=True)
class IdleParams:
    """``fault``: '' | refuse (bad input at the start) | crash (a bug) | hang (in a step)."""

    fault: str = ""
    size_m: float = 1.0
    source: dict[str, Any] = field(default_factory=dict)
    limits: IdleLimits = field(default_factory=IdleLimits)


class Idle:
    """Reads and writes nothing."""

    Params: ClassVar[type] = IdleParams
    idle_s: ClassVar[float] = 0.1

    def __init__(self, params: IdleParams, context: Context) -> None:
        self._params = params

    def open(self, bus: Bus) -> None:
        """Fail, if that is the fault."""
        if self._params.fault == "refuse":
            raise ValueError("no such recording")
        if self._params.fault == "crash":
            raise RuntimeError("a bug")

    def step(self, received: Received | None) -> None:
        """Hang, if that is the fault."""
        if self._params.fault == "hang":
            time.sleep(600)

    def close(self) -> None:
        """Nothing to release."""
