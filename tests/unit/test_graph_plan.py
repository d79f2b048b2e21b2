"""What one machine runs, where its router is, and what its scene is called."""

import socket
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_schemas.topics import ID
from sceneq_tools.errors import UserError
from sceneq_tools.graph import load
from sceneq_tools.graph_plan import Plan, need_free_port, plan, scene_name
from sceneq_tools.graph_problem import GraphError

TEXT = """\
robot: r2
router: {{listen: ['tcp/0.0.0.0:7500'], connect: ['tcp/far:7447']}}
nodes:
  - {{id: ingest, params: {{source: {{kind: folder, path: '{folder}'}}}}}}
  - {{id: mapping}}
  - {{id: routing, deploy: {{machine: server}}}}
"""


def planned(
    folder: Path,
    machine: str = "local",
    only: tuple[str, ...] = (),
    source: Path | None = None,
    port: int | None = None,
) -> Plan:
    path = folder / "graph.yaml"
    path.write_text(TEXT.format(folder=source or folder))
    return plan(*load(path), machine, only, port)


def test_a_machine_runs_its_part(tmp_path: Path) -> None:
    assert [n.id for n in planned(tmp_path).nodes] == ["ingest", "mapping"]
    assert [n.id for n in planned(tmp_path, "server").nodes] == ["routing"]
    assert [n.id for n in planned(tmp_path, only=("mapping",)).nodes] == ["mapping"]
    assert planned(tmp_path, only=("router",)).nodes == ()


def test_a_name_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"no node has 'deploy: \{machine: servr\}' \(did you mean"):
        planned(tmp_path, "servr")
    with pytest.raises(UserError, match=r"--only maping: no such node here \(did you mean 'mapp"):
        planned(tmp_path, only=("maping",))


def test_nodes_read_everything_from_one_json(tmp_path: Path) -> None:
    folder = tmp_path / "My Kitchen (2)"
    folder.mkdir()
    assert planned(tmp_path, source=folder, port=7600).as_json() == {
        "scene": "my_kitchen_2",
        "robot": "r2",
        "sensor": "camera",
        "store": None,
        "router": {
            "endpoint": "tcp/127.0.0.1:7600",
            "credentials": None,
            "listen": ["tcp/0.0.0.0:7600"],
            "connect": ["tcp/far:7447"],
        },
        "nodes": {
            "ingest": {
                "kind": "ingest",
                "params": {"source": {"kind": "folder", "path": str(folder)}},
            },
            "mapping": {"kind": "mapping", "params": {}},
        },
    }


def test_the_store_is_one_folder_from_wherever_a_node_looks(tmp_path: Path) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text("scene: room\nstore: maps/../kept\nnodes: [{id: mapping}]")
    assert plan(*load(path), "local").as_json()["store"] == str(Path.cwd() / "kept")


def test_a_source_folder_has_to_be_there_where_it_is_read(tmp_path: Path) -> None:
    absent = tmp_path / "absent"
    with pytest.raises(GraphError, match=r"graph\.yaml:4: nodes\.ingest\..*no such folder.*--sour"):
        planned(tmp_path, source=absent)
    assert planned(tmp_path, "server", source=absent).scene == "absent"


def test_without_a_source_the_scene_needs_a_name(tmp_path: Path) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text("nodes: [{id: mapping}]")
    with pytest.raises(GraphError, match=r"scene: missing key.*--scene NAME"):
        plan(*load(path), "local")


@given(st.text(max_size=40).filter(lambda name: not set(name) & set("/\0")))
def test_any_folder_gives_a_scene(name: str) -> None:
    assert ID.fullmatch(scene_name(Path("/data") / name))


def test_a_port_that_is_taken_is_told_with_a_way_out() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(UserError, match=rf"{port}: address already in use \(.*--port N"):
            need_free_port(f"tcp/127.0.0.1:{port}")
    need_free_port(f"tcp/127.0.0.1:{port}")
    need_free_port("unixsock-stream//run/zenoh")
    with pytest.raises(UserError, match=r"cannot listen on tcp/127\.0\.0\.1:many"):
        need_free_port("tcp/127.0.0.1:many")
