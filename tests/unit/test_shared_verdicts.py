"""The same question asked by many at once is solved once."""

import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import Problem, UnansweredError, Usage, Verdict
from sceneq_core.routing.remembered import RememberedParams, still_holds
from sceneq_nodes import _shared_verdicts
from sceneq_nodes._shared_verdicts import SharedVerdicts

PATIENCE_S = 25.0
UP = np.array([0.0, 0.0, 1.0])
QUESTION = Problem("the cup", "cup", (), (), UP, np.zeros(3), time_s=60.0)
OTHER = replace(QUESTION, text="the bowl", target="bowl")
VERDICT = Verdict(((6, 0.8),), "seen", 1, Usage(1600, 9, 0.01))
PAID_FOR = replace(VERDICT, cached=True)


class Slow:
    """A reasoner that answers when it is let go."""

    def __init__(self, failures: int = 0) -> None:
        self.asked: list[Problem] = []
        self.counted: Counter[str] = Counter()
        self.go = threading.Event()
        self.entered = threading.Semaphore(0)
        self.failures = failures

    def solve(self, problem: Problem) -> Verdict:
        self.asked.append(problem)
        self.entered.release()
        assert self.go.wait(PATIENCE_S)
        if len(self.asked) <= self.failures:
            raise UnansweredError("the model is down", 1)
        return VERDICT

    def count(self, name: str) -> None:
        self.counted[name] += 1

    def shared(self, capacity: int = 256) -> SharedVerdicts[Problem, Verdict]:
        return SharedVerdicts(RememberedParams(capacity=capacity), self.solve, self.count)


def test_many_askers_share_one_call():
    slow = Slow()
    verdicts = slow.shared()
    with ThreadPoolExecutor(8) as pool:
        futures = [pool.submit(verdicts.solve, QUESTION) for _ in range(8)]
        assert slow.entered.acquire(timeout=PATIENCE_S)
        other = pool.submit(verdicts.solve, OTHER)
        slow.go.set()
        told = [future.result(PATIENCE_S) for future in futures]
        assert other.result(PATIENCE_S) == VERDICT
    assert [one.text for one in slow.asked].count("the cup") == 1
    assert told.count(VERDICT) == 1
    assert told.count(PAID_FOR) == 7
    assert sum(slow.counted.values()) == 7  # under way, or known already


def test_afterwards_it_is_known():
    slow = Slow()
    slow.go.set()
    verdicts = slow.shared()
    assert verdicts.solve(QUESTION) == VERDICT
    assert verdicts.solve(QUESTION) == PAID_FOR
    assert slow.counted == {"verdicts_cached": 1}


@pytest.fixture
def joined(monkeypatch):
    """Counts who found the same question under way, and now waits for its verdict."""
    joined = threading.Semaphore(0)

    def holds(*problems):
        joined.release()
        return still_holds(*problems)

    monkeypatch.setattr(_shared_verdicts, "still_holds", holds)
    return joined


def test_a_failure_is_shared_and_not_remembered(joined):
    slow = Slow(failures=1)
    verdicts = slow.shared()
    with ThreadPoolExecutor(4) as pool:
        first = pool.submit(verdicts.solve, QUESTION)
        assert slow.entered.acquire(timeout=PATIENCE_S)
        others = [pool.submit(verdicts.solve, replace(QUESTION, time_s=40.0)) for _ in range(3)]
        assert all(joined.acquire(timeout=PATIENCE_S) for _ in others)
        slow.go.set()
        errors = [one.exception(PATIENCE_S) for one in (first, *others)]
    assert [str(error) for error in errors] == ["the model is down"] * 4
    assert [error.vlm_calls for error in errors] == [1, 0, 0, 0]
    assert len(slow.asked) == 1
    assert verdicts.solve(QUESTION) == VERDICT


def test_who_has_more_time_tries_again(joined):
    slow = Slow(failures=1)
    verdicts = slow.shared()
    with ThreadPoolExecutor(2) as pool:
        hurried = pool.submit(verdicts.solve, replace(QUESTION, time_s=30.0))
        assert slow.entered.acquire(timeout=PATIENCE_S)
        patient = pool.submit(verdicts.solve, QUESTION)
        assert joined.acquire(timeout=PATIENCE_S)
        slow.go.set()
        assert isinstance(hurried.exception(PATIENCE_S), UnansweredError)
        assert patient.result(PATIENCE_S) == VERDICT
    assert 30.0 < slow.asked[1].time_s < 60.0


def test_nobody_waits_longer_than_his_own_time():
    slow = Slow()
    verdicts = slow.shared()
    with ThreadPoolExecutor(1) as pool:
        patient = pool.submit(verdicts.solve, QUESTION)
        assert slow.entered.acquire(timeout=PATIENCE_S)
        with pytest.raises(UnansweredError, match="under way, but not answered yet"):
            verdicts.solve(replace(QUESTION, time_s=0.05))
        slow.go.set()
        assert patient.result(PATIENCE_S) == VERDICT


def test_the_same_words_about_another_map_are_solved_apart():
    slow = Slow()
    verdicts = slow.shared()
    newer = replace(QUESTION, map_epoch=1)
    with ThreadPoolExecutor(2) as pool:
        old = pool.submit(verdicts.solve, QUESTION)
        assert slow.entered.acquire(timeout=PATIENCE_S)
        new = pool.submit(verdicts.solve, newer)
        assert slow.entered.acquire(timeout=PATIENCE_S)
        slow.go.set()
        assert old.result(PATIENCE_S) == new.result(PATIENCE_S) == VERDICT
    assert len(slow.asked) == 2


def test_an_error_that_nobody_meant_reaches_all_and_blocks_nobody():
    def broken(problem: Problem) -> Verdict:
        raise ValueError("a bug")

    verdicts: SharedVerdicts[Problem, Verdict] = SharedVerdicts(
        RememberedParams(), broken, lambda name: None
    )
    for _ in range(2):
        with pytest.raises(ValueError, match="a bug"):
            verdicts.solve(QUESTION)
