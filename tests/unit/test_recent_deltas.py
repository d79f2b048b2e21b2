"""The last deltas, for readers that missed some."""

from dataclasses import replace

import pytest

from sceneq_core.mapping.mapper import Mapper
from sceneq_nodes import _recent_deltas
from sceneq_nodes._bus import QueryError, Request
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._recent_deltas import RecentDeltas, wanted_deltas
from sceneq_schemas.topics import MAP_JOURNAL

from support.surfaces import SMALL

NOTHING = map_delta_message(Mapper(SMALL).unchanged(0, 0), 1, 0)
BEGIN = 1 << 32


def delta(seq):
    return replace(NOTHING, seq=seq, quarantined="blurred")


def quiet(seq):
    return replace(NOTHING, seq=seq)


def seqs(recent, after):
    found = recent.after(after)
    return found and [one.seq for one in found]


def test_a_reader_gets_what_it_missed():
    recent = RecentDeltas()
    for seq in (1, 2, 3):
        recent.add(delta(seq))
    assert seqs(recent, 0) == [1, 2, 3]
    assert seqs(recent, 2) == [3]
    assert recent.after(3) == ()


def test_what_is_forgotten_is_not_passed_over(monkeypatch):
    monkeypatch.setattr(_recent_deltas, "MAX_DELTAS", 2)
    recent = RecentDeltas()
    for seq in (1, 2, 3):
        recent.add(delta(seq))
    assert recent.after(0) is None
    assert seqs(recent, 1) == [2, 3]


def test_what_says_nothing_drives_nothing_out(monkeypatch):
    monkeypatch.setattr(_recent_deltas, "MAX_DELTAS", 2)
    monkeypatch.setattr(_recent_deltas, "MAX_QUIET", 2)
    recent = RecentDeltas()
    for one in (delta(1), quiet(2), quiet(3), delta(4), quiet(5)):
        recent.add(one)
    assert seqs(recent, 0) == [1, 3, 4, 5]
    assert seqs(recent, 2) == [3, 4, 5]


def test_large_deltas_are_forgotten_sooner(monkeypatch):
    monkeypatch.setattr(_recent_deltas, "MAX_VOXELS", 5)
    recent = RecentDeltas()
    for seq in (1, 2, 3):
        recent.add(replace(delta(seq), voxel_id=range(3)))
    assert seqs(recent, 2) == [3]
    assert recent.after(1) is None


def test_the_end_of_the_last_run_comes_first():
    recent = RecentDeltas(complete_after=4, begin=BEGIN, before=[delta(5), delta(7)])
    recent.add(delta(BEGIN + 1))
    assert recent.after(3) is None
    assert seqs(recent, 4) == [5, 7, BEGIN + 1]
    assert seqs(recent, 7) == [BEGIN + 1]
    assert seqs(recent, BEGIN) == [BEGIN + 1]


def test_the_last_run_is_known_up_to_its_last_word():
    recent = RecentDeltas(complete_after=4, begin=BEGIN, before=[delta(5), quiet(6)])
    assert seqs(recent, 4) == [5, 6]
    assert recent.after(6) == ()
    assert recent.after(7) is None


def test_who_heard_more_than_reached_the_disk_needs_the_whole_map():
    recent = RecentDeltas(complete_after=4, begin=BEGIN, before=[delta(5)])
    assert recent.after(6) is None
    assert RecentDeltas(complete_after=4, begin=BEGIN).after(6) is None


def test_a_request_names_what_it_wants():
    def asked(**parameters):
        return wanted_deltas(Request(MAP_JOURNAL, "key", {}, False, parameters))

    assert asked(epoch="17", after="3") == (17, 3)
    for bad in ({}, {"epoch": "17"}, {"epoch": "17", "after": "-1"}, {"epoch": "x", "after": "1"}):
        with pytest.raises(QueryError, match="bad_request"):
            asked(**bad)
