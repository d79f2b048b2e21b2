"""Whatever happens to the bytes of names.jsonl: what is read was once written."""

import tempfile
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.teaching.taught import Looks, Spot, Taught
from sceneq_nodes._name_store import FILE, NameStore


def name(number: int) -> Taught:
    spot = Spot(number, 5, np.ones(3), np.ones((2, 3)))
    looks = Looks("words", np.ones(3, np.float32), np.zeros(0, np.float32))
    return Taught(number, f"name {number}", "individual", "anna", 7, spot, looks)


def written() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        NameStore(Path(folder)).write(taught=[name(n) for n in (1, 2, 3, 4)])
        NameStore(Path(folder)).write(forgotten=[name(2)], moved=[name(3)])
        return (Path(folder) / FILE).read_bytes()


WHOLE = written()
PLACES = st.integers(0, len(WHOLE) - 1)
CHANGES = st.lists(st.tuples(PLACES, st.binary(max_size=6)), max_size=3)


@settings(max_examples=150, deadline=None)
@given(changes=CHANGES, cut=st.one_of(st.none(), PLACES))
def test_damage_loses_names_but_never_invents_one(changes, cut) -> None:
    data = bytearray(WHOLE)
    for place, new in changes:
        data[place : place + len(new)] = new
    data = data[:cut]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / FILE
        path.write_bytes(data)
        store = NameStore(Path(folder))
        found = store.read()
        assert {one.name for one in found} <= {name(n).name for n in (1, 2, 3, 4)}
        if bytes(data) == WHOLE:
            assert [one.number for one in found] == [1, 3, 4]
            assert not store.problem
        again = NameStore(Path(folder))
        assert [one.number for one in again.read()] == [one.number for one in found]
        assert again.problem == ""
        store.write(taught=[name(9)])
        assert [one.number for one in NameStore(Path(folder)).read()][-1] == 9
