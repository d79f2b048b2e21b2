"""A visit that was never placed outlives its process, and goes into the map when a place of it
is seen again.
"""

import shutil

import numpy as np
import pytest
from typer.testing import CliRunner

from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse
from sceneq_core.visits import seq_of, visit_of
from sceneq_nodes._held_files import held_files, read_waiting
from sceneq_nodes._scene_folder import SceneFolder
from sceneq_tools.scene_command import app

from support.kept_scene import KeptScene, surface_error_m
from support.papered_recording import write_walk
from support.papered_room import PaperedRoom
from support.rigid import rigid

ROOM = PaperedRoom()
FIRST, FAR, ROUND = range(0, 100, 25), range(180, 252, 18), range(75, 275, 25)
T_ODOM_WORLD = rigid(8, reach_m=3.0)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    return {
        "first": write_walk(folder / "first", ROOM, FIRST),
        "far": write_walk(folder / "far", ROOM, FAR, T_ODOM_WORLD),
        "round": write_walk(folder / "round", ROOM, ROUND),
    }


@pytest.fixture(scope="module")
def left(recordings, tmp_path_factory):
    """A store with a scene in which the visit of r2 was held when everything was killed."""
    store, here = tmp_path_factory.mktemp("maps"), tmp_path_factory.mktemp("running")
    kept = KeptScene(here / "room", recordings["first"], robots=("r2",))
    kept.visit(recordings["first"])
    kept.visit(recordings["far"], "r2")
    shutil.copytree(here / "room", store / "room")  # as kill -9 leaves it
    kept.close()
    return store


def said(store, *arguments):
    done = CliRunner().invoke(app, [*arguments, "--store", str(store)])
    assert done.exit_code == 0, done.output
    return done.output


def test_it_waits_and_is_placed_when_another_comes_by(left, recordings, tmp_path):
    store = shutil.copytree(left, tmp_path / "maps")
    assert "1 visit not placed, 4 keyframes" in said(store, "info", "room")
    kept = KeptScene(store / "room", recordings["first"])
    fast = {"quiet_s": 0.0, "share": 1.0, "release_hz": 100.0}
    name = kept.come(recordings["round"], rate_hz=100.0, start="same_frame", **fast)
    kept.play(name)
    while kept.hub.reported[name]["unplaced"]:
        kept.hub.idle(name)
    kept.play(name)
    visits = {visit["robot"]: visit for visit in kept.visits()}
    T_world_odom = np.array(visits["r2"]["T_world_odom"])
    assert distance_m(T_world_odom, inverse(T_ODOM_WORLD)) < 0.05
    assert angle_deg(T_world_odom, inverse(T_ODOM_WORLD)) < 1.0
    assert kept.hub.counters["frames_integrated"] == len(ROUND) + len(FAR)
    assert surface_error_m(kept.map(), ROOM) < 0.03
    of_r2 = {seq_of(seq) for seq in kept.frames() if visit_of(seq) == visits["r2"]["visit"]}
    assert of_r2 == set(range(len(FAR)))
    assert held_files(store / "room") == []
    kept.close()
    assert "not placed" not in said(store, "info", "room")


def test_its_own_recording_played_again_is_not_held_twice(left, recordings, tmp_path):
    store = shutil.copytree(left, tmp_path / "maps")
    kept = KeptScene(store / "room", recordings["first"], robots=("r2",))
    reported = kept.visit(recordings["far"], "r2")
    assert (reported["held"], len(kept.visits())) == (len(FAR), 2)
    kept.close()
    (path,) = held_files(store / "room")
    assert read_waiting(path).keyframes == len(FAR)


def test_it_is_shown_checked_and_deleted(left, tmp_path):
    store = shutil.copytree(left, tmp_path / "maps")
    assert "1 visit not placed, 4 keyframes" in said(store, "list").replace("\n", " ")
    told = said(store, "info", "room")
    assert "visit 1: r2: where it started is not known; 4 keyframes wait" in told
    (path,) = held_files(store / "room")
    assert f"{path.name}: ok" in said(store, "verify", "room")
    assert "4 keyframes of visit 1 deleted" in said(store, "drop", "room", "1", "--yes")
    assert SceneFolder(store / "room").facts().waiting_visits == 0
    assert CliRunner().invoke(app, ["drop", "room", "1", "--store", str(store)]).exit_code != 0
