"""Descriptors that survive the end of their process."""

import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_core.views.view import View, ViewSet
from sceneq_nodes._bus import Reply
from sceneq_nodes._convert import view_set_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.encoding import Encoding, EncodingParams
from sceneq_schemas.codec import encode
from sceneq_schemas.topics import FEATURE_SNAPSHOT, VIEW_DELTA, VIEW_IMAGE
from sceneq_schemas.view import ViewDelta

from support.fake_bus import CONTEXT, FakeBus
from support.killed_files import leave_as_killed
from support.open_nodes import opened

MODEL = "hash-v1"


def view_set(instance_id: int, *seqs: int):
    box, mask = np.array([8, 8, 24, 24], np.float32), np.ones((8, 8), bool)
    views = tuple(View(seq, seq * 100, 64, box, mask) for seq in seqs)
    return view_set_message(ViewSet(instance_id, views))


def delta(seq: int, *view_sets, full: bool = False, map_epoch: int = 1) -> ViewDelta:
    return ViewDelta(5, seq, full, 10 * seq, 1000 * seq, map_epoch, seq, tuple(view_sets))


def picture(request) -> Reply:
    colour = (int(request.parameters["seq"]) * 3, 40, 90)
    return Reply(jpeg_from_rgb(np.full((48, 64, 3), colour, np.uint8)), "image/jpeg")


class Graph:
    def __init__(self, store: Path | None) -> None:
        self.store = store
        self.start()

    def start(self) -> None:
        self.bus = FakeBus(replace(CONTEXT, store=self.store))
        self.bus.answer(VIEW_IMAGE, picture)
        self.node = Encoding(EncodingParams(encoder={"kind": "hash"}, nice=0), self.bus.context)
        opened(self.node, self.bus)

    def kill(self) -> None:
        leave_as_killed(self.store, self.node.close)

    def hear(self, message: ViewDelta) -> "Graph":
        self.bus.deliver(self.node, VIEW_DELTA, message)
        for _ in range(5):
            self.node.step(None)
        return self

    def snapshot(self):
        return from_bytes(FEATURE_SNAPSHOT, self.bus.query(FEATURE_SNAPSHOT, model=MODEL).payload)

    def descriptors(self) -> dict[int, bytes]:
        return {one.instance_id: encode(one) for one in self.snapshot().descriptors}


def test_descriptors_come_back_and_are_not_made_again(tmp_path):
    sets = view_set(1, 10, 20), view_set(2, 30)
    graph = Graph(tmp_path / "kept").hear(delta(1, *sets, full=True))
    before, epoch = graph.descriptors(), graph.snapshot().epoch
    assert set(before) == {1, 2}
    graph.kill()
    graph.start()
    assert graph.descriptors() == before
    assert graph.snapshot().epoch == epoch
    graph.hear(delta(9, *sets, full=True))
    assert graph.bus.counters["instances_described"] == 0
    graph.hear(delta(10, view_set(2, 30, 40)))
    assert graph.bus.counters["instances_described"] == 1
    whole = Graph(None).hear(delta(1, view_set(1, 10, 20), view_set(2, 30, 40), full=True))
    assert graph.descriptors() == whole.descriptors()


def test_an_instance_seen_by_its_best_view_only_is_described_again(tmp_path, monkeypatch):
    graph = Graph(tmp_path / "kept")
    graph.bus.deliver(graph.node, VIEW_DELTA, delta(1, view_set(1, 10, 20), full=True))
    graph.node._describe_next()
    graph.kill()
    graph.start()
    assert set(graph.descriptors()) == {1}
    graph.hear(delta(2, view_set(1, 10, 20), full=True))
    assert graph.descriptors() == Graph(None).hear(delta(1, view_set(1, 10, 20))).descriptors()


def test_what_went_while_it_was_dead_is_gone(tmp_path):
    graph = Graph(tmp_path / "kept").hear(delta(1, view_set(1, 10), view_set(2, 30), full=True))
    graph.kill()
    graph.start()
    graph.hear(delta(4, view_set(2, 30), full=True))
    assert set(graph.descriptors()) == {2}
    graph.kill()
    graph.start()
    assert set(graph.descriptors()) == {2}


def test_another_map_leaves_nothing_of_the_old_one(tmp_path):
    graph = Graph(tmp_path / "kept").hear(delta(1, view_set(1, 10), view_set(2, 30), full=True))
    graph.hear(delta(2, view_set(7, 10), full=True, map_epoch=2))
    assert set(graph.descriptors()) == {7}
    graph.kill()
    graph.start()
    assert set(graph.descriptors()) == {7}


@pytest.mark.parametrize("kind", ["rest", "instance"])
def test_a_damaged_piece_costs_no_more_than_making_it_again(tmp_path, kind):
    sets = view_set(1, 10), view_set(2, 30)
    graph = Graph(tmp_path / "kept").hear(delta(1, *sets, full=True))
    before = graph.descriptors()
    graph.kill()
    path = tmp_path / "kept" / f"features-{MODEL}.sqlite"
    with sqlite3.connect(path) as database:
        database.execute(f"UPDATE item SET crc = 0 WHERE kind = '{kind}'")
    database.close()
    graph.start()
    assert graph.bus.counters["store_damaged"] >= 1
    assert graph.descriptors() == {}
    assert graph.hear(delta(2, *sets, full=True)).descriptors() == before


@pytest.mark.parametrize("missing", ["epoch", "latest", "map_epoch", "view_epoch"])
def test_what_another_version_kept_is_set_aside(tmp_path, caplog, missing):
    one = view_set(1, 10)
    graph = Graph(tmp_path / "kept").hear(delta(1, one, full=True))
    before, beside = graph.descriptors(), graph.node._beside()
    del beside[missing]
    graph.node._store.note(beside)
    graph.kill()
    graph.start()
    assert f"kept by another version: without {missing}; set aside as" in caplog.text
    assert graph.bus.counters["store_damaged"] == 1
    assert graph.descriptors() == {}
    assert graph.hear(delta(2, one, full=True)).descriptors() == before


def test_descriptors_of_an_earlier_form_are_set_aside(tmp_path, caplog, monkeypatch):
    graph = Graph(tmp_path / "kept").hear(delta(1, view_set(1, 10), full=True))
    graph.kill()
    monkeypatch.setattr("sceneq_nodes._feature_store.FORM", 2)
    graph.start()
    assert "items of form 1, this version reads 2; set aside as" in caplog.text
    assert graph.descriptors() == {}
