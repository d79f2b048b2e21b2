"""Options and commands about sources, recordings and cameras."""

from pathlib import Path

import pytest

from sceneq_nodes._bus import Context
from sceneq_tools import replaying
from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode, load
from sceneq_tools.graph_plan import plan, scene_name
from sceneq_tools.import_command import run as run_import
from sceneq_tools.record_option import need_new_file, with_recorder
from sceneq_tools.replay_command import run as run_replay
from sceneq_tools.up_command import _chosen_names, camera_overrides, source_overrides

from support.fake_bus import FakeBus
from support.live_graph import write_graph
from support.mcap_files import write_mcap
from support.seven_scenes import write_folder


def overrides(source: Path) -> dict:
    given = source_overrides(source, None, None, None, False, False, None)
    return {override.path: override.value for override in given}


def test_every_keyframe_of_a_recording_is_one(tmp_path: Path) -> None:
    write_mcap(tmp_path / "My Run.mcap", 1)
    found = overrides(tmp_path / "My Run.mcap")
    assert found["source", "kind"] == "mcap"
    assert found["keyframes",] == {"kind": "every", "every": 1}
    assert scene_name(tmp_path / "My Run.mcap") == "my_run"
    assert ("keyframes",) not in overrides(write_folder(tmp_path / "wall", [0]))


def test_a_path_that_fits_no_layout_is_a_line_with_all_of_them(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no frames in a layout that is known") as caught:
        overrides(tmp_path)
    assert caught.value.exit_code == 2
    assert "\n" not in str(caught.value)


def test_a_camera_is_live_and_names_the_scene() -> None:
    values = {o.path: o.value for o in camera_overrides("oak")}
    assert values == {("scene",): "oak", ("source",): {"kind": "oak"}, ("rate_hz",): 30.0}
    assert camera_overrides(None) == []
    with pytest.raises(UserError, match=r"--camera webcam: expected one of realsense, oak"):
        camera_overrides("webcam")


def test_nodes_can_be_left_out(tmp_path: Path) -> None:
    graph, _ = load(write_graph(tmp_path, write_folder(tmp_path / "wall", [0])), [])
    assert _chosen_names(graph, "local", ["ingest,views"], []) == ["ingest", "views"]
    left = _chosen_names(graph, "local", [], ["ingest"])
    assert "ingest" not in left
    assert "mapping" in left
    with pytest.raises(UserError, match=r"--without injest: no such node here \(did you mean"):
        _chosen_names(graph, "local", [], ["injest"])


def test_ingest_waits_for_the_recorder(tmp_path: Path) -> None:
    graph, document = load(
        write_graph(tmp_path, write_folder(tmp_path / "wall", [0])),
        source_overrides(tmp_path / "wall", None, None, None, False, False, None),
    )
    recorded = with_recorder(plan(graph, document, "local"), tmp_path / "run.mcap")
    nodes = {node.id: node for node in recorded.nodes}
    assert nodes["recorder"].params == {"path": str(tmp_path / "run.mcap")}
    waits = nodes["ingest"].params["wait_for"]
    assert waits == ["segmentation", "mapping", "views", "recorder"]
    with pytest.raises(UserError, match="has a recorder already"):
        with_recorder(recorded, tmp_path / "other.mcap")
    assert with_recorder(recorded, None) is recorded


def test_nothing_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "run.mcap").touch()
    for path, said in (
        ("run.mcap", "is there already"),
        ("run.bag", "recordings are called .mcap"),
        ("nowhere/run.mcap", "no such folder"),
    ):
        with pytest.raises(UserError, match=said):
            need_new_file(tmp_path / path)


def test_only_what_was_recorded_in_time_is_replayed(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "wall", [0])
    with pytest.raises(UserError, match=r"no recording in time .*sceneq up --source"):
        run_replay(folder, connect="tcp/127.0.0.1:1")


def test_a_replay_ends_its_process_when_all_is_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_mcap(tmp_path / "run.mcap", 2)
    signals: list[int] = []
    monkeypatch.setattr(replaying.signal, "raise_signal", signals.append)
    params = replaying.Replay.Params(
        {"kind": "mcap", "path": str(tmp_path / "run.mcap")},
        keyframes={"kind": "every", "every": 1},
        rate_hz=1e6,
        wait_for=(),
    )
    node = replaying.Replay(params, Context("replay-1", "room", "r1", "cam"))
    bus = FakeBus()
    node.open(bus)
    for _ in range(50):
        node.step(None)
        if signals:
            break
    node.close()
    assert signals == [replaying.signal.SIGTERM]
    assert bus.reported["state"] == "finished"
    assert bus.reported["keyframes"] == 2


def test_an_import_says_what_it_cannot_do(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "wall", [0], poses=False)
    with pytest.raises(UserError, match="has no poses"):
        run_import(folder, tmp_path / "wall.mcap", quiet=True)
    with pytest.raises(UserError, match="is there already"):
        run_import(folder, folder, quiet=True)
    with pytest.raises(UserError, match="--set step: expected NAME=VALUE"):
        run_import(folder, tmp_path / "new", params=["step"], quiet=True)
    with pytest.raises(UserError, match="unknown key"):
        run_import(folder, tmp_path / "new", params=["pace=2"], quiet=True)
    (folder / "frame-000000.depth.png").write_bytes(b"gone")
    with pytest.raises(UserError, match="no frame has a usable depth image"):
        run_import(folder, tmp_path / "new", quiet=True)


def test_an_import_may_shrink_colour_to_jpeg(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "wall", [0, 1])
    run_import(folder, tmp_path / "small", quality=50, params=["step=2"], quiet=True)
    names = {path.name for path in (tmp_path / "small").iterdir()}
    assert "frame-000000.color.jpg" in names
    assert "frame-000001.color.jpg" not in names
    run_import(folder, tmp_path / "small.mcap", quality=50, quiet=True)
    assert overrides(tmp_path / "small.mcap")["source", "kind"] == "mcap"


def test_a_recorder_is_a_node_of_any_graph() -> None:
    assert GraphNode(id="recorder").node_kind == "recorder"
