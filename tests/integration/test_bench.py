"""Benches on as little as possible, typed as the documents have them: structure, no timings.

What is typed behind a command, so that it takes seconds, is in support/command_ways.py. A map of
laps has 120 keyframes here, not 500, and the room that is rendered is an empty box.
"""

import json
import shutil
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from sceneq_tools.bench import laps as laps_module
from sceneq_tools.bench import stages as stages_module
from sceneq_tools.bench.processes import helper
from sceneq_tools.bench.registry import BENCHES, ON_REQUEST
from sceneq_tools.room.layout import compose as compose_module

from support.command_ways import row_of, shortened
from support.documents import Command
from support.live_graph import write_graph
from support.reader import Reader
from support.recording import write_recording
from support.tiny_room import cube, thing, tiny_room

pytestmark = pytest.mark.integration

Measured = dict[str, dict[str, Any]]


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Reader:
    """A person with a small recording, and a graph without trained weights for it."""
    folder = tmp_path_factory.mktemp("bench")
    write_recording(folder / "kitchen", frames=12)
    shutil.copy(write_graph(folder, folder / "kitchen"), folder / "small.yaml")
    return Reader(folder, folder)


@pytest.mark.parametrize("command", shortened(__file__), ids=lambda command: command.where)
def test_what_the_documents_measure(
    reader: Reader, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(laps_module, "EARLY", 12)
    monkeypatch.setattr(laps_module, "LATE", 24)
    monkeypatch.setattr(compose_module, "compose", lambda *_: tiny_room(thing(7, cube(0.4))))
    files = ("--graph", "small.yaml", "--json", "measured.json")
    source = () if "--source" in command.text else ("--source", "kitchen")
    reader.succeeds(command.text, *row_of(command).more.split(), *source, *files)
    found = read(reader.folder / "measured.json")
    named = [word for word in command.text.split() if word in BENCHES]
    assert list(found) == (named or [name for name in BENCHES if name not in ON_REQUEST])
    for name, measured in found.items():
        assert all(one["value"] > 0 or "lost" in one["name"] for one in measured.values()), name
        CHECKS.get(name, print)(measured)


def read(path: Path) -> dict[str, Measured]:
    """Return what was measured, by bench and name."""
    found: dict[str, Measured] = defaultdict(dict)
    for one in json.loads(path.read_text())["measurements"]:
        found[one["bench"]][f"{one['name']} {one['unit']}"] = one
    return found


def check_bus(measured: Measured) -> None:
    assert {one["name"] for one in measured.values()} == {
        "get of 64 B p50",
        "get of 64 B p99",
        "frame of 1.5 MB p50",
        "frame of 1.5 MB p99",
        "stream of frames",
        "frames lost",
    }
    assert measured.pop("frames lost frames")["value"] >= 0
    assert all(one["ratio"] for one in measured.values())


def check_stages(measured: Measured) -> None:
    parts = [measured[f"{part} ms a keyframe"]["value"] for part in stages_module.PARTS]
    nodes = {node: measured[f"{node} ms a keyframe"] for node in stages_module.NODES}
    assert all(node["reference"] > 0 for node in nodes.values())
    named = zip(stages_module.PARTS, parts, strict=True)
    of_mapping = sum(value for part, value in named if "mapping" in part)
    assert of_mapping <= nodes["mapping"]["value"]
    assert "segmentation, mapping, views keyframes/s" in measured
    assert "mapping, last third ms" in measured
    assert measured["memory at most MiB"]["value"] > 50


def check_stream(measured: Measured) -> None:
    (one,) = measured.values()
    assert (one["name"], one["unit"]) == ("keyframes, 4 processes", "/s")
    assert one["ratio"] is not None


def check_laps(measured: Measured) -> None:
    cost, memory = measured.values()
    assert (cost["name"], memory["name"]) == ("mapping, keyframe 24", "memory of mapping, 10 laps")
    assert len(cost["series"]) == len(memory["series"]) == 40
    assert memory["value"] > 50
    assert 0.9 < memory["ratio"] < 1.5


def check_query(measured: Measured) -> None:
    assert {one["name"] for one in measured.values()} == {
        "answer",
        *(
            f"{question}{when}, {share}"
            for question in ("question asked before", "new question")
            for when in ("", " while mapping at 10/s")
            for share in ("p50", "p99")
        ),
    }
    assert measured["new question, p50 ms"]["beside"] == "bare get + text tower"
    assert 0.2 < measured["answer kB"]["value"] < 100


CHECKS = {
    "bus": check_bus,
    "stages": check_stages,
    "stream": check_stream,
    "laps": check_laps,
    "query": check_query,
}


def test_a_helper_that_ends_early_is_named(capfd: pytest.CaptureFixture[str]) -> None:
    with (
        pytest.raises(ConnectionError, match=r"bench\.echo ended with exit code 1"),
        helper("sceneq_tools.bench.echo"),
    ):
        pass
    assert "IndexError" in capfd.readouterr().err
