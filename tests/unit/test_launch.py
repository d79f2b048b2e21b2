"""What a process runs: from the launcher's file, from the command line, or a clear refusal."""

import json
from pathlib import Path
from typing import Any

import pytest

from sceneq_nodes._bus import Context
from sceneq_nodes._launch import Launch, RouterLaunch, read_launch

GRAPH = {
    "scene": "kitchen",
    "robot": "r1",
    "sensor": "cam",
    "router": {
        "endpoint": "tcp/127.0.0.1:7000",
        "listen": ["tcp/0.0.0.0:7000"],
        "connect": ["tcp/server:7447"],
    },
    "nodes": {"mapping": {"kind": "mapping", "params": {"mapper": {"voxel_m": 0.02}}}},
}


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    path = tmp_path / "graph.json"
    path.write_text(json.dumps(GRAPH))
    return {"SCENEQ_GRAPH": str(path), "SCENEQ_NODE": "mapping"}


def test_the_file_says_everything(environment: dict[str, str]) -> None:
    context = Context(node="mapping", scene="kitchen", robot="r1", sensor="cam")
    params = {"mapper": {"voxel_m": 0.02}}
    assert read_launch([], environment) == Launch("mapping", context, params, "tcp/127.0.0.1:7000")


def test_the_command_line_goes_over_the_file(environment: dict[str, str]) -> None:
    arguments = ["--param", "mapper.voxel_m=0.05", "--param", "mapper.name=a b", "--scene", "room"]
    launch = read_launch([*arguments, "--endpoint", "tcp/other:1"], environment)
    assert isinstance(launch, Launch)
    assert launch.params == {"mapper": {"voxel_m": 0.05, "name": "a b"}}
    assert launch.context.scene == "room"
    assert launch.endpoint == "tcp/other:1"


def test_a_node_runs_alone_without_a_file() -> None:
    launch = read_launch(["views", "--param", "waiting=3", "--param", 'names=["a"]'], {})
    context = Context(node="views", scene="scene", robot="robot", sensor="camera")
    assert launch == Launch("views", context, {"waiting": 3, "names": ["a"]}, "tcp/127.0.0.1:7447")


def test_durable_files_lie_in_a_folder_of_the_scene(environment: dict[str, str]) -> None:
    path = Path(environment["SCENEQ_GRAPH"])
    path.write_text(json.dumps({**GRAPH, "store": "/maps"}))
    launch = read_launch([], environment)
    assert isinstance(launch, Launch)
    assert launch.context.store == Path("/maps/kitchen")
    alone = read_launch(["mapping", "--scene", "hall", "--store", "here"], {})
    assert isinstance(alone, Launch)
    assert alone.context.store == Path("here/hall")


def test_the_router(environment: dict[str, str]) -> None:
    assert read_launch(["router"], environment) == RouterLaunch(
        ["tcp/0.0.0.0:7000"], ["tcp/server:7447"], scene="kitchen"
    )
    assert read_launch(["router"], {}) == RouterLaunch(["tcp/127.0.0.1:7447"], ())
    alone = read_launch(["router", "--endpoint", "tcp/127.0.0.1:1"], {})
    assert alone == RouterLaunch(["tcp/127.0.0.1:1"], ())


@pytest.mark.parametrize(
    ("arguments", "changes", "says"),
    [
        ([], {"SCENEQ_NODE": "maping"}, "nodes.maping: no such node (did you mean 'mapping'?)"),
        ([], {"SCENEQ_GRAPH": "/no/graph.json"}, "SCENEQ_GRAPH /no/graph.json: "),
        (["--param", "voxel_m"], {}, "--param voxel_m: expected KEY=VALUE"),
        (["--param", "=3"], {}, "--param =3: expected KEY=VALUE"),
        (["--scene", "My Kitchen"], {}, "scene: 'My Kitchen' does not match [a-z0-9_-]+"),
        ([], {"SCENEQ_GRAPH": "", "SCENEQ_NODE": ""}, "nothing to run: name a node kind"),
    ],
)
def test_refusals(
    environment: dict[str, str], arguments: list[str], changes: dict[str, Any], says: str
) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011  (the text is compared below)
        read_launch(arguments, environment | changes)
    assert str(caught.value).startswith(says)


def test_a_file_that_is_no_json_is_named(tmp_path: Path) -> None:
    path = tmp_path / "graph.json"
    path.write_text("{")
    with pytest.raises(ValueError, match=r"graph\.json: Expecting property name"):
        read_launch([], {"SCENEQ_GRAPH": str(path), "SCENEQ_NODE": "mapping"})
