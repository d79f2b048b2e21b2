"""A map that survives the end of its process, and a disk that does not do what it should."""

import json
import logging
import resource
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from sceneq_nodes._bus import QueryError
from sceneq_nodes._checkpoints import Checkpoints
from sceneq_nodes._journal import Journal
from sceneq_nodes._recent_deltas import FORGOTTEN
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._store_params import StoreParams
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.topics import MAP_DELTA, MAP_JOURNAL, POSE_CORRECTION, PROPOSAL

from support.durable_map import EVERY_TIME, NEVER, VIEWS, DurableMap
from support.surfaces import SMALL


@pytest.fixture(scope="module")
def undisturbed() -> DurableMap:
    return DurableMap(None).show(*range(6))


def corrected(map_: DurableMap, after: int, frame_seq: int) -> None:
    pose = VIEWS[0][0].T_world_camera.copy()
    pose[0, 3] += 0.02
    message = PoseCorrection(1, 1, True, frame_seq, after, np.array([0]), pose[None])
    map_.bus.deliver(map_.node, POSE_CORRECTION, message)


def proposed(map_: DurableMap) -> None:
    points = map_.snapshot().points_world[:50]
    number = np.arange(50, dtype=np.int32)
    masks = ProposalSet(0, "test", points, np.zeros(50, np.int32), number, np.ones(1, np.float32))
    map_.bus.deliver(map_.node, PROPOSAL, masks)


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "map").iterdir())


def newest(folder: Path) -> Path:
    return Checkpoints(folder / "map").newest_first()[0].path


