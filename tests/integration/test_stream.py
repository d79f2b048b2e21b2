"""A recording through the whole graph, asked by strangers while it runs."""

import json
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from trimesh import load_scene

from sceneq_nodes._client import Client

from support.live_graph import LiveGraph, run
from support.rerun_file import contents
from support.shared_room import FRAMES, NODES, RED_BALL, SharedRoom

pytestmark = pytest.mark.integration

CLIENTS = 8


@pytest.fixture(scope="module")
def settled(room: SharedRoom) -> LiveGraph:
    return room.live


def test_no_frame_is_lost_on_the_way(settled: LiveGraph) -> None:
    nodes = settled.status()
    assert set(NODES) <= set(nodes)
    assert nodes["ingest"]["values"]["keyframes"] == FRAMES
    assert nodes["mapping"]["counters"]["frames_integrated"] == FRAMES
    # Routing wants the newest pose only; older ones are dropped by design.
    dropped = {name: nodes[name]["flows"]["dropped"] for name in NODES if name != "routing"}
    assert set(dropped.values()) == {0}
    assert sum(node["flows"]["undecodable"] for node in nodes.values()) == 0


def test_the_same_numbers_are_told_to_prometheus(settled: LiveGraph) -> None:
    told = settled.sceneq("metrics").stdout
    assert told.endswith("# EOF\n")
    for node in NODES:
        assert f'sceneq_node_up{{kind="{node}",node="{node}"}} 1.0' in told
    mapped = 'sceneq_events_total{event="frames_integrated",node="mapping"}'
    assert f"{mapped} {FRAMES}.0" in told


def test_the_live_map_is_the_one_that_sceneq_map_makes(
    settled: LiveGraph, room: SharedRoom, tmp_path: Path
) -> None:
    mapped = run(
        sys.executable, "-m", "sceneq_tools", "map",
        str(room.recording), str(tmp_path / "map"), "--graph", str(room.graph),
    )  # fmt: skip
    assert mapped.returncode == 0, mapped.stderr
    exported = settled.sceneq("export", str(tmp_path / "live"))
    assert exported.returncode == 0, exported.stderr
    a, b = (json.loads((tmp_path / f / "instances.json").read_text()) for f in ("map", "live"))
    assert a["digest"] == b["digest"]
    assert a["instance_count"] >= 5
    assert [i["id"] for i in a["instances"]] == [i["id"] for i in b["instances"]]
    assert [i["views"] for i in a["instances"]] == [i["views"] for i in b["instances"]]
    files = np.load(tmp_path / "live" / "instances.npz")
    assert files["points"].shape == (len(files["instance_id"]), 3)
    assert files["points"].dtype == np.float32
    assert files["instance_id"].dtype == np.int32
    assert (tmp_path / "live" / "cloud.ply").stat().st_size > 10_000
    assert (tmp_path / "live" / "instances.png").stat().st_size > 1_000


def test_a_running_graph_is_exported_with_the_pictures_it_is_known_from(
    settled: LiveGraph, tmp_path: Path
) -> None:
    kinds = [word for kind in ("coco", "rrd", "glb", "costmap") for word in ("--as", kind)]
    done = settled.sceneq("export", str(tmp_path), *kinds)
    assert done.returncode == 0, done.stderr
    coco = json.loads((tmp_path / "coco" / "instances.json").read_text())
    assert coco["info"]["views_without_image"] == 0
    named = {image["file_name"] for image in coco["images"]}
    assert named == {path.name for path in (tmp_path / "coco" / "images").iterdir()}
    assert len(coco["annotations"]) > len(named) >= 3
    assert "/world/boxes" in contents(tmp_path / "scene.rrd").entities
    assert set(load_scene(tmp_path / "scene.glb").graph.nodes) > {"scene"}
    assert (tmp_path / "costmap" / "map.yaml").exists()


def test_a_stranger_gets_an_answer_with_place_and_evidence(settled: LiveGraph) -> None:
    (answer,) = settled.zenoh_get("sceneq/query/room/instances?q=red ball;k=3")
    best = answer["instances"][0]
    assert np.linalg.norm(np.subtract(best["centre"], RED_BALL)) < 0.15
    assert len(best["views"]) >= 3
    assert answer["route"] == "fast"
    assert answer["status"] in ("found", "ambiguous")
    picture = settled.zenoh_get(best["views"][0]["key"], decoder="base64")[0]
    assert picture.strip().startswith("/9j/")  # the first bytes of every JPEG, in base64


def test_a_wildcard_get_lists_what_can_be_asked(settled: LiveGraph) -> None:
    answers = settled.zenoh_get("sceneq/query/**")
    overview = next(a for a in answers if isinstance(a.get("usage"), dict))
    assert overview["scene"] == "room"
    assert overview["instances"] >= 5
    assert len(answers) >= 4


def test_the_command_line_answers_and_explains(settled: LiveGraph) -> None:
    done = settled.sceneq("ask", "the red ball on the table", "--mode", "reason", "--json")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["route"] == "reasoned"
    assert np.linalg.norm(np.subtract(answer["instances"][0]["centre"], RED_BALL)) < 0.2
    shown = settled.zenoh_get("sceneq/query/room/instances?q=blue box", decoder="sceneq")[0]
    assert "blue box" in shown


def test_many_clients_at_once_all_get_an_answer_or_busy(settled: LiveGraph) -> None:
    key = "sceneq/query/room/instances?q="
    things = ("red ball", "blue box", "table", "green box", "something yellow")

    def ask(client: Client, thing: str) -> str:
        replies, errors = client.get(key + thing, timeout_s=60.0)
        assert len(replies) + len(errors) == 1
        return json.loads(replies[0][1].payload)["status"] if replies else errors[0].code

    with ExitStack() as stack, ThreadPoolExecutor(CLIENTS * 10) as pool:
        clients = [stack.enter_context(Client(settled.endpoint, 10.0)) for _ in range(CLIENTS)]
        asked = [
            pool.submit(ask, clients[i % CLIENTS], things[i % len(things)]) for i in range(400)
        ]
        said = Counter(one.result(120) for one in asked)
        assert set(said) <= {"found", "ambiguous", "not_found", "busy"}
        assert said.total() == 400
        assert said.total() > said["busy"]
        settled.wait(lambda: ask(clients[0], "red ball") != "busy")
