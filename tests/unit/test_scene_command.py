"""`sceneq scene` on the files that nodes leave."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sceneq_nodes._journal import Journal
from sceneq_nodes._scene_folder import SceneFolder, find
from sceneq_nodes._set_aside import StoreError
from sceneq_tools.errors import UserError
from sceneq_tools.scene_command import app

from support.durable_map import EVERY_TIME, DurableMap
from support.open_nodes import closed


@pytest.fixture
def store(tmp_path: Path) -> Path:
    """A store with two scenes; the one of three keyframes has two checkpoints."""
    DurableMap(tmp_path / "kitchen", EVERY_TIME).show(0, 1, 2).kill()
    DurableMap(tmp_path / "hall").show(0).kill()
    (tmp_path / "notes").mkdir()
    return tmp_path


def said(store: Path, *arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, [*arguments, "--store", str(store)])
    assert done.exit_code == code, done.output
    return done.output


def test_what_is_kept_is_listed_and_told(store: Path) -> None:
    hall, kitchen = json.loads(said(store, "list", "--json"))
    assert (hall["name"], hall["position"], hall["checkpoints"]) == ("hall", 1, [])
    assert (kitchen["position"], kitchen["first"], kitchen["checkpoints"]) == (3, 1, [3, 2])
    assert not kitchen["is_in_use"]
    assert "kitchen" in said(store, "list")
    told = said(store, "info", "kitchen")
    assert "3 entries made the map" in told
    assert "journal: entries from 1 on; checkpoints at 3, 2" in told
    assert json.loads(said(store, "info", "hall", "--json")) == hall | {"visits": []}


def test_verifying_names_the_file_that_is_damaged(store: Path) -> None:
    assert said(store, "verify", "kitchen").count(": ok") == 4
    path = store / "kitchen" / "map" / "checkpoint-000000000003.sceneq"
    path.write_bytes(path.read_bytes()[:-100])
    told = said(store, "verify", "kitchen", code=1)
    assert "map/checkpoint-000000000003.sceneq: wrong checksum" in told
    assert told.count(": ok") == 3


def test_a_damaged_entry_is_found(store: Path) -> None:
    journal = Journal(store / "hall" / "map" / "journal.sqlite")
    journal._db.execute("UPDATE entry SET crc = 1")
    journal.close()
    assert "entry 1: wrong checksum" in said(store, "verify", "hall", code=1)


def test_a_compacted_scene_is_smaller_and_the_same(store: Path) -> None:
    before = DurableMap(store / "kitchen")
    digest = before.digest()
    closed(before.node.close)
    assert " MB -> " in said(store, "compact", "kitchen")
    facts = SceneFolder(store / "kitchen").facts()
    assert (facts.position, facts.first, facts.checkpoints) == (3, 0, (3,))
    after = DurableMap(store / "kitchen")
    assert after.digest() == digest
    after.show(3).kill()
    assert DurableMap(store / "kitchen").bus.reported["frame_seq"] == 3


def test_compacting_passes_over_a_damaged_checkpoint(store: Path) -> None:
    path = store / "kitchen" / "map" / "checkpoint-000000000003.sceneq"
    path.write_bytes(b"")
    said(store, "compact", "kitchen")
    assert SceneFolder(store / "kitchen").facts().checkpoints == (2,)
    assert DurableMap(store / "kitchen").bus.reported["frame_seq"] == 2


def test_a_scene_without_a_checkpoint_keeps_its_journal(store: Path) -> None:
    said(store, "compact", "hall")
    assert DurableMap(store / "hall").bus.reported["frame_seq"] == 0


def test_a_deleted_scene_is_gone_after_a_question(store: Path) -> None:
    runner = CliRunner()
    no = runner.invoke(app, ["delete", "hall", "--store", str(store)], input="n\n")
    assert no.exit_code == 1
    assert (store / "hall").exists()
    assert said(store, "delete", "hall", "--yes") == "hall: deleted\n"
    assert [folder.path.name for folder in find(store)] == ["kitchen"]


def test_a_scene_in_use_is_left_alone(store: Path) -> None:
    map_ = DurableMap(store / "hall")
    folder = SceneFolder(store / "hall")
    assert folder.facts().is_in_use
    assert [verdict.problem for verdict in folder.verify()] == ["", ""]
    with pytest.raises(StoreError, match="another process writes here"):
        folder.compact()
    with pytest.raises(StoreError, match="another process writes here"):
        folder.delete()
    closed(map_.node.close)
    assert not folder.facts().is_in_use


def test_what_is_not_there_is_told(store: Path) -> None:
    done = CliRunner().invoke(app, ["info", "kitchn", "--store", str(store)])
    assert isinstance(done.exception, UserError)
    assert str(done.exception) == "no scene kitchn (did you mean 'kitchen'?)"
    with pytest.raises(StoreError, match="no such folder"):
        find(store / "nowhere")
