"""Answers problems that the encoder alone cannot decide.

Serves  sceneq/reason/<scene>/v1: a JSON problem (question, candidates with boxes and evidence) in
        the payload, a JSON verdict (ranking with probabilities, reason) in the reply.
Rate    as asked; several problems at once on the query pool.
Bad     a problem that is not valid or not solvable is answered with ``bad_request``, and counted.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from sceneq_core.reasoning.reasoner import Reasoner
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, QueryError, Received, Reply, Request
from sceneq_nodes._reason_json import problem_from_bytes, verdict_bytes
from sceneq_schemas.topics import REASON


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

    def open(self, bus: Bus) -> None:
        """Build the backend and serve it."""
        self._bus = bus
        self._reasoner: Reasoner = build("reasoner", self._params.reasoner, ("reasoner",))
        bus.serve(REASON, self._solve, scene=self._context.scene)

    def step(self, received: Received | None) -> None:
        """Nothing to do between problems."""

    def close(self) -> None:
        """Nothing to release."""

    def _solve(self, request: Request) -> Reply | None:
        if not request.payload:
            return None
        try:
            verdict = self._reasoner.solve(problem_from_bytes(request.payload))
        except ValueError as error:
            self._bus.count("problems_refused")
            raise QueryError("bad_request", str(error), "send a problem as routing does") from error
        self._bus.count("problems_solved")
        return Reply(verdict_bytes(verdict), REASON.encoding)