@contextmanager
def full_disk() -> Iterator[None]:
    """Let no file grow; the system tells it in the same way, as an error of `write`."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def whole_map_asked_of(map_: DurableMap) -> bool:
    """Tell whether nobody can go on from deltas of before, not even from the first."""
    try:
        map_.bus.query(MAP_JOURNAL, parameters={"epoch": "0", "after": "0"})
    except QueryError as error:
        return error.code == FORGOTTEN
    return False


def flip(path: Path, place: int) -> None:
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(data)


@pytest.mark.parametrize("store", [NEVER, EVERY_TIME], ids=["journal", "checkpoints"])
@pytest.mark.parametrize("killed_after", [2, 6])
def test_a_killed_map_comes_back_and_goes_on_as_if_nothing_was(
    undisturbed, tmp_path, store, killed_after
):
    DurableMap(tmp_path, store).show(*range(killed_after)).kill()
    back = DurableMap(tmp_path, store)
    assert back.bus.reported["frame_seq"] == killed_after - 1
    back.show(*range(6))
    assert back.digest() == undisturbed.digest()
    assert back.bus.counters["frames_repeated"] == killed_after
    assert back.bus.counters["frames_integrated"] == 6 - killed_after
    assert [i.instance_id for i in back.snapshot().instances] == [
        i.instance_id for i in undisturbed.snapshot().instances
    ]


def test_corrections_and_proposals_come_back_in_their_order(tmp_path):
    def grown(folder: Path | None, *killed: int, store: StoreParams) -> DurableMap:
        map_ = DurableMap(folder, store)
        for number in range(6):
            map_.show(number)
            if number == 1:
                proposed(map_)
            if number == 3:
                corrected(map_, 3, frame_seq=5)
            if number in killed:
                map_.kill()
                map_ = DurableMap(folder, store)
        return map_

    whole = grown(None, store=NEVER)
    assert whole.bus.counters["corrections_applied"] == 1
    assert grown(tmp_path / "a", 1, 3, 4, store=NEVER).digest() == whole.digest()
    assert grown(tmp_path / "b", 1, 3, 4, 5, store=EVERY_TIME).digest() == whole.digest()


@pytest.mark.parametrize("store", [NEVER, EVERY_TIME], ids=["journal", "checkpoints"])
def test_an_odometry_that_begins_anew_corrects_nothing_twice(tmp_path, store):
    whole = DurableMap(None).show(0, 1, 2)
    corrected(whole, 2, frame_seq=2)
    whole.show(3)
    map_ = DurableMap(tmp_path, store).show(0, 1, 2)
    corrected(map_, 2, frame_seq=2)
    map_.show(3).kill()
    back = DurableMap(tmp_path, store).show(0, 1, 2)
    corrected(back, 2, frame_seq=2)
    assert back.bus.counters["corrections_applied"] == 0
    assert back.show(3).digest() == whole.digest()


def test_masks_that_the_graph_names_are_taken_once(tmp_path):
    np.savez(tmp_path / "masks.npz", points_world=np.eye(3, dtype=np.float32), instance=[1, 1, 0])
    proposals = {"kind": "file", "path": str(tmp_path / "masks.npz")}
    for _ in range(2):
        map_ = DurableMap(tmp_path / "kept", proposals=proposals)
        map_.kill()
    with_others = DurableMap(tmp_path / "kept").show(0)
    assert with_others.node._store._position == 2


def test_the_map_keeps_its_epoch_and_numbers_on_beyond_all_it_may_have_told(tmp_path):
    first = DurableMap(tmp_path).show(0, 1)
    first.kill()
    second = DurableMap(tmp_path)
    second.node.step(None)
    (mark,) = second.bus.sent(MAP_DELTA)
    before = first.bus.sent(MAP_DELTA)[-1]
    assert mark.epoch == before.epoch
    assert mark.seq > before.seq + 1_000_000
    assert (mark.frame_seq, len(mark.voxel_id)) == (1, 0)
    assert second.snapshot().seq == mark.seq


def test_another_recording_under_the_same_name_is_told_apart(tmp_path, caplog):
    DurableMap(tmp_path).show(0).kill()
    back = DurableMap(tmp_path)
    number = VIEWS[0][0].seq
    back.node._mapped.refuse(number, 1)
    back.show(0, 0)
    assert back.bus.counters["frames_foreign"] == 2
    assert caplog.text.count("another recording") == 1


@pytest.mark.parametrize("place", [5, 3000, -1], ids=["header", "body", "checksum"])
def test_a_changed_checkpoint_is_set_aside_and_the_one_before_used(undisturbed, tmp_path, place):
    DurableMap(tmp_path, EVERY_TIME).show(*range(4)).kill()
    flip(path := newest(tmp_path), place)
    back = DurableMap(tmp_path, EVERY_TIME)
    assert path.with_name(path.name + ".corrupt").exists()
    assert back.bus.counters["store_damaged"] == 1
    assert len(back.node._store.repeated) == 1
    assert back.show(4, 5).digest() == undisturbed.digest()


def test_a_torn_checkpoint_is_set_aside(undisturbed, tmp_path):
    DurableMap(tmp_path, EVERY_TIME).show(*range(4)).kill()
    path = newest(tmp_path)
    path.write_bytes(path.read_bytes()[:-1000])
    back = DurableMap(tmp_path, EVERY_TIME).show(4, 5)
    assert back.digest() == undisturbed.digest()
    assert any(name.endswith(".corrupt") for name in files(tmp_path))


def test_a_checkpoint_that_was_being_written_is_no_checkpoint(undisturbed, tmp_path):
    DurableMap(tmp_path).show(*range(3)).kill()
    unfinished = tmp_path / "map" / "checkpoint-000000000003.sceneq.unfinished"
    unfinished.write_bytes(b"{}")
    back = DurableMap(tmp_path, EVERY_TIME).show(3, 4, 5)
    assert back.digest() == undisturbed.digest()
    assert not unfinished.exists()


def test_the_torn_tail_of_a_journal_costs_what_was_in_it(tmp_path):
    """As after a power cut: SQLite drops what its own log does not hold whole."""
    DurableMap(tmp_path).show(*range(4)).kill()
    wal = tmp_path / "map" / "journal.sqlite-wal"
    wal.write_bytes(wal.read_bytes()[:-5000])
    back = DurableMap(tmp_path)
    assert back.bus.reported["frame_seq"] == 2
    assert back.show(3).digest() == DurableMap(None).show(*range(4)).digest()


def test_a_changed_entry_ends_the_journal_and_the_map_goes_on_in_a_new_one(tmp_path):
    DurableMap(tmp_path).show(*range(4)).kill()
    with sqlite3.connect(tmp_path / "map" / "journal.sqlite") as database:
        database.execute("UPDATE entry SET kind = 'refused' WHERE position = 3")
    database.close()
    back = DurableMap(tmp_path)
    assert back.bus.reported["frame_seq"] == 1
    assert "journal.sqlite.corrupt" in files(tmp_path)
    assert whole_map_asked_of(back)
    back.show(2).kill()
    again = DurableMap(tmp_path)
    assert again.bus.reported["frame_seq"] == 2
    assert again.show(3).digest() == DurableMap(None).show(*range(4)).digest()


def test_a_journal_that_is_no_database_is_set_aside(undisturbed, tmp_path):
    DurableMap(tmp_path, EVERY_TIME).show(*range(4)).kill()
    for path in (tmp_path / "map").glob("journal.sqlite*"):
        path.write_bytes(b"no database" * 1000)
    back = DurableMap(tmp_path, EVERY_TIME)
    assert "journal.sqlite.corrupt" in files(tmp_path)
    assert whole_map_asked_of(back)
    assert back.show(4, 5).digest() == undisturbed.digest()


def disk_contents(folder: Path) -> dict[str, object]:
    journal = Journal(folder / "map" / "journal.sqlite")
    entries = list(journal.entries(max(journal.span()[0] - 1, 0)))
    journal.close()
    checkpoints = (folder / "map").glob("checkpoint*")
    return {"entries": entries} | {path.name: path.read_bytes() for path in checkpoints}


def test_a_newer_checkpoint_is_left_alone(tmp_path, caplog):
    DurableMap(tmp_path, EVERY_TIME).show(0).kill()
    path = newest(tmp_path)
    header, _, rest = path.read_bytes().partition(b"\n")
    path.write_bytes(json.dumps({**json.loads(header), "schema": 2}).encode() + b"\n" + rest)
    before = disk_contents(tmp_path)
    back = DurableMap(tmp_path, EVERY_TIME).show(0, 1)
    assert back.bus.counters["store_failed"] == 1
    assert back.bus.counters["frames_integrated"] == 2
    assert "schema 2, this version knows 1 at most" in caplog.text
    back.node.close()
    assert disk_contents(tmp_path) == before


def test_a_newer_journal_is_left_alone(tmp_path, caplog):
    DurableMap(tmp_path).show(0).kill()
    with sqlite3.connect(tmp_path / "map" / "journal.sqlite") as database:
        database.execute("PRAGMA user_version = 9")
    database.close()
    back = DurableMap(tmp_path).show(0, 1)
    assert back.bus.counters["frames_integrated"] == 2
    assert "schema 9, this version knows 1 at most" in caplog.text


def test_other_parameters_make_the_map_anew_from_the_whole_journal(tmp_path):
    map_ = DurableMap(tmp_path, EVERY_TIME).show(0, 1)
    first = map_.node
    map_.kill()
    coarse = type(SMALL)(voxel_size_m=0.05, surface=SMALL.surface)
    back = DurableMap(tmp_path, EVERY_TIME, mapper=coarse)
    assert back.node._store._position == 2
    assert back.node._epoch not in (0, first._epoch)
    assert back.digest() == DurableMap(None, mapper=coarse).show(0, 1).digest()


def test_other_parameters_without_the_whole_journal_harm_nothing(tmp_path, caplog):
    small = StoreParams(replay_s=0.0, share=1.0, max_mb=0.001)
    DurableMap(tmp_path, small).show(*range(6)).kill()
    before = disk_contents(tmp_path)
    coarse = type(SMALL)(voxel_size_m=0.05, surface=SMALL.surface)
    back = DurableMap(tmp_path, small, mapper=coarse)
    assert "other parameters" in caplog.text
    assert back.snapshot().frame_seq == -1
    assert disk_contents(tmp_path) == before
    assert DurableMap(tmp_path, small).bus.reported["frame_seq"] == 5


def test_a_second_writer_keeps_out(tmp_path, caplog):
    first = DurableMap(tmp_path).show(0)
    second = DurableMap(tmp_path).show(0)
    assert "another process writes here" in caplog.text
    assert second.bus.counters["frames_integrated"] == 1
    first.show(1).kill()
    assert DurableMap(tmp_path).bus.reported["frame_seq"] == 1


def test_old_entries_go_when_there_are_too_many(undisturbed, tmp_path):
    small = StoreParams(replay_s=0.0, share=1.0, max_mb=0.001)
    map_ = DurableMap(tmp_path, small).show(*range(5))
    assert map_.node._store._journal.span() == (4, 5)
    assert len(Checkpoints(tmp_path / "map").newest_first()) == 2
    map_.kill()
    assert DurableMap(tmp_path, small).show(5).digest() == undisturbed.digest()


def test_a_full_disk_costs_durability_until_there_is_room_again(undisturbed, tmp_path, caplog):
    map_ = DurableMap(tmp_path, EVERY_TIME).show(0, 1)
    before = newest(tmp_path).name
    with full_disk():
        map_.show(2, 3)
    assert map_.bus.counters["frames_integrated"] == 4
    assert map_.bus.counters["store_failed"] >= 1
    assert caplog.text.count("lives on in memory only") == 1
    assert newest(tmp_path).name == before
    map_.show(4)
    assert "the map is durable again" in caplog.text
    map_.kill()
    assert DurableMap(tmp_path, EVERY_TIME).show(5).digest() == undisturbed.digest()


def test_a_map_killed_while_the_disk_is_full_is_that_of_before(tmp_path):
    map_ = DurableMap(tmp_path).show(0, 1)
    with full_disk():
        map_.show(2)
    map_.kill()
    with full_disk():
        back = DurableMap(tmp_path)
    assert back.bus.counters["store_failed"] >= 1
    assert back.bus.reported["frame_seq"] == 1
    back.kill()
    again = DurableMap(tmp_path)
    assert again.bus.reported["frame_seq"] == 1
    assert again.show(2).digest() == DurableMap(None).show(0, 1, 2).digest()


def test_a_disk_that_cannot_be_written_leaves_the_map_in_memory(tmp_path, caplog):
    (tmp_path / "file").write_text("no folder")
    map_ = DurableMap(tmp_path / "file").show(0)
    assert map_.bus.counters == {"store_failed": 1, "frames_integrated": 1}
    assert "the map is made anew, in memory only" in caplog.text


def test_a_disk_that_became_read_only_is_told_once(tmp_path, monkeypatch, caplog):
    map_ = DurableMap(tmp_path)

    def refuse(*_: object) -> None:
        raise StoreError("attempt to write a readonly database")

    monkeypatch.setattr(Journal, "append", refuse)
    monkeypatch.setattr(Journal, "note", refuse)
    with caplog.at_level(logging.ERROR):
        map_.show(0, 1, 2)
    assert caplog.text.count("readonly") == 1
    assert map_.bus.counters["frames_integrated"] == 3


def test_the_files_are_their_owners_alone(tmp_path):
    DurableMap(tmp_path, EVERY_TIME).show(0).kill()
    assert (tmp_path / "map").stat().st_mode & 0o777 == 0o700
    assert {p.stat().st_mode & 0o777 for p in (tmp_path / "map").iterdir()} == {0o600}


def test_a_gap_in_a_journal_is_damage(tmp_path):
    DurableMap(tmp_path).show(0, 1, 2).kill()
    journal = Journal(tmp_path / "map" / "journal.sqlite")
    journal._db.execute("DELETE FROM entry WHERE position = 2")
    found = journal.entries(0)
    assert next(found).position == 1
    with pytest.raises(DamageError, match="entries 2 to 2 are missing"):
        next(found)
    journal.close()
