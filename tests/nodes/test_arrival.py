"""Coming back to a scene that has a map: the same recording, another one, another robot."""

import numpy as np
import pytest

from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse
from sceneq_core.visits import seq_of, visit_of
from sceneq_nodes._held_files import held_files, read_waiting

from support.kept_scene import KeptScene, surface_error_m
from support.papered_recording import write_walk
from support.papered_room import PaperedRoom
from support.rigid import rigid

ROOM = PaperedRoom()
FIRST = range(0, 200, 25)
SECOND = range(125, 325, 25)
T_ODOM_WORLD = rigid(8, reach_m=3.0)


def confirmed(kept):
    """Return the centres of what is surely there, to the decimetre."""
    sure = [thing.centre_world for thing in kept.things() if thing.state == "confirmed"]
    return sorted(np.round(centre, 1).tolist() for centre in sure)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    return {
        "first": write_walk(folder / "first", ROOM, FIRST),
        "second": write_walk(folder / "second", ROOM, SECOND, T_ODOM_WORLD),
        "here": write_walk(folder / "here", ROOM, SECOND),
        "elsewhere": write_walk(folder / "elsewhere", PaperedRoom(seed=5), SECOND),
    }


@pytest.fixture
def scene(recordings, tmp_path):
    made = []

    def make(folder=tmp_path / "room", **params):
        made.append(KeptScene(folder, recordings["first"], **params))
        return made[-1]

    yield make
    for one in made:
        one.close()


def test_the_first_one_founds_the_frame_of_reference(scene, recordings):
    kept = scene()
    kept.visit(recordings["first"])
    (visit,) = kept.visits()
    assert (visit["visit"], visit["robot"], visit["evidence"]) == (0, "r1", "the first one")
    assert kept.hub.counters["frames_integrated"] == len(FIRST)
    assert {visit_of(seq) for i in kept.things() for seq in kept.views_of(i.instance_id)} == {0}


def test_another_recording_goes_on_where_it_finds_itself(scene, recordings):
    before = scene()
    before.visit(recordings["first"])
    things = {thing.instance_id for thing in before.things()}
    before.close()
    kept = scene()
    reported = kept.visit(recordings["second"])
    assert reported["arrival"] == "in place"
    assert kept.hub.counters["relocalised"] == 1
    assert kept.hub.counters["frames_foreign"] == kept.hub.counters["frames_unplaced"] == 0
    visit = kept.visits()[1]
    T_world_odom = np.array(visit["T_world_odom"])
    assert distance_m(T_world_odom, inverse(T_ODOM_WORLD)) < 0.05
    assert angle_deg(T_world_odom, inverse(T_ODOM_WORLD)) < 0.5
    assert "places" in visit["evidence"]
    # All that was held while it looked around is in the map, and nothing is out of place.
    assert kept.hub.counters["frames_integrated"] == len(SECOND)
    assert surface_error_m(kept.map(), ROOM) < 0.02
    assert things <= {thing.instance_id for thing in kept.things()}


def test_views_tell_which_visit_they_are_of(scene, recordings):
    kept = scene(folder=None)
    kept.visit(recordings["first"])
    kept.visit(recordings["second"], robot=None)
    seqs = [seq for thing in kept.things() for seq in kept.views_of(thing.instance_id)]
    assert {visit_of(seq) for seq in seqs} == {0, 1}
    assert max(map(seq_of, seqs)) < len(SECOND)


def test_poses_that_are_in_the_frame_already_are_taken_at_once(scene, recordings):
    kept = scene(folder=None)
    kept.visit(recordings["first"])
    kept.visit(recordings["here"], start="same_frame")
    assert kept.visits()[1]["T_world_odom"] == np.eye(4).tolist()
    assert kept.hub.counters["frames_integrated"] == len(FIRST) + len(SECOND)
    assert surface_error_m(kept.map(), ROOM) < 0.02


def test_the_same_recording_is_known_again(scene, recordings):
    before = scene()
    before.visit(recordings["first"])
    before.visit(recordings["second"])
    digest = before.map().points_world
    before.close()
    kept = scene()
    kept.visit(recordings["second"])
    assert len(kept.visits()) == 2
    assert kept.hub.counters["frames_repeated"] == len(SECOND)
    assert np.array_equal(kept.map().points_world, digest)


def test_what_is_not_found_is_held_and_counted(scene, recordings, tmp_path):
    kept = scene()
    kept.visit(recordings["first"])
    reported = kept.visit(recordings["elsewhere"], hold=4)
    assert reported["arrival"] == "relocalising: 4 held"
    assert reported["unplaced"] == "1 visit not placed, 4 keyframes"
    assert kept.hub.counters["frames_integrated"] == len(FIRST)
    assert kept.hub.counters["frames_let_go"] == len(SECOND) - 4
    assert kept.visits()[1]["T_world_odom"] is None
    kept.close()
    (held,) = held_files(tmp_path / "room")
    assert read_waiting(held).keyframes == 4
    assert kept.hub.counters["frames_unplaced"] == 0


def test_without_a_store_what_is_held_ends_with_the_process_and_is_counted(scene, recordings):
    kept = scene(folder=None)
    kept.visit(recordings["first"])
    kept.visit(recordings["elsewhere"], hold=2)
    kept.close()
    assert kept.hub.counters["frames_unplaced"] == 2


def test_two_robots_make_one_map(scene, recordings):
    kept = scene(folder=None, robots=("r2",))
    kept.play(kept.come(recordings["first"]), kept.come(recordings["second"], "r2"))
    for _ in SECOND:
        kept.hub.idle("ingest-r2")
    kept.play("ingest-r2")
    robots = {visit["visit"]: visit["robot"] for visit in kept.visits()}
    assert robots == {0: "r1", 1: "r2"}
    seen = [kept.views_of(thing.instance_id) for thing in kept.things()]
    assert {robots[visit_of(seq)] for seqs in seen for seq in seqs} == {"r1", "r2"}
    assert kept.hub.counters["frames_integrated"] == len(FIRST) + len(SECOND)
    assert surface_error_m(kept.map(), ROOM) < 0.02
    alone = scene(folder=None)
    alone.visit(recordings["first"])
    alone.visit(recordings["here"], start="same_frame")
    assert confirmed(kept) == confirmed(alone)


@pytest.mark.parametrize("settle_s", [0.0, 0.3])
def test_a_source_that_ends_before_its_answer_stands_still_is_placed_by_what_there_is(
    scene, recordings, tmp_path, settle_s
):
    kept = scene()
    kept.visit(recordings["first"])
    short = write_walk(tmp_path / "short", ROOM, range(125, 200, 25), T_ODOM_WORLD)
    told = kept.visit(short, settle_s=settle_s)
    assert told["arrival"] == "in place"
    assert kept.visits()[1]["evidence"].startswith("3 keyframes recognised")
    assert kept.hub.counters["frames_integrated"] == len(FIRST) + 3


def test_a_restart_of_mapping_brings_the_same_map_with_all_visits(scene, recordings):
    before = scene()
    before.visit(recordings["first"])
    before.visit(recordings["second"])
    told, points = before.visits(), before.map().points_world
    before.close()
    after = scene()
    assert after.visits() == told
    assert np.array_equal(after.map().points_world, points)
