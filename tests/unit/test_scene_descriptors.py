"""Descriptors in a scene's folder: written, read again, and missed where they are not."""

import json
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._bus import Reply
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._wire import to_bytes
from sceneq_schemas import topics
from sceneq_tools.collect import collect
from sceneq_tools.errors import UserError
from sceneq_tools.scene_files import (
    Descriptors,
    SceneFiles,
    no_descriptors,
    read_descriptors,
    read_scene,
)

from support.true_map import delta

ROWS = {7: np.array([0.6, 0.8], np.float32), 3: np.array([1.0, 0.0], np.float32)}
FEATURES = {7: np.array([0.0, 0.0, 1.0], np.float32), 3: np.array([0.0, 1.0, 0.0], np.float32)}


def write(folder: Path, descriptors: Descriptors) -> Path:
    SceneFiles("room", "scannet200", replica(), (), descriptors).write(folder)
    return folder


def replica() -> MapReplica:
    """A map without a voxel, which has no picture either."""
    made = MapReplica()
    made.apply(delta(full=True))
    return made


def test_descriptors_are_kept_by_id(tmp_path):
    read = read_descriptors(write(tmp_path, Descriptors("hash-v1", ROWS, FEATURES)))
    assert read.model == "hash-v1"
    assert {key: row.tolist() for key, row in read.rows.items()} == {
        key: row.tolist() for key, row in ROWS.items()
    }
    ids, rows, features = read.arrays()
    assert ids.tolist() == [3, 7]
    assert rows.dtype == np.float32
    assert features.tolist() == [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def test_a_scene_without_an_encoder_has_none(tmp_path):
    assert read_descriptors(write(tmp_path, no_descriptors())).rows == {}


def test_the_digest_of_the_map_does_not_depend_on_them(tmp_path):
    one = read_scene(write(tmp_path / "a", Descriptors("hash-v1", ROWS, FEATURES)))[1]
    two = read_scene(write(tmp_path / "b", no_descriptors()))[1]
    assert one["digest"] == two["digest"]


def test_a_folder_of_an_older_version_says_so(tmp_path):
    write(tmp_path, no_descriptors())
    document = json.loads((tmp_path / "instances.json").read_text())
    del document["model"]
    (tmp_path / "instances.json").write_text(json.dumps(document))
    with pytest.raises(UserError, match=r"no descriptors: model \(write it anew"):
        read_descriptors(tmp_path)
    with pytest.raises(UserError, match="nowhere: cannot be read"):
        read_descriptors(tmp_path / "nowhere")


def test_a_scene_is_gathered_also_when_no_encoder_answers():
    empty = {"instances": [], "label_set": "custom", "model": "hash-v1"}

    def get(topic, parameters, **ids):
        if topic is topics.FEATURE_SNAPSHOT:
            assert ids == {"model": "hash-v1"}
            return None
        if topic is topics.MAP_SNAPSHOT:
            return Reply(map_snapshot(), topic.encoding)
        return Reply(json.dumps(empty).encode(), "application/json")

    files = collect(get, "room")
    assert (files.descriptors.model, dict(files.descriptors.rows)) == ("hash-v1", {})


def map_snapshot() -> bytes:
    return to_bytes(topics.MAP_SNAPSHOT, map_delta_message(delta(full=True), 1, 1))
