"""Lists by row id."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.mapping import ragged
from sceneq_core.mapping.ragged import Ragged

lists = st.dictionaries(st.integers(0, 9), st.lists(st.integers(0, 99), max_size=40), max_size=5)


def ids(values):
    return np.array(list(values), np.int32)


@pytest.fixture(autouse=True)
def small_buffer(monkeypatch):
    monkeypatch.setattr(ragged, "_LEAST", 16)


def put(table, content):
    lengths = np.array([len(numbers) for numbers in content.values()], np.int64)
    table.put(ids(content), lengths, ids(n for numbers in content.values() for n in numbers))


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(lists, st.sets(st.integers(0, 9))), max_size=8))
def test_a_ragged_table_is_a_dictionary_of_lists(steps):
    table, model = Ragged(), {row: [] for row in range(10)}
    put(table, model)
    for content, forgotten in steps:
        put(table, content)
        table.forget(ids(forgotten))
        model |= content
        model |= {row: [] for row in forgotten}
    order = [3, 0, *range(9, 3, -1), 1, 2]
    assert table.of(ids(order)).tolist() == [n for row in order for n in model[row]]
    for row in order:
        assert table.of(ids([row])).tolist() == model[row]


def test_a_list_set_over_and_over_takes_no_more_room():
    table, numbers = Ragged(), np.arange(3000, dtype=np.int32)
    for start in range(200):
        table.put(ids([0, 1]), np.array([1000, 2000]), numbers + start)
    assert table.of(ids([1])).tolist() == list(range(1199, 3199))
    assert len(table._numbers) < 20_000
