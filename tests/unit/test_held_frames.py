"""Keyframes that wait for their place, in a file."""

import contextlib
import shutil
import sqlite3

import numpy as np
import pytest

from sceneq_core.ingest.ingestor import Ingested
from sceneq_nodes._held_files import (
    Caller,
    check_held,
    held_files,
    read_waiting,
    waiting_in,
    waiting_text,
)
from sceneq_nodes._held_frames import HeldFrames
from sceneq_nodes._journal import Journal
from sceneq_nodes._set_aside import DamageError, StoreError

from support.papered_room import PaperedRoom

ROOM = PaperedRoom(size=(64, 48), focal_px=52.0)
CALLER = Caller("r2", 0, 5, 7)


def keyframe(seq, corrected=None):
    frame = ROOM.frame(seq, 20.0 * seq)
    return Ingested(seq, frame.stamp_ns, frame.T_world_camera, "given", frame, corrected or {})


def held_of(folder, *seqs, most=9):
    held = HeldFrames.of(CALLER, folder, most)
    for seq in seqs:
        held.add(keyframe(seq))
    return held


def read_all(held):
    found, after = [], 0
    while (one := held.read(after)) is not None:
        after, frame = one
        found.append(frame)
    return found


def test_what_was_added_is_there_whenever_the_process_ends(tmp_path):
    held = held_of(tmp_path, 3, 4)
    held.add(keyframe(5, {3: np.eye(4), 4: ROOM.frame(4, 1.0).T_world_camera}))
    killed = tmp_path / "killed"
    shutil.copytree(tmp_path, killed)
    held.close()
    for folder in (killed, tmp_path):
        (path,) = held_files(folder)
        again = HeldFrames(path, 9)
        assert (again.caller, len(again), again.oldest_seq, again.newest_seq) == (CALLER, 3, 3, 5)
        frames = read_all(again)
        assert [frame.seq for frame in frames] == [3, 4, 5]
        assert np.array_equal(frames[0].keyframe.rgb, keyframe(3).keyframe.rgb)
        assert np.array_equal(frames[1].T_world_camera, keyframe(4).T_world_camera)
        assert np.array_equal(frames[2].corrected[4], ROOM.frame(4, 1.0).T_world_camera)
        assert list(frames[2].corrected) == [3, 4]
        again.close()


def test_the_file_goes_when_the_last_one_is_in_the_map(tmp_path):
    held = held_of(tmp_path, 0, 1, 2)
    held.forget(2)
    assert [frame.seq for frame in read_all(held)] == [0, 1, 2]
    held.forget(1)
    assert [frame.seq for frame in read_all(held)] == [2]
    held.forget(3)
    held.close()
    assert list(tmp_path.iterdir()) == []


def test_the_oldest_gives_way(tmp_path):
    held = held_of(tmp_path, most=2)
    assert [held.add(keyframe(seq)) for seq in range(4)] == [False, False, True, True]
    assert [frame.seq for frame in read_all(held)] == [2, 3]
    assert read_waiting(held.path).keyframes == 2
    held.close()


def test_one_process_at_a_time(tmp_path):
    held = held_of(tmp_path, 0)
    with pytest.raises(StoreError, match="another process"):
        HeldFrames(held.path, 9)
    beside = HeldFrames.of(CALLER, tmp_path, 9)
    assert not beside.is_durable
    beside.close()
    held.close()
    assert read_waiting(held.path).keyframes == 1


def test_a_file_that_is_begun_or_gone_holds_nothing_yet(tmp_path):
    path = tmp_path / CALLER.file_name
    assert waiting_in(path) == []
    path.touch()
    assert waiting_in(path) == []
    Journal(path).close()
    assert waiting_in(path) == []
    path.unlink()
    held = held_of(tmp_path, 0)
    assert [one.keyframes for one in waiting_in(held.path)] == [1]
    held._journal._db.execute("DELETE FROM note")
    with pytest.raises(DamageError, match="whose keyframes"):
        waiting_in(held.path)
    held.close()


def test_a_file_whose_maker_was_killed_holds_nothing_yet(tmp_path):
    making, path = tmp_path / "making.sqlite", tmp_path / CALLER.file_name
    with contextlib.closing(sqlite3.connect(making, isolation_level=None)) as db:
        db.execute("PRAGMA cache_size = 1")
        db.execute("CREATE TABLE before (x BLOB)")
        db.execute("BEGIN")
        for _ in range(20):
            db.execute("INSERT INTO before VALUES (zeroblob(4000))")
        for suffix in ("", "-journal"):  # as they lie there when the process is gone
            shutil.copy(f"{making}{suffix}", f"{path}{suffix}")
    with pytest.raises(StoreError, match="readonly"):
        read_waiting(path)
    assert waiting_in(path) == []


def test_damage_is_found(tmp_path):
    held = held_of(tmp_path, 0, 1)
    held._journal._db.execute("UPDATE entry SET crc = 1 WHERE position = 1")
    with pytest.raises(DamageError, match="entry 1: wrong checksum"):
        held.read(0)
    held.close()
    with pytest.raises(DamageError, match="entry 1: wrong checksum"):
        check_held(held.path)
    again = HeldFrames.of(CALLER, tmp_path, 9)
    assert (len(again), again.is_durable) == (0, True)
    again.close()
    assert (tmp_path / f"{CALLER.file_name}.corrupt").is_file()
    assert held_files(tmp_path) == []


def test_it_is_told_in_words():
    assert waiting_text(0, 0) == ""
    assert waiting_text(1, 14) == "1 visit not placed, 14 keyframes"
    assert waiting_text(2, 3) == "2 visits not placed, 3 keyframes"
