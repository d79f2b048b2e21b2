"""Answers problems that the encoder alone cannot decide.

Serves  sceneq/reason/<scene>/v1: a JSON problem (question and candidates, or instance and labels,
        with boxes and evidence) in the payload, a JSON verdict (ranking with probabilities, reason,
        cost) in the reply.
Reads   the keyframes of the evidence, from the views node, when the reasoner looks at pictures.
Rate    as asked; several problems at once on the query pool.
Bad     a problem that is not valid or not solvable is answered with ``bad_request``, and counted;
        a model that is down, late or out of budget with why, and what that cost.
"""

import logging
import threading
from dataclasses import dataclass, field
from typing import Any, ClassVar

from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Problem,
    Reasoner,
    UnansweredError,
    Usage,
    Verdict,
)
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, QueryError, Received, Reply, Request
from sceneq_nodes._keyframe_pictures import KeyframePictures
from sceneq_nodes._reason_json import any_problem_from_bytes, verdict_bytes
from sceneq_schemas.topics import REASON

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ReasoningParams:
    """``reasoner``: kind and parameters of the backend."""

    reasoner: dict[str, Any] = field(default_factory=lambda: {"kind": "geometric"})


class Reasoning:
    """Serves one reasoner."""

    Params: ClassVar[type] = ReasoningParams
    idle_s: ClassVar[float] = 1.0

    def __init__(self, params: ReasoningParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._spending = threading.Lock()
        self._money = 0.0

    def open(self, bus: Bus) -> None:
        """Build the backend and serve it."""
        self._bus = bus
        self._pictures = KeyframePictures(bus, self._context.scene)
        self._reasoner: Reasoner = build("reasoner", self._params.reasoner, ("reasoner",))
        bus.serve(REASON, self._solve, scene=self._context.scene)

    def step(self, received: Received | None) -> None:
        """Nothing to do between problems."""

    def close(self) -> None:
        """Release the reasoner."""
        self._reasoner.close()

    def _solve(self, request: Request) -> Reply | None:
        if not request.payload:
            return None
        try:
            verdict = self._verdict(any_problem_from_bytes(request.payload))
        except ValueError as error:
            self._bus.count("problems_refused")
            raise QueryError("bad_request", str(error), "send a problem as routing does") from error
        return Reply(verdict_bytes(verdict), REASON.encoding)

    def _verdict(self, problem: Problem | LabelProblem) -> Verdict | LabelVerdict | UnansweredError:
        """Let the reasoner think, and count what it cost, also when nothing came of it."""
        verdict: Verdict | LabelVerdict | UnansweredError
        try:
            if isinstance(problem, LabelProblem):
                verdict = self._reasoner.label(problem, self._pictures)
            else:
                verdict = self._reasoner.solve(problem, self._pictures)
            self._bus.count("problems_solved")
        except UnansweredError as error:
            self._bus.count("problems_unanswered")
            log.warning("no verdict: %s", error)
            verdict = error
        self._spend(verdict.vlm_calls, verdict.usage)
        return verdict

    def _spend(self, vlm_calls: int, usage: Usage) -> None:
        if not vlm_calls:
            return
        self._bus.count("vlm_calls", vlm_calls)
        self._bus.count("vlm_tokens", usage.tokens_in + usage.tokens_out)
        with self._spending:
            self._money += usage.money
            self._bus.report(vlm_money=round(self._money, 6))
