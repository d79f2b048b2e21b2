"""What is run on two network namespaces is right, and said plainly where it may not run."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from sceneq_tools.bench import link
from sceneq_tools.bench.measurement import Options
from sceneq_tools.chaos import namespaces, partition
from sceneq_tools.chaos.namespaces import Machine, NotPermittedError, Pair
from sceneq_tools.chaos.robot_and_server import EDGE, SERVER, Setup, faulty_graph
from sceneq_tools.chaos.scenario import Plan
from sceneq_tools.graph import load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.graph_plan import plan

PAIR = Pair(Machine("a", "10.0.0.1", "va", 1), Machine("b", "10.0.0.2", "vb", 2))


def faulty(folder: Path) -> dict[str, Any]:
    return faulty_graph(PAIR, Setup(source=folder), folder)


def thin(folder: Path) -> dict[str, Any]:
    return link.graph(PAIR, folder, "#so_sndbuf=32768")


@pytest.mark.parametrize("build", [faulty, thin])
def test_their_graphs_are_right(build: Callable[[Path], dict[str, Any]], tmp_path: Path) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text(yaml.safe_dump(build(tmp_path)))
    graph, document = load(path)
    check_nodes(graph, document)
    edge, server = (plan(graph, document, machine) for machine in (EDGE, SERVER))
    assert edge.router.connect == ["tcp/10.0.0.2:7448#so_sndbuf=32768"]
    assert edge.endpoint == server.endpoint == "tcp/127.0.0.1:7447"
    assert {"ingest", "mapping", "routing"} <= {node.id for node in edge.nodes}
    assert "pulled" in {node.id for node in server.nodes}
    assert edge.watchdog.silent_s > 60  # nodes are stopped on purpose


@pytest.fixture
def forbidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(namespaces.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(namespaces.shutil, "which", lambda program: program)


@pytest.mark.usefixtures("forbidden")
def test_faults_are_skipped_where_they_may_not_be_made(tmp_path: Path) -> None:
    (outcome,) = partition.run(Plan(tmp_path, tmp_path))
    assert outcome.verdict == "skipped"
    assert outcome.detail == "making network namespaces needs root"


@pytest.mark.usefixtures("forbidden")
def test_the_bench_says_what_it_lacks(tmp_path: Path) -> None:
    with pytest.raises(ConnectionError, match="needs root"):
        list(link.link(Options(source=tmp_path)))
    with pytest.raises(ConnectionError, match="say --source FOLDER"):
        list(link.link(Options()))


def test_a_missing_program_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(namespaces.shutil, "which", lambda program: None)
    with pytest.raises(NotPermittedError, match="no ip on this machine"):
        namespaces.need_permission()
