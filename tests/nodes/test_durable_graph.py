"""Mapping and views that end at once, views behind the newest checkpoint of the map."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_nodes._bus import Reply, Request
from sceneq_nodes._images import frame_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.views import Views, ViewsParams
from sceneq_schemas.codec import encode
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import (
    FRAME,
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    MASK,
    POSE_CORRECTION,
    VIEW_SNAPSHOT,
)

from support.durable_map import EVERY_TIME, VIEWS, DurableMap
from support.fake_bus import CONTEXT, FakeBus
from support.killed_files import leave_as_killed
from support.open_nodes import opened

FRAMES = [
    (replace(frame_message(frame, "raw", "raw"), after=max(frame.seq - 1, 0)), instance)
    for frame, instance in VIEWS
]


class DurableGraph:
    """Both nodes with their files in one folder; views hears the map when it is told to."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self.start()

    def start(self) -> None:
        self.map = DurableMap(self._folder, EVERY_TIME)
        self.bus = FakeBus(replace(CONTEXT, store=self._folder))
        for topic in (MAP_JOURNAL, MAP_SNAPSHOT):
            self.bus.answer(topic, self._asked_of_map)
        self.views = Views(ViewsParams(), self.bus.context)
        opened(self.views, self.bus)
        self._heard = 0

    def kill(self) -> None:
        self.map.kill()
        leave_as_killed(self._folder, self.views.close)

    def play(self, *numbers: int) -> "DurableGraph":
        """Send keyframes to both; mapping takes them in, views has yet to hear of it."""
        for number in numbers:
            frame, instance = FRAMES[number]
            self.map.bus.deliver(self.map.node, FRAME, frame)
            self.map.bus.deliver(self.map.node, MASK, Masks(frame.seq, frame.stamp_ns, instance))
            self.map.settle()
            self.bus.deliver(self.views, FRAME, frame)
        return self

    def hear(self) -> "DurableGraph":
        told = self.map.bus.sent(MAP_DELTA)
        for delta in told[self._heard :]:
            self.bus.deliver(self.views, MAP_DELTA, delta)
        self._heard = len(told)
        return self

    def view_sets(self) -> list[bytes]:
        snapshot = from_bytes(VIEW_SNAPSHOT, self.bus.query(VIEW_SNAPSHOT).payload)
        return [encode(view_set) for view_set in snapshot.view_sets]

    def _asked_of_map(self, request: Request) -> Reply | None:
        return self.map.bus.query(request.topic, parameters=request.parameters)


@pytest.fixture(scope="module")
def undisturbed() -> DurableGraph:
    return DurableGraph(None).play(*range(6)).hear()


@pytest.mark.parametrize(("heard", "mapped"), [(0, 2), (1, 3), (3, 4), (2, 6), (4, 6)])
def test_views_are_chosen_as_if_nothing_was(undisturbed, tmp_path, heard, mapped):
    """Mapping has a checkpoint of all of it; the recording begins anew."""
    graph = DurableGraph(tmp_path)
    graph.play(*range(heard)).hear().play(*range(heard, mapped))
    graph.kill()
    graph.start()
    assert graph.map.node._store.repeated == []
    graph.play(*range(6)).hear()
    assert graph.view_sets() == undisturbed.view_sets()
    assert graph.map.digest() == undisturbed.map.digest()
    assert graph.bus.counters["frames_observed"] == 6 - heard


def test_views_are_chosen_as_if_nothing_was_after_many_ends(undisturbed, tmp_path):
    graph = DurableGraph(tmp_path)
    for mapped in range(1, 6):
        graph.play(*range(mapped))
        if mapped % 2:
            graph.hear()
        graph.map.node.step(None)
        graph.kill()
        graph.start()
    graph.play(*range(6)).hear()
    assert graph.view_sets() == undisturbed.view_sets()


def test_a_map_that_moves_as_a_whole_is_taken_over_in_its_turn(tmp_path):
    """A correction tells all of the map: the keyframes before it are looked at before."""

    def corrected(graph: DurableGraph) -> None:
        pose = VIEWS[0][0].T_world_camera.copy()
        pose[0, 3] += 0.1
        message = PoseCorrection(1, 1, True, 2, 2, np.array([0]), pose[None])
        graph.map.bus.deliver(graph.map.node, POSE_CORRECTION, message)

    whole = DurableGraph(None).play(0, 1, 2).hear()
    corrected(whole)
    whole.hear().play(3).hear()
    graph = DurableGraph(tmp_path).play(0).hear().play(1, 2)
    corrected(graph)
    graph.play(3).kill()
    graph.start()
    corrected(graph.play(0, 1, 2))
    graph.play(3).hear()
    assert graph.view_sets() == whole.view_sets()
    assert graph.map.digest() == whole.map.digest()


def test_keyframes_of_long_ago_are_not_looked_at_again(undisturbed, tmp_path, monkeypatch):
    monkeypatch.setattr("sceneq_nodes.views.REMEMBERED", 2)
    graph = DurableGraph(tmp_path).play(*range(6)).hear()
    graph.kill()
    graph.start()
    graph.play(*range(6)).hear()
    assert graph.bus.counters["frames_observed"] == 0
    assert graph.view_sets() == undisturbed.view_sets()
