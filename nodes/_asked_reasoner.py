"""The reasoning node as routing sees it: asked over the bus, for a limited time and money."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Verdict,
)
from sceneq_core.routing.outlook import NAME, RELATION, THING
from sceneq_core.routing.remembered import RememberedParams
from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes._purse import LostVerdictError, Purse
from sceneq_nodes._reason_json import (
    label_problem_bytes,
    label_verdict_from_bytes,
    problem_bytes,
    verdict_from_bytes,
)
from sceneq_nodes._shared_verdicts import SharedVerdicts
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import REASON

V = TypeVar("V", Verdict, LabelVerdict)

LOST = ("timeout", "too_large", "unknown", "internal")
"""Codes of errors after which the reasoner may have asked a model."""

LEAST_S = 0.01
"""With less time than this nobody is asked: a get alone takes a part of it."""


class AskedReasoner:
    """Asks for a verdict, at most ``timeout_s`` or as long as the problem has time.

    What is known or under way is not asked again; everything else the ``purse`` pays for.
    """

    def __init__(
        self,
        bus: Bus,
        scene: str,
        timeout_s: float,
        purse: Purse,
        remembered: RememberedParams | None = None,
    ) -> None:
        remembered = remembered or RememberedParams()
        self._bus = bus
        self._scene = scene
        self._timeout_s = timeout_s
        self._purse = purse
        self._verdicts = SharedVerdicts[Problem, Verdict](remembered, self._solve, bus.count)
        self._names = SharedVerdicts[LabelProblem, LabelVerdict](remembered, self._label, bus.count)

    def solve(self, problem: Problem) -> Verdict:
        """Return the verdict; raise ``UnansweredError`` when no usable one comes."""
        return self._verdicts.solve(replace(problem, time_s=self._time_s(problem.time_s)))

    def label(self, problem: LabelProblem) -> LabelVerdict:
        """Return what an instance is called; raises as ``solve``."""
        return self._names.solve(replace(problem, time_s=self._time_s(problem.time_s)))

    def _solve(self, problem: Problem) -> Verdict:
        def ask(may_spend: bool) -> Verdict:
            payload = problem_bytes(replace(problem, may_spend=may_spend))
            verdict = self._ask(payload, verdict_from_bytes, problem.time_s)
            posed = [c.instance_id for c in problem.candidates if c.role == "target"]
            _need_known(verdict, posed, "instance {} was not a candidate")
            return verdict

        return self._purse.pay(RELATION if problem.constraints else THING, ask)

    def _label(self, problem: LabelProblem) -> LabelVerdict:
        def ask(may_spend: bool) -> LabelVerdict:
            payload = label_problem_bytes(replace(problem, may_spend=may_spend))
            verdict = self._ask(payload, label_verdict_from_bytes, problem.time_s)
            _need_known(verdict, [name for name, _ in problem.labels], "{!r:.40} was not proposed")
            return verdict

        return self._purse.pay(NAME, ask)

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
            lost = isinstance(error, DecodeError) or error.code in LOST
            raise (LostVerdictError if lost else UnansweredError)(
                f"the reasoner failed: {error}"
            ) from error
        except UnansweredError:
            self._bus.count("reasoner_unanswered")
            raise
        self._bus.count("reasoner_missing")
        raise UnansweredError("no reasoner answered")


def _need_known(verdict: Verdict | LabelVerdict, posed: Sequence[Any], complaint: str) -> None:
    """Refuse a verdict on something else; it is paid for, but nothing to remember."""
    for choice, _ in verdict.ranking:
        if choice not in posed:
            why = "verdict: " + complaint.format(choice)
            raise UnansweredError(why, verdict.vlm_calls, verdict.usage)
