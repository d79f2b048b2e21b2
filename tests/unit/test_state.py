"""Object graphs as plain values and arrays."""

import json
from collections import OrderedDict, deque
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.spatial import cKDTree

from sceneq_core.mapping.ids import Ids
from sceneq_core.state import State, StateError, build, take_apart

from support.surfaces import flat_frame

PLAIN = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
VALUES = st.recursive(
    PLAIN | st.binary(),
    lambda inner: (
        st.lists(inner)
        | st.lists(inner).map(tuple)
        | st.dictionaries(st.integers() | st.text(), inner)
    ),
    max_leaves=20,
)


def there_and_back(value):
    state = take_apart(value)
    return build(State(json.loads(json.dumps(state.parts)), state.arrays))


@given(VALUES)
def test_plain_values_come_back(value):
    assert there_and_back([value]) == [value]


@given(
    arrays.arrays(st.sampled_from(["<f4", "<i8", "|u1", "|b1"]), arrays.array_shapes(min_dims=0))
)
def test_arrays_come_back(array):
    back = there_and_back(array)
    assert back.dtype == array.dtype
    assert back.shape == array.shape
    assert back.tobytes() == array.tobytes()


def test_containers_keep_their_kind_and_order():
    values = [
        {3, 1, 2},
        frozenset({1}),
        deque([1, 2], 2),
        OrderedDict([("b", 1), ("a", 2)]),
        {"b": 1, "a": 2},
        np.float32(0.1),
        float("inf"),
    ]
    back = there_and_back(values)
    assert back == values
    assert [type(one) for one in back] == [type(one) for one in values]
    assert list(back[3]) == ["b", "a"] == list(back[4])
    assert back[2].maxlen == 2


def test_what_is_shared_stays_shared():
    shared = np.arange(3)
    one, other = there_and_back([shared, {"again": shared}])
    assert other["again"] is one


def test_columns_stay_columns():
    turned = np.arange(6.0).reshape(2, 3).T
    back = there_and_back(turned)
    assert back.flags.f_contiguous
    assert np.array_equal(back, turned)


def test_objects_come_back_with_what_they_hold():
    ids = Ids()
    ids.give_back(ids.take(5)[1:3])
    back = there_and_back(ids)
    assert type(back) is Ids
    assert back.take(3).tolist() == ids.take(3).tolist() == [1, 2, 5]
    frame = flat_frame(1.0, seq=7)
    assert there_and_back(frame).seq == 7
    assert np.array_equal(there_and_back(frame).depth_m, frame.depth_m)


def test_a_tree_finds_what_it_found():
    points = np.random.default_rng(0).uniform(size=(50, 3))
    found = there_and_back(cKDTree(points)).query(points[:5] + 0.01)
    assert np.array_equal(found[1], cKDTree(points).query(points[:5] + 0.01)[1])


@dataclass
class Foreign:
    value: int = 0


@pytest.mark.parametrize("value", [Foreign(), print, np.array([object()]), 1j, [Foreign]])
def test_foreign_things_are_refused(value):
    with pytest.raises(StateError):
        take_apart(value)


def test_a_circle_is_refused():
    circle = []
    circle.append(circle)
    with pytest.raises(StateError, match="a list refers to itself"):
        take_apart(circle)


@pytest.mark.parametrize(
    "part",
    [
        ["object", "os:system"],
        ["object", "subprocess:Popen", "args", "true"],
        ["object", "sceneq_core.mapping.mapper:np"],
        ["object", "sceneq_core.mapping.nothing:Nothing"],
        ["object", "sceneq_core.frame:Frame", "seq", 1],
        ["list", [7]],
        ["array", 3],
        ["dict", 1],
        ["set", [0]],
        ["what"],
        [],
        [{}],
    ],
)
def test_parts_that_mean_nothing_are_refused(part):
    with pytest.raises(StateError):
        build(State([part], []))
