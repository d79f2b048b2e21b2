"""One verdict for all who ask the same: while it is under way, and as long as it holds."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Verdict,
)
from sceneq_core.routing.remembered import (
    Remembered,
    RememberedParams,
    question_of,
    still_holds,
)

P = TypeVar("P", bound=Problem | LabelProblem)
V = TypeVar("V", bound=Verdict | LabelVerdict)


@dataclass(frozen=True, slots=True)
class _UnderWay(Generic[P, V]):
    """A problem that somebody solves until ``end_s``, on the clock of ``time.monotonic``."""

    problem: P
    end_s: float
    verdict: "Future[V]" = field(default_factory=Future)


class SharedVerdicts(Generic[P, V]):
    """Solves the same problem once; ``count`` hears of every verdict that was cached or shared."""

    def __init__(
        self, params: RememberedParams, solve: Callable[[P], V], count: Callable[[str], None]
    ) -> None:
        self._params = params
        self._solve = solve
        self._count = count
        self._lock = threading.Lock()
        self._remembered: Remembered[V] = Remembered(params)
        self._under_way: dict[str, _UnderWay[P, V]] = {}

    def solve(self, problem: P) -> V:
        """Return the verdict; raise ``UnansweredError`` when none comes in the problem's time."""
        mine: _UnderWay[P, V] = _UnderWay(problem, time.monotonic() + problem.time_s)
        with self._lock:
            known = self._remembered.recall(problem)
            leader = mine if known else self._leader(mine)
        if known is not None:
            self._count("verdicts_cached")
            return known
        return self._lead(mine) if leader is mine else self._follow(leader, mine)

    def _leader(self, mine: _UnderWay[P, V]) -> _UnderWay[P, V]:
        """Return who solves the same problem already, or else ``mine``, which others may follow."""
        key = question_of(mine.problem)
        other = self._under_way.get(key)
        if other is not None and still_holds(other.problem, mine.problem, self._params):
            return other
        self._under_way[key] = mine
        return mine

    def _lead(self, mine: _UnderWay[P, V]) -> V:
        try:
            verdict = self._solve(mine.problem)
        except BaseException as error:
            self._end(mine)
            mine.verdict.set_exception(error)
            raise
        self._end(mine, verdict)
        mine.verdict.set_result(verdict)
        return verdict

    def _end(self, mine: _UnderWay[P, V], verdict: V | None = None) -> None:
        with self._lock:
            key = question_of(mine.problem)
            if self._under_way.get(key) is mine:
                del self._under_way[key]
            if verdict is not None:
                self._remembered.keep(mine.problem, verdict)

    def _follow(self, leader: _UnderWay[P, V], mine: _UnderWay[P, V]) -> V:
        """Wait for another's verdict; if he failed and had less time, try oneself."""
        try:
            verdict = leader.verdict.result(timeout=mine.end_s - time.monotonic())
        except TimeoutError:
            raise UnansweredError("the same question is under way, but not answered yet") from None
        except UnansweredError as error:
            left_s = mine.end_s - time.monotonic()
            if leader.end_s < mine.end_s:
                return self._solve(replace(mine.problem, time_s=left_s))
            raise UnansweredError(str(error)) from error
        self._count("verdicts_shared")
        return replace(verdict, cached=True)
