"""A finished map as a recording."""

from pathlib import Path

import pytest

from sceneq_core.mapping.replica import MapReplica
from sceneq_tools.errors import UserError
from sceneq_tools.rerun_file import write_rerun
from sceneq_tools.scene_files import SceneFiles

from support.rerun_file import contents
from support.room import Room
from support.true_map import TrueMap, frame_of


@pytest.fixture
def files() -> SceneFiles:
    room, replica = Room(), MapReplica()
    true_map = TrueMap(room)
    for i in range(2):
        replica.apply(true_map.integrate(*frame_of(room, i, 2)))
    records = [{"id": key, "label": "ball", "p": 0.2 * key} for key in replica.instances]
    return SceneFiles("room", "labels", replica, tuple(records))


def test_cloud_and_boxes_are_in_the_file(files: SceneFiles, tmp_path: Path) -> None:
    write_rerun(files, tmp_path / "scene.rrd")
    shown = contents(tmp_path / "scene.rrd")
    assert {"/world", "/world/colour/0", "/world/instances/0", "/world/boxes"} <= set(
        shown.entities
    )
    points = [
        point
        for entity, logged in shown.entities.items()
        if entity.startswith("/world/colour/")
        for row in logged["Points3D:positions"]
        for point in row
    ]
    assert len(points) == files.replica.alive.sum()
    words = shown.texts("/world/boxes")
    assert "1" in words
    assert "4 ball" in words


def test_without_rerun_it_names_the_package(
    files: SceneFiles, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rerun", None)
    with pytest.raises(UserError, match="rerun-sdk"):
        write_rerun(files, tmp_path / "scene.rrd")
