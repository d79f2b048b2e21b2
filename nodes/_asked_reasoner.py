"""The reasoning node as routing sees it: asked over the bus, for a limited time."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Verdict,
)
from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes._reason_json import (
    label_problem_bytes,
    label_verdict_from_bytes,
    problem_bytes,
    verdict_from_bytes,
)
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import REASON

V = TypeVar("V", Verdict, LabelVerdict)

LEAST_S = 0.01
"""With less time than this nobody is asked: a get alone takes a part of it."""


class AskedReasoner:
    """Asks for a verdict, at most ``timeout_s`` or as long as the problem has time."""

    def __init__(self, bus: Bus, scene: str, timeout_s: float) -> None:
        self._bus = bus
        self._scene = scene
        self._timeout_s = timeout_s

    def solve(self, problem: Problem) -> Verdict:
        """Return the verdict; raise ``UnansweredError`` when no usable one comes."""
        time_s = self._time_s(problem.time_s)
        return self._ask(problem_bytes(replace(problem, time_s=time_s)), verdict_from_bytes, time_s)

    def label(self, problem: LabelProblem) -> LabelVerdict:
        """Return what an instance is called; raises as ``solve``."""
        time_s = self._time_s(problem.time_s)
        payload = label_problem_bytes(replace(problem, time_s=time_s))
        return self._ask(payload, label_verdict_from_bytes, time_s)

    def _time_s(self, time_s: float) -> float:
        if time_s < LEAST_S:
            raise UnansweredError("no time left for the reasoner")
        return min(time_s, self._timeout_s)

    def _ask(self, payload: bytes, read: Callable[[bytes], V], time_s: float) -> V:
        try:
            replies = self._bus.ask(REASON, payload=payload, timeout_s=time_s, scene=self._scene)
            if replies:
                return read(replies[0].payload)
        except (QueryError, DecodeError) as error:
            self._bus.count("reasoner_failed")
            raise UnansweredError(f"the reasoner failed: {error}") from error
        except UnansweredError:
            self._bus.count("reasoner_unanswered")
            raise
        self._bus.count("reasoner_missing")
        raise UnansweredError("no reasoner answered")
