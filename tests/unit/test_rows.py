"""Tables by id, and the numbers of their rows."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.mapping.ids import Ids
from sceneq_core.mapping.rows import (
    counted,
    distinct,
    first_of_each,
    first_of_runs,
    largest_of_runs,
    marked,
    put_rows,
    runs,
    stable_order,
    with_rows,
)
from sceneq_core.mapping.tally import Tally
from sceneq_core.vectors import divided, unit_rows


def ids(*values):
    return np.array(values, np.int32)


def test_numbers_that_came_back_are_handed_out_first_and_smallest_first():
    numbers = Ids()
    assert numbers.take(4).tolist() == [0, 1, 2, 3]
    numbers.give_back(ids(3, 1))
    numbers.give_back(ids(1))
    assert numbers.take(3).tolist() == [1, 3, 4]
    assert numbers.take(0).tolist() == []
    assert len(numbers) == 5


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=20))
def test_a_number_never_has_two_owners(steps):
    numbers, held = Ids(), set()
    for count, returned in steps:
        taken = numbers.take(count).tolist()
        assert held.isdisjoint(taken)
        held.update(taken)
        back = sorted(held)[:returned]
        numbers.give_back(ids(*back))
        held.difference_update(back)
        assert len(numbers) > max(held, default=-1)


def test_rows_are_added_with_the_fill_and_none_is_lost():
    table = with_rows(ids(7, 8), 3, -1)
    assert table.tolist() == [7, 8, -1, -1]
    assert table.dtype == np.int32
    assert with_rows(table, 4, -1) is table


def test_marks_and_distinct_ids():
    assert marked(ids(2, 0, 2), 4).tolist() == [True, False, True, False]
    assert distinct(ids(2, 0, 2), 4).tolist() == [0, 2]


def test_the_first_in_order_stands_for_its_key():
    key, size = ids(4, 1, 4, 1), ids(5, 9, 6, 2)
    assert first_of_each(np.lexsort((-size, key)), key).tolist() == [1, 2]


def test_unit_rows_keep_direction_and_zero():
    assert unit_rows(np.array([[3.0, 0, 4.0], [0, 0, 0]])).tolist() == [[0.6, 0, 0.8], [0, 0, 0]]


def test_rows_are_put_where_they_belong_and_runs_are_found():
    table = np.zeros((4, 3))
    put_rows(table, ids(3, 1), np.array([[1.0, 2, 3], [4, 5, 6]]))
    assert table.tolist() == [[0, 0, 0], [4, 5, 6], [0, 0, 0], [1, 2, 3]]
    first, of_row = runs(np.array([[1, 2], [1, 2], [1, 3], [1, 2]]))
    assert first.tolist() == [0, 2, 3]
    assert of_row.tolist() == [0, 0, 1, 2]
    assert runs(np.zeros((0, 3), np.int32))[1].shape == (0,)


@given(st.lists(st.integers(0, 5), max_size=30))
def test_keys_are_counted_like_unique_does(keys):
    value, count = counted(np.array(keys, np.int64))
    wanted = np.unique(np.array(keys, np.int64), return_counts=True)
    assert (value.tolist(), count.tolist()) == (wanted[0].tolist(), wanted[1].tolist())


@given(st.lists(st.integers(0, 200_000), max_size=40))
def test_ids_are_ordered_as_a_stable_sort_orders_them(numbers):
    row_id = np.array(numbers, np.int32)
    assert stable_order(row_id).tolist() == np.argsort(row_id, kind="stable").tolist()


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 3)), max_size=20))
def test_the_largest_of_each_run_is_the_first_of_the_largest(rows):
    key, size = np.array(sorted(rows), np.int64).reshape(-1, 2).T
    size = size[::-1].copy()
    order = np.lexsort((np.arange(len(key)), -size, key))
    assert largest_of_runs(key, size).tolist() == first_of_each(order, key).tolist()
    assert first_of_runs(key).tolist() == np.unique(key, return_index=True)[1].tolist()


@given(st.sets(st.tuples(st.integers(0, 9), st.integers(0, 3))), st.sets(st.integers(0, 12)))
def test_a_tally_finds_the_keys_under_some_prefixes(keys, wanted):
    tally = Tally()
    tally.add(np.array([a << 8 | b for a, b in keys], np.int64), np.ones(len(keys), np.int64))
    row = tally.under(np.array(sorted(wanted), np.int64), 8)
    expected = [row for row, key in enumerate(tally.key.tolist()) if key >> 8 in wanted]
    assert row.tolist() == expected


def test_rows_are_divided_as_broadcasting_divides_them():
    rng = np.random.default_rng(3)
    table, by = rng.normal(size=(50, 10)), rng.uniform(0.1, 9, 50)
    assert (divided(table[:, 2:5], by) == table[:, 2:5] / by[:, None]).all()
