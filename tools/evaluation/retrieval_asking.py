"""Questions put to the front door of a scene, in one process: what the routing node would answer.

The front door, router, judge and reasoner are the ones of the graph, and problems and verdicts
pass through the bytes in which they travel between the nodes.
"""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sceneq_core.reasoning.reasoner import Pictures, Problem, Verdict, no_pictures
from sceneq_core.routing.answer import FALLBACK, FAST, FOUND, NOT_FOUND, REASONED
from sceneq_core.routing.matches import MAX_MATCHES
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._bus import Request
from sceneq_nodes._front_door import FrontDoor
from sceneq_nodes._look import Look
from sceneq_nodes._reason_json import (
    problem_bytes,
    problem_from_bytes,
    verdict_bytes,
    verdict_from_bytes,
)
from sceneq_schemas.topics import QUERY_ASK
from sceneq_tools.evaluation.retrieval_queries import Query
from sceneq_tools.evaluation.retrieval_setup import Setup

NONE, SELECTIVE, ALWAYS = "none", "selective", "always"
MODES = {NONE: "fast", SELECTIVE: "", ALWAYS: "reason"}
"""When to reason -> what the question says about it on the network."""

SCENE = "evaluation"
ROUTES = (FAST, REASONED, FALLBACK)


@dataclass(frozen=True, slots=True)
class Answered:
    """An answer: its ``status`` and ``route``, the ``ranked`` instance ids, and what it cost.

    ``ms`` includes reading the question (the text tower) as if it was asked for the first time.
    """

    query: Query
    status: str
    route: str
    ranked: tuple[int, ...]
    ms: float
    vlm_calls: int
    reason: str

    @property
    def is_found(self) -> bool:
        """Whether it says: the first one is it."""
        return self.status == FOUND

    @property
    def is_not_found(self) -> bool:
        """Whether it says: there is no such thing."""
        return self.status == NOT_FOUND


class Asking:
    """Asks about one snapshot; ``pictures`` are for a reasoner that looks."""

    def __init__(
        self, setup: Setup, snapshot: SceneSnapshot, pictures: Pictures = no_pictures
    ) -> None:
        look = Look(snapshot, time.monotonic())
        self._router = setup.router
        self._reasoner = setup.reasoner
        self._pictures = pictures
        self._door = FrontDoor(SCENE, setup.router, lambda: look, self._reason, dict)
        self._read_ms = setup.read_ms

    def ask_all(self, queries: Sequence[Query], reasoning: str) -> tuple[Answered, ...]:
        """Return the answers to all ``queries``; ``reasoning`` is one of ``MODES``."""
        if queries:
            self._router.read("hello")  # the text tower loads when it is first used
        return tuple(self.ask(query, reasoning) for query in queries)

    def ask(self, query: Query, reasoning: str) -> Answered:
        """Return the answer to one question."""
        read_ms = self._read_once(query.text)
        answer = self._ask({"q": query.text, "k": MAX_MATCHES, "mode": MODES[reasoning]})
        return Answered(
            query=query,
            status=answer["status"],
            route=answer["route"],
            ranked=tuple(match["id"] for match in answer["instances"]),
            ms=read_ms + answer["took_ms"],
            vlm_calls=answer["cost"]["vlm_calls"],
            reason=answer["reason"],
        )

    def _ask(self, said: dict[str, Any]) -> dict[str, Any]:
        key = QUERY_ASK.key(scene=SCENE)
        payload = json.dumps(said).encode()
        request = Request(QUERY_ASK, key, {}, False, {}, payload, "application/json")
        reply = self._door.ask(request)
        assert reply is not None  # only wildcard requests may get no answer
        answer: dict[str, Any] = json.loads(reply.payload)
        return answer

    def _read_once(self, text: str) -> float:
        """Return the milliseconds it took to read a text for the first time."""
        if text not in self._read_ms:
            start_s = time.perf_counter()
            self._router.read(text)
            self._read_ms[text] = (time.perf_counter() - start_s) * 1e3
        return self._read_ms[text]

    def _reason(self, problem: Problem) -> Verdict:
        problem = problem_from_bytes(problem_bytes(problem))
        verdict = self._reasoner.solve(problem, self._pictures)
        return verdict_from_bytes(verdict_bytes(verdict))
