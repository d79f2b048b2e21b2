"""The heartbeat: what it says, that it tells busy from idle, and that it survives a failure."""

import os
import threading

import pytest

from sceneq_nodes import _health
from sceneq_nodes._counters import Counters
from sceneq_nodes._health import Health, metrics, rss_mb


@pytest.fixture
def now() -> list[float]:
    return [100.0]


@pytest.fixture
def health(now: list[float]) -> Health:
    counters = Counters(clock=lambda: now[0])
    counters.topic("mask", "in")
    counters.count("skipped", 2)
    counters.report(instances=12, source="folder")
    return Health("mapping", counters, clock=lambda: now[0])


def test_the_message(health: Health, now: list[float]) -> None:
    now[0] = 102.5
    message = health.message("mapping", {"sceneq/mask/room/v1": 3})
    assert message.pop("rss_mb") == pytest.approx(rss_mb(), abs=50)
    assert message == {
        "node": "mapping",
        "kind": "mapping",
        "pid": os.getpid(),
        "state": "starting",
        "uptime_s": 2.5,
        "busy_s": 0.0,
        "inbox": {"sceneq/mask/room/v1": 3},
        "topics": {"mask": {"in": 1, "age_ms": 2500}},
        "counters": {"skipped": 2},
        "values": {"instances": 12, "source": "folder"},
    }


def test_a_long_step_shows(health: Health, now: list[float]) -> None:
    with health.step():
        now[0] += 7.0
        assert health.message("mapping", {})["busy_s"] == 7.0
    assert health.message("mapping", {})["busy_s"] == 0.0


def test_a_step_that_fails_is_over(health: Health) -> None:
    with pytest.raises(RuntimeError), health.step():
        raise RuntimeError("a bug")
    assert health.message("mapping", {})["busy_s"] == 0.0


def test_metrics_are_the_numbers(health: Health) -> None:
    flat = metrics(health.message("mapping", {"a": 3, "b": 1}))
    assert flat.pop("rss_mb") > 0
    assert flat == {
        "mask.in": 1,
        "mask.age_ms": 0,
        "skipped": 2,
        "instances": 12,
        "uptime_s": 0.0,
        "busy_s": 0.0,
        "inbox": 4,
    }


def test_a_change_is_told_at_once_and_nothing_after_the_rest(
    health: Health, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_health, "PERIOD_S", 3600.0)
    told: list[str] = []
    beat, stop = threading.Semaphore(0), threading.Event()

    def publish() -> None:
        told.append(health.state)
        beat.release()

    rest = health.beat(publish, stop)
    assert beat.acquire(timeout=30)
    health.state = "ready"
    health.hurry()
    assert beat.acquire(timeout=30)
    rest()
    assert stop.is_set()
    health.hurry()
    assert told == ["starting", "ready"]


def test_a_failing_network_is_nothing_to_tell_while_leaving(
    health: Health, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    closing, stop = threading.Event(), threading.Event()

    def publish() -> None:
        closing.set()
        assert stop.wait(30)
        raise RuntimeError("session closed")

    rest = health.beat(publish, stop)
    assert closing.wait(30)
    rest()
    assert caplog.text == ""


def test_the_heart_beats_on_after_a_failure_and_stops_when_told(
    health: Health, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(_health, "PERIOD_S", 0.001)
    beats, enough, stop = [0], threading.Event(), threading.Event()

    def publish() -> None:
        beats[0] += 1
        if beats[0] == 1:
            raise RuntimeError("no network")
        if beats[0] == 3:
            stop.set()
            enough.set()

    health.beat(publish, stop)
    assert enough.wait(30)
    assert beats[0] == 3
    assert "no heartbeat" in caplog.text
