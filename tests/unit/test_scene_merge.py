"""`sceneq scene merge`: two kept scenes become one where they overlap."""

import pytest
from typer.testing import CliRunner

from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.visits import visit_of
from sceneq_nodes._held_files import Caller
from sceneq_nodes._held_frames import HeldFrames
from sceneq_nodes._scene_folder import SceneFolder
from sceneq_nodes._store_params import StoreParams
from sceneq_tools.cli import app

from support.kept_scene import KeptScene, surface_error_m
from support.papered_recording import write_walk
from support.papered_room import PaperedRoom
from support.rigid import rigid

ROOM = PaperedRoom()
FIRST, SECOND = range(0, 200, 25), range(125, 325, 25)


OFTEN = StoreParams(replay_s=0.0, share=1.0)
"""Checkpoints as often as can be, for there is nothing to compact without one."""


def make(store, name, recording, masks):
    kept = KeptScene(store / name, masks, store=OFTEN)
    kept.visit(recording)
    kept.close()


@pytest.fixture(autouse=True)
def graph(tmp_path, monkeypatch):
    """Work in a folder whose graph has the parameters that the scenes were made with."""
    monkeypatch.chdir(tmp_path)
    nodes = "nodes:\n  - id: mapping\n    params: {mapper: {voxel_size_m: 0.05}}\n  - id: views\n"
    (tmp_path / "graph.yaml").write_text(nodes)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    store = folder / "maps"
    walks = {
        "kitchen": write_walk(folder / "a", ROOM, FIRST),
        "hall": write_walk(folder / "b", ROOM, SECOND, rigid(8, reach_m=3.0)),
        "cellar": write_walk(folder / "c", PaperedRoom(seed=5), SECOND),
    }
    for name, walk in walks.items():
        make(store, name, walk, walks["kitchen"])
    return store


def merge(store, *arguments):
    result = CliRunner().invoke(app, ["scene", "merge", *arguments, "--store", str(store)])
    return result.exit_code, result.output + str(result.exception or "")


def wait_in(scene):
    """Let a visit wait in a scene that nobody found the place of."""
    held = HeldFrames.of(Caller("r2", 0, 0, 0), scene, 9)
    frame = ROOM.frame(0, 0.0)
    held.add(Ingested(0, 0, frame.T_world_camera, "given", frame))
    held.close()


def test_scenes_that_overlap_become_one(made):
    wait_in(made / "hall")
    code, told = merge(made, "kitchen", "hall", "--out", "house")
    assert code == 0, told
    assert "house: 1 keyframes that hall did not place wait here" in told
    assert SceneFolder(made / "house").facts().waiting_keyframes == 1
    assert "hall lies in kitchen" in told
    assert "8 keyframes of hall taken in as visit 1" in told
    before, after = KeptScene(made / "kitchen", made), KeptScene(made / "house", made)
    try:
        origins = {visit["visit"]: visit["origin"] for visit in after.visits()}
        assert origins == {0: "", 1: "hall"}
        assert surface_error_m(after.map(), ROOM) < 0.02
        ids = {thing.instance_id for thing in before.things()}
        assert ids <= {thing.instance_id for thing in after.things()}
        seqs = [seq for thing in after.things() for seq in after.views_of(thing.instance_id)]
        assert {visit_of(seq) for seq in seqs} == {0, 1}
    finally:
        before.close()
        after.close()
    assert all(not verdict.problem for verdict in SceneFolder(made / "house").verify())


def test_what_does_not_overlap_is_refused_with_numbers(made):
    code, told = merge(made, "kitchen", "cellar", "--out", "cave")
    assert code != 0
    assert "no overlap: of 8 places of cellar" in told
    assert "(3 needed)" in told
    assert not (made / "cave").exists()


def test_a_compacted_scene_cannot_be_taken_in(made):
    SceneFolder(made / "cellar").compact()
    code, told = merge(made, "kitchen", "cellar")
    assert code != 0
    assert "not kept any more (compacted" in told


def test_names_are_checked(made):
    assert "no scene attic" in merge(made, "kitchen", "attic")[1]
    assert "is there already" in merge(made, "kitchen", "hall", "--out", "cellar")[1]
    assert "must match" in merge(made, "kitchen", "hall", "--out", "../out")[1]
    assert "one scene twice" in merge(made, "kitchen", "kitchen")[1]


def test_other_parameters_are_refused_and_nothing_changes(made, tmp_path):
    (tmp_path / "graph.yaml").write_text("nodes:\n  - id: mapping\n  - id: views\n")
    SceneFolder(made / "kitchen").compact()
    code, told = merge(made, "kitchen", "hall")
    assert code != 0
    assert "was it made with other parameters?" in told
    assert SceneFolder(made / "kitchen").facts().keyframes == len(FIRST)
