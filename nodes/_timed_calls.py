"""Calls that are waited for no longer than their time, whatever the other side does."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import TypeVar

T = TypeVar("T")


class OutOfTimeError(Exception):
    """The call has not ended in time; nobody waits for it any more."""


class TimedCalls:
    """At most ``limit`` calls at a time, the others wait for their turn.

    Each runs on a daemon thread: a server that answers one byte a second holds up neither a
    question nor the end of the process. An abandoned call keeps its place until it has ended.
    """

    def __init__(self, limit: int) -> None:
        self._free = threading.Semaphore(limit)

    def start(self, call: Callable[[], T], end_s: float) -> "Future[T]":
        """Run ``call`` soon; it never starts after ``end_s`` on the clock ``time.monotonic``."""
        future: Future[T] = Future()
        work = threading.Thread(
            target=self._work, args=(call, end_s, future), name="call", daemon=True
        )
        work.start()
        return future

    def _work(self, call: Callable[[], T], end_s: float, future: "Future[T]") -> None:
        if not self._free.acquire(timeout=min(left(end_s), threading.TIMEOUT_MAX)):
            future.set_exception(OutOfTimeError("too many calls are under way"))
            return
        try:
            future.set_result(call())
        except BaseException as error:
            future.set_exception(error)
        finally:
            self._free.release()


def wait(future: "Future[T]", end_s: float) -> T:
    """Return what the call returned or raise what it raised.

    Raises:
        OutOfTimeError: it had not ended at ``end_s``.
    """
    try:
        return future.result(min(left(end_s), threading.TIMEOUT_MAX))
    except FutureTimeoutError:
        if future.done():
            raise
        raise OutOfTimeError("no reply in time") from None


def left(end_s: float) -> float:
    """Return the seconds until ``end_s``, 0 when it has passed."""
    return max(0.0, end_s - time.monotonic())
