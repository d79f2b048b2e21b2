"""When a map may be used again, and when it must be made again."""

from pathlib import Path

import pytest

from sceneq_tools.evaluation import suite_maps
from sceneq_tools.evaluation.suite_maps import MapOptions, Mapped, mapped
from sceneq_tools.evaluation.suite_recordings import Recording

from support.live_graph import write_graph
from support.recording import write_recording

MADE = {"frames": 2, "keyframes": 1, "taken_ms": {"ingest": 3.5}, "took_s": 0.5, "troubles": {}}


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Recording:
    def make(plan: object, name: str, folder: Path, quiet: bool) -> dict:
        folder.mkdir(parents=True, exist_ok=True)
        return MADE

    monkeypatch.setattr(suite_maps, "_make", make)
    return Recording("room", write_recording(tmp_path / "room", frames=2), "given")


@pytest.fixture
def options(tmp_path: Path) -> MapOptions:
    return MapOptions(tmp_path / "maps", write_graph(tmp_path, tmp_path / "room"))


def keys(first: Mapped, second: Mapped) -> set[str]:
    assert not first.was_there
    return {first.key, second.key}


def test_the_same_map_is_made_once(recording: Recording, options: MapOptions) -> None:
    first, second = mapped(recording, options), mapped(recording, options)
    assert len(keys(first, second)) == 1
    assert second.was_there
    assert (second.frames, second.keyframes, second.taken_ms) == (2, 1, {"ingest": 3.5})
    assert first.folder.name == f"room-{first.key}"
    assert not mapped(recording, MapOptions(options.cache, options.graph, fresh=True)).was_there


def test_a_map_that_was_not_finished_is_none(recording: Recording, options: MapOptions) -> None:
    (mapped(recording, options).folder / suite_maps.RECORD_FILE).unlink()
    assert not mapped(recording, options).was_there


def test_what_changes_a_map_changes_its_key(
    recording: Recording, options: MapOptions, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = mapped(recording, options)
    every = Recording("room", recording.folder, "given", every=2)
    assert len(keys(first, mapped(every, options))) == 2
    rgbd = MapOptions(options.cache, options.graph, "rgbd")
    assert len(keys(first, mapped(recording, rgbd))) == 2
    with monkeypatch.context() as patch:
        patch.setattr(suite_maps, "code_digest", lambda: "another")
        assert len(keys(first, mapped(recording, options))) == 2
    (recording.folder / "frame-000001.pose.txt").write_text("1 0 0 0\n" * 4)
    assert len(keys(first, mapped(recording, options))) == 2


def test_where_a_recording_lies_does_not_change_its_map(
    recording: Recording, options: MapOptions, tmp_path: Path
) -> None:
    first = mapped(recording, MapOptions(options.cache, options.graph, "files"))
    moved = recording.folder.rename(tmp_path / "elsewhere")
    again = mapped(
        Recording("room", moved, "given"), MapOptions(options.cache, options.graph, "files")
    )
    assert again.was_there
    assert len(keys(first, again)) == 1
