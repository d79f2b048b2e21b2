"""Keyframes and views that survive the end of their process."""

import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest

from sceneq_core.state import take_apart
from sceneq_nodes._bus import Reply, Request
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._images import frame_message
from sceneq_nodes._item_store import Change, Item
from sceneq_nodes._recent_deltas import RecentDeltas, wanted_deltas
from sceneq_nodes._state_bytes import packed
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_nodes.views import Views, ViewsParams
from sceneq_schemas.codec import encode
from sceneq_schemas.map import MapDelta, MapDeltas
from sceneq_schemas.topics import (
    FRAME,
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    VIEW_DELTA,
    VIEW_IMAGE,
    VIEW_SNAPSHOT,
)

from support.fake_bus import CONTEXT, FakeBus
from support.killed_files import leave_as_killed
from support.open_nodes import opened
from support.room import Room
from support.true_map import TrueMap, frame_of

FRAMES = 6
EPOCH = 11
ROOM = Room()


@pytest.fixture(scope="module")
def stream():
    """Frames as a lossless source sends them, and the deltas of a map that grows with them."""
    true_map, frames, deltas = TrueMap(ROOM), [], []
    for i in range(FRAMES):
        frame, things = frame_of(ROOM, i, FRAMES)
        frames.append(replace(frame_message(frame, "raw", "zstd"), after=i - 1))
        deltas.append(map_delta_message(true_map.integrate(frame, things), EPOCH, i + 1))
    return frames, deltas


class Graph:
    """The views node, and a map beside it that goes on while the node is dead."""

    def __init__(self, stream, store: Path | None) -> None:
        self.frames, self.deltas = stream
        self.recent = RecentDeltas()
        self.told: list[MapDelta] = []
        self.store = store
        self.start()

    def start(self) -> None:
        self.bus = FakeBus(replace(CONTEXT, store=self.store))
        self.bus.answer(MAP_JOURNAL, self.journal)
        self.bus.answer(MAP_SNAPSHOT, lambda request: None)
        self.node = Views(ViewsParams(), self.bus.context)
        opened(self.node, self.bus)

    def kill(self) -> None:
        leave_as_killed(self.store, self.node.close)

    def journal(self, request: Request) -> Reply | None:
        epoch, after = wanted_deltas(request)
        deltas = self.recent.after(after)
        if epoch != EPOCH or deltas is None:
            return None
        message = MapDeltas(EPOCH, self.told[-1].seq, deltas)
        return Reply(to_bytes(MAP_JOURNAL, message), MAP_JOURNAL.encoding)

    def integrate(self, number: int, *, heard: bool = True) -> None:
        """Let the map take in a keyframe; a dead node hears nothing of it."""
        self.recent.add(self.deltas[number])
        self.told.append(self.deltas[number])
        if heard:
            self.bus.deliver(self.node, MAP_DELTA, self.deltas[number])

    def send(self, *numbers: int) -> None:
        for number in numbers:
            self.bus.deliver(self.node, FRAME, self.frames[number])

    def show(self, *numbers: int) -> "Graph":
        for number in numbers:
            self.send(number)
            self.integrate(number)
        return self

    def view_sets(self) -> list[bytes]:
        snapshot = from_bytes(VIEW_SNAPSHOT, self.bus.query(VIEW_SNAPSHOT).payload)
        return [encode(view_set) for view_set in snapshot.view_sets]

    def acknowledged(self) -> list[int]:
        return [message.frame_seq for message in self.bus.sent(VIEW_DELTA)]


@pytest.fixture(scope="module")
def undisturbed(stream) -> Graph:
    return Graph(stream, None).show(*range(FRAMES))


@pytest.mark.parametrize("killed_after", range(1, FRAMES + 1))
def test_killed_views_come_back_and_go_on_as_if_nothing_was(
    undisturbed, stream, tmp_path, killed_after
):
    graph = Graph(stream, tmp_path / "kept").show(*range(killed_after))
    before = graph.view_sets()
    graph.kill()
    graph.start()
    assert graph.view_sets() == before
    graph.show(*range(killed_after, FRAMES))
    assert graph.view_sets() == undisturbed.view_sets()
    picture = graph.bus.query(VIEW_IMAGE, parameters={"seq": "0"})
    assert picture == undisturbed.bus.query(VIEW_IMAGE, parameters={"seq": "0"})


def test_frames_are_looked_at_in_the_map_of_their_time(undisturbed, stream, tmp_path):
    """The map went on while views was dead, and its frames come again only later."""
    graph = Graph(stream, tmp_path / "kept").show(0, 1, 2)
    graph.kill()
    graph.integrate(3, heard=False)
    graph.integrate(4, heard=False)
    graph.start()
    assert graph.acknowledged() == []
    graph.send(4)
    assert graph.acknowledged() == []
    graph.send(3)
    assert graph.acknowledged() == [3, 4]
    graph.show(5)
    assert graph.view_sets() == undisturbed.view_sets()


def test_what_never_comes_is_waited_for_only_so_long(stream, tmp_path):
    graph = Graph(stream, tmp_path / "kept").show(0, 1, 2)
    graph.integrate(3)
    graph.show(4)
    assert graph.acknowledged()[-1] == 2
    for _ in range(100):
        graph.node.step(None)
    assert graph.node._held == type(graph.node._held)()
    assert graph.node._map_seq == 5


