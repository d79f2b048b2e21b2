"""What a node's process does between opening the node and answering."""

from threading import Event
from types import SimpleNamespace

import pytest

from sceneq_nodes import _process


def test_what_was_loaded_is_left_out_of_garbage_collection_before_anybody_asks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done: list[str] = []
    for name in ("collect", "freeze"):
        monkeypatch.setattr(_process.gc, name, lambda name=name: done.append(name))
    node = SimpleNamespace(
        idle_s=1.0,
        open=lambda bus: done.append("open"),
        close=lambda: done.append("close"),
    )
    bus = SimpleNamespace(announce=lambda instance: done.append("announce"))
    health = SimpleNamespace(state="", hurry=lambda: done.append("hurry"))
    stop = Event()
    stop.set()
    assert _process._live(node, bus, health, stop) == _process.STOPPED
    assert done == ["open", "collect", "freeze", "announce", "hurry", "close"]


def test_a_node_that_cannot_open_freezes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(_process.gc, "freeze", lambda: done.append("freeze"))

    def refuse(bus: object) -> None:
        raise ValueError("no such file")

    node = SimpleNamespace(idle_s=1.0, open=refuse)
    health = SimpleNamespace(state="")
    assert _process._live(node, SimpleNamespace(), health, Event()) == _process.BAD_INPUT
    assert done == []
