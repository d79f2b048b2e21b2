"""Two robots in a graph: whoever reads frames has to hear both."""

from pathlib import Path

import pytest

from sceneq_tools.graph import load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.graph_problem import GraphError

TEXT = """\
scene: room
robot: a
nodes:
  - {id: ingest, params: {source: {kind: folder, path: a}}}
  - id: second
    kind: ingest
    params: {robot: b, source: {kind: folder, path: b}}
  - {id: segmentation, params: {robots: [b]}}
  - {id: mapping, params: {robots: [b]}}
  - {id: views, params: {robots: [b]}}
"""


def problems(folder: Path, old: str = "", new: str = "") -> list[str]:
    path = folder / "graph.yaml"
    path.write_text(TEXT.replace(old, new))
    graph, document = load(path)
    try:
        check_nodes(graph, document)
    except GraphError as error:
        return str(error).splitlines()
    return []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("robot: b, ", ""),  # the graph's own robot is heard by all
        ("robot: b, ", "robot: a, "),
        ("  - {id: mapping, params: {robots: [b]}}\n", ""),  # on a machine of another graph
    ],
)
def test_robots_that_are_heard_are_fine(tmp_path: Path, old: str, new: str) -> None:
    assert problems(tmp_path, old, new) == []


def test_one_of_a_kind_that_hears_is_enough(tmp_path: Path) -> None:
    one = "  - {id: segmentation, params: {robots: [b]}}\n"
    both = "  - {id: segmentation}\n  - {id: other, kind: segmentation, params: {robots: [b]}}\n"
    assert problems(tmp_path, one, both) == []


def test_what_is_no_list_is_told_as_such(tmp_path: Path) -> None:
    told = problems(tmp_path, "id: views, params: {robots: [b]}", "id: views, params: {robots: 5}")
    assert len(told) == 2
    assert any("nodes.views.params.robots" in line and "got 5" in line for line in told)


@pytest.mark.parametrize("node", ["segmentation", "mapping", "views"])
def test_a_robot_that_nobody_hears_is_told(tmp_path: Path, node: str) -> None:
    (line,) = problems(tmp_path, f"id: {node}, params: {{robots: [b]}}", f"id: {node}")
    assert f"nodes.{node}.params.robots: does not name 'b', whose frames 'second' sends" in line
    assert line.endswith("(robots: [b])")
    assert line.startswith("graph.yaml:")