def test_the_epoch_stays_and_numbers_leap(stream, tmp_path):
    graph = Graph(stream, tmp_path / "kept").show(0, 1)
    (*_, before) = graph.bus.sent(VIEW_DELTA)
    graph.kill()
    graph.start()
    graph.send(1)
    (mark,) = graph.bus.sent(VIEW_DELTA)
    assert (mark.epoch, mark.frame_seq, mark.map_epoch) == (before.epoch, 1, EPOCH)
    assert mark.seq > before.seq + 1_000_000


def test_a_damaged_picture_is_left_out(stream, tmp_path):
    graph = Graph(stream, tmp_path / "kept").show(0, 1, 2)
    graph.kill()
    with sqlite3.connect(tmp_path / "kept" / "views.sqlite") as database:
        database.execute("UPDATE item SET crc = 0 WHERE kind = 'keyframe' AND number = 1")
    database.close()
    graph.start()
    assert graph.bus.counters["store_damaged"] == 1
    graph.show(3, 4, 5)
    shown = {view.seq for one in graph.node._selector.view_sets() for view in one.views}
    assert shown == {0, 2, 3, 4, 5}


def test_a_damaged_view_set_is_chosen_again(undisturbed, stream, tmp_path):
    graph = Graph(stream, tmp_path / "kept").show(*range(FRAMES))
    graph.kill()
    with sqlite3.connect(tmp_path / "kept" / "views.sqlite") as database:
        database.execute("UPDATE item SET crc = 0 WHERE kind = 'views'")
    database.close()
    graph.start()
    graph.node.step(None)
    assert len(graph.view_sets()) == len(undisturbed.view_sets())


@pytest.mark.parametrize("kind", ["rest", "places"])
def test_damaged_files_are_set_aside_and_views_begin_anew(stream, tmp_path, kind):
    graph = Graph(stream, tmp_path / "kept").show(0, 1, 2)
    graph.kill()
    with sqlite3.connect(tmp_path / "kept" / "views.sqlite") as database:
        database.execute(f"UPDATE item SET crc = 0 WHERE kind = '{kind}' AND number = 0")
    database.close()
    graph.start()
    assert graph.view_sets() == []
    assert (tmp_path / "kept" / "views.sqlite.corrupt").exists()


def test_a_newer_schema_is_left_alone(stream, tmp_path, caplog):
    graph = Graph(stream, tmp_path / "kept").show(0)
    graph.kill()
    with sqlite3.connect(tmp_path / "kept" / "views.sqlite") as database:
        database.execute("PRAGMA user_version = 7")
    database.close()
    graph.start()
    assert graph.bus.counters["store_failed"] == 1
    assert "schema 7, this version knows 1 at most" in caplog.text
    graph.recent, graph.told = RecentDeltas(), []
    graph.show(0, 1)
    assert graph.acknowledged() == [0, 1]


def change(path, statement, *values):
    with sqlite3.connect(path) as database:
        database.execute(statement, values)
    database.close()


def test_items_of_an_earlier_form_are_set_aside(stream, tmp_path, monkeypatch, caplog):
    graph = Graph(stream, tmp_path / "kept").show(0, 1)
    graph.kill()
    monkeypatch.setattr("sceneq_nodes._view_store.FORM", 2)
    graph.start()
    assert "items of form 1, this version reads 2; set aside as" in caplog.text
    assert graph.bus.counters["store_damaged"] == 1
    assert (tmp_path / "kept" / "views.sqlite.corrupt").exists()
    graph.show(2)
    graph.kill()
    graph.start()
    assert graph.bus.counters["store_damaged"] == 0


def test_items_of_a_later_form_are_left_alone(stream, tmp_path, caplog):
    graph = Graph(stream, tmp_path / "kept").show(0)
    graph.kill()
    change(tmp_path / "kept" / "views.sqlite", "DELETE FROM item WHERE kind = 'form'")
    change(tmp_path / "kept" / "views.sqlite", "INSERT INTO item VALUES ('form', 7, '', 0)")
    graph.start()
    assert graph.bus.counters["store_failed"] == 1
    assert "items of form 7, this version knows 1 at most" in caplog.text
    assert not (tmp_path / "kept" / "views.sqlite.corrupt").exists()


@pytest.mark.parametrize("missing", ["sightings", "concerned", "archive"])
def test_what_another_version_kept_is_set_aside(stream, tmp_path, caplog, missing):
    graph = Graph(stream, tmp_path / "kept").show(0, 1)
    store = graph.node._store
    parts = graph.node._selector.parts()
    del parts[missing]
    rest = packed(take_apart({"selector": parts, "beside": graph.node._parts()}))
    store._items.commit(Change((Item("rest", 0, rest),)))
    graph.kill()
    graph.start()
    assert f"its selector differs in {missing}; set aside as" in caplog.text
    assert graph.view_sets() == []
    graph.recent, graph.told = RecentDeltas(), []
    graph.show(0, 1)
    assert graph.acknowledged() == [0, 1]


def test_a_failing_disk_is_written_anew_when_it_works_again(
    undisturbed, stream, tmp_path, monkeypatch, caplog
):
    graph = Graph(stream, tmp_path / "kept").show(0, 1)
    items = graph.node._store._items
    works = items._write

    def full(*_: object, **__: object) -> None:
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr(items, "_write", full)
    graph.show(2, 3)
    assert graph.bus.counters["store_failed"] >= 1
    assert caplog.text.count("goes on in memory only") == 1
    monkeypatch.setattr(items, "_write", works)
    monkeypatch.setattr(items, "_again_s", 0.0)
    graph.show(4)
    assert "durable again" in caplog.text
    graph.kill()
    graph.start()
    graph.show(5)
    assert graph.view_sets() == undisturbed.view_sets()
