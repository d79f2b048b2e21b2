"""graph.yaml: every mistake is named with its line, path, value and a hint."""

from pathlib import Path

import pytest

from sceneq_nodes import NODES
from sceneq_tools.graph import Graph, Override, default_path, load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.graph_problem import GraphError

GOOD = """\
scene: room
nodes:
  - id: left
    kind: idle
    params: {size_m: 2}
  - id: right
    kind: idle
"""


@pytest.fixture(autouse=True)
def _idle_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(NODES, "idle", "support.idle_node:Idle")


def write(folder: Path, text: str) -> Path:
    path = folder / "graph.yaml"
    path.write_text(text)
    return path


def problems(folder: Path, text: str, *overrides: Override) -> list[str]:
    with pytest.raises(GraphError) as caught:
        check_nodes(*load(write(folder, text), overrides))
    assert caught.value.exit_code == 2
    return [str(problem) for problem in caught.value.problems]


def test_a_good_graph_has_the_defaults_of_the_rest(tmp_path: Path) -> None:
    graph, document = load(write(tmp_path, GOOD))
    check_nodes(graph, document)
    assert graph.scene == "room"
    assert graph.router.listen == ["tcp/127.0.0.1:7447"]
    assert [(n.id, n.node_kind, n.deploy.machine) for n in graph.nodes] == [
        ("left", "idle", "local"),
        ("right", "idle", "local"),
    ]
    assert graph.nodes[0].params == {"size_m": 2}


def test_the_graph_that_comes_with_the_package_is_right() -> None:
    graph, document = load(default_path())
    check_nodes(graph, document)
    first = ["ingest", "segmentation", "mapping", "views"]
    kinds = [*first, "encoding", "routing", "reasoning", "gateway"]
    assert [node.id for node in graph.nodes] == kinds


def test_the_graph_in_the_package_is_the_top_level_one() -> None:
    root = Path(__file__).parents[2]
    assert (root / "tools" / "graph.yaml").resolve() == root / "graph.yaml"


def test_every_mistake_is_told_at_once(tmp_path: Path) -> None:
    text = """\
scene: Room 1
sensr: camera
router:
  lisen: []
nodes:
  - id: left
    kind: idle
    restart_policy: sometimes
    max_restarts: lots
  - kind: idle
"""
    assert problems(tmp_path, text) == [
        "graph.yaml:1: scene: String should match pattern '^[a-z0-9_-]+$', got 'Room 1'",
        "graph.yaml:4: router.lisen: unknown key (did you mean 'listen'?)",
        "graph.yaml:8: nodes.left.restart_policy: Input should be 'on-failure', 'always' or "
        "'never', got 'sometimes'",
        "graph.yaml:9: nodes.left.max_restarts: Input should be a valid integer, got 'lots'",
        "graph.yaml:10: nodes.1.id: missing key (add 'id: ...')",
        "graph.yaml:2: sensr: unknown key (did you mean 'sensor'?)",
    ]


def test_every_parameter_is_checked_against_its_node(tmp_path: Path) -> None:
    text = """\
nodes:
  - id: left
    kind: idel
  - id: right
    kind: idle
    params:
      size_m: big
      faults: none
      source: {kind: foldr}
      limits:
        mast: 3
        least: none
"""
    told = problems(tmp_path, text)
    assert told[0].startswith("graph.yaml:3: nodes.left.kind: unknown kind, got 'idel' (did you")
    assert "graph.yaml:8: nodes.right.params.faults: unknown key (did you mean 'fault'?)" in told
    assert (
        "graph.yaml:9: nodes.right.params.source.kind: unknown kind, got 'foldr' "
        "(did you mean 'folder'?)" in told
    )
    assert (
        "graph.yaml:11: nodes.right.params.limits.mast: unknown key (did you mean 'most'?)" in told
    )
    assert any(line.startswith("graph.yaml:12: nodes.right.params.limits.least: ") for line in told)
    size = next(line for line in told if "size_m" in line)
    assert size.startswith("graph.yaml:7: nodes.right.params.size_m: ")
    assert size.endswith(", got 'big'")
    assert len(told) == 6


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("nodes: [", "graph.yaml:1: not YAML: "),
        ("- 1\n", "graph.yaml:1: expected 'key: value' lines"),
        ("", "graph.yaml:1: expected 'key: value' lines"),
        ("scene: a\nscene: b\n", "graph.yaml:2: scene: written twice"),
        ("scene: a\n", "graph.yaml:1: nodes: missing key (add 'nodes: ...')"),
        ("nodes: []\n", "graph.yaml:1: nodes: List should have at least 1 item"),
        ("nodes:\n- id: a\n- id: a\n", "graph.yaml:3: nodes.a.id: another node's id, got 'a'"),
        ("nodes:\n- id: router\n", "graph.yaml:2: nodes.router.id: the router's own name"),
        ("nodes:\n- id: a\n  deploy: {machin: b}\n", "graph.yaml:3: nodes.a.deploy.machin: unk"),
        ("nodes: 3\n", "graph.yaml:1: nodes: Input should be a valid list, got 3"),
        ("? [a]\n: 1\n", "graph.yaml:1: a key must be plain text"),
    ],
)
def test_what_cannot_be_read_is_told_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    assert problems(tmp_path, text)[0].startswith(told)


def test_what_the_parameters_check_themselves_is_told_where_it_is_written(tmp_path: Path) -> None:
    text = "nodes:\n- id: a\n  kind: idle\n  params:\n    limits:\n      least: 3\n      most: 2\n"
    assert problems(tmp_path, text) == [
        "graph.yaml:7: nodes.a.params.limits.most: expected at least 3, got 2"
    ]


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(GraphError, match=r"nowhere\.yaml: No such file or directory"):
        load(tmp_path / "nowhere.yaml")


def test_both_encoders_of_a_change_are_checked(tmp_path: Path) -> None:
    text = """\
nodes:
  - id: routing
    params:
      encoder: {kind: onnx, model: towers, bach: 2}
      meanwhile: {kind: conze}
"""
    assert problems(tmp_path, text) == [
        "graph.yaml:4: nodes.routing.params.encoder.bach: unknown key (did you mean 'batch'?)",
        "graph.yaml:5: nodes.routing.params.meanwhile.kind: unknown kind, got 'conze' "
        "(did you mean 'conse'?)",
    ]


def test_an_option_goes_over_every_node_of_its_kind(tmp_path: Path) -> None:
    over = [
        Override("idle", ("source", "path"), "/data", "--source"),
        Override("", ("scene",), "kitchen", "--scene"),
    ]
    graph, _ = load(write(tmp_path, GOOD), over)
    assert graph.scene == "kitchen"
    assert graph.nodes[0].params == {"size_m": 2, "source": {"path": "/data"}}
    assert graph.nodes[1].params == {"source": {"path": "/data"}}


def test_an_option_is_blamed_for_its_own_value(tmp_path: Path) -> None:
    over = Override("idle", ("size_m",), "wide", "--size")
    told = problems(tmp_path, GOOD, over)
    assert [line.partition(":")[0] for line in told] == ["--size", "--size"]
    absent = Override("ingest", ("rate_hz",), 3.0, "--rate")
    assert problems(tmp_path, GOOD, absent) == ["--rate: nodes: graph.yaml has no node 'ingest'"]


def test_a_graph_cannot_be_changed(tmp_path: Path) -> None:
    graph, _ = load(write(tmp_path, GOOD))
    assert isinstance(graph, Graph)
    with pytest.raises(ValueError, match="frozen"):
        graph.scene = "other"  # type: ignore[misc]
