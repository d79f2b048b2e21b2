"""Machines of a graph: whose nodes, whose router, and what their link has to carry."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_tools.crossing import crossings
from sceneq_tools.errors import UserError
from sceneq_tools.graph import Graph, load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.graph_machines import link_problems
from sceneq_tools.graph_plan import Plan, plan
from sceneq_tools.graph_problem import GraphError

TEXT = """\
scene: room
router: {listen: ['tcp/127.0.0.1:7600']}
machines:
  edge:
    uplink_mbit_s: 20
    router:
      listen: ['tcp/127.0.0.1:7447']
      connect:
        - tcp/far:7448?prio=0-3
        - tcp/far:7449?prio=4-7
  server: {}
nodes:
  - id: ingest
    deploy: {machine: edge}
    params:
      source: {kind: folder, path: /data}
      keyframes: {kind: interval, period_s: 0.2}
      rgb_codec: jpeg
      depth_codec: delta
  - {id: mapping, deploy: {machine: edge}}
  - {id: views, deploy: {machine: server}}
"""


def read(folder: Path, old: str = "", new: str = "") -> Graph:
    """Return the checked graph with ``new`` instead of ``old``."""
    assert old in TEXT
    path = folder / "graph.yaml"
    path.write_text(TEXT.replace(old, new) if old else TEXT)
    graph, document = load(path)
    check_nodes(graph, document)
    return graph


def of(folder: Path, machine: str, **options: object) -> Plan:
    read(folder, "uplink_mbit_s: 20", "uplink_mbit_s: 100")
    return plan(*load(folder / "graph.yaml"), machine, elsewhere=True, **options)  # type: ignore[arg-type]


def problems(folder: Path, old: str = "", new: str = "") -> list[str]:
    with pytest.raises(GraphError) as caught:
        read(folder, old, new)
    return str(caught.value).splitlines()


def test_each_machine_has_a_router_of_its_own_or_the_common_one(tmp_path: Path) -> None:
    edge, server = of(tmp_path, "edge"), of(tmp_path, "server")
    assert edge.router.connect == ["tcp/far:7448?prio=0-3", "tcp/far:7449?prio=4-7"]
    assert edge.endpoint == "tcp/127.0.0.1:7447"
    assert server.endpoint == "tcp/127.0.0.1:7600"
    assert [node.id for node in server.nodes] == ["views"]
    assert of(tmp_path, "edge", connect=["tcp/other:1"]).router.connect == ["tcp/other:1"]


def test_a_machine_may_run_its_router_alone(tmp_path: Path) -> None:
    graph = read(tmp_path, "uplink_mbit_s: 20", "uplink_mbit_s: 100")
    text = (tmp_path / "graph.yaml").read_text()
    (tmp_path / "graph.yaml").write_text(text.replace("  server: {}", "  server: {}\n  hub: {}"))
    loaded, document = load(tmp_path / "graph.yaml")
    assert plan(loaded, document, "hub", elsewhere=True).nodes == ()
    assert set(graph.machines) == {"edge", "server"}
    with pytest.raises(UserError, match=r"did you mean 'hub'"):
        plan(loaded, document, "hubb", elsewhere=True)


def test_what_is_written_wrong_is_told_with_its_line(tmp_path: Path) -> None:
    assert problems(tmp_path, "uplink_mbit_s", "uplink") == [
        "graph.yaml:5: machines.edge.uplink: unknown key (did you mean 'uplink_mbit_s'?)"
    ]
    assert problems(tmp_path, "      listen: ['tcp/127.0.0.1:7447']", "      lisen: []") == [
        "graph.yaml:7: machines.edge.router.lisen: unknown key (did you mean 'listen'?)"
    ]
    homeless, *_ = problems(
        tmp_path, "mapping, deploy: {machine: edge}", "mapping, deploy: {machine: edg}"
    )
    assert homeless.startswith("graph.yaml:20: nodes.mapping.deploy.machine: not one of 'machines'")
    assert "did you mean 'edge'" in homeless


def test_two_machines_need_a_common_name_for_the_scene(tmp_path: Path) -> None:
    found = problems(tmp_path, "scene: room\n", "")
    assert any("scene: missing key (add 'scene: NAME'" in line for line in found)


def test_a_link_that_is_too_thin_is_told(tmp_path: Path) -> None:
    (line,) = problems(tmp_path)
    assert line.startswith("graph.yaml:5: machines.edge.uplink_mbit_s: edge would send up to 30.8")
    assert "most of it map_delta (18.0)" in line
    assert read(tmp_path, "uplink_mbit_s: 20", "uplink_mbit_s: 40").scene == "room"


def test_raw_frames_are_seen_in_the_budget(tmp_path: Path) -> None:
    compressed = read(tmp_path, "uplink_mbit_s: 20", "uplink_mbit_s: 100")
    raw = read(tmp_path, "    uplink_mbit_s: 20\n", "").model_copy()
    params = {**raw.nodes[0].params, "rgb_codec": "raw", "depth_codec": "raw"}
    nodes = [raw.nodes[0].model_copy(update={"params": params}), *raw.nodes[1:]]
    raw = raw.model_copy(update={"nodes": nodes})
    rates = [{one.stream: one.mbit_s for one in crossings(graph)} for graph in (compressed, raw)]
    assert rates[0]["frame"] == pytest.approx(12.8)
    assert rates[1]["frame"] == pytest.approx(61.44)
    rounded = {one.stream: one.mbit_s for one in crossings(compressed, rounded=True)}
    assert rounded["frame"] == pytest.approx(5.8)


@pytest.mark.parametrize(
    "endpoints",
    [
        [],
        ["tcp/a:1"],
        ["tcp/a:1", "tcp/b:1"],
        ["tcp/a:1?prio=0-3", "tcp/a:2?prio=4-7", "tcp/b:1"],
        ["tcp/a:1?prio=0-7"],
    ],
)
def test_links_that_carry_everything_once(endpoints: list[str]) -> None:
    assert link_problems(endpoints) == []


@pytest.mark.parametrize(
    "endpoints",
    [
        ["tcp/a:1?prio=0-3"],
        ["tcp/a:1?prio=0-3", "tcp/a:2?prio=5-7"],
        ["tcp/a:1?prio=0-4", "tcp/a:2?prio=4-7"],
        ["tcp/a:1?prio=0-3", "tcp/a:2"],
        ["tcp/a:1?prio=0-9"],
        ["tcp/a:1?prio=0-3", "tcp/b:2?prio=4-7"],
    ],
)
def test_links_that_leave_a_gap_or_overlap(endpoints: list[str]) -> None:
    assert "must carry priorities 0 to 7 once" in link_problems(endpoints)[0]


@given(st.integers(0, 6))
def test_any_split_in_two_is_right(last: int) -> None:
    links = [f"tcp/a:1?prio=0-{last}", f"tcp/a:2?prio={last + 1}-7"]
    assert link_problems(links) == []
