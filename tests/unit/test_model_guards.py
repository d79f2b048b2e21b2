"""What stands between questions and a paid model: circuit breaker, budget, time."""

import threading
import time

import pytest

from sceneq_core.reasoning.reasoner import Usage
from sceneq_core.routing.budget import Budget, OverBudgetError
from sceneq_nodes._accounting import Ledger, Prices
from sceneq_nodes._circuit_breaker import BreakerParams, CircuitBreaker, OpenCircuitError
from sceneq_nodes._timed_calls import OutOfTimeError, TimedCalls, wait


class Clock:
    def __init__(self):
        self.now_s = 1000.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def breaker(clock):
    return CircuitBreaker(BreakerParams(failures=2, rest_s=30.0), clock)


def is_open(breaker):
    try:
        breaker.enter()
    except OpenCircuitError:
        return True
    return False


def test_failures_in_a_row_open_the_circuit(breaker):
    breaker.failed("first")
    breaker.succeeded()
    breaker.failed("second")
    assert not is_open(breaker)
    breaker.failed("third")
    with pytest.raises(OpenCircuitError, match=r"2 failures in a row, the last: third; .* in 30 s"):
        breaker.enter()


def test_after_the_rest_one_probe_decides(breaker, clock):
    breaker.failed("a")
    breaker.failed("b")
    clock.now_s += 30.0
    assert not is_open(breaker)  # the probe
    assert is_open(breaker)  # the others go on waiting
    breaker.failed("c")
    clock.now_s += 29.0
    assert is_open(breaker)
    clock.now_s += 1.0
    assert not is_open(breaker)
    breaker.succeeded()
    assert not is_open(breaker)


def test_a_probe_that_never_reports_does_not_lock_out_for_ever(breaker, clock):
    breaker.failed("a")
    breaker.failed("b")
    clock.now_s += 30.0
    breaker.enter()
    clock.now_s += 30.0
    assert not is_open(breaker)


PRICES = Prices(per_million_in=2.0, per_million_out=8.0, per_call=0.5)


def test_calls_and_tokens_have_their_price(clock):
    ledger = Ledger(PRICES, Budget(), clock)
    assert ledger.begin_call() == Usage(0, 0, 0.5)
    assert ledger.end_call(1_000_000, 500_000) == Usage(1_000_000, 500_000, 6.0)
    assert ledger.last_hour() == (1, Usage(1_000_000, 500_000, 6.5))


def test_a_call_that_did_not_reach_the_server_is_taken_back(clock):
    ledger = Ledger(PRICES, Budget(calls_per_hour=1), clock)
    ledger.begin_call()
    assert ledger.cancel_call() == Usage(0, 0, -0.5)
    assert ledger.last_hour() == (0, Usage())
    ledger.begin_call()


def test_the_budget_is_of_any_sixty_minutes(clock):
    ledger = Ledger(PRICES, Budget(calls_per_hour=2), clock)
    ledger.begin_call()
    clock.now_s += 1800
    ledger.begin_call()
    with pytest.raises(OverBudgetError, match="2 of 2 calls; the oldest call leaves it in 1800 s"):
        ledger.begin_call()
    clock.now_s += 1800
    ledger.begin_call()
    with pytest.raises(OverBudgetError):
        ledger.begin_call()


@pytest.mark.parametrize(
    ("budget", "message"),
    [
        (Budget(tokens_per_hour=30), "30 of 30 tokens"),
        (Budget(money_per_hour=0.25), "0.50012 of 0.25 money"),
    ],
)
def test_tokens_and_money_are_limited_too(clock, budget, message):
    ledger = Ledger(PRICES, budget, clock)
    ledger.begin_call()
    ledger.end_call(20, 10)
    with pytest.raises(OverBudgetError, match=message):
        ledger.begin_call()


def test_no_budget_at_all_is_a_budget():
    with pytest.raises(OverBudgetError, match="the budget is 0 of 0 calls an hour"):
        Ledger(Prices(), Budget(calls_per_hour=0)).begin_call()


def soon():
    return time.monotonic() + 30.0


def test_a_call_is_waited_for_and_its_error_comes_out():
    calls = TimedCalls(1)
    assert wait(calls.start(lambda: 7, soon()), soon()) == 7
    with pytest.raises(ZeroDivisionError):
        wait(calls.start(lambda: 1 // 0, soon()), soon())


def test_a_call_that_takes_too_long_is_left_to_itself():
    go_on = threading.Event()
    future = TimedCalls(1).start(lambda: go_on.wait(30), soon())
    with pytest.raises(OutOfTimeError, match="no reply in time"):
        wait(future, time.monotonic() + 0.02)
    go_on.set()
    assert wait(future, soon()) is True


def test_a_call_that_finds_no_place_in_time_never_starts():
    go_on, started = threading.Event(), []
    calls = TimedCalls(1)
    first = calls.start(lambda: go_on.wait(30), soon())
    second = calls.start(lambda: started.append(1), time.monotonic() + 0.02)
    with pytest.raises(OutOfTimeError, match="too many calls are under way"):
        wait(second, soon())
    go_on.set()
    wait(first, soon())
    assert not started


def test_a_timeout_within_the_call_is_its_own():
    def late():
        raise TimeoutError("from inside")

    with pytest.raises(TimeoutError, match="from inside"):
        wait(TimedCalls(1).start(late, soon()), soon())
