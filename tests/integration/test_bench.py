"""Benches that need other processes or a map, on as little as possible: structure, no timings."""

from pathlib import Path

import pytest

from sceneq_tools.bench import laps as laps_module
from sceneq_tools.bench import stages as stages_module
from sceneq_tools.bench.bus import bus
from sceneq_tools.bench.laps import laps
from sceneq_tools.bench.measurement import Options
from sceneq_tools.bench.processes import helper
from sceneq_tools.bench.query import query
from sceneq_tools.bench.stages import stages
from sceneq_tools.bench.stream import stream

from support.live_graph import write_graph
from support.recording import write_recording

pytestmark = pytest.mark.integration


@pytest.fixture
def options(tmp_path: Path) -> Options:
    recording = write_recording(tmp_path / "room", frames=12)
    graph = write_graph(tmp_path, recording)
    return Options(recording, graph, seconds=0.02, quiet=True)


def test_the_bus_is_measured_beside_tcp() -> None:
    measured = {(one.name, one.unit): one for one in bus(Options(seconds=0.02))}
    assert {name for name, _ in measured} == {
        "get of 64 B p50",
        "get of 64 B p99",
        "frame of 1.5 MB p50",
        "frame of 1.5 MB p99",
        "stream of frames",
        "frames lost",
    }
    assert measured.pop(("frames lost", "frames")).value >= 0
    assert all(one.value > 0 and one.ratio for one in measured.values())


def test_every_stage_of_a_keyframe_is_measured(options: Options) -> None:
    measured = {one.name: one for one in stages(options)}
    for name in (*stages_module.NODES, *stages_module.PARTS):
        assert measured[name].value > 0, name
        assert measured[name].reference > 0
    assert sum(measured[part].value for part in stages_module.PARTS if "mapping" in part) <= (
        measured["mapping"].value
    )
    assert measured["segmentation, mapping, views"].unit == "keyframes/s"
    assert measured["mapping, last third"].value > 0
    assert measured["memory at most"].value > 50


def test_keyframes_are_counted_through_processes(options: Options) -> None:
    (measured,) = stream(options)
    assert (measured.name, measured.unit) == ("keyframes, 4 processes", "/s")
    assert measured.value > 0
    assert measured.ratio is not None


def test_laps_are_mapped_in_a_process_of_their_own(
    options: Options, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(laps_module, "EARLY", 12)
    monkeypatch.setattr(laps_module, "LATE", 24)
    cost, memory = laps(options)
    assert (cost.name, memory.name) == ("mapping, keyframe 24", "memory of mapping, 10 laps")
    assert len(cost.series) == len(memory.series) == 120
    assert cost.value > 0
    assert memory.value > 50
    assert memory.ratio is not None
    assert 0.9 < memory.ratio < 1.5


def test_questions_are_measured_beside_a_bare_get(options: Options) -> None:
    measured = {one.name: one for one in query(options)}
    assert set(measured) == {
        "answer",
        *(
            f"{question}{when}, {share}"
            for question in ("question asked before", "new question")
            for when in ("", " while mapping at 10/s")
            for share in ("p50", "p99")
        ),
    }
    assert measured["new question, p50"].beside == "bare get + text tower"
    assert all(one.value > 0 for one in measured.values())
    assert 0.2 < measured["answer"].value < 100


def test_a_helper_that_ends_early_is_named(capfd: pytest.CaptureFixture[str]) -> None:
    with (
        pytest.raises(ConnectionError, match=r"bench\.echo ended with exit code 1"),
        helper("sceneq_tools.bench.echo"),
    ):
        pass
    assert "IndexError" in capfd.readouterr().err
