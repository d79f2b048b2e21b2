"""names.jsonl: only added to, whole or not at all, and honest about damage."""

import json
import os
import stat
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.teaching.taught import Looks, Spot, Taught
from sceneq_nodes._name_record import forget_record, line_of, record_of, replay, teach_record
from sceneq_nodes._name_store import FILE, SPARE_LINES, NameStore


def name(number=1, words="aunt Mary's mug", instance_id=7):
    rng = np.random.default_rng(number)
    spot = Spot(instance_id, 5, np.array([0.1, 0.2, 0.3]), np.arange(6.0).reshape(2, 3) / 7)
    looks = Looks("words", rng.random(4, np.float32), rng.random(6, np.float32))
    return Taught(number, words, "individual", "anna", 1_795_363_500_000_000_000, spot, looks)


def same(one, other):
    arrays = ("centre_world", "aabb_world")
    assert all((getattr(one.spot, a) == getattr(other.spot, a)).all() for a in arrays)
    assert (one.looks.descriptor == other.looks.descriptor).all()
    assert (one.looks.feature == other.looks.feature).all()
    plain = ("number", "name", "kind", "by", "stamp_ns")
    assert all(getattr(one, a) == getattr(other, a) for a in plain)
    assert (one.spot.instance_id, one.spot.map_epoch) == (
        *(other.spot.instance_id, other.spot.map_epoch),
    )
    return True


def test_what_is_written_comes_back_to_the_last_bit(tmp_path):
    NameStore(tmp_path).write(taught=[name(1), name(2, "Bertha")])
    first, second = NameStore(tmp_path).read()
    assert same(first, name(1))
    assert same(second, name(2, "Bertha"))
    assert stat.S_IMODE((tmp_path / FILE).stat().st_mode) == 0o600


def test_moves_and_forgetting_are_lines_of_their_own(tmp_path):
    store = NameStore(tmp_path)
    store.write(taught=[name(1), name(2)])
    elsewhere = Spot(9, 6, np.ones(3), np.ones((2, 3)))
    store.write(moved=[replace(name(1), spot=elsewhere)])
    store.write(forgotten=[name(2)])
    (one,) = NameStore(tmp_path).read()
    assert (one.spot.instance_id, one.spot.map_epoch) == (9, 6)
    assert len((tmp_path / FILE).read_bytes().splitlines()) == 4
    store.write()
    assert len((tmp_path / FILE).read_bytes().splitlines()) == 4


def test_without_a_folder_nothing_is_kept():
    store = NameStore(None)
    store.write(taught=[name()])
    assert (store.keeps, store.read(), store.problem) == (False, (), "")


def test_wherever_the_last_line_is_torn_the_others_stay(tmp_path):
    whole = line_of(teach_record(name(1))) + line_of(teach_record(name(2)))
    first = len(line_of(teach_record(name(1))))
    for cut in (first + 1, first + 100, len(whole) - 1):
        folder = tmp_path / str(cut)
        folder.mkdir()
        (folder / FILE).write_bytes(whole[:cut])
        store = NameStore(folder)
        assert [one.number for one in store.read()] == [1]
        assert store.problem.startswith("1 damaged lines (line 2: it ends in the middle)")
        assert (folder / FILE).read_bytes() == whole[:first]
        assert (folder / f"{FILE}.corrupt").read_bytes() == whole[:cut]
        again = NameStore(folder)
        assert (len(again.read()), again.problem) == (1, "")


def test_a_changed_line_in_the_middle_is_found_by_its_checksum(tmp_path):
    lines = [line_of(teach_record(name(n))) for n in (1, 2, 3)]
    lines[1] = lines[1].replace(b'"instance_id":7', b'"instance_id":8')
    (tmp_path / FILE).write_bytes(b"".join(lines))
    (tmp_path / f"{FILE}.corrupt").write_bytes(b"an older one")
    store = NameStore(tmp_path)
    assert [one.number for one in store.read()] == [1, 3]
    assert "line 2: its checksum is wrong" in store.problem
    assert (tmp_path / f"{FILE}.corrupt1").read_bytes() == b"".join(lines)


@pytest.mark.parametrize(
    ("field", "value"),
    [("centre_world", [1, 2]), ("kind", "thing"), ("descriptor", "?"), ("name", "a\u0000b")],
)
def test_a_whole_line_that_makes_no_sense_is_damage_too(tmp_path, field, value):
    (tmp_path / FILE).write_bytes(line_of(teach_record(name()) | {field: value}))
    store = NameStore(tmp_path)
    assert store.read() == ()
    assert store.problem.startswith("1 damaged lines (line 1: record 1: ")


@pytest.mark.parametrize("line", [b"[]\n", b"7\n", b"{}\n", b"\xff\n", b'{"crc":"x"}\n', b"\n"])
def test_what_is_no_record_is_no_record(line):
    with pytest.raises(ValueError, match=r"no record|checksum"):
        record_of(line)


def test_a_line_of_a_later_version_is_left_where_it_is(tmp_path):
    line = line_of({"format": "sceneq.name.v9", "op": "dream"})
    (tmp_path / FILE).write_bytes(line + line_of(teach_record(name())))
    store = NameStore(tmp_path)
    assert len(store.read()) == 1
    assert store.problem == ""
    assert (tmp_path / FILE).read_bytes().startswith(line)


def test_forgetting_what_was_never_taught_is_no_error():
    assert replay([forget_record(name())]) == {}


def test_a_long_history_is_written_anew_in_short(tmp_path):
    store = NameStore(tmp_path)
    store.write(taught=[name(1), name(2)])
    store.write(moved=[name(1)] * (SPARE_LINES + 5))
    (tmp_path / "names.new").write_bytes(b"left by a crash")
    assert len(NameStore(tmp_path).read()) == 2
    lines = (tmp_path / FILE).read_bytes().splitlines(keepends=True)
    assert [json.loads(line)["op"] for line in lines] == ["teach", "teach"]


def test_half_a_line_is_taken_back_when_the_disk_is_full(tmp_path, monkeypatch):
    store = NameStore(tmp_path)
    store.write(taught=[name(1)])
    before = (tmp_path / FILE).read_bytes()
    write = os.write
    monkeypatch.setattr(
        "sceneq_nodes._name_store.os.write", lambda fd, data: write(fd, data[: len(data) // 2])
    )
    with pytest.raises(OSError, match="bytes could be written"):
        store.write(taught=[name(2)])
    assert (tmp_path / FILE).read_bytes() == before


def test_a_folder_that_is_not_there_is_an_error_of_writing(tmp_path):
    store = NameStore(tmp_path / "gone")
    assert store.read() == ()
    with pytest.raises(OSError, match="No such file"):
        store.write(taught=[name()])
