"""Two robots as processes, each with an odometry frame of its own, make one map of one room.

While they do, mapping and one robot's ingest are killed: nothing that was held or mapped is lost.
The map is, to the bit, that of a process nobody disturbs which is given the same keyframes, and
what is in it is what one robot finds that sees everything.
"""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse, transform
from sceneq_core.mapping.delta import CONFIRMED, MapDelta
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.visits import seq_of, visit_of
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._mapped import Mapped
from sceneq_nodes._scene_folder import SceneFolder
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.topics import MAP_SNAPSHOT, VIEW_SNAPSHOT, VISIT

from support.kept_scene import COARSE, KeptScene
from support.live_graph import LiveGraph
from support.papered_recording import write_walk
from support.papered_room import PaperedRoom

pytestmark = pytest.mark.integration

ROOM = PaperedRoom()
TURNS_DEG = list(range(0, 270, 15))
ONE, OTHER = slice(7, 18), slice(0, 11)
"""Each box is in four views at least, four views are of both, and each begins somewhere else."""
GRAPH = """\
scene: room
robot: r1
nodes:
  - {{id: ingest, params: {{source: {{kind: folder, path: {one}}}, {how}}}}}
  - id: second
    kind: ingest
    params: {{robot: r2, source: {{kind: folder, path: {other}}}, {how}}}
  - {{id: segmentation, params: {{robots: [r2], segmenter: {{kind: files, path: {masks}}}}}}}
  - {{id: mapping, params: {{robots: [r2], mapper: {{voxel_size_m: {voxel_size_m}}}}}}}
  - {{id: views, params: {{robots: [r2]}}}}
"""
PATIENCE_S = 300.0
NEAR_M = 3 * COARSE.voxel_size_m
"""Both grids lie turned to each other: each face may be a voxel off, and its patch end another."""
VISITS_TOLD = 3
"""Entries of the journal: two that came, one that found its place."""
HOW = "rate_hz: 0, tries: 10, keyframes: {kind: every, every: 1}, arrival: {look_again_s: 0.5}"


def turned_about_up() -> np.ndarray:
    turn = np.radians(70.0)
    motion = np.eye(4)
    motion[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    motion[:3, 3] = [1.5, -2.0, 0.4]
    return motion


T_OTHER_ONE = turned_about_up()


@pytest.fixture
def runtime() -> Iterator[Path]:
    """A short path: a unix socket lives in it."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        yield Path(folder)


def told(live: LiveGraph, topic: Any) -> Any:
    """Return what a node of the graph answers, ``None`` while nobody does."""
    replies, _ = live.client.get(topic.key(scene="room"))
    return from_bytes(topic, replies[0][1].payload) if replies else None


def visits(live: LiveGraph) -> dict[str, Any]:
    answer = told(live, VISIT)
    return {one["robot"]: one for one in answer["visits"]} if answer else {}


def seen(live: LiveGraph) -> list[int]:
    """Return the keyframes that show something."""
    views = told(live, VIEW_SNAPSHOT)
    return [view.seq for one in views.view_sets for view in one.views] if views else []


def entries(store: Path) -> int:
    return SceneFolder(store / "room").facts().position


def replica_of(whole: MapDelta) -> MapReplica:
    replica = MapReplica()
    replica.apply(whole)
    return replica


def digest(replica: MapReplica) -> str:
    points, _, instance_id = replica.cloud()
    return map_digest(np.floor(points / replica.voxel_size_m).astype(np.int32), points, instance_id)


def undisturbed(store: Path) -> MapReplica:
    """Return the map that comes of what the journal says has come, in its order."""
    mapped = Mapped(COARSE)
    for entry in SceneFolder(store / "room").entries():
        mapped.repeat(entry)
    return replica_of(mapped.mapper.snapshot())


def its_map(live: LiveGraph, expected_digest: str) -> MapReplica | None:
    """Return the map of the graph once it is the expected one."""
    whole = told(live, MAP_SNAPSHOT)
    replica = replica_of(map_delta_from_message(whole)) if whole else None
    return replica if replica and digest(replica) == expected_digest else None


def middles(replica: MapReplica) -> np.ndarray:
    """Return the middles of the boxes of what is surely there.

    Not the means of its voxels: walls that lie between two layers of voxels fill one of them or
    both, by a hair, and so weigh once or twice.
    """
    sure = [one for one in replica.instances.values() if one.state == CONFIRMED]
    return np.stack([one.T_world_box[:3, 3] for one in sure])


def alone(walk: Path) -> MapReplica:
    """Return the map of one robot that sees everything."""
    kept = KeptScene(None, walk)
    try:
        kept.visit(walk)
        return kept.map()
    finally:
        kept.close()


def kill(live: LiveGraph, *nodes: str) -> None:
    for node in nodes:
        os.kill(live.pids()[node], signal.SIGKILL)


def test_two_robots_in_frames_of_their_own_make_one_map(tmp_path: Path, runtime: Path) -> None:
    walk = write_walk(tmp_path / "walk", ROOM, TURNS_DEG)
    one = write_walk(tmp_path / "one", ROOM, TURNS_DEG[ONE], first=ONE.start)
    numbers = list(range(len(TURNS_DEG)))
    other = write_walk(tmp_path / "other", ROOM, TURNS_DEG[OTHER], T_OTHER_ONE, first=OTHER.start)
    graph = tmp_path / "graph.yaml"
    size_m, store = COARSE.voxel_size_m, tmp_path / "maps"
    text = GRAPH.format(one=one, other=other, masks=walk, how=HOW, voxel_size_m=size_m)
    graph.write_text(text)
    live = LiveGraph(graph, None, runtime, "--store", str(store))
    try:
        live.wait(lambda: len(visits(live)) == 2)
        kill(live, "mapping", "second")
        expected = len(numbers[ONE]) + len(numbers[OTHER])
        live.wait(lambda: entries(store) >= expected + VISITS_TOLD, PATIENCE_S)
        came = live.wait(lambda: visits(live))
        T_world = {robot: np.array(visit["T_world_odom"]) for robot, visit in came.items()}
        T_one_other = inverse(T_world["r1"]) @ T_world["r2"]
        assert distance_m(T_one_other, inverse(T_OTHER_ONE)) < 0.03
        assert angle_deg(T_one_other, inverse(T_OTHER_ONE)) < 0.5

        expected_digest = digest(undisturbed(store))
        together = live.wait(lambda: its_map(live, expected_digest), PATIENCE_S)
        found = transform(inverse(T_world["r1"]), middles(together))
        truth = middles(alone(walk))
        apart = np.linalg.norm(found[:, None] - truth, axis=2)
        assert len(found) == len(truth)
        assert apart.min(axis=1).max() < NEAR_M
        assert sorted(apart.argmin(axis=1)) == list(range(len(truth)))

        numbered = {visit["visit"]: robot for robot, visit in came.items()}
        live.wait(lambda: {numbered[visit_of(seq)] for seq in seen(live)} == {"r1", "r2"})
        assert {seq_of(seq) for seq in seen(live)} <= set(numbers)
        live.wait(lambda: not SceneFolder(store / "room").waiting())
    finally:
        assert live.close() == 0
