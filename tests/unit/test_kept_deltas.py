"""What was told of the map, on disk."""

import sqlite3
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from zstandard import ZstdCompressor

from sceneq_core.mapping.mapper import Mapper
from sceneq_nodes import _kept_deltas, _recent_deltas
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._item_store import Change, Item, ItemStore
from sceneq_nodes._kept_deltas import FILE, KeptDeltas, LastRun
from sceneq_nodes._set_aside import StoreError

from support.surfaces import SMALL

EPOCH, BEGIN = 1, 1 << 32
NOTHING = map_delta_message(Mapper(SMALL).unchanged(0, 0), EPOCH, 0)


def delta(seq):
    return replace(NOTHING, seq=seq, quarantined="blurred")


def quiet(seq):
    return replace(NOTHING, seq=seq)


def opened(folder: Path, told_after=0, first_seq=0, again=(), count=lambda name: None):
    return KeptDeltas(folder, LastRun(EPOCH, told_after, first_seq, again), count)


def told(folder: Path, *deltas) -> None:
    kept = opened(folder)
    for one in deltas:
        kept.add(one)
    kept.close()


def seqs(kept, after):
    found = kept.after(after)
    kept.close()
    return None if found is None else [one.seq for one in found]


def test_what_lies_before_a_checkpoint_is_known_to_the_next_run(tmp_path):
    told(tmp_path, delta(1), delta(2), quiet(3), delta(4))
    assert seqs(opened(tmp_path, told_after=4, first_seq=BEGIN), 0) == [1, 2, 3, 4]
    assert seqs(opened(tmp_path, told_after=4, first_seq=2 * BEGIN), 2) == [3, 4]


def test_what_was_made_anew_goes_on_from_there_and_is_kept(tmp_path):
    told(tmp_path, delta(1), delta(2))
    back = opened(tmp_path, told_after=2, first_seq=BEGIN, again=[delta(3), delta(4)])
    back.add(delta(BEGIN + 1))
    back.close()
    again = opened(tmp_path, told_after=BEGIN + 1, first_seq=2 * BEGIN)
    assert seqs(again, 1) == [2, 3, 4, BEGIN + 1]


def test_a_checkpoint_after_a_keyframe_that_changed_nothing(tmp_path, monkeypatch):
    told(tmp_path, delta(1), delta(2), quiet(3))
    assert seqs(opened(tmp_path, told_after=3, first_seq=BEGIN), 0) == [1, 2, 3]
    monkeypatch.setattr(_recent_deltas, "MAX_QUIET", 1)
    told(tmp_path / "more", delta(1), delta(2), quiet(3), quiet(4))
    assert seqs(opened(tmp_path / "more", told_after=3, first_seq=BEGIN), 0) == [1, 2, 4]


def test_the_last_word_of_a_run_is_known(tmp_path):
    told(tmp_path, delta(1), quiet(2))
    assert seqs(opened(tmp_path, told_after=1, first_seq=BEGIN), 2) == []


@pytest.mark.parametrize("told_after", [3, 1])
def test_what_the_map_lost_is_not_told(tmp_path, told_after):
    """After a power cut the checkpoint may be newer than what was told, or the other way round."""
    told(tmp_path, delta(1), delta(2), *(() if told_after == 3 else [quiet(3)]))
    back = opened(tmp_path, told_after, first_seq=BEGIN)
    assert back.after(2) is None
    assert [one.seq for one in back] == ([1] if told_after == 1 else [])
    back.close()


def test_what_is_missing_is_not_passed_over(tmp_path):
    told(tmp_path, delta(1), delta(2), delta(3), delta(4))
    with sqlite3.connect(tmp_path / FILE) as database:
        database.execute("UPDATE item SET crc = 0 WHERE number = 2")
    database.close()
    counts = Counter()
    back = opened(tmp_path, 4, BEGIN, count=lambda name: counts.update([name]))
    assert counts["store_damaged"] == 1
    assert back.after(1) is None
    assert seqs(back, 2) == [3, 4]


def test_another_map_begins_with_nothing(tmp_path):
    told(tmp_path, delta(1), delta(2))
    back = KeptDeltas(tmp_path, LastRun(EPOCH + 1, 2, BEGIN, ()), lambda name: None)
    assert list(back) == []
    back.close()


@pytest.mark.parametrize("data", [b"", bytes(8), bytes(8) + ZstdCompressor().compress(b"7")])
def test_what_another_version_told_is_set_aside(tmp_path, data):
    items = ItemStore(tmp_path / FILE, lambda: (), lambda name: None)
    items.commit(Change((Item("delta", 1, data),)))
    items.close()
    counts = Counter()
    back = opened(tmp_path, 1, BEGIN, count=lambda name: counts.update([name]))
    assert back.after(0) is None
    back.close()
    assert counts == {"store_damaged": 1}
    assert (tmp_path / f"{FILE}.corrupt").exists()


def test_a_newer_file_is_left_alone(tmp_path):
    told(tmp_path, delta(1))
    with sqlite3.connect(tmp_path / FILE) as database:
        database.execute("PRAGMA user_version = 9")
    database.close()
    with pytest.raises(StoreError, match="schema 9"):
        opened(tmp_path)


@pytest.mark.parametrize("place", [(_recent_deltas, "MAX_DELTAS"), (_kept_deltas, "KEPT")])
def test_the_disk_keeps_no_more_than_is_needed(tmp_path, monkeypatch, place):
    monkeypatch.setattr(*place, 3)
    monkeypatch.setattr(_recent_deltas, "MAX_QUIET", 2)
    told(tmp_path, *map(delta, range(1, 10)), *map(quiet, range(10, 20)))
    with sqlite3.connect(tmp_path / FILE) as database:
        rows = database.execute("SELECT kind, number FROM item WHERE kind != 'form'").fetchall()
    database.close()
    assert sorted(rows) == [("delta", 7), ("delta", 8), ("delta", 9), ("quiet", 18), ("quiet", 19)]
    assert seqs(opened(tmp_path, 9, BEGIN), 6) == [7, 8, 9, 18, 19]
